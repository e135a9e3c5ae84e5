"""Vehicles that drive freely in trials: missions, controllers, twists and invalid keys."""

import math
import textwrap

import numpy as np
import pytest
import shapely
from run_events import events, record

import floorplan
import navigation
import sim
from floorplan import InputError

LONG = """
floorplan: warehouse
duration: {duration}
seed: 1
rules: observe
people: {people}
machines:
  fork:
    kind: amr
    at: [8.5, 10.0, 1.5708]
    size: [2.4, 0.8]
    {more}
"""


def long_vehicle(more, *, duration=60.0, people="[]", folder="."):
    """A trial with a vehicle of 2.4 × 0.8 m in an aisle of the warehouse."""
    text = LONG.format(more=more, duration=duration, people=people)
    return sim.Trial.parse(text, folder=folder)


def problems(text):
    """Return the problems of the trial in a text, with their fields."""
    with pytest.raises(InputError) as why:
        sim.Trial.parse(text)
    return [(problem.field, problem.message) for problem in why.value.problems]


def test_missions_are_done_in_order_without_contacts():
    missions = "missions: [{go: aisle3}, {wait: 2.0}, {go: [3.0, 5.0, 0.5]}, {turn: -1.0}]"
    run = sim.run(long_vehicle(missions, duration=90.0))
    assert [event["job"] for event in events(run, "job_done")] == ["go", "wait", "go", "turn"]
    went, waited, *_ = events(run, "job_done")
    assert went["to"] == "aisle3" and waited["t"] - went["t"] == pytest.approx(2.0)
    motion = run.motions["fork"]
    *_, last = motion.pieces
    assert motion.position(went["t"]) == pytest.approx([16.5, 6.0], abs=1e-6)
    assert motion.position(last.end) == pytest.approx([3.0, 5.0], abs=1e-6)
    assert math.remainder(motion.rotation(last.end) + 1.0, math.tau) == pytest.approx(0, abs=1e-6)
    free = navigation.CollisionWorld(floorplan.load("warehouse"), top=0.4).walkable.buffer(1e-6)
    shape = run.scene.machine("fork")
    for t in np.arange(0.0, motion.end, 0.1):
        assert free.covers(shape.footprint(motion.state(t).at, float(motion.rotation(t))))
    assert run.summary["machines"]["fork"]["jobs_done"] == 4


def test_rounds_begin_at_intervals_or_at_once():
    every = sim.run(long_vehicle("missions: [{wait: 3.0}]\n    every: 20.0"))
    assert [event["t"] for event in events(every, "job_started")] == [0.0, 20.0, 40.0]
    at_once = sim.run(long_vehicle("missions: [{wait: 3.0}]\n    repeat: true", duration=10.0))
    assert [event["t"] for event in events(at_once, "job_started")] == [0.0, 3.0, 6.0, 9.0]


@pytest.mark.parametrize("controller", ["pausing", "avoiding"])
def test_a_cautious_vehicle_keeps_the_distance_by_its_own_motion(controller):
    people = "[{name: ann, at: [20.5, 2.0]}]"
    more = f"controller: {controller}\n    missions: [{{go: [12.5, 17.5]}}, {{go: [3.0, 5.0]}}]"
    run = sim.run(long_vehicle(more + "\n    repeat: true", duration=200.0, people=people))
    assert run.summary["machines"]["fork"]["jobs_done"] >= 2
    assert navigation.minimum_separation(run.motions["ann"], run.motions["fork"], 0, 200)[1] < 8
    assert events(run, "violation", **{"with": "fork"}) == []
    assert {event["machine"] for event in events(run, "gantry_yielded", "job_done")} == {"fork"}


def test_a_vehicle_passes_a_stationary_one(tmp_path):
    text = """
    floorplan: warehouse
    duration: 60
    rules: observe
    machines:
      fork: {kind: amr, at: [8.5, 2.0, 0.0], size: [2.4, 0.8], missions: [{go: [20.5, 2.0]}]}
      parked: {kind: amr, at: [14.5, 2.0, 0.0], size: [1.2, 0.8]}
    """
    run = sim.run(sim.Trial.parse(textwrap.dedent(text)))
    assert run.summary["collisions"] == 0
    (done,) = events(run, "job_done")
    assert run.motions["fork"].position(done["t"]) == pytest.approx([20.5, 2.0], abs=1e-6)


