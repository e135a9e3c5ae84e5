"""Scenes with crowds: the number of finished walks, and the time that people lose to others."""

from __future__ import annotations

import math
import random
from collections.abc import Sequence
from dataclasses import replace

import pytest
from run_events import events

import floorplan
import sim

Place = tuple[float, float]
Room = tuple[Place, Place]
"""Minimum and maximum corner of the positions in a room, m."""

GO = """
+human_start <- !next.
+!next : todo([g(X, Y) | T]) <- -+todo(T); move(X, Y, 0).
+!next <- +done.
+work_completed(_) <- !next.
"""


def lost(run: sim.Run) -> float:
    """Return the total time (s) that people lose to others."""
    return sum(person["time_lost_to_others"] for person in run.summary["people"].values())


def places(rng: random.Random, count: int, room: Room) -> list[Place]:
    """Return random positions in a room, 0.65 m apart."""
    (low_x, low_y), (high_x, high_y) = room
    places: list[Place] = []
    while len(places) < count:
        place = (round(rng.uniform(low_x, high_x), 3), round(rng.uniform(low_y, high_y), 3))
        if all(math.dist(place, other) > 0.65 for other in places):
            places.append(place)
    return places


def there_and_back(
    tmp_path,
    boundary: Place,
    walls: Sequence[tuple[float, ...]],
    sides: tuple[Room, Room],
    count: int,
    draw: int,
) -> sim.Run:
    """Run `count` people on each of two sides for 240 s, to the other side and back."""
    rng = random.Random(draw)
    people = []
    for here, there in (sides, sides[::-1]):
        starts, goals = places(rng, count, here), places(rng, count, there)
        people += [(start, [goal, start]) for start, goal in zip(starts, goals, strict=True)]
    width, depth = boundary
    lines = [f"boundary: [[0, 0], [{width}, 0], [{width}, {depth}], [0, {depth}]]", "obstacles:"]
    for k, (x0, y0, x1, y1) in enumerate(walls):
        lines.append(f"  wall{k}: {{x: [{x0}, {x1}], y: [{y0}, {y1}], z: [0, 2]}}")
    (tmp_path / "go.asl").write_text(GO)
    return sim.run(
        sim.Trial(
            floorplan=floorplan.parse("\n".join(lines if walls else lines[:1])),
            duration=240.0,
            rules=sim.RULE_SETS["observe"],
            folder=tmp_path,
            people=tuple(
                sim.PersonEntry(
                    name=f"p{k}",
                    personality="go.asl",
                    at=start,
                    beliefs=("todo([" + ", ".join(f"g({x}, {y})" for x, y in goals) + "])",),
                )
                for k, (start, goals) in enumerate(people)
            ),
        )
    )


def two_rooms(
    tmp_path, count: int, gap: float, thickness: float, width: float, *, draw: int = 1
) -> sim.Run:
    """Run `count` people in each of two rooms, joined by a gap in a wall of a thickness (m)."""
    depth = width
    far = width + thickness
    walls = [
        (width, 0.0, far, (depth - gap) / 2),
        (width, (depth + gap) / 2, far, depth),
    ]
    west = ((0.4, 0.4), (width - 0.9, depth - 0.4))
    east = ((far + 0.9, 0.4), (far + width - 0.4, depth - 0.4))
    return there_and_back(tmp_path, (far + width, depth), walls, (west, east), count, draw)


def corridor(tmp_path, count: int, length: float, width: float, *, draw: int = 1) -> sim.Run:
    """Run `count` people at each end of a closed corridor."""
    west = ((0.4, 0.35), (0.42 * length, width - 0.35))
    east = ((0.58 * length, 0.35), (length - 0.4, width - 0.35))
    return there_and_back(tmp_path, (length, width), [], (west, east), count, draw)


@pytest.mark.parametrize(
    ("name", "legs", "most_lost"),
    [
        ("people_aisle", 17.4, 16.0),
        ("people_blind_spot", 6.0, 1.0),
        ("people_bottleneck", 10.0, 27.0),
        ("people_corner", 8.0, 8.0),
        ("people_counterflow", 16.6, 40.0),
        ("people_crossing", 14.0, 1.0),
        ("people_door", 30.5, 55.0),
        ("people_frontal", 5.0, 1.0),
        ("people_group", 2.0, 1.0),
        ("people_overtaking", 1.0, 1.0),
        ("people_parallel", 4.5, 7.0),
        ("people_perpendicular", 7.0, 1.0),
        ("people_queue", 16.0, 3.0),
    ],
)
def test_people_of_a_scene_arrive_without_losing_much_time(name, legs, most_lost):
    """Means of eight runs that differ by millimetres of the comfort distance.

    Encounters change with every detail, and so does the time lost in a single run.
    """
    trial = sim.Trial.load(name)
    runs = []
    for k in range(8):
        manners = [replace(one.manners, comfort=0.1 + 0.002 * k) for one in trial.people]
        pairs = zip(trial.people, manners, strict=True)
        runs.append(sim.run(replace(trial, people=tuple(replace(p, manners=m) for p, m in pairs))))
    assert all(run.summary["overlaps"] == 0 for run in runs)
    assert sum(len(events(run, "arrived")) for run in runs) >= len(runs) * legs
    assert sum(map(lost, runs)) <= len(runs) * most_lost


