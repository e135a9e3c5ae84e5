"""People among people: no two of them overlap, and all of them arrive."""

from __future__ import annotations

import dataclasses
import itertools
import math
import random
from collections import Counter
from collections.abc import Iterator
from dataclasses import replace

import numpy as np
import pytest
from run_events import events

import floorplan
import navigation
import sim

GO = """
+human_start <- !next.
+!next : todo([g(X, Y) | T]) <- -+todo(T); move(X, Y, 0).
+!next <- +done.
+work_completed(_) <- !next.
"""

Place = tuple[float, float]


def hall(width: float, depth: float, *walls: tuple[float, float, float, float]) -> str:
    """Return a floor of one room with walls in it, each from x0, y0 to x1, y1."""
    lines = [f"boundary: [[0, 0], [{width}, 0], [{width}, {depth}], [0, {depth}]]"]
    if walls:
        lines.append("obstacles:")
    for k, (x0, y0, x1, y1) in enumerate(walls):
        lines.append(f"  wall{k}: {{x: [{x0}, {x1}], y: [{y0}, {y1}], z: [0, 2]}}")
    return "\n".join(lines)


@pytest.fixture
def walks(tmp_path):
    """Return a function that runs people who walk from each start to their goals on a floor."""
    (tmp_path / "go.asl").write_text(GO)

    def run(
        floor: str,
        ways: list[tuple[Place, list[Place]]],
        duration: float = 120.0,
        speeds: list[float] | None = None,
        manners: dict | None = None,
        **more,
    ):
        usual = sim.PersonEntry(name="p").manners
        people = tuple(
            sim.PersonEntry(
                name=f"p{k}",
                personality="go.asl",
                at=at,
                beliefs=("todo([" + ", ".join(f"g({x:.9f}, {y:.9f})" for x, y in goals) + "])",),
                max_speed=speeds[k] if speeds else None,
                manners=replace(usual, **(manners or {})),
                **more,
            )
            for k, (at, goals) in enumerate(ways)
        )
        trial = sim.Trial(
            floorplan=floorplan.parse(floor), people=people, duration=duration, folder=tmp_path
        )
        return sim.run(trial)

    return run


def places(rng: random.Random, count: int, low: Place, high: Place, apart: float) -> list[Place]:
    chosen: list[Place] = []
    while len(chosen) < count:
        place = (rng.uniform(low[0], high[0]), rng.uniform(low[1], high[1]))
        if all(math.dist(place, other) > apart for other in chosen):
            chosen.append(place)
    return chosen


def pairs(run: sim.Run) -> Iterator[tuple[navigation.Motion, navigation.Motion]]:
    return itertools.combinations([run.motions[name] for name in run.summary["people"]], 2)


def least(run: sim.Run) -> float:
    """Return the minimum distance between two centres, by the exact monitor."""
    return min(navigation.minimum_separation(a, b, 0.0, run.duration)[1] for a, b in pairs(run))


def sampled(run: sim.Run) -> float:
    """Return the minimum distance between two centres, sampled every 10 ms."""
    t = np.arange(0.0, run.duration, 0.01)
    at = [run.motions[name].position(t) for name in run.summary["people"]]
    return min(float(np.hypot(*(a - b).T).min()) for a, b in itertools.combinations(at, 2))


def through_walls(run: sim.Run, radius: float = 0.3) -> list[str]:
    """Return the people who came closer to a wall than their radius."""
    plan = run.trial.floorplan
    world = navigation.CollisionWorld(plan).as_if(away=[lane.name for lane in plan.lanes])
    close = []
    for name in run.summary["people"]:
        begin, end = run.presence[name]
        ends = [piece.end for piece in run.motions[name].pieces if begin <= piece.end < end]
        line = run.motions[name].position(np.array([begin, *ends]))
        if world.clearance(line) < radius - 1e-6:
            close.append(name)
    return close


def arrived(run: sim.Run) -> set[str]:
    return {event["person"] for event in events(run, "arrived")}