def test_a_vehicle_passes_an_obstacle_that_appears_on_its_route():
    text = LONG.format(more="missions: [{go: [8.5, 2.0]}]", duration=90, people="[]") + (
        "obstacles:\n"
        "  pallet: {x: [8.2, 8.8], y: [4.0, 4.5], z: [0.0, 1.0], there: [[2.0, 90.0]]}\n"
    )
    run = sim.run(sim.Trial.parse(text))
    (done,) = events(run, "job_done")
    pallet = navigation.standing((8.5, 4.25))
    distance = navigation.minimum_separation(run.motions["fork"], pallet, 0.0, done["t"])[1]
    assert distance > 0.4 + 0.25
    assert run.motions["fork"].position(done["t"]) == pytest.approx([8.5, 2.0], abs=1e-6)


@pytest.mark.parametrize("rotation", [0.1, 2.0, math.pi, -3.0])
def test_a_vehicle_that_was_held_after_a_turn_continues_from_its_position(rotation):
    text = (
        "floorplan: {boundary: [[0, 0], [24, 0], [24, 6], [0, 6]], stations: {a: [1, 1]}}\n"
        "duration: 40\nmachines:\n"
        f"  fork: {{kind: amr, at: [3, 3, {rotation}], missions: [{{go: [20, 3, 0]}}]}}\n"
        "commands: [{time: 9.0, hold: fork}, {time: 12.0, release: fork}]\n"
    )
    motion = sim.run(sim.Trial.parse(text)).motions["fork"]
    x = motion.position(np.linspace(0.0, 40.0, 4001))[:, 0]
    assert x[900] > 5.0
    assert (np.diff(x) > -1e-9).all() and x[-1] == pytest.approx(20.0)


def test_a_blocked_vehicle_records_it_and_continues_later():
    text = LONG.format(more="missions: [{go: [8.5, 2.0]}]", duration=60, people="[]") + (
        "obstacles:\n"
        "  south: {x: [7.6, 9.4], y: [4.0, 4.5], z: [0.0, 1.0], there: [[0.0, 20.0]]}\n"
        "  north: {x: [7.6, 9.4], y: [15.0, 15.5], z: [0.0, 1.0], there: [[0.0, 20.0]]}\n"
    )
    run = sim.run(sim.Trial.parse(text))
    (blocked,) = events(run, "machine_blocked")
    assert blocked["machine"] == "fork" and "not even a disc" in blocked["message"]
    assert events(run, "job_done")[0]["t"] > 20.0
    moved = next(piece for piece in run.motions["fork"].pieces if not piece.stands)
    assert moved.begin == pytest.approx(20.0)


def test_a_held_vehicle_brakes_waits_and_continues():
    text = LONG.format(more="missions: [{go: [8.5, 2.0]}]", duration=40, people="[]") + (
        "commands: [{time: 3.0, hold: fork}, {time: 9.0, release: fork}]\n"
    )
    run = sim.run(sim.Trial.parse(text))
    motion = run.motions["fork"]
    assert motion.state(2.9).speed > 1.0 and motion.state(6.5).speed == 0.0
    (done,) = events(run, "job_done")
    assert motion.position(done["t"]) == pytest.approx([8.5, 2.0], abs=1e-6)


STEERING = """
import math

def circle(vehicle):
    return (0.8, 0.8)

def timid(vehicle):
    near = any(math.dist(person.at, vehicle.position[:2]) < 3.0 for person in vehicle.people)
    return (0.0, 0.0) if near else (0.8, 0.0)

def wild(vehicle):
    return (math.nan, 0.0)

def hasty(vehicle):
    return (9.0, 0.0)

def by_hand(vehicle):
    yield vehicle.move_to(8.5, 12.0)
    yield vehicle.wait(1.0)
    yield vehicle.twist((0.5, 0.0), 2.0)
    yield vehicle.stop()
"""


@pytest.fixture
def beside(tmp_path):
    """A folder with controllers."""
    (tmp_path / "steer.py").write_text(STEERING)
    return tmp_path


