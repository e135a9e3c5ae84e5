"""Values made in Python: integers are accepted as floats, and a wrong type is reported in its
place.
"""

import dataclasses
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from shapely.geometry import box

import bdi
import floorplan
import navigation
import sim

AXIS = floorplan.Axis(low=0.0, high=12.0, max_speed=1.0, max_acceleration=1.0, max_jerk=2.0)
FLOOR = floorplan.Floorplan(
    name="hall",
    boundary=box(0.0, 0.0, 12.0, 12.0),
    obstacles=(
        floorplan.Obstacle(name="table", footprint=box(5.0, 5.0, 6.0, 6.0), bottom=0.0, top=1.0),
    ),
    stations=(floorplan.Station("a", (2.0, 2.0)), floorplan.Station("b", (10.0, 10.0))),
    safe_zone=floorplan.SafeZone((2.0, 10.0), 3.0),
    human=floorplan.Human(
        radius=0.3, height=2.0, max_speed=1.0, max_acceleration=2.0, goal_tolerance=0.25
    ),
    lanes=(
        floorplan.Lane(
            name="agv1",
            origin=(4.0, 3.0),
            heading=0.0,
            limits=(0.0, 4.0),
            locations={"home": 0.0, "away": 4.0},
            start="home",
            length=1.0,
            width=1.0,
            height=1.0,
            max_speed=1.0,
            max_acceleration=1.0,
        ),
    ),
    gantry=floorplan.Gantry(
        x=AXIS,
        y=AXIS,
        rotation=replace(AXIS, low=-7.0, high=7.0),
        start=(8.0, 3.0, 0.0),
        torso=(1.0, 1.0, 1.0, 3.0),
        arm_mount=(1.0, 0.0),
        arm_reach=1.0,
        arm_bottom=1.0,
        rail_height=3.0,
        tray_height=1.0,
    ),
)
TRIAL = sim.Trial(
    FLOOR,
    duration=30.0,
    rules=replace(sim.PAPER, grace=1.0),
    people=(
        sim.PersonEntry(
            "ada",
            personality="helpful",
            start=sim.Start(1.0),
            at=(1.0, 5.0),
            max_speed=1.0,
            changes=(sim.PersonalityChange(sim.Start(12.0), "antagonistic"),),
        ),
        sim.PersonEntry("ben", radius=1.0, max_acceleration=2.0),
    ),
    gantry=sim.GantryEntry(
        "pausing",
        at=(8.0, 4.0, 0.0),
        jobs=(
            sim.Job("move", target=(3.0, 9.0, 1.0)),
            sim.Job("wait", seconds=1.0),
            sim.Job("pick_place", pick="table", place="a", part="x"),
        ),
    ),
    agvs={"agv1": (sim.AgvMove(2.0, 3.0), sim.AgvMove(9.0, "home"))},
)


def converted(number, value):
    """Return `value` with each whole float, at any depth, converted by `number`."""
    if isinstance(value, float) and value.is_integer():
        return number(value)
    if isinstance(value, tuple):
        return tuple(converted(number, one) for one in value)
    if isinstance(value, dict):
        return {key: converted(number, one) for key, one in value.items()}
    if dataclasses.is_dataclass(value) and not isinstance(value, bdi.Program):
        fields = {f.name: getattr(value, f.name) for f in dataclasses.fields(value) if f.init}
        return replace(value, **{name: converted(number, one) for name, one in fields.items()})
    return value


@pytest.mark.parametrize("number", [int, np.int64, np.float64])
def test_numbers_of_any_type_are_numbers(number):
    assert isinstance(converted(number, FLOOR).stations[0].position[0], number)
    run, other = sim.run(TRIAL), sim.run(converted(number, TRIAL))
    assert len(run.events) > 10
    assert other.events == run.events


def trial(**changes):
    return lambda: sim.run(replace(TRIAL, **changes))


def person(**changes):
    return trial(people=(replace(TRIAL.people[0], **changes),))


LAW = navigation.FixedDistance(1.0)


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: sim.run("ariac2023"), r"expected a Trial, .*; sim.Trial.load\('ariac2023'\)"),
        (lambda: sim.Simulation(Path("t.yaml")), r"a Trial, .*; sim.Trial.load\('t.yaml'\)"),
        (lambda: sim.run_study("s.yaml"), r"a Study, .*; sim.Study.load\('s.yaml'\)"),
        (lambda: sim.export("run", "a.csv"), r"an Outcome, .*; sim.load_run\('run'\)"),
        (lambda: navigation.CollisionWorld("warehouse"), r"floorplan.load\('warehouse'\)"),
        (lambda: navigation.PathPlanner(FLOOR), "expected a CollisionWorld"),
        (lambda: navigation.first_violation((0, 0), (1, 1), LAW, 0, 1), "expected a Motion"),
        (lambda: bdi.Agent("human.asl"), "program must be a bdi.Program"),
        (lambda: bdi.Literal("at", (None,)), "a term must be a number, .* not None"),
        (trial(floorplan="ariac2023"), "Trial.floorplan: expected a Floorplan"),
        (trial(duration="5"), "Trial.duration: expected a number, found '5'"),
        (trial(people=("ada",)), r"Trial.people\[0\]: expected a PersonEntry"),
        (trial(people=TRIAL.people[0]), "Trial.people: expected a tuple"),
        (trial(gantry=sim.GantryEntry(jobs=("pick",))), r"jobs\[0\]: expected a Job"),
        (trial(agvs={"agv1": [(0, 2)]}), r"Trial.agvs.agv1\[0\]: expected an AgvMove"),
        (person(at=(1.0,)), r"people\[0\].at: expected 2 of them, found 1"),
        (person(beliefs="tired"), r"people\[0\].beliefs: expected a tuple, found 'tired'"),
        (person(max_speed=True), r"people\[0\].max_speed: expected a number or .*, found True"),
        (person(personality=None), "personality: expected text or a Program, found None"),
    ],
)
def test_a_wrong_type_is_reported_with_the_expected_one(call, message):
    with pytest.raises(TypeError, match=message):
        call()


def test_values_are_shown_in_a_line():
    loaded = sim.Trial.load("people_bottleneck")
    simulation = sim.Simulation(dataclasses.replace(loaded, duration=1.0))
    simulation.advance(1.0)
    study = sim.Study.parse("trials: [people_bottleneck]\nrepeat: 2")
    for value in (loaded, simulation, simulation.finish(), study):
        assert "people_bottleneck" in repr(value) and len(repr(value)) < 150


def test_a_planned_path_is_walked_as_it_is():
    world = navigation.CollisionWorld(floorplan.load("warehouse"))
    path = navigation.PathPlanner(world, radius=0.3).plan((1.5, 1.5), (28.0, 10.0))
    walked, expected = navigation.walk(path), navigation.walk(path.points)
    assert walked.end == expected.end and np.array_equal(np.asarray(path), path.points)


def test_an_invalid_pose_and_invalid_samples_are_rejected():
    with pytest.raises(ValueError, match=r"x, y and a rotation, found \(1, 2\)"):
        navigation.gantry_move((1, 2), (3, 4, 0))
    with pytest.raises(ValueError, match=r"t must have the shape \(2,\), found \(1, 2\)"):
        navigation.Motion.from_samples([[0, 1]], [(0, 0), (1, 1)])