def turns_in_a_second(run: sim.Run) -> int:
    """Return the maximum number of turns of a person by 5 degrees or more within a second."""
    most = 0
    for name in run.summary["people"]:
        pieces = run.motions[name].pieces
        turns = [
            after.begin
            for before, after in itertools.pairwise(pieces)
            if abs(math.remainder(after.rotation[0] - before.rotation[0], math.tau)) > 0.09
        ]
        most = max([most, *(sum(t <= other < t + 1.0 for other in turns) for t in turns)])
    return most


def head_on(width: float) -> tuple[str, list[tuple[Place, list[Place]]]]:
    floor, y = hall(24, width), width / 2
    return floor, [((1, y), [(23, y)]), ((23, y), [(1, y)])]


def narrow(inside: bool) -> tuple[str, list[tuple[Place, list[Place]]]]:
    floor = hall(22, 6, (6, 0, 16, 2.5), (6, 3.5, 16, 6))
    left, right = ((10, 3), (12, 3)) if inside else ((3, 3), (19, 3))
    return floor, [(left, [(20, 3)]), (right, [(2, 3)])]


def circle(count: int) -> tuple[str, list[tuple[Place, list[Place]]]]:
    around = [
        (8 + 6 * math.cos(a), 8 + 6 * math.sin(a))
        for a in (2 * math.pi * k / count for k in range(count))
    ]
    return hall(16, 16), [((x, y), [(16 - x, 16 - y)]) for x, y in around]


def rooms(
    seed: int, count: int, gap: float, thickness: float
) -> tuple[str, list[tuple[Place, list[Place]]]]:
    """Return two rooms with a gap between them, and `count` people in each bound for the other."""
    rng, width, depth = random.Random(seed), 12.0 + thickness, 6.0
    left, right = 6.0, 6.0 + thickness
    floor = hall(width, depth, (left, 0, right, 3 - gap / 2), (left, 3 + gap / 2, right, depth))
    west = ((0.4, 0.4), (5.0, 5.6))
    east = ((right + 1.0, 0.4), (width - 0.4, 5.6))
    ways = []
    for here, there in ((west, east), (east, west)):
        starts, goals = (places(rng, count, *room, apart=0.65) for room in (here, there))
        ways += [(a, [b]) for a, b in zip(starts, goals, strict=True)]
    return floor, ways


SCENES = {
    "head-on in a corridor": (head_on(3.0), 1.0),
    "head-on in an aisle": (head_on(1.5), 1.0),
    "crossing at a right angle": (
        (hall(12, 12), [((1, 6), [(11, 6)]), ((6, 1), [(6, 11)])]),
        1.0,
    ),
    "head-on where two can't pass": (narrow(inside=False), 20.0),
    "head-on within it": (narrow(inside=True), 20.0),
    "circle of eight": (circle(8), 15.0),
    "door, three from each side": (rooms(1, 3, 0.8, 0.2), 25.0),
    "narrow aisle, two from each side": (rooms(2, 2, 1.0, 6.0), 40.0),
}


@pytest.mark.parametrize("name", SCENES)
def test_all_people_arrive_without_overlaps(walks, name):
    (floor, ways), most_lost = SCENES[name]
    run = walks(floor, ways)
    assert arrived(run) == set(run.summary["people"])
    assert least(run) >= 0.6 and sampled(run) >= 0.6
    assert through_walls(run) == []
    ends = {event["person"]: event["t"] for event in events(run, "arrived")}
    world = navigation.CollisionWorld(run.trial.floorplan)
    planner = navigation.PathPlanner(world, 0.3)
    for k, (at, goals) in enumerate(ways):
        alone = navigation.walk(planner.plan(at, goals[0]).points).end
        assert ends[f"p{k}"] < alone + most_lost


def test_people_do_not_shiver(walks):
    (floor, ways), _ = SCENES["circle of eight"]
    assert turns_in_a_second(walks(floor, ways)) <= 4  # two courses, each with a turn


