"""Random trials: clearance, limits, intervals, rules and the verdicts of FCL all hold."""

from dataclasses import replace

import pytest

import navigation
import sim
from floorplan import Door

from . import (
    faults,
    random_trial,
    random_trial_with_doors,
    random_trial_with_fields,
    tracked_trial,
)


# In 20177, a person gives way who has approached another.
@pytest.mark.parametrize("number", [*range(15), 20177])
def test_nothing_is_broken(number):
    assert faults(sim.run(random_trial(number))) == []


@pytest.mark.parametrize("number", range(15))
def test_nothing_is_broken_where_people_walk_as_measured(number):
    assert faults(sim.run(tracked_trial(number))) == []


@pytest.mark.parametrize("number", range(10))
def test_nothing_is_broken_by_doors_and_vehicles(number):
    assert faults(sim.run(random_trial_with_doors(number))) == []


@pytest.mark.parametrize("number", range(4))
def test_no_vehicle_with_fields_touches_anybody(number):
    assert faults(sim.run(random_trial_with_fields(number))) == []


@pytest.mark.slow
@pytest.mark.parametrize("first", range(100, 140, 5))
def test_no_vehicle_with_fields_touches_anybody_in_many_more(first):
    found = {n: faults(sim.run(random_trial_with_fields(n))) for n in range(first, first + 5)}
    assert {number: wrong for number, wrong in found.items() if wrong} == {}


@pytest.mark.slow
@pytest.mark.parametrize("first", range(100, 200, 10))
def test_nothing_is_broken_in_many_more(first):
    numbers, kinds = range(first, first + 10), (random_trial, tracked_trial)
    found = {(n, kind.__name__): faults(sim.run(kind(n))) for n in numbers for kind in kinds}
    assert {key: wrong for key, wrong in found.items() if wrong} == {}


def test_what_is_broken_is_found():
    """A run with violations, in which somebody then does what may not be."""
    run = next(
        run
        for run in map(sim.run, map(random_trial, range(0, 100, len(sim.RULE_SETS))))
        if run.summary["penalties"]
    )
    assert faults(run) == []
    one = run.trial.people[0].name
    away = navigation.standing((-100.0, 0.0)).cut(0.0, run.duration)
    first = next(event for event in run.events if event["kind"] == "violation")
    flipped = tuple(
        event | {"penalty": not event["penalty"]} if event is first else event
        for event in run.events
    )
    stayed = tuple(event for event in run.events if event["kind"] != "teleport")
    pair, always = (first["person"], first["with"]), ((0.0, run.duration),)
    other, solid = run.trial.people[1].name, run.floorplan.obstacles[0]
    inside = navigation.standing(solid.footprint.centroid.coords[0]).cut(0.0, run.duration)
    x, y = next(p for p in run.motions[one].pieces if p.moves)[2:4]
    door = Door(name="shut", ends=((x[0] - 0.5, y[0]), (x[0] + 0.5, y[0])), is_open=False)
    shut = replace(run.floorplan, doors=(door,))
    tampered = {
        "what never moves": {"motions": run.motions | {one: away}},
        "the monitor does not know": {"violations": run.violations | {pair: ()}},
        "is not put home": {"events": stayed},
        "be a penalty": {"events": flipped},
        "jumps by": {"events": stayed},
        "the summary says penalties": {"summary": run.summary | {"penalties": 99}},
        "are violations, and should be": {"violations": run.violations | {pair: always}},
        "the end of the floor is there": {"motions": run.motions | {one: away}},
        f"{solid.name} is there": {"motions": run.motions | {one: inside}},
        f"{other} is there": {"motions": run.motions | {one: run.motions[other]}},
        "the closed door shut is there": {"trial": replace(run.trial, floorplan=shut)},
    }
    for fault, change in tampered.items():
        assert any(fault in found for found in faults(replace(run, **change))), fault
