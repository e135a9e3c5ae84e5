"""Doors, zones and temporary obstacles, for people and AGVs."""

import math
import random

import numpy as np
import pytest
import shapely
from run_events import events, record
from small_floors import LANE, on_floor, run_on

import floorplan
import navigation
import sim

TWO_ROOMS = """\
boundary: [[0, 0], [20, 0], [20, 10], [0, 10]]
obstacles:
  south: {x: [9.8, 10.2], y: [0, 2], z: [0, 3]}
  middle: {x: [9.8, 10.2], y: [3.5, 6.5], z: [0, 3]}
  north: {x: [9.8, 10.2], y: [8, 10], z: [0, 3]}
doors:
  lower: {between: [[10, 2], [10, 3.5]]}
  upper: {between: [[10, 6.5], [10, 8]], open: false}
safe_zone: {at: [2, 2.75]}
"""

WITH_CART = TWO_ROOMS.replace("at: [2, 2.75]", "at: [2, 8]") + LANE

GO = "+human_start <- move(18, 2.75, 0).\n+path_blocked(_) <- .wait(500); move(18, 2.75, 0).\n"


@pytest.fixture
def run(tmp_path):
    (tmp_path / "go.asl").write_text(GO)
    return lambda text, floor=TWO_ROOMS: run_on(floor, text, tmp_path)


ALONE = "people: [{name: eve, personality: go.asl}]\n"
PAIR = (
    "people: [{name: eve, personality: go.asl}, {name: max, personality: external, at: [1, 9]}]\n"
)


def nearest(run, body, shape, begin, end, step=0.01):
    """Return the minimum distance from the centre of a body to a shape, sampled."""
    times = np.arange(begin, min(end, run.duration), step)
    return shapely.distance(shape, shapely.points(run.motions[body].position(times))).min()


@pytest.mark.parametrize("people", [ALONE, PAIR])
def test_a_closed_door_is_a_wall_and_an_open_one_is_free(run, people):
    door = floorplan.parse(TWO_ROOMS).doors["lower"].footprint
    through = run(f"duration: 30\n{people}")
    (arrived,) = events(through, "arrived")
    assert arrived["t"] == pytest.approx(16 / 1.0, abs=1.0)
    closed = run(f"duration: 60\ndoors: {{lower: {{closed: [[0, 30]]}}}}\n{people}")
    blocked = events(closed, "path_blocked")[0]
    assert blocked["t"] == 0.0 and "cuts it off" in blocked["message"]
    assert nearest(closed, "eve", door, 0.0, 30.0) >= 0.3 - 1e-6
    assert [e["t"] for e in events(closed, "door_opened")] == [30.0]
    assert events(closed, "arrived")[0]["t"] == pytest.approx(46.5, abs=1.0)
    # The door closes while the person is under way, so the detour is the other door.
    other = run(
        "duration: 60\ndoors: {lower: {closed: [[4]]}, upper: {open: [[0, 60]]}}\n" + people
    )
    assert nearest(other, "eve", door, 4.0, 60.0) >= 0.3 - 1e-6
    assert len(events(other, "arrived")) == 1


@pytest.mark.parametrize("people", [ALONE, PAIR])
def test_a_distant_person_learns_at_once_that_the_path_is_blocked(run, people):
    shut = run(f"duration: 8\ndoors: {{lower: {{closed: [[1]]}}}}\n{people}")
    assert events(shut, "path_blocked")[0]["t"] == pytest.approx(1.0)
    assert shut.motions["eve"].position(8.0)[0] < 4.0


def test_a_distant_person_learns_at_once_that_an_agv_has_stopped_on_the_route(run):
    """The AGV rests beyond the part of the path to which the person is committed."""
    lane = (
        LANE.replace("max_speed: 1.0", "max_speed: 2.0")
        .replace("max_acceleration: 0.5", "max_acceleration: 2.0")
        .replace("middle: 8, east: 16", "east: 2.25")
        .replace("origin: [2, 2.75]", "origin: [11, 5], heading: -1.5707963267948966")
        .replace("limits: [0, 16]", "limits: [0, 3]")
    )
    cart = "agvs: {cart: {moves: [{time: 0.5, to: east}], yield: true}}\n"
    finished = run(f"duration: 6\n{cart}{PAIR}", TWO_ROOMS + lane)
    (drove,) = events(finished, "agv_moved")
    assert drove["arrives"] < 3.0
    assert events(finished, "path_blocked")[0]["t"] == pytest.approx(drove["arrives"], abs=1e-5)