def test_people_change_course_at_most_twice_per_second(walks):
    """This includes a person who has just given way, and resumes together with the other one."""
    run = walks(*rooms(7, 10, 0.8, 0.2), 40.0)
    again = sim.Simulation(run.trial)
    changes: dict[str, list[float]] = {person.name: [] for person in again.people}
    for person in again.people:
        times = changes[person.name]
        person.body.on_change.append(lambda times=times: times.append(again.clock.now))
    again.advance(40.0)
    assert sum(map(len, changes.values())) > 100
    for times in changes.values():
        assert all(
            third - first >= 1.0 - 1e-9 for first, third in zip(times, times[2:], strict=False)
        )


def scene(seed: int) -> tuple[str, list[tuple[Place, list[Place]]]]:
    """Return a random floor with random people. A person alone can reach each place."""
    rng = random.Random(seed)
    if rng.random() < 0.4:
        return rooms(
            seed, rng.randint(1, 4), rng.choice([0.8, 1.0, 1.5, 3.0]), rng.choice([0.2, 3])
        )
    walls = []
    for _ in range(rng.randint(0, 4)):
        x, y = rng.uniform(2, 9), rng.uniform(2, 9)
        walls.append((x, y, x + rng.uniform(0.3, 2), y + rng.uniform(0.3, 2)))
    floor = hall(13, 13, *walls)
    world = navigation.CollisionWorld(floorplan.parse(floor))
    count, space = rng.randint(2, 10), world.free_space(0.3)
    starts: list[Place] = []
    goals: list[Place] = []
    while len(goals) < count:
        for chosen in (starts, goals):
            while True:
                at = (rng.uniform(0.35, 12.65), rng.uniform(0.35, 12.65))
                if (
                    all(math.dist(at, other) > 0.65 for other in chosen)
                    and world.free(at, 0.31)
                    and (not starts or space.together(at, starts[0]))
                ):
                    chosen.append(at)
                    break
    return floor, [(a, [b, a]) for a, b in zip(starts, goals, strict=True)]


@pytest.mark.parametrize(
    "seed",
    [
        *range(12),
        *(pytest.param(seed, marks=pytest.mark.slow) for seed in range(12, 212)),
    ],
)
def test_random_people_never_overlap_and_arrive(walks, seed):
    floor, ways = scene(seed)
    run = walks(floor, ways, 200.0)
    assert least(run) >= 0.6 and sampled(run) >= 0.6
    assert through_walls(run) == []
    assert arrived(run) == set(run.summary["people"])


@pytest.mark.parametrize("abreast", [1, 4, 5])
def test_a_faster_person_overtakes_people_who_walk_abreast(walks, abreast):
    slow = [(3.0, 4.0 + 0.65 * (k - (abreast - 1) / 2)) for k in range(abreast)]
    ways = [((1.0, 4.0), [(29.0, 4.0)]), *((at, [(28.0, at[1])]) for at in slow)]
    run = walks(hall(30, 8), ways, 80.0, speeds=[1.0, *(0.4 for _ in slow)])
    ends = {event["person"]: event["t"] for event in events(run, "arrived")}
    assert ends["p0"] < 28.0 / 1.0 + 5.0


def test_a_person_arrives_on_stopping_beside_an_occupied_goal(walks):
    run = walks(hall(12, 8), [((1.0, 4.0), [(8.0, 4.0)]), ((8.0, 4.0), [])], 20.0)
    (arrival,) = events(run, "arrived", person="p0")
    comes_to_rest = run.motions["p0"].pieces[-1].begin
    assert comes_to_rest <= arrival["t"] < comes_to_rest + 0.3


