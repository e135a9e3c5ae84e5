"""Random trials: clearance, continuity, limits, the monitor's intervals and the rules all hold."""

from dataclasses import replace

import pytest

import navigation
import sim

from . import faults, random_trial, random_trial_with_doors


@pytest.mark.parametrize("number", range(15))
def test_nothing_is_broken(number):
    assert faults(sim.run(random_trial(number))) == []


@pytest.mark.parametrize("number", range(10))
def test_nothing_is_broken_by_doors_and_vehicles(number):
    assert faults(sim.run(random_trial_with_doors(number))) == []


@pytest.mark.slow
@pytest.mark.parametrize("first", range(100, 200, 10))
def test_nothing_is_broken_in_many_more(first):
    found = {n: faults(sim.run(random_trial(n))) for n in range(first, first + 10)}
    assert {n: wrong for n, wrong in found.items() if wrong} == {}


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
    pair = (first["person"], first["with"])
    tampered = {
        "what never moves": {"motions": run.motions | {one: away}},
        "the monitor does not know": {"violations": run.violations | {pair: ()}},
        "is not put home": {"events": stayed},
        "be a penalty": {"events": flipped},
        "jumps by": {"events": stayed},
        "the summary says penalties": {"summary": run.summary | {"penalties": 99}},
    }
    for fault, change in tampered.items():
        assert any(fault in found for found in faults(replace(run, **change))), fault
