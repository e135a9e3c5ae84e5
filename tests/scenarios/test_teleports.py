"""Teleports into the safe zone in every phase of an errand: the person always restarts."""

import math
from functools import cache

import pytest

import sim

HOME = (2.0, 2.0)
HALL = """
floorplan: hall.yaml
duration: 60
people: [{{name: operator, personality: {personality}, start: {{time: 1.0}}}}]
agvs: {{cart: [{moves}]}}
rules:
  based_on: paper
  agv_law: {{fixed: 30.0}}
"""
"""The cart is always too close, so each of its drives puts the person back."""

PHASES = {
    "before the start": lambda arrival: 0.5,
    "setting out": lambda arrival: 1.1,
    "walking": lambda arrival: arrival / 2,
    "slowing down before a goal": lambda arrival: arrival - 0.2,
    "at a goal": lambda arrival: arrival + 0.001,
    "on the next leg": lambda arrival: arrival + 5.0,
}
"""Times of the phases, by the time of the first arrival (s)."""


def put_back(folder, personality, *times):
    """Return the run in which the cart drives a little at each of `times` (s)."""
    moves = ", ".join(f"{{time: {t}, to: {0.5 if k % 2 == 0 else 0}}}" for k, t in enumerate(times))
    text = HALL.format(personality=personality, moves=moves)
    return sim.run(sim.Trial.parse(text, folder=folder))


@cache
def first_arrival(folder, personality):
    """Return the time (s) of the first arrival of a person whom no cart disturbs before."""
    undisturbed = put_back(folder, personality, 59.0)
    return next(e["t"] for e in undisturbed.events if e["kind"] == "arrived")


@pytest.mark.parametrize("personality", ["indifferent", "helpful", "scared"])
@pytest.mark.parametrize("phase", PHASES)
def test_the_person_restarts_after_the_pause(request, personality, phase):
    t = PHASES[phase](first_arrival(request.path.parent, personality))
    run = put_back(request.path.parent, personality, t)
    begins_anew(run, after=max(t, 1.0))


@pytest.mark.parametrize("later", [0.0, 0.3, 2.5, 7.9, 8.5, 9.0])
def test_a_person_can_be_put_back_again_while_waiting_or_starting(request, later):
    run = put_back(request.path.parent, "indifferent", 9.0, 11.0 + later)
    assert len([e for e in run.events if e["kind"] == "teleport"]) >= 2
    begins_anew(run, after=11.0 + later)


def begins_anew(run, after):
    teleports = [e["t"] for e in run.events if e["kind"] == "teleport"]
    assert teleports
    last = max(teleports)
    # Events are rounded to 1e-9 s, so the person is certainly there just after.
    assert run.motions["operator"].position(last + 1e-6) == pytest.approx(HOME)
    goals = [e for e in run.events if e["kind"] == "goal" and e["t"] > last]
    assert goals[0]["station"] == "east"
    assert goals[0]["t"] == pytest.approx(max(last + sim.PAPER.pause_after_agv, after), abs=0.01)
    arrived = next(e for e in run.events if e["kind"] == "arrived" and e["t"] > last)
    assert arrived["station"] == "east"
    walked = run.motions["operator"].cut(last, goals[0]["t"])
    assert all(math.hypot(*walked.velocity(t)) == 0.0 for t in (last + 1.0, goals[0]["t"] - 0.01))