def test_time_passes_between_two_taken_goals_within_reach_of_each_other(walks):
    """A person between them is beside each, but starts for the other first."""
    goals = [(5.2, 4.0), (6.8, 4.0)]
    ways = [((6.0, 3.0), goals * 5), *((at, []) for at in goals)]
    run = walks(hall(12, 8), ways, 60.0, manners={"reaction_time": 0.4})
    arrivals = [event["t"] for event in events(run, "arrived", person="p0")]
    assert len(arrivals) == 10
    assert min(np.diff(arrivals)) > 0.39


@pytest.mark.parametrize("speed", [0.2, 0.8])
def test_the_distance_in_a_single_file_grows_with_the_speed(walks, speed):
    """Each takes up 0.36 m and 1.06 s times the speed (Seyfried et al. 2005), within 15 %."""
    floor = "human: {radius: 0.2, max_speed: 1.34}\n" + hall(24, 0.7)
    ways = [((7.0 - 1.2 * k, 0.35), [(23.0 - k, 0.35)]) for k in range(4)]
    speeds = [speed, 1.34, 1.34, 1.34]
    run = walks(floor, ways, 10.0 / speed, speeds=speeds)
    t = np.linspace(0.8 * run.duration, run.duration, 50)
    x = np.array([run.motions[f"p{k}"].position(t)[:, 0] for k in range(4)])
    assert float(np.mean(-np.diff(x, axis=0))) == pytest.approx(0.36 + 1.06 * speed, rel=0.15)


def test_a_full_corridor_takes_up_its_width(walks):
    """One person/m² in files 0.93 m apart walk at Weidmann's speed (1993), within 20 %."""
    rng = random.Random(1)
    starts = [(0.5 + 1.07 * (c + r % 2 / 2), 0.6 + 0.93 * r) for c in range(16) for r in range(4)]
    speeds = [min(max(rng.gauss(1.34, 0.26), 0.6), 2.0) for _ in starts]
    floor = "human: {radius: 0.2, max_speed: 1.34}\n" + hall(40, 4)
    run = walks(floor, [((x, y), [(39, y)]) for x, y in starts], 8.0, speeds=speeds)
    assert least(run) >= 0.4
    t = np.linspace(3.0, 8.0, 50)
    middle = [k for k, (x, _) in enumerate(starts) if x < 10.0]
    means = [np.hypot(*run.motions[f"p{k}"].velocity(t).T).mean() for k in middle]
    weidmann = 1.34 * (1 - math.exp(-1.913 * (1 / 1.0 - 1 / 5.4)))
    assert float(np.mean(means)) == pytest.approx(weidmann, rel=0.2)


def test_many_people_who_meet_in_a_corridor_pass_each_other_one_by_one(walks):
    """Past the first of them, there is less room than people look ahead.

    The mean arrival of several draws is compared, because single draws lie 10 s apart.
    """
    ends = []
    for seed in range(4):
        rng = random.Random(seed)
        west, east = (places(rng, 9, (x, 0.35), (x + 5.0, 2.65), 0.65) for x in (0.5, 18.5))
        ways = [((x, y), [(x + 18, y)]) for x, y in west] + [
            ((x, y), [(x - 18, y)]) for x, y in east
        ]
        run = walks(hall(24, 3), ways)
        assert least(run) >= 0.6
        ends += [event["t"] for event in events(run, "arrived")]
    assert len(ends) == 4 * 18
    assert float(np.mean(ends)) < 35.0  # 18 s alone


@pytest.mark.parametrize("apart", [0.601, 0.606, 0.65])
@pytest.mark.parametrize("angle", [0.0, 0.5, 2.5, 4.0])
def test_two_people_back_to_back_walk_away_from_each_other(walks, apart, angle):
    c, s = math.cos(angle), math.sin(angle)
    starts = [(10, 10), (10 + apart * c, 10 + apart * s)]
    run = walks(
        hall(20, 20),
        [(starts[0], [(10 - 8 * c, 10 - 8 * s)]), (starts[1], [(10 + 8 * c, 10 + 8 * s)])],
    )
    assert [event["t"] < 8.5 for event in events(run, "arrived")] == [True, True]
    assert least(run) == pytest.approx(apart, abs=1e-6)


