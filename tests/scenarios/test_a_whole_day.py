"""One person for 24 hours."""

import os
from pathlib import Path

import pytest

import sim

HOUR = 3600.0
MOST_GROWN = 20e6
"""Bytes that 23 hours may take up: approximately 60,000 motions and 34,000 events."""


def resident():
    """Return the memory that this process takes up now (bytes)."""
    pages = Path("/proc/self/statm").read_text(encoding="ascii").split()[1]
    return int(pages) * os.sysconf("SC_PAGE_SIZE")


@pytest.mark.slow
@pytest.mark.skipif(not Path("/proc/self/statm").exists(), reason="memory is read from /proc")
def test_a_helpful_person_walks_about_for_a_whole_day():
    trial = sim.Trial.parse(
        "floorplan: ariac2023\nduration: 86400\n"
        "people: [{name: operator, personality: helpful}]\ngantry: {at: [-2.5, 0.5, 0.0]}\n"
        "expect:\n  penalties: 0\n  distance_walked: '> 70000'\n"
        "  timeline: [{always: {apart: [operator, gantry], metres: 3.5}}]\n"
    )
    simulation = sim.Simulation(trial)
    simulation.advance(HOUR)
    after_an_hour = resident()
    simulation.advance(24 * HOUR)
    grown = resident() - after_an_hour
    run = simulation.finish()
    assert run.duration == 86400.0
    assert run.unmet == []
    assert grown < MOST_GROWN