def test_a_function_returns_a_twist_at_a_fixed_rate(beside):
    text = """
    floorplan: warehouse
    duration: 30
    rules: observe
    machines:
      turtle: {kind: amr, at: [4.0, 3.5, 0.0], controller: "steer:circle", rate: 10}
    """
    run = sim.run(sim.Trial.parse(textwrap.dedent(text), folder=beside))
    motion = run.motions["turtle"]
    # At full speed the vehicle drives on a circle of radius v / ω.
    t = np.linspace(5.0, 29.0, 2000)
    rotation, at = motion.rotation(t), motion.position(t)
    centres = at + np.column_stack([-np.sin(rotation), np.cos(rotation)])
    assert np.ptp(centres, axis=0).max() < 1e-4
    assert np.hypot(*motion.velocity(t).T) == pytest.approx(0.8, abs=1e-3)


def test_a_function_sees_people(beside):
    people = "[{name: ann, at: [8.5, 15.5], personality: external}]"
    trial = long_vehicle(
        "controller: steer:timid\n    rate: 10", duration=20.0, people=people, folder=beside
    )
    motion = sim.run(trial).motions["fork"]
    at = motion.position(20.0)
    assert motion.state(20.0).speed == 0.0
    assert 2.0 < math.dist(at, (8.5, 15.5)) < 3.0


def test_a_custom_generator_gives_the_same_commands_as_for_a_gantry(beside):
    run = sim.run(long_vehicle("controller: steer:by_hand", folder=beside))
    assert run.motions["fork"].position(60.0)[1] > 12.5


@pytest.mark.parametrize(
    ("name", "message"),
    [
        ("wild", "'steer:wild' failed at t = 0 s.*a twist must be finite"),
        ("hasty", "'steer:hasty' failed at t = 0 s.*9 m/s is faster than speed, 1.5 m/s"),
        ("by_hand", "is no function that returns a command.*omit rate for a generator"),
    ],
)
def test_an_invalid_twist_ends_the_run(beside, name, message):
    with pytest.raises(ValueError, match=message):
        sim.run(long_vehicle(f"controller: steer:{name}\n    rate: 10", folder=beside))


def test_a_rate_that_is_too_high_is_an_error(beside):
    with pytest.raises(InputError, match="at most 100 Hz, not 1000"):
        long_vehicle("controller: steer:circle\n    rate: 1000", folder=beside)


@pytest.mark.parametrize(
    ("entry", "field", "message"),
    [
        ("at: [8.0, 10.0, 0.0], size: [2.4, 0.8]", "at", "touches rack1 at (8, 10, 0)"),
        (
            "at: [8.5, 10.0, 1.57], size: [2.4, 0.8], missions: [{go: [8.5, 12.0, 0.0]}]",
            "missions[0].go",
            "touches rack1, rack2 at the goal (8.5, 12, 0)",
        ),
        (
            "at: [8.5, 10.0, 1.57], size: [2.4, 0.8], missions: [{turn: 0.0}]",
            "missions[0].turn",
            "touches rack1, rack2",
        ),
        ("at: [4, 3, 0], missions: [{go: dok}]", "missions[0].go", "did you mean 'dock'"),
        ("at: [4, 3, 0], missions: [{go: dock, wait: 2}]", "missions[0]", "one of go, turn, wait"),
        ("at: [4, 3, 0], missions: [{go: [1]}]", "missions[0]", "[x, y] or [x, y, rotation], not"),
        ("at: [4, 3, 0], missions: [{go: [1, 2, x]}]", "missions[0].go[2]", "expected a number"),
        ("at: [4, 3, 0], controller: avoidin", "controller", "did you mean 'avoiding'"),
        ("at: [4, 3, 0], controller: steer:circle, rate: 10", "controller", "no steer.py in"),
        ("at: [4, 3, 0], controller: pausing, rate: 10", "controller", "has no rate; omit it"),
        ("at: [4, 3, 0], max_side_speed: 1.0", "max_side_speed", "only a holonomic drive"),
        ("at: [4, 3, 0], footprint: [[1, 1], [2, 1], [2, 2]]", "footprint", "must contain (0, 0)"),
        ("at: [4, 3, 0], footprint: [[1, 1], [2, 1]]", "footprint", "simple polygon"),
        ("at: [4, 3, 0], max_speed: .nan", "max_speed", ""),
    ],
)
def test_invalid_keys_are_errors_before_the_run(entry, field, message):
    reported = problems(f"floorplan: warehouse\nmachines:\n  one: {{kind: amr, {entry}}}\n")
    assert len(reported) == 1
    assert reported[0][0] == f"machines.one.{field}" and message in reported[0][1]