def test_a_crowd_around_a_goal_dissolves(walks):
    """Fifteen people go to one place and back. Later ones arrive at the edge of the others."""
    _, ways = circle(15)
    run = walks(hall(16, 16), [(start, [(8, 8), start]) for start, _ in ways], 90.0)
    assert len(events(run, "arrived")) == 30
    assert least(run) >= 0.6


COLUMNS = [(x, y, x + 1, y + 1) for x in range(2, 19, 3) for y in range(2, 12, 3)]


@pytest.mark.parametrize(
    ("floor", "start", "goal", "stands"),
    [
        pytest.param(hall(13, 13), (10.2, 1.7), (11.38, 2.66), (11.96, 2.6), id="at the goal"),
        pytest.param(
            hall(20, 14, *COLUMNS), (7.5, 6.8), (17.3, 0.8), (9.1, 6.4), id="at a bend of the path"
        ),
        pytest.param(
            hall(20, 14, *COLUMNS), (12, 7.2), (7.2, 10), (10.6, 8.6), id="beside a gap of the path"
        ),
    ],
)
def test_people_do_not_walk_to_and_fro_in_front_of_a_stationary_person(
    walks, floor, start, goal, stands
):
    run = walks(floor, [(start, [goal]), (stands, [])], 40.0)
    assert arrived(run) == {"p0"}
    assert least(run) >= 0.6


def test_three_and_three_people_pass_each_other_between_the_ends_of_an_aisle(walks):
    """Two people can pass only close to the walls, so people who need room move to a wall
    themselves.
    """
    west = [(0.6, 1.01), (1.5, 0.56), (2.4, 0.88)]
    east = [(13.0, 1.01), (12.1, 0.56), (11.2, 0.88)]
    goals = [(13.4, 0.73), (12.5, 0.96), (11.6, 0.65), (1.1, 1.01), (2.0, 0.56), (2.9, 0.88)]
    ways = [(start, [goal]) for start, goal in zip(west + east, goals, strict=True)]
    run = walks(hall(14, 1.5), ways)
    assert least(run) >= 0.6
    assert arrived(run) == set(run.summary["people"])


@pytest.mark.parametrize(
    "seed",
    [
        pytest.param(2, id="a person who gives up a detour does not follow its turns"),
        pytest.param(3, id="an arch before it opens"),
    ],
)
def test_a_crowd_gets_through_a_door(walks, seed):
    rng = random.Random(seed)
    starts = places(rng, 24, (0.4, 0.4), (7.0, 7.6), 0.65)
    goals = places(rng, 24, (9.2, 0.4), (15.8, 7.6), 0.65)
    floor = hall(16.2, 8, (8, 0, 8.2, 3.5), (8, 4.5, 8.2, 8))
    run = walks(floor, [(a, [b]) for a, b in zip(starts, goals, strict=True)])
    assert least(run) >= 0.6
    assert arrived(run) == set(run.summary["people"])


@pytest.mark.parametrize(
    "seed",
    [
        pytest.param(12, id="no person enters behind others while a person inside approaches"),
        pytest.param(7, id="people at the entrance make way for people inside"),
    ],
)
def test_ten_people_from_either_side_get_through_an_aisle_for_two(walks, seed):
    floor, ways = rooms(seed, 10, 1.5, 3.0)
    run = walks(floor, ways, 100.0)
    assert least(run) >= 0.6
    assert arrived(run) == set(run.summary["people"])