@pytest.mark.parametrize("people", [ALONE, PAIR])
def test_people_avoid_obstacles_while_they_are_there(run, people, tmp_path):
    pallet = "obstacles: {pallet: {x: [5, 6], y: [1, 4], z: [0, 1], there: [[2.0, 30.0]]}}\n"
    finished = run(f"duration: 40\n{people}{pallet}")
    assert nearest(finished, "eve", shapely.box(5, 1, 6, 4), 2.5, 30.0) >= 0.3 - 1e-6
    kinds = [e["kind"] for e in events(finished, "obstacle_came", "obstacle_went", "replanned")]
    assert kinds == ["obstacle_came", "replanned", "obstacle_went"]
    assert len(events(finished, "arrived")) == 1
    record(finished.trial, tmp_path / "run")
    assert sim.load_run(tmp_path / "run").scene == finished.scene and finished.scene.passing


def test_a_person_steps_out_of_an_obstacle_that_is_put_down(run):
    text = "duration: 20\npeople: [{name: eve, personality: go.asl, start: {time: 9}}]\n"
    finished = run(
        text + "obstacles: {box: {x: [1, 2.2], y: [2, 3.5], z: [0, 1], there: [[5, 20]]}}\n"
    )
    assert nearest(finished, "eve", shapely.box(1, 2, 2.2, 3.5), 10.0, 20.0) >= 0.3 - 1e-6


@pytest.mark.parametrize("people", [ALONE, PAIR])
def test_a_zone_is_closed_to_people_for_whom_it_is_forbidden(run, people):
    cell = "zones: {cell: {x: [4, 6], y: [0, 5], forbidden: true, concerns: ['e*']}}\n"
    area = shapely.box(4, 0, 6, 5)
    detour = run(f"duration: 40\n{people}", TWO_ROOMS + cell)
    assert nearest(detour, "eve", area, 0.0, 40.0) >= 0.3 - 1e-6
    assert len(events(detour, "arrived")) == 1
    free = run(f"duration: 40\n{people.replace('eve', 'ann')}", TWO_ROOMS + cell)
    assert nearest(free, "ann", area, 0.0, 40.0) == 0.0
    wall = "zones: {wall: {x: [4, 6], y: [0, 10], forbidden: true}}\n"
    shut = run(f"duration: 5\n{people}", TWO_ROOMS + wall)
    assert "wall cuts it off" in events(shut, "path_blocked")[0]["message"]


@pytest.mark.parametrize(
    "key", ["at: [5, 2]", "home: [5, 2]", "sink: [5, 2]", "source: {at: [5, 2], rate: 1, count: 2}"]
)
def test_a_start_or_exit_in_a_forbidden_zone_is_an_error(run, key):
    cell = "zones: {cell: {x: [4, 6], y: [0, 5], forbidden: true, concerns: ['e*']}}\n"
    place = key.split(":")[0] + (".at" if "source" in key else "")
    with pytest.raises(sim.TrialError, match="zone 'cell'") as error:
        run(f"duration: 5\npeople: [{{name: eve, {key}}}]\n", TWO_ROOMS + cell)
    (problem,) = error.value.problems
    assert problem.field == f"people[0].{place}"
    run(f"duration: 5\npeople: [{{name: ann, {key}}}]\n", TWO_ROOMS + cell)


def speeds_within(motion, area, step=0.005):
    times = np.arange(motion.start, motion.end, step)
    inside = shapely.contains_xy(area, *motion.position(times).T)
    return np.hypot(*motion.velocity(times).T)[inside]