def test_two_vehicles_in_one_place_are_an_error():
    text = """
    floorplan: warehouse
    machines:
      one: {kind: amr, at: [4, 5, 0]}
      two: {kind: amr, at: [4.3, 5.2, 1.0]}
      three: {kind: amr, at: [3.0, 2.2, 0.0]}
    """
    assert problems(textwrap.dedent(text)) == [
        ("machines.two", "starts where one stands"),
        ("machines.three", "starts where tug1 stands"),
    ]


def test_footprint_load_and_recording(tmp_path):
    """A wedge with a load: its outline is recorded, drawn and read again."""
    text = """
    floorplan: warehouse
    duration: 5
    rules: paper
    people: [{name: ann, at: [12.5, 17.0]}]
    machines:
      wedge:
        kind: amr
        at: [4.0, 3.0, 0.0]
        footprint: [[0.8, 0.1], [0.4, 0.4], [-0.5, 0.4], [-0.5, -0.4], [0.4, -0.4]]
        height: 0.3
        load: [0.6, 0.6, 1.0]
        drive: holonomic
        missions: [{go: [4.0, 6.0, 0.0]}]
    """
    trial = sim.Trial.parse(textwrap.dedent(text))
    run = record(trial, tmp_path / "one")
    shape = sim.load_run(tmp_path / "one").scene.machine("wedge")
    assert shape == run.scene.machine("wedge")
    assert (shape.length, shape.width, shape.top) == (1.6, 0.8, 1.3)
    assert shapely.Polygon(shape.outline).area < 1.6 * 0.8 * 0.7
    assert shape.footprint((4.0, 3.0), math.pi / 2).bounds == pytest.approx((3.6, 2.5, 4.4, 3.8))
    record(trial, tmp_path / "two")
    for file in ("motions.jsonl", "events.jsonl", "scene.json"):
        one, two = ((tmp_path / k / file).read_bytes() for k in ("one", "two"))
        assert one == two
    again = sim.Trial.parse(trial.to_yaml(tmp_path), folder=tmp_path)
    assert sim.run(again).motions["wedge"].pieces == run.motions["wedge"].pieces


SLOW = """
floorplan:
  name: hall
  boundary: [[0, 0], [30, 0], [30, 8], [0, 8]]
  zones: {{slow: {{polygon: [[12, 0], [18, 0], [18, 8], [12, 8]], max_speed: 0.4{whom}}}}}
duration: 60
rules: observe
machines:
  cart: {{kind: amr, at: [2, 4, 0.0], missions: [{{go: {to}}}]}}
"""


@pytest.mark.parametrize("to", ["[28, 4]", "[15, 4]", "[18.8, 4]"])
def test_speed_limits_of_zones_apply_while_the_footprint_covers_them(to):
    run = sim.run(sim.Trial.parse(SLOW.format(whom="", to=to)))
    assert events(run, "job_done")
    motion = run.motions["cart"]
    times = np.arange(0.0, motion.end, 0.01)
    x, speed = motion.position(times)[:, 0], np.hypot(*motion.velocity(times).T)
    inside = (x > 12 - 0.6) & (x < 18 + 0.6)
    assert speed[inside].max() <= 0.4 + 1e-6
    assert speed[x < 11].max() == pytest.approx(1.5, abs=1e-3)
    assert (np.diff(x) >= -1e-9).all()
    pieces = [p for p in motion.pieces if p.moves]
    for piece in pieces:
        u = piece.end - piece.begin
        pull = [2 * piece.x[2], 2 * piece.x[2] + 6 * u * piece.x[3]]
        assert max(map(abs, pull)) <= 0.7 + 1e-6 and abs(6 * piece.x[3]) <= 3 + 1e-6


def test_a_zone_for_other_machines_does_not_slow_a_vehicle():
    run = sim.run(sim.Trial.parse(SLOW.format(whom=", concerns: [ann]", to="[28, 4]")))
    assert events(run, "job_done")[0]["t"] < 22