@pytest.mark.parametrize("seed", [91, pytest.param(92, marks=pytest.mark.slow)])
def test_a_crowd_in_an_aisle_for_two_dissolves(walks, seed):
    """The highest ranks may be in its middle, where only the others can back out."""
    rng = random.Random(seed)
    floor = hall(22, 9, (9.5, 0, 12.5, 3.75), (9.5, 5.25, 12.5, 9))

    def anywhere() -> list[Place]:
        chosen: list[Place] = []
        while len(chosen) < 44:
            x, y = rng.uniform(0.4, 21.6), rng.uniform(0.4, 8.6)
            if not 9.1 <= x <= 12.9 and all(math.dist((x, y), other) > 0.65 for other in chosen):
                chosen.append((x, y))
        return chosen

    ways = [
        (start, [*goals]) for start, *goals in zip(*(anywhere() for _ in range(3)), strict=True)
    ]
    run = walks(floor, ways, 400.0)
    assert least(run) >= 0.6
    assert Counter(event["person"] for event in events(run, "arrived")) == dict.fromkeys(
        run.summary["people"], 2
    )


def test_a_person_stops_behind_another_who_blocks_an_aisle(walks):
    ways = [((1, 0.35), [(15, 0.35)]), ((8, 0.35), [])]
    run = walks(hall(16, 0.7), ways, 40.0, manners={"steps_aside": False})
    assert 0.6 <= math.dist(*(run.motions[name].position(40.0) for name in ("p0", "p1"))) < 0.9


def test_the_same_people_walk_the_same_again(walks):
    floor, ways = scene(3)
    one, again = walks(floor, ways, 40.0), walks(floor, ways, 40.0)
    assert one.events == again.events
    for name, motion in one.motions.items():
        assert tuple(motion.pieces) == tuple(again.motions[name].pieces)


def test_a_safe_zone_has_room_for_several():
    people = "".join(f"  - {{name: p{k}}}\n" for k in range(5))
    run = sim.run(
        sim.Trial.parse(f"floorplan: ariac2023\nduration: 60\nrules: observe\npeople:\n{people}")
    )
    assert least(run) >= 0.6
    assert all(person["visits"] for person in run.summary["people"].values())


def test_the_summary_has_the_minimum_distance_of_people(walks):
    floor, ways = scene(8)
    run = walks(floor, ways, 60.0)
    nearest = run.summary["nearest_people"]
    radii = sum(one.radius for one in run.scene.people if one.name in nearest["between"])
    centres = run.distance(*nearest["between"], nearest["time"])
    assert centres - radii == pytest.approx(nearest["distance"], abs=1e-6)
    assert nearest["distance"] == pytest.approx(least(run) - 0.6, abs=1e-8)
    one, other = (run.motions[name].position(nearest["time"]) for name in nearest["between"])
    assert math.dist(one, other) == pytest.approx(least(run), abs=1e-6)
    assert run.summary["overlaps"] == run.summary["deadlocks"] == 0


NICHE = """
floorplan:
  boundary: [[0, 0], [12, 0], [12, 1.2], [7.5, 1.2], [7.5, 2.4], [6, 2.4], [6, 1.2], [0, 1.2]]
  stations: {{west: [1, 0.6], east: [11, 0.6]}}
duration: 60
people:
  - {{name: ada, at: [1, 0.6], beliefs: ["bound_for(east)"]}}
  - {{name: late, at: [6.75, 0.6], start: {{time: {start}}}, personality: external}}
"""


@pytest.mark.parametrize("start", [50.0, 7.0])
def test_steps_before_the_start_are_not_walked(start):
    """A person gives way before their start, or starts in the middle of the step aside."""
    run = sim.run(sim.Trial.parse(NICHE.format(start=start)))
    (aside,) = (e["t"] for e in run.events if e["kind"] == "gave_way")
    before, after = run.motions["late"].position([start, run.duration])
    assert aside < start and (start > 10.0 or math.dist(before, after) > 0.2)
    figures = run.summary["people"]["late"]
    assert figures["distance_walked"] == pytest.approx(math.dist(before, after), abs=1e-6)
    assert figures["distance_walked"] == run.metrics["people"]["late"]["path_length"]