@pytest.mark.parametrize("people", [ALONE, PAIR])
@pytest.mark.parametrize("seed", range(4))
def test_people_keep_the_speed_limit_of_a_zone(run, people, seed):
    rng = random.Random(seed)
    lines, areas = [], []
    for k in range(3):
        x, y = rng.uniform(1, 14), rng.uniform(0, 2.6)
        area = (x, x + rng.uniform(0.1, 4), y, y + rng.uniform(0.2, 4))
        limit = rng.uniform(0.2, 0.9)
        areas.append((shapely.box(area[0], area[2], area[1], area[3]), limit))
        lines.append(f"  z{k}: {{x: {[*area[:2]]}, y: {[*area[2:]]}, max_speed: {limit}}}")
    finished = run(f"duration: 90\n{people}", TWO_ROOMS + "zones:\n" + "\n".join(lines) + "\n")
    walked = finished.motions["eve"]
    assert len(events(finished, "arrived")) == 1
    for area, limit in areas:
        assert (speeds_within(walked, area) <= limit + 1e-6).all()
    times = np.arange(0.0, walked.end, 0.01)
    change = np.hypot(*np.diff(walked.velocity(times), axis=0).T) / 0.01
    assert np.median(change) <= 2.5 and speeds_within(walked, shapely.box(0, 0, 20, 10)).max() > 0.9


def test_agvs_wait_for_obstacles_in_their_way(run):
    moves = "duration: 90\nagvs: {cart: [{time: 1, to: east}, {time: 60, to: west}]}\n"
    text = moves + (
        "doors: {lower: {closed: [[0, 20]]}}\n"
        "obstacles: {pallet: {x: [14, 15], y: [2.5, 3], z: [0, 1], there: [[8, 40]]}}\n"
    )
    finished = run(text, WITH_CART)
    cart, door = finished.motions["cart"], floorplan.parse(TWO_ROOMS).doors["lower"].footprint
    for shape, begin, end in ((door, 0, 20), (shapely.box(14, 2.5, 15, 3), 8, 40)):
        for t in np.arange(begin, end, 0.05):
            x, y = cart.position(t)
            assert not shapely.box(x - 0.6, y - 0.4, x + 0.6, y + 0.4).intersects(shape)
    blocked = events(finished, "agv_blocked")
    assert [e["by"] for e in blocked] == ["lower", "pallet"]
    assert cart.position(58.0)[0] == pytest.approx(18.0)
    assert cart.position(90.0)[0] == pytest.approx(2.0)


def test_agvs_brake_for_new_obstacles_and_slow_down_in_zones(run):
    zone = "zones: {slow: {x: [6, 9], y: [0, 5], max_speed: 0.3, concerns: [cart]}}\n"
    text = (
        "duration: 80\nagvs: {cart: {moves: [{time: 0, to: east}], yield: true}}\n"
        "obstacles: {pallet: {x: [16, 17], y: [2, 3], z: [0, 1], there: [[22, 40]]}}\n"
    )
    finished = run(text, WITH_CART + zone)
    cart = finished.motions["cart"]
    times = np.arange(0.0, 80.0, 0.01)
    x, speed = cart.position(times)[:, 0], np.hypot(*cart.velocity(times).T)
    assert (speed[(x > 5.4) & (x < 9.6)] <= 0.3 + 1e-6).all() and speed.max() > 0.9
    assert (np.abs(np.diff(speed)) <= 0.5 * 0.01 + 1e-6).all()
    there = (times >= 22) & (times < 40)
    assert x[there].max() <= 16 - 0.6 + 1e-6
    assert x[-1] == pytest.approx(18.0) and (cart.rotation(times) == 0.0).all()


def test_a_move_to_nowhere_hides_no_move_into_a_forbidden_zone(run):
    lanes = WITH_CART.replace("[2, 2.75]}}", "[2, 2.75]}, van: {origin: [2, 7.25]}}")
    zone = "zones: {cell: {x: [12, 14], y: [5, 10], forbidden: true, concerns: [van]}}\n"
    moves = "agvs: {cart: [{time: 0, to: nowhere}], van: [{time: 0, to: east}]}\n"
    with pytest.raises(sim.TrialError, match="no location 'nowhere'") as error:
        run("duration: 10\n" + moves, lanes + zone)
    assert "leads into the zone 'cell', forbidden to van" in str(error.value)