@pytest.mark.parametrize(
    ("scene", "arguments", "legs", "most_lost"),
    [
        pytest.param(
            two_rooms,
            (15, 1.5, 10.0, 6.0),
            60,
            3300.0,
            id="aisle for two, 15 + 15",
            marks=pytest.mark.slow,
        ),
        pytest.param(
            two_rooms,
            (20, 0.8, 0.2, 7.0),
            80,
            3600.0,
            id="door of 0.8 m, 20 + 20",
            marks=pytest.mark.slow,
        ),
        pytest.param(corridor, (3, 10.0, 1.5), 12, 110.0, id="closed aisle for two, 3 + 3"),
        pytest.param(
            two_rooms,
            (30, 1.5, 10.0, 9.0),
            36,
            15000.0,
            id="aisle for two, 30 + 30",
            marks=pytest.mark.slow,
        ),
    ],
)
def test_a_jam_dissolves(tmp_path, scene, arguments, legs, most_lost):
    run = scene(tmp_path, *arguments)
    assert run.summary["overlaps"] == 0
    assert len(events(run, "arrived")) >= legs
    assert lost(run) <= most_lost


@pytest.mark.slow
def test_an_aisle_for_one_lets_eight_and_eight_pass(tmp_path):
    """Mean of four draws, because one of them may lose twice as much."""
    runs = [two_rooms(tmp_path, 8, 1.0, 10.0, 6.0, draw=draw) for draw in range(1, 5)]
    assert all(run.summary["overlaps"] == 0 for run in runs)
    assert all(len(events(run, "arrived")) == 32 for run in runs)
    assert sum(map(lost, runs)) <= 4 * 900.0


@pytest.mark.slow
def test_all_people_pass_a_corridor(tmp_path):
    """Fifteen people against fifteen in a corridor of 2 x 30 m, within 240 s."""
    run = corridor(tmp_path, 15, 30.0, 2.0)
    assert run.summary["overlaps"] == 0
    assert len(events(run, "arrived")) >= 55
    assert lost(run) <= 3500.0
    assert {event["person"] for event in events(run, "arrived")} == set(run.summary["people"])


@pytest.mark.parametrize(
    ("count", "legs", "most_lost"),
    [
        pytest.param(10, 360, 40.0, id="10"),
        pytest.param(50, 920, 4000.0, id="50", marks=pytest.mark.slow),
    ],
)
def test_a_patrol_keeps_walking(count, legs, most_lost):
    run = sim.run(
        sim.Trial.parse(
            "floorplan: ariac2023\nduration: 275\nrules: observe\nseed: 1\n"
            f"people: [{{name: crew, count: {count}, at: anywhere}}]\n"
        )
    )
    assert run.summary["overlaps"] == 0
    assert len(events(run, "arrived")) >= legs
    assert lost(run) <= most_lost


CORNER = """
floorplan:
  boundary: [[0, 0], [14, 0], [14, 14], [12, 14], [12, 2], [0, 2]]
  stations: {{west: [1, 1], north: [13, 13]}}
  safe_zone: {{at: [1, 1]}}
duration: 60.0
people:
  - {{name: right1, at: [{x}, 1], beliefs: ["bound_for(north)"]}}
  - {{name: right2, at: [{ahead}, 1.1], beliefs: ["bound_for(north)"]}}
  - {{name: left, count: 2, home: [13, 13], beliefs: ["bound_for(west)"]}}
"""


def test_pairs_who_meet_in_a_corner_lose_little_time():
    """Two pairs meet in the corner of a corridor of 2 m, from 24 starts."""
    runs = [
        sim.run(sim.Trial.parse(CORNER.format(x=1.0 + 0.07 * k, ahead=1.65 + 0.09 * k)))
        for k in range(24)
    ]
    assert sum(lost(run) for run in runs) <= 24 * 7.5
