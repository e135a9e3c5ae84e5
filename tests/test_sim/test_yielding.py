"""Yielding AGVs: they never come too close by their own motion, and arrive in the end."""

import itertools
import math

import pytest
from hypothesis import given, settings, strategies as st
from run_events import events

import sim

FLOOR = """
boundary: [[0, 0], [30, 0], [30, 16], [0, 16]]
stations: {a: [2, 2], b: [28, 14]}
safe_zone: {at: [1, 15]}
agvs:
  size: [1.2, 0.8]
  height: 1.0
  max_speed: 2.0
  max_acceleration: 2.0
  limits: [0.0, 13.0]
  locations: {near: 0.0, far: 13.0}
  start: near
  lanes:
    one: {origin: [3.0, 5.0], heading: 0.0}
    two: {origin: [20.0, 15.0], heading: -1.5707963267948966}
"""

LAWS = [
    "{iso_ts_15066: {t1: 1.0, t2: 1.5, intrusion: 1.0}}",
    "{iso_ts_15066: {t1: 0.2, t2: 0.3, stopping: 0.3, intrusion: 0.5}}",
    "{iso_ts_15066_integral: {t1: 0.5, t2: 0.5, intrusion: 0.8}}",
    "{iso_13855: {time: 1.0, intrusion: 0.5}}",
    "{fixed: 2.1}",
    "{'steep:Law': {}}",
]

STEEP = """
class Law:
    def distance(self, human_speed, robot_speed):
        return 0.8 + robot_speed**2 + (1.0 if human_speed > 0.5 else 0.0)
"""

places = st.tuples(st.floats(0.5, 29.5), st.floats(0.5, 15.5))
errands = st.lists(st.tuples(st.floats(0, 6), places), min_size=1, max_size=8)
starts = places.filter(lambda at: not (2.3 < at[0] < 3.7 and 4.5 < at[1] < 5.5))
people = st.lists(
    st.tuples(starts, st.floats(0.3, 2.0), errands),
    min_size=1,
    max_size=3,
    # No two people start in one place.
    unique_by=lambda person: (round(person[0][0]), round(person[0][1])),
).filter(
    lambda people: all(
        math.dist(one[0], other[0]) > 0.6 for one, other in itertools.combinations(people, 2)
    )
)
drives = st.lists(st.tuples(st.floats(0, 40), st.floats(0, 13)), min_size=1, max_size=6)


def program(errands):
    steps = "; ".join(
        f".wait({wait * 1000:.0f}); !to({x:.3f}, {y:.3f})" for wait, (x, y) in errands
    )
    return f"!go.\n+!go <- {steps}.\n+!to(X, Y) <- move(X, Y, 0).\n-!to(_, _).\n"


def trial(folder, people, moves, law, yields=True):
    (folder / "floor.yaml").write_text(FLOOR)
    (folder / "steep.py").write_text(STEEP)
    entries = []
    for k, (at, speed, errands) in enumerate(people):
        (folder / f"p{k}.asl").write_text(program(errands))
        entries.append(
            f"{{name: p{k}, personality: p{k}.asl, max_speed: {speed:.4f},"
            f" at: [{at[0]:.4f}, {at[1]:.4f}]}}"
        )
    agvs = [
        f"{name}: {{yield: {str(yields).lower()}, moves: ["
        + ", ".join(f"{{time: {t:.4f}, to: {q:.4f}}}" for t, q in sorted(drives))
        + "]}"
        for name, drives in moves.items()
    ]
    text = (
        f"floorplan: floor.yaml\nduration: 60\nrules: {{agv_law: {law}}}\n"
        f"people: [{', '.join(entries)}]\nagvs: {{{', '.join(agvs)}}}\n"
    )
    return sim.Trial.parse(text, folder=folder)


@settings(max_examples=settings.default.max_examples // 3)
@given(people=people, one=drives, two=drives, law=st.sampled_from(LAWS))
def test_an_agv_that_yields_never_comes_too_close_while_it_moves(
    tmp_path_factory, people, one, two, law
):
    folder = tmp_path_factory.mktemp("yielding")
    run = sim.run(trial(folder, people, {"one": one, "two": two}, law))
    assert events(run, "violation") == []
    assert run.summary["agv_teleports"] == 0


CROSSING = [((11.0, 1.0), 1.0, [(1.0, (11.0, 12.0))])]


def test_an_agv_stops_for_a_crossing_person_and_drives_on(tmp_path):
    law = LAWS[0]
    moves = {"one": [(0.0, 13.0)]}
    careless = sim.run(trial(tmp_path, CROSSING, moves, law, yields=False))
    assert events(careless, "violation")
    run = sim.run(trial(tmp_path, CROSSING, moves, law))
    (yielded,) = events(run, "agv_yielded")
    assert (yielded["agv"], yielded["person"]) == ("one", "p0")
    assert yielded["distance"] > yielded["required"]
    first, second = events(run, "agv_moved")
    assert first["t"] == 0.0
    assert yielded["t"] < second["t"] < 40.0
    agv = run.motions["one"]
    assert agv.state(second["t"] - 1e-6).speed == 0.0
    assert agv.position(60.0) == pytest.approx((16.0, 5.0))
    # The AGV brakes with its maximum deceleration.
    at = agv.state(yielded["t"])
    stopped = yielded["t"] + at.speed / 2.0
    assert agv.state(stopped + 1e-9).speed == 0.0
    assert math.dist(agv.position(stopped), at.at) == pytest.approx(at.speed**2 / 4.0)


def test_an_agv_that_yields_drives_as_any_other_if_no_person_is_near(tmp_path):
    far = [((1.0, 15.0), 1.0, [(0.0, (2.0, 15.0))])]
    moves = {"one": [(0.0, 12.0), (3.0, 4.0)]}
    runs = [sim.run(trial(tmp_path, far, moves, LAWS[4], yields)) for yields in (False, True)]
    assert runs[0].events[1:] == runs[1].events[1:]
    assert runs[0].motions["one"].pieces == runs[1].motions["one"].pieces


def test_an_agv_waits_for_as_long_as_a_person_stands_in_its_way(tmp_path):
    standing = [((11.0, 6.0), 1.0, [(30.0, (29.0, 15.0))])]
    run = sim.run(trial(tmp_path, standing, {"one": [(0.0, 13.0)]}, LAWS[4]))
    assert events(run, "violation") == []
    assert len(events(run, "agv_yielded")) == 1
    waited = run.motions["one"].state(29.0)
    assert waited.speed == 0.0
    assert 11.0 - waited.at[0] > 2.1
    assert run.motions["one"].position(60.0) == pytest.approx((16.0, 5.0))


def test_a_drive_to_another_place_replaces_the_waiting_one(tmp_path):
    standing = [((11.0, 6.0), 1.0, [(50.0, (29.0, 15.0))])]
    moves = {"one": [(0.0, 13.0), (20.0, 1.0)]}
    run = sim.run(trial(tmp_path, standing, moves, LAWS[4]))
    assert events(run, "violation") == []
    assert run.motions["one"].position(40.0) == pytest.approx((4.0, 5.0))