def test_people_who_can_go_nowhere_are_blocked_and_a_deadlock(walks):
    # Two people at the ends of a closed single-file aisle swap places. Three stand between them.
    floor, y = hall(7, 0.7), 0.35
    ways = [((x, y), [(goal, y)]) for x, goal in ((0.4, 6.6), (2.5, 2.5), (3.5, 3.5), (4.5, 4.5))]
    run = walks(floor, [*ways, ((6.6, y), [(0.4, y)])], 60.0)
    assert {event["person"] for event in events(run, "blocked")} == {"p0", "p4"}
    (deadlock,) = events(run, "deadlock")
    assert deadlock["people"] == ["p0", "p4"]
    # No person moves after 2 s, and blocked people decide every 8 s.
    assert 30.0 <= deadlock["t"] <= 40.0
    assert run.summary["deadlocks"] == 1
    assert run.summary["people"]["p0"]["time_lost_to_others"] > 20
    assert least(run) >= 0.6


def test_a_person_takes_another_aisle_if_one_is_full(walks):
    # Two aisles lead on. A person who does not step aside stands in the nearer one.
    floor = hall(16, 8, (5, 0, 11, 1.5), (5, 2.5, 11, 5.5), (5, 6.5, 11, 8))
    ways = [((2, 2), [(14, 2)]), ((8, 2), [])]
    run = walks(floor, ways, 60.0, manners={"steps_aside": False})
    assert [event["person"] for event in events(run, "arrived") if event["t"] < 40] == ["p0"]
    assert least(run) >= 0.6 and through_walls(run) == []


CREW = """
floorplan: ariac2023
duration: 20
rules: observe
seed: {seed}
people:
  - {{name: crew, count: 8, at: anywhere, manners: {{comfort: [0.05, 0.2]}}}}
  - {{name: guest}}
"""


def test_a_crew_is_spread_from_the_seed():
    runs = [sim.run(sim.Trial.parse(CREW.format(seed=seed))) for seed in (1, 1, 2)]
    starts = [
        {name: tuple(run.motions[name].position(0.0)) for name in run.summary["people"]}
        for run in runs
    ]
    assert list(starts[0]) == [*(f"crew{k}" for k in range(1, 9)), "guest"]
    assert starts[0] == starts[1] and starts[0]["crew3"] != starts[2]["crew3"]
    for run in runs:
        assert least(run) >= 0.6 and run.summary["overlaps"] == 0
        assert through_walls(run) == []
    trial = sim.Trial.parse(CREW.format(seed=1))
    assert sim.Trial.parse(trial.to_yaml()).people == trial.people


@pytest.mark.parametrize(
    ("person", "says"),
    [
        ("{name: b, at: [-5.2, 0]}", "line 5, people[1].at: .* is 0.2 m from where a starts"),
        ("{name: b, count: 3, manners: {comfort: -1}}", r"line 5, people[1].manners.comfort"),
        ("{name: b, count: 2, manners: {patience: [3, 2]}}", r"line 5, people[1].manners.pati"),
        ("{name: b, count: 0}", r"line 5, people[1].count"),
        ("{name: b, count: 3000, at: anywhere}", "line 3, people: 3001 people don't fit"),
        ("{name: b, count: 500}", "no room for b"),
    ],
)
def test_impossible_people_are_rejected_before_the_run(person, says):
    text = f"floorplan: ariac2023\nduration: 5\npeople:\n  - {{name: a, at: [-5, 0]}}\n  - {person}"
    with pytest.raises(sim.TrialError, match=says.replace("people[1]", r"people\[1\]")):
        sim.Simulation(sim.Trial.parse(text))


def test_agents_know_the_positions_of_others(walks, tmp_path):
    (tmp_path / "look.asl").write_text(
        '+human_start <- .wait(1000); ?person(N, X, Y, V); .print(N, " ", X, " ", Y).'
    )
    trial = sim.Trial(
        floorplan=floorplan.parse(hall(6, 6)),
        people=(
            sim.PersonEntry(name="a", personality="look.asl", at=(1, 1)),
            sim.PersonEntry(name="b", personality="look.asl", at=(4, 2)),
        ),
        duration=3,
        folder=tmp_path,
    )
    assert [event["text"] for event in events(sim.run(trial), "said")] == ["b 4 2", "a 1 1"]


