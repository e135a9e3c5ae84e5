"""Random trials: clearance, limits, intervals, rules and the verdicts of FCL all hold."""

from dataclasses import replace
from types import SimpleNamespace

import pytest

import navigation
import sim
from floorplan import Door

from . import (
    escape,
    faults,
    judge_faults,
    movement_faults,
    random_trial,
    random_trial_of_vehicles,
    random_trial_with_doors,
    random_trial_with_fields,
    rule_faults,
    separation_faults,
    tracked_trial,
    vehicle_faults,
)


# In 20177, a person who has approached another gives way.
@pytest.mark.parametrize("number", [*range(8), 11, 20177])
def test_random_trials_have_no_faults(number):
    assert faults(sim.run(random_trial(number))) == []


@pytest.mark.parametrize("number", range(6))
def test_trials_with_recorded_people_have_no_faults(number):
    assert faults(sim.run(tracked_trial(number))) == []


@pytest.mark.parametrize("number", range(6))
def test_trials_with_doors_and_vehicles_have_no_faults(number):
    assert faults(sim.run(random_trial_with_doors(number))) == []


@pytest.mark.parametrize("number", [0, 1, 3])
def test_a_vehicle_with_fields_touches_no_person(number):
    assert faults(sim.run(random_trial_with_fields(number))) == []


@pytest.mark.parametrize("number", [5, 13, 14, 17])
def test_trials_of_all_kinds_of_vehicles_have_no_faults(number):
    assert [*vehicle_faults(sim.run(random_trial_of_vehicles(number)))] == []


def tampered_run(run, name, motion=None, **changed):
    """Return the run with another motion of a vehicle, or with other events or figures."""
    motions = run.motions | ({} if motion is None else {name: motion})
    return SimpleNamespace(
        **{
            "trial": run.trial,
            "duration": run.duration,
            "motions": motions,
            "events": run.events,
            "summary": run.summary,
            **changed,
        }
    )


def test_faults_of_vehicles_are_detected(monkeypatch):
    """Tamper with the motion, events and figures of a vehicle among people."""
    trial = random_trial_of_vehicles(7)
    assert len(trial.people) > 1 and len(trial.machines) > 1
    run = sim.run(replace(trial, duration=20.0))
    one, other = [*run.trial.machines][:2]
    end = run.duration
    wall = run.floorplan.boundary.exterior.coords[0]
    there = run.motions[other].position(end - 5.0)
    person = run.motions[run.trial.people[0].name].position(end - 5.0)
    turned = float(run.motions[one].rotation(0.0))

    def to(place, seconds=4.0):
        """Return a motion that goes to a place from 3 m away, and stays there."""
        places = [(place[0] - 3.0, place[1]), (place[0] - 3.0, place[1]), place, place]
        times = [0.0, end - 5.0 - seconds, end - 5.0, end]
        return navigation.Motion.from_samples(times, places, [turned] * 4)

    gone = tuple(event for event in run.events if event["kind"] != "job_done")
    figures = {key: value + 1 for key, value in run.summary.items() if key == "collisions"}
    expected = {
        "walls": tampered_run(run, one, to(wall)),
        "machines": tampered_run(run, one, to(there)),
        "people": tampered_run(run, one, to(person)),
        "limits": tampered_run(run, one, to((wall[0] + 5.0, wall[1] + 5.0), 0.5)),
        "events": tampered_run(run, one, summary=run.summary | figures, events=gone),
    }
    # The search for an escape repeats the trial, which does not have the changed motion.
    monkeypatch.setattr(escape, "avoidable", lambda trial, contact: contact[2])
    for row, changed in expected.items():
        assert any(fault.startswith(f"{row}: ") for fault in vehicle_faults(changed)), row


@pytest.mark.slow
@pytest.mark.parametrize("first", range(100, 120, 5))
def test_many_trials_of_all_kinds_of_vehicles_have_no_faults(first):
    numbers = range(first, first + 5)
    by_trial = {n: [*vehicle_faults(sim.run(random_trial_of_vehicles(n)))] for n in numbers}
    assert {number: wrong for number, wrong in by_trial.items() if wrong} == {}


@pytest.mark.slow
@pytest.mark.parametrize("first", range(100, 120, 5))
def test_a_vehicle_with_fields_touches_no_person_in_many_trials(first):
    by_trial = {n: faults(sim.run(random_trial_with_fields(n))) for n in range(first, first + 5)}
    assert {number: wrong for number, wrong in by_trial.items() if wrong} == {}


@pytest.mark.slow
@pytest.mark.parametrize("first", range(100, 150, 10))
def test_many_random_trials_have_no_faults(first):
    numbers, kinds = range(first, first + 10), (random_trial, tracked_trial)
    by_trial = {(n, kind.__name__): faults(sim.run(kind(n))) for n in numbers for kind in kinds}
    assert {key: wrong for key, wrong in by_trial.items() if wrong} == {}


def test_faults_of_people_and_rules_are_detected():
    """Tamper with the people of a run with violations."""
    run = sim.run(random_trial(8))
    assert run.summary["penalties"] and faults(run) == []
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
    moved = {"motions": run.motions | {one: away}}
    tampered = (
        (movement_faults, "what never moves", moved),
        (rule_faults, "the monitor does not know", {"violations": run.violations | {pair: ()}}),
        (rule_faults, "is not put home", {"events": stayed}),
        (rule_faults, "be a penalty", {"events": flipped}),
        (movement_faults, "jumps by", {"events": stayed}),
        (rule_faults, "the summary says penalties", {"summary": run.summary | {"penalties": 99}}),
        (
            separation_faults,
            "are violations, and should be",
            {"violations": run.violations | {pair: always}},
        ),
        (judge_faults, "the end of the floor is there", moved),
        (judge_faults, f"{solid.name} is there", {"motions": run.motions | {one: inside}}),
        (judge_faults, f"{other} is there", {"motions": run.motions | {one: run.motions[other]}}),
        (
            judge_faults,
            "the closed door shut is there",
            {"trial": replace(run.trial, floorplan=shut)},
        ),
    )
    for check, fault, change in tampered:
        reported = [*check(replace(run, **change))]
        assert any(fault in one for one in reported), (fault, reported)
