"""People beside vehicles: they never walk into a vehicle that they see coming."""

import random

import pytest
import yaml

import navigation
import sim
from navigation import Cylinder, FixedDistance, Shapes

WALKER = """
route([{route}]).
!go.
+!go : route([at(X, Y)|Rest]) <- -+route(Rest); move(X, Y, 0).
+!go.
-!go.
+work_completed(_) <- !!go.
"""


def walks_into(run):
    """Yield the name and time (s) of each contact of a person walking towards a vehicle."""
    for person in run.scene.people:
        walk = run.motions[person.name]
        body = Cylinder(radius=person.radius, top=person.height)
        for machine in run.scene.machines:
            drive, shapes = (
                run.motions[machine.name],
                Shapes(person=body, machine=(machine.chassis,)),
            )
            touches = navigation.violations(
                walk, drive, FixedDistance(1e-4), 0.0, run.duration, shapes=shapes
            )
            for begin, _ in touches:
                t = max(begin - 1e-3, 0.0)
                here, velocity = walk.state_before(t).at, walk.state_before(t).velocity
                ahead = tuple(at + 1e-3 * v for at, v in zip(here, velocity, strict=False))
                before, after = (
                    navigation.minimum_separation(
                        navigation.standing(at), drive, t, t, shapes=shapes
                    )[1]
                    for at in (here, ahead)
                )
                if (before - after) / 1e-3 > 0.05:
                    yield person.name, begin


def run_of(folder, size, people, machines, seed=0):
    """Run a trial in a hall of length and width `size`, of people at places with routes."""
    length, width = size
    entries = []
    for k, (at, route) in enumerate(people):
        name = f"p{k}"
        places = ", ".join(f"at({x:.2f}, {y:.2f})" for x, y in route)
        (folder / f"{name}.asl").write_text(WALKER.format(route=places))
        entries.append({"name": name, "at": [*at], "personality": f"{name}.asl"})
    floor = {
        "name": "hall",
        "boundary": [[0, 0], [length, 0], [length, width], [0, width]],
        "safe_zone": {"at": [0.5, 0.5]},
    }
    keys = {"duration": 60, "seed": seed, "rules": "observe"}
    keys |= {"floorplan": floor, "people": entries, "machines": machines}
    (folder / "trial.yaml").write_text(yaml.safe_dump(keys))
    return sim.run(sim.Trial.load(folder / "trial.yaml"))


@pytest.mark.parametrize("seed", range(20))
def test_a_person_passes_a_vehicle_that_comes_head_on(tmp_path, seed):
    rng = random.Random(seed)
    start = rng.uniform(12.0, 28.0), rng.uniform(0.5, 3.5)
    lane, goal = rng.uniform(0.7, 3.3), rng.uniform(0.7, 3.3)
    bot = {"kind": "amr", "at": [2.0, lane, 0.0], "missions": [{"go": [28.0, goal]}]}
    run = run_of(tmp_path, (30.0, 4.0), [(start, [(1.0, 2.0)])], {"bot": bot})
    assert run.summary["contacts"] == 0
    assert run.motions["p0"].position(run.duration) == pytest.approx([1.0, 2.0], abs=1e-3)


CORRIDORS = [
    pytest.param(width, seed, marks=pytest.mark.slow if seed > 2 else ())
    for width in (2.0, 2.4, 3.0, 4.0)
    for seed in range(12)
]
STRUCK = [(3.0, 5209), (3.0, 5366), (4.0, 5183), (4.0, 5220), (4.0, 5531)]
"""Widths and seeds for which the vehicle turns towards a walking person."""


@pytest.mark.parametrize(("width", "seed"), [*CORRIDORS, *STRUCK])
def test_people_avoid_a_long_vehicle_that_turns_in_a_corridor(tmp_path, width, seed):
    rng = random.Random(seed)
    people = [
        (
            (12 + 3 * k + rng.uniform(0.0, 1.5), rng.uniform(0.5, width - 0.5)),
            [(1.0 + k, rng.uniform(0.5, width - 0.5))],
        )
        for k in range(rng.randint(1, 3))
    ]
    missions = [{"go": [20.0, width / 2]}]
    if width > 2.8:
        missions = [{"go": [12.0, width / 2]}, {"turn": 3.14}, *missions]
    controller = rng.choice(["oblivious", "pausing"])
    bot = {"kind": "amr", "at": [5.5, width / 2, 0.0], "size": [2.4, 0.8]}
    bot |= {"controller": controller, "missions": missions}
    run = run_of(tmp_path, (24.0, width), people, {"bot": bot}, seed)
    assert [*walks_into(run)] == []


def test_a_person_passes_a_long_vehicle_that_leaves_room(tmp_path):
    """A vehicle of 2.4 × 0.8 m leaves 0.8 m in a 2.4 m corridor, but a disc around it does not."""
    bot = {"kind": "amr", "at": [3.0, 0.7, 0.0], "size": [2.4, 0.8]}
    bot |= {"missions": [{"go": [20.0, 0.7]}]}
    run = run_of(tmp_path, (24.0, 2.4), [((16.0, 1.2), [(1.0, 1.2)])], {"bot": bot})
    assert run.summary["contacts"] == 0
    assert run.motions["p0"].position(30.0)[0] < run.motions["bot"].position(30.0)[0]


def hall(rng):
    """Return people and vehicles at random places of a hall, with routes and missions."""
    spots = [(2 + 4 * i, 2 + 4 * j) for i in range(4) for j in range(3)]
    rng.shuffle(spots)
    people = [
        (spots.pop(), [(rng.uniform(1, 15), rng.uniform(1, 11)) for _ in range(4)])
        for _ in range(rng.randint(1, 5))
    ]
    machines = {
        f"bot{k}": {
            "kind": "amr",
            "at": [*spots.pop(), round(rng.uniform(-3, 3), 2)],
            "size": rng.choice([[2.4, 0.8], [1.2, 0.8], [0.8, 0.6]]),
            "controller": rng.choice(["oblivious", "pausing"]),
            "missions": [
                *({"go": [rng.randint(2, 14), rng.randint(2, 10)]} for _ in range(3)),
                {"turn": round(rng.uniform(-3, 3), 2)},
            ],
            "repeat": True,
        }
        for k in range(rng.randint(1, 3))
    }
    return people, machines


@pytest.mark.slow
@pytest.mark.parametrize("seed", [*range(40), 5236, 5241])
def test_people_avoid_a_vehicle_in_a_hall(tmp_path, seed):
    people, machines = hall(random.Random(seed))
    run = run_of(tmp_path, (16.0, 12.0), people, machines, seed)
    assert [*walks_into(run)] == []


def test_contacts_use_the_actual_position_of_the_footprint(tmp_path):
    """A footprint behind the axis does not reach people in front of the axis."""
    behind = [[-1.5, -0.4], [0.1, -0.4], [0.1, 0.4], [-1.5, 0.4]]
    bot = {"kind": "amr", "at": [6.0, 3.0, 0.0], "footprint": behind}
    bot |= {"missions": [{"go": [7.0, 3.0]}]}
    run = run_of(tmp_path, (12.0, 6.0), [((8.0, 3.0), [])], {"bot": bot})
    assert run.summary["contacts"] == 0
    shape = run.scene.machine("bot")
    assert shape.bounds == (-1.5, -0.4, 0.1, 0.4)