def test_a_trial_without_changing_places_has_none():
    run = sim.run(sim.Trial.parse("{floorplan: ariac2023, duration: 1}"))
    assert not run.scene.passing and not run.floorplan.doors


def test_doors_and_zones_are_written_scaled_and_turned(tmp_path):
    plan = floorplan.parse(TWO_ROOMS + "zones: {a: {x: [1, 2], y: [3, 4], max_speed: 0.5}}\n")
    plan.save(tmp_path / "floor.yaml")
    assert floorplan.load(tmp_path / "floor.yaml") == plan
    (tmp_path / "turned.yaml").write_text(
        f"base: floor.yaml\nname: {plan.name}\norigin: [10, 0]\nrotation: {math.pi / 2}\n"
    )
    turned = floorplan.load(tmp_path / "turned.yaml")
    assert np.allclose(turned.doors["lower"].ends, [(-2, 0), (-3.5, 0)])
    assert turned.zones["a"].area.equals(shapely.box(-4, -9, -3, -8))
    assert navigation.CollisionWorld(turned).walkable.area == pytest.approx(200 - 0.4 * 7)


def test_a_leg_past_the_corner_of_a_zone_is_clear_of_it(tmp_path):
    floor = "boundary: [[-9, -9], [20, -9], [20, 20], [-9, 20]]\nsafe_zone: {at: [19, 19]}\n"
    zone = "zones: {slow: {x: [0, 10], y: [0, 10], max_speed: 0.5}}\n"
    start = "duration: 30\npeople: [{name: eve, personality: past.asl, at: [-4, %d]}]\n"

    def walk(floor, y):
        (tmp_path / "past.asl").write_text(f"+human_start <- move(3, {y + 7}, 0).\n")
        return run_on(floor, start % y, tmp_path).motions["eve"]

    # Within the zone's bounds, not in the zone.
    assert walk(floor + zone, 8) == walk(floor, 8)
    slow, free = walk(floor + zone, 4), walk(floor, 4)
    t = np.arange(0.0, slow.end, 0.001)
    x, y = slow.position(t).T
    inside = (x > 0.01) & (y < 9.99)
    assert inside.any() and np.hypot(*slow.velocity(t[inside]).T).max() <= 0.5 + 1e-9
    assert np.hypot(*slow.velocity(t).T).max() == np.hypot(*free.velocity(t).T).max() > 0.9


ROOMS = on_floor(
    """\
boundary: [[0, 0], [12, 0], [12, 6], [0, 6]]
obstacles:
  south: {x: [5.9, 6.1], y: [0, 2.2], z: [0, 3]}
  north: {x: [5.9, 6.1], y: [3.8, 6], z: [0, 3]}
doors: {gate: {between: [[6, 2.2], [6, 3.8]], open: true}}
stations: {east: [11, 3]}
""",
    """\
duration: 20
people: [{name: p, personality: east.asl, count: COUNT, at: [1, 3], max_acceleration: MOST}]
doors: {gate: {closed: [[AT, 19]]}}
""",
)


@pytest.mark.parametrize("count", [1, 6])
@pytest.mark.parametrize("most", [0.8, 2.5])
@pytest.mark.parametrize("at", [5.2, 5.7, 6.0, 6.3, 6.6])
def test_people_do_not_walk_through_a_closed_door(at, most, count, tmp_path):
    """People stop before it if they can. The others leave it soon after."""
    (tmp_path / "east.asl").write_text("+human_start <- move(11, 3, 0).\n")
    text = ROOMS.replace("AT", str(at)).replace("MOST", str(most)).replace("COUNT", str(count))
    if count > 1:
        text = text.replace("at: [1, 3]", "at: anywhere")
    run = sim.run(sim.Trial.parse(text, folder=tmp_path))
    gate = run.trial.floorplan.doors[0].closed.footprint
    t = np.arange(at, 19.0, 0.01)
    for person in run.trial.people:
        motion = run.motions[person.name]
        gap = shapely.distance(shapely.points(motion.position(t)), gate) - 0.3
        could_stop = gap[0] > motion.state(at).speed ** 2 / (2 * most) + 1e-3
        assert gap[t >= (at if could_stop else at + 5.0)].min() > -1e-3
    assert run.summary.get("overlaps", 0) == 0
