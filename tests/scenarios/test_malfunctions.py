"""A robot that breaks down while it is disabled for a violation: the longer of the two counts."""

from pathlib import Path

import pytest
import yaml

import sim

EXAMPLE = Path(__file__).resolve().parents[2] / "examples" / "kitting.ariac.yaml"


def run_with(*malfunctions):
    """Run the ARIAC example with a person who walks up to the gantry and a breakdown (time, s)."""
    data = yaml.safe_load(EXAMPLE.read_text())
    human = {"behavior": "antagonistic", "time_condition": 0.0}
    challenges = [{"human": human}] + [
        {
            "robot_malfunction": {
                "duration": seconds,
                "robots_to_disable": ["ceiling_robot"],
                "time_condition": time,
            }
        }
        for time, seconds in malfunctions
    ]
    text = yaml.safe_dump({**data, "time_limit": 90, "challenges": challenges})
    return sim.run(sim.Trial.parse(text, file="broken.yaml", folder=EXAMPLE.parent))


def first(run, kind, after=0.0):
    return next(e["t"] for e in run.events if e["kind"] == kind and e["t"] > after)


@pytest.fixture(scope="module")
def violation():
    """Return the time of the first violation without a breakdown."""
    run = run_with()
    t = first(run, "violation")
    assert first(run, "gantry_enabled", t) == pytest.approx(t + 15.0)
    return t


@pytest.mark.parametrize("seconds", [2.0, 11.9, 12.1, 30.0])
@pytest.mark.parametrize("delay", [0.5, 3.0])
def test_the_gantry_stands_until_both_stops_are_over(violation, delay, seconds):
    run = run_with((violation + delay, seconds))
    assert first(run, "violation") == pytest.approx(violation)
    until = violation + max(15.0, delay + seconds)
    assert first(run, "gantry_enabled", violation) == pytest.approx(until)
    gantry = run.motions["gantry"]
    stopped = violation + 4.0  # the gantry brakes as fast as it can
    assert gantry.position(stopped) == pytest.approx(gantry.position(until))
    assert run.summary["gantry_disabled_time"] >= until - violation - 1e-6
    broken = [e for e in run.events if e["kind"] == "robot_malfunction"]
    assert [e["t"] for e in broken] == [pytest.approx(violation + delay)]