OWN = """
import navigation


class Reckless:
    def replan(self, body, neighbours, outlook):
        return outlook.wish


class Broken:
    def replan(self, body, neighbours, outlook):
        return outlook.nothing


class Abrupt:
    def replan(self, body, neighbours, outlook):
        walks = body.body.state.speed > 0
        return navigation.standing(body.body.at, start=outlook.now) if walks else outlook.wish


class Empty:
    pass
"""


def own(tmp_path, name):
    (tmp_path / "mine.py").write_text(OWN)
    text = "floorplan: ariac2023\nduration: 40\nrules: observe\npeople: [{name: a, count: 5}]\n"
    return sim.Trial.parse(f'{text}steering: "mine:{name}"', folder=tmp_path)


def test_people_never_overlap_with_a_custom_steering(tmp_path):
    run = sim.run(own(tmp_path, "Reckless"))
    assert least(run) >= 0.6 and all(run.motions[name].end > 5 for name in run.summary["people"])
    assert run.events != sim.run(dataclasses.replace(run.trial, steering=None)).events
    written = run.trial.to_yaml(folder=tmp_path)
    assert sim.Trial.parse(written, folder=tmp_path).steering == "mine:Reckless"


def test_an_invalid_steering_is_an_error(tmp_path):
    with pytest.raises(ValueError, match=r"a1 at t = 0 s \(mine.py, line 12\): Attribute"):
        sim.run(own(tmp_path, "Broken"))
    with pytest.raises(ValueError, match=r"its motion must begin at 1 m/s, not 0 m/s"):
        sim.run(own(tmp_path, "Abrupt"))
    with pytest.raises(sim.TrialError, match=r"line 5, steering: the steering .*Missing"):
        own(tmp_path, "Missing")
    empty = own(tmp_path, "Empty")
    with pytest.raises(sim.TrialError, match=r"\(mine.py, line \d+\) is no steering: a steering"):
        sim.run(empty)


@pytest.mark.parametrize(
    "name",
    [
        "people_frontal",
        "people_crossing",
        "people_aisle",
        pytest.param("people_door", marks=pytest.mark.slow),
        pytest.param("people_counterflow", marks=pytest.mark.slow),
        "people_overtaking",
        "people_corner",
        "people_group",
        "people_queue",
        pytest.param("people_bottleneck", marks=pytest.mark.slow),
        "people_parallel",
        "people_perpendicular",
        "people_blind_spot",
    ],
)
def test_the_built_in_scenes_meet_their_expectations(name):
    run = sim.run(sim.Trial.load(name))
    assert run.unmet == [] and least(run) >= 0.6 and through_walls(run) == []


def test_a_goal_replaced_on_the_last_metres_is_not_reached(tmp_path):
    """Another person follows too closely to turn round, so the motion to the old goal stays."""
    (tmp_path / "back.asl").write_text("+human_start <- move(11, 0.5); .wait(8700); move(1, 0.5).")
    (tmp_path / "on.asl").write_text("+human_start <- move(10.2, 0.5).")
    (tmp_path / "t.trial.yaml").write_text(
        "floorplan: {boundary: [[0, 0], [12, 0], [12, 1], [0, 1]]}\n"
        "duration: 12\n"
        "people:\n"
        "  - {name: ada, personality: back.asl, at: [2, 0.5]}\n"
        "  - {name: bob, personality: on.asl, at: [1.2, 0.5]}\n"
    )
    run = sim.run(sim.Trial.load(tmp_path / "t.trial.yaml"))
    assert math.dist(run.motions["ada"].position(9.5), (11.0, 0.5)) < 1e-6
    assert [event["person"] for event in events(run, "arrived")] == ["bob"]
