"""Commands of machines end: at the goal, by the next command, or with an event that says why."""

import itertools
import math
import random
import textwrap
from functools import partial

import pytest
from run_events import events

import floorplan
import navigation
import sim

HALL = "{boundary: [[0, 0], [30, 0], [30, 20], [0, 20]], safe_zone: {at: [1, 19]}}"
BUILT_IN_GANTRY = "floorplan: ariac2023\nduration: 4000\ngantry: {controller: external}\n"


def external_vehicles(*poses, more="", hall=(30, 20)):
    """A started simulation of vehicles that external code commands, in an empty hall."""
    lines = [
        f"  v{k}: {{kind: amr, at: {list(at)}, controller: external}}" for k, at in enumerate(poses)
    ]
    plan = HALL.replace("30", str(hall[0])).replace("20", str(hall[1]))
    text = f"floorplan: {plan}\nduration: 4000\nmachines:\n" + "\n".join(lines) + "\n" + more
    return started(text)


def started(text):
    simulation = sim.Simulation(sim.Trial.parse(textwrap.dedent(text)))
    simulation.start()
    return simulation


def is_at(machine, target):
    x, y, *rotation = target
    turned = math.remainder(machine.position[2] - rotation[0], math.tau) if rotation else 0.0
    return math.dist(machine.position[:2], (x, y)) < 1e-4 and abs(turned) < 1e-4


def hold_for_no_time(machine):
    machine.hold(True)
    machine.hold(False)


@pytest.mark.parametrize("times", [(0.0,), (0.0, 0.0), (1.0,), (1.0, 1.0), (2.0, 2.3)])
def test_a_move_arrives_if_the_machine_is_held_and_released_at_one_time(times):
    simulation = external_vehicles((3, 4, 0))
    vehicle = simulation.machines["v0"]
    arrived = []
    vehicle.move_to(12.0, 9.0, 1.0).callbacks.append(lambda _: arrived.append(vehicle.now))
    for t in times:
        simulation.advance(t) if t > vehicle.now else None
        hold_for_no_time(vehicle)
    simulation.advance(60.0)
    assert len(arrived) == 1 and is_at(vehicle, (12.0, 9.0, 1.0))
    assert vehicle.body.motion.end == arrived[0]


@pytest.mark.parametrize(("count", "shift"), [(2, 8.0), (10, 8.0), (20, 6.0)])
def test_vehicles_that_external_code_moves_among_each_other_all_arrive(count, shift):
    """Vehicles wait for each other, and for goals that others still occupy."""
    places = [(3.0 + 5 * (k % 10), 4.0 + 8 * (k // 10), 0.0) for k in range(count)]
    simulation = external_vehicles(*places, hall=(60, 40))
    goals = {}
    for k, (x, y, _) in enumerate(places):
        goals[f"v{k}"] = [(x + 1.5, y + 16.0), (x + shift, y + 16.0)]
    begin, current = {f"v{k}": 0.7 * k for k in range(count)}, {}
    while simulation.clock.now < 120.0 and any(goals.values()):
        for name, left in goals.items():
            vehicle = simulation.machines[name]
            if not left or simulation.clock.now < begin[name]:
                continue
            if current.get(name) != left[0]:
                current[name] = left[0]
                vehicle.move_to(*left[0])
            elif is_at(vehicle, left[0]) and vehicle.state.speed == 0.0:
                left.pop(0)
        simulation.advance(simulation.clock.now + 0.1)
    assert not any(goals.values()), goals


def test_a_mission_waits_while_a_field_stops_the_vehicle():
    text = f"""
    floorplan: {HALL}
    duration: 30
    machines:
      v0: {{kind: amr, at: [3, 4, 0], missions: [{{wait: 10}}, {{go: [6, 4]}}]}}
    commands: [{{time: 2, hold: v0}}, {{time: 12, release: v0}}]
    """
    run = sim.run(sim.Trial.parse(textwrap.dedent(text)))
    waited, _ = events(run, "job_done")
    assert waited["t"] == 10.0
    assert run.summary["machines"]["v0"]["idle_time"] < 20.0


def test_a_move_commanded_while_the_machine_is_held_begins_at_its_release():
    simulation = external_vehicles((3, 4, 0))
    vehicle = simulation.machines["v0"]
    vehicle.hold(True)
    vehicle.move_to(6.0, 4.0)
    simulation.advance(5.0)
    assert is_at(vehicle, (3, 4)) and vehicle.disabled
    # The machine is released and held again at once, so it must not start.
    vehicle.hold(False)
    vehicle.hold(True)
    simulation.advance(9.0)
    assert is_at(vehicle, (3, 4))
    vehicle.hold(False)
    simulation.advance(30.0)
    assert is_at(vehicle, (6, 4))


def test_a_move_that_must_not_resume_ends_where_it_was_broken_off():
    simulation = external_vehicles((3, 4, 0))
    vehicle = simulation.machines["v0"]
    move = vehicle.move_to(20.0, 4.0, resume=False)
    simulation.advance(3.0)
    hold_for_no_time(vehicle)
    vehicle.limit_speed(0.3)
    simulation.advance(60.0)
    assert move.processed and 4.0 < vehicle.position[0] < 8.0


def test_a_command_that_is_replaced_ends_at_once():
    simulation = external_vehicles((3, 4, 0))
    vehicle = simulation.machines["v0"]
    ended = []
    for at, goal in ((0.0, (20.0, 4.0)), (2.0, (20.0, 9.0)), (4.0, (3.0, 15.0))):
        simulation.advance(at) if at else None
        move = vehicle.move_to(*goal)
        move.callbacks.append(lambda _: ended.append(vehicle.now))
    simulation.advance(60.0)
    assert ended[:2] == [2.0, 4.0] and len(ended) == 3 and is_at(vehicle, (3.0, 15.0))


def test_a_task_without_a_free_path_ends_when_another_command_replaces_it():
    text = f"""
    floorplan: {HALL}
    duration: 200
    obstacles: {{box: {{x: [9, 11], y: [9, 11], z: [0, 1], there: [[0, 200]]}}}}
    machines:
      v0: {{kind: amr, at: [3, 4, 0], controller: external, missions: [{{go: [10, 10]}}]}}
    """
    simulation = started(text)
    vehicle = simulation.machines["v0"]
    done = vehicle.do(vehicle.open_tasks[0])
    simulation.advance(11.0)
    assert not done.processed
    vehicle.move_to(5.0, 4.0)
    simulation.advance(12.0)
    assert done.processed and done.value is False
    assert len(events(simulation, "machine_blocked")) == 1


DOOR = """
obstacles:
  door: {x: [14, 14.4], y: [0, 20], z: [0, 2], there: [[3.0, 500.0]]}
"""


@pytest.mark.parametrize("held", [False, True])
def test_a_move_ends_with_an_event_if_a_door_closes_on_its_path(held):
    simulation = external_vehicles((3, 4, 0), more=DOOR)
    vehicle = simulation.machines["v0"]
    move = vehicle.move_to(25.0, 4.0)
    simulation.advance(2.0)
    if held:
        vehicle.hold(True)
        simulation.advance(4.0)
        vehicle.hold(False)
    simulation.advance(60.0)
    (blocked,) = events(simulation, "machine_blocked")
    assert blocked["machine"] == "v0" and blocked["goal"] == [25.0, 4.0]
    assert move.processed and vehicle.position[0] < 13.5


def test_a_stopped_move_that_is_resumed_does_not_drive_through_a_door_closed_since():
    simulation = external_vehicles((3, 4, 0), more=DOOR.replace("[0, 20]", "[0, 12]"))
    vehicle = simulation.machines["v0"]
    vehicle.move_to(25.0, 4.0)
    simulation.advance(2.0)
    vehicle.stop()
    simulation.advance(8.0)
    vehicle.resume()
    simulation.advance(90.0)
    assert is_at(vehicle, (25.0, 4.0))
    door = navigation.standing((14.2, 4.0))
    distance = navigation.minimum_separation(vehicle.body.track(), door, 0.0, 90.0)[1]
    assert distance > 4.0


def commands(machine, draw, log):
    """Give random commands, wait for each or replace it, and log the outcomes."""
    low, high = ((2.0, 2.0), (28.0, 18.0)) if machine.shape.kind == "amr" else ((-14, -6), (0, 6))
    stopped = False
    for _ in range(15):
        kind = draw.choice(["move", "move", "move", "turn", "wait", "stop", "twist", "follow"])
        if kind in ("turn", "twist") and machine.shape.kind != "amr":
            kind = "move"
        x, y = (round(draw.uniform(a, b), 2) for a, b in zip(low, high, strict=True))
        share, target = draw.choice([1.0, 0.4]), None
        try:
            if stopped and draw.random() < 0.5 and machine._drive.last_move:
                target = machine._drive.last_move[0]
                command = machine.resume()
            elif kind == "move":
                target = (x, y)
                command = machine.move_to(x, y, speed_share=share)
            elif kind == "turn":
                target = (*machine.position[:2], x % 6.0)
                target = target if machine.state.speed == 0.0 else None
                command = machine.turn_to(x % 6.0)
            elif kind == "wait":
                command = machine.wait(draw.choice([0.0, 0.7]))
            elif kind == "twist" and not machine.disabled:
                command = machine.twist((0.4, 0.5), draw.choice([0.0, 1.3]))
            elif kind == "follow" and not machine.disabled:
                command = machine.follow(machine.preview(x, y, speed_share=share))
            else:
                command = machine.stop()
        except navigation.PlanningError:
            continue
        stopped = kind == "stop"
        entry = {"kind": kind, "command": command, "target": target, "t": machine.now}
        log.append(entry)
        if draw.random() < 0.3:  # the next command replaces it
            entry["target"] = None
            yield command | machine.until(machine.now + draw.choice([0.0, 0.4, 2.5]))
        else:
            yield command
            entry["at"] = machine.position


def disturbances(machine, draw, until):
    """Hold, release, slow down and disable the machine at random times, some of them equal."""
    clock = machine.body.clock
    while clock.now < until:
        yield clock.at(clock.now + draw.choice([0.0, 0.3, 1.1, 4.0]) + draw.choice([0.0, 0.1]))
        for _ in range(draw.choice([1, 1, 2])):
            action = draw.choice(["hold", "hold", "hold for", "limit", "no limit", "disable"])
            if action == "hold":
                hold_for_no_time(machine)
            elif action == "hold for":
                machine.hold(True)
                yield clock.at(clock.now + draw.choice([0.0, 0.2, 1.7]))
                machine.hold(False)
            elif action == "disable":
                machine.disable(draw.choice([0.0, 0.5]))
            else:
                machine.limit_speed(draw.choice([0.2, 0.6]) if action == "limit" else None)
    machine.limit_speed(None)


@pytest.mark.parametrize("seed", range(12))
@pytest.mark.parametrize("kind", ["amr", "gantry"])
def test_each_command_ends_despite_disturbances(kind, seed):
    draw = random.Random(f"{kind} {seed}")
    if kind == "amr":
        simulation = external_vehicles((3, 4, 0), (20, 15, 1))
        machines = list(simulation.machines.values())
    else:
        simulation = started(BUILT_IN_GANTRY)
        machines = [simulation.gantry]
    logs = []
    for machine in machines:
        logs.append([])
        machine.start(commands(machine, draw, logs[-1]))
        simulation.clock.process(disturbances(machine, draw, 150.0))
    simulation.advance(1500.0)
    for machine, log in zip(machines, logs, strict=True):
        assert len(log) > 8 and not machine.disabled
        for entry in log:
            assert entry["command"].triggered, entry
            if entry["target"] is not None and "at" in entry:
                assert math.dist(entry["at"][:2], entry["target"][:2]) < 1e-4, entry


ARGUMENTS = [
    ("wait(nan)", "wait(seconds)"),
    ("wait(-1)", "wait(seconds)"),
    ("wait(None)", "wait(seconds)"),
    ("look('soon')", "look(after)"),
    ("until(inf)", "until(t)"),
    ("move_to(nan, 2)", "move_to(x)"),
    ("move_to(5, 'b')", "move_to(y)"),
    ("move_to(5, 2, inf)", "move_to(rotation)"),
    ("move_to(5, 2, speed_share=nan)", "move_to(speed_share)"),
    ("preview(None, 2)", "preview(x)"),
    ("turn_to(None)", "turn_to(rotation)"),
    ("follow(None)", "follow(motion)"),
    ("twist((0.5, 0.1), nan)", "twist(seconds)"),
    ("twist((0.5, 0.1), inf)", "twist(seconds)"),
    ("twist((0.5, 0.1), -1)", "twist(seconds)"),
    ("twist((0.5, nan), 1)", "twist"),
    ("twist(None, 1)", "twist"),
    ("interrupt_on('person_close', 'near')", "interrupt_on(distance)"),
    ("limit_speed(0)", "limit_speed(speed)"),
    ("do(None)", "do(task)"),
    ("handle('go')", "handle(task)"),
    ("locate(3)", "locate(task)"),
]


@pytest.mark.parametrize(("call", "argument"), ARGUMENTS)
@pytest.mark.parametrize("kind", ["amr", "gantry"])
def test_an_invalid_argument_of_a_command_is_named(kind, call, argument):
    simulation = external_vehicles((3, 4, 0)) if kind == "amr" else started(BUILT_IN_GANTRY)
    machine = simulation.machines["v0"] if kind == "amr" else simulation.gantry
    if not hasattr(machine, call.split("(")[0]):
        pytest.skip("a gantry has no such command")
    names = {"machine": machine, "nan": math.nan, "inf": math.inf}
    with pytest.raises(floorplan.UserError, match="must be") as why:
        eval(f"machine.{call}", names)
    assert argument in str(why.value)


@pytest.mark.parametrize("twist", [(0.5, 0.3), (0.05, 0.0), (0.3, 0.1), (0.0, 0.7)])
def test_a_twist_of_any_length_costs_only_the_driven_part(twist):
    simulation = external_vehicles((15, 8, 0))
    vehicle = simulation.machines["v0"]
    motions = []
    vehicle.body.on_change.append(lambda: motions.append(vehicle.body.motion))
    move = vehicle.twist(twist, 1e9)
    simulation.advance(20.0)
    # The motion is the same as if the whole twist was planned at once.
    shorter = navigation.vehicle_twist((15, 8, 0), twist, seconds=400.0)
    for t in range(20, 200, 7):
        simulation.advance(t)
        assert vehicle.body.motion.end > t + 29.0
        assert vehicle.position == pytest.approx(shorter.state(t).position, abs=1e-3)
        assert vehicle.state.velocity == pytest.approx(shorter.state(t).velocity, abs=2e-3)
    assert max(len(motion.pieces) for motion in motions) < 200 and len(motions) < 10
    for before, after in itertools.pairwise(motions):
        t = after.start
        velocity = before.state_before(t).velocity
        assert after.state(t).velocity == pytest.approx(velocity, abs=1e-3)
    vehicle.hold(True)
    simulation.advance(300.0)
    assert move.processed and vehicle.state.speed == 0.0 and vehicle.body.motion.end < 210.0


def test_a_twist_beyond_the_planning_horizon_stops_in_time():
    simulation = external_vehicles((3, 4, 0))
    vehicle = simulation.machines["v0"]
    ended = []
    vehicle.twist((0.1, 0.0), 130.0).callbacks.append(lambda _: ended.append(vehicle.now))
    simulation.advance(200.0)
    expected = navigation.vehicle_twist((3, 4, 0), (0.1, 0.0), seconds=130.0)
    assert ended == [pytest.approx(expected.end)]
    assert vehicle.position == pytest.approx(expected.state(expected.end).position)


@pytest.mark.parametrize("twist", [(1e-300, 0.0), (1e-300, 1e-300), (0.0, 1e-12), (1e-9, 1.0)])
@pytest.mark.parametrize("seconds", [0.0, 1e-300, 1e-12, 1.0])
def test_a_tiny_twist_ends(twist, seconds):
    simulation = external_vehicles((3, 4, 0))
    vehicle = simulation.machines["v0"]
    move = vehicle.twist(twist, seconds)
    simulation.advance(10.0)
    assert move.processed and vehicle.position[:2] == pytest.approx((3, 4), abs=1e-6)


def test_a_held_machine_counts_its_stationary_time():
    simulation = external_vehicles((3, 4, 0))
    vehicle = simulation.machines["v0"]
    vehicle.move_to(20.0, 4.0)
    simulation.advance(3.0)
    vehicle.hold(True)
    rests_from = vehicle.body.motion.end
    simulation.advance(8.0)
    vehicle.hold(True)
    simulation.advance(9.0)
    vehicle.hold(False)
    vehicle.hold(False)
    assert vehicle._drive.standing_time == pytest.approx(9.0 - rests_from) and rests_from > 3.5


@pytest.mark.parametrize("seconds", [0.0, 0.2])
def test_a_machine_that_is_held_only_while_it_brakes_is_not_idle(seconds):
    simulation = external_vehicles((3, 4, 0))
    vehicle = simulation.machines["v0"]
    vehicle.move_to(20.0, 4.0)
    simulation.advance(3.0)
    vehicle.hold(True)
    simulation.advance(3.0 + seconds)
    vehicle.hold(False)
    simulation.advance(8.0)
    motion = vehicle.body.track().cut(0.0, 8.0)
    assert vehicle.body.motion.end > 8.0
    assert vehicle.figures(motion, 8.0)["idle_time"] == pytest.approx(0.0, abs=1e-6)


def test_a_machine_stops_until_no_reason_is_left():
    simulation = external_vehicles((3, 4, 0))
    vehicle = simulation.machines["v0"]
    for released_first in (True, False):
        vehicle.follow(vehicle.preview(vehicle.position[0] + 4.0, 4.0))
        simulation.advance(simulation.clock.now + 1.5)
        vehicle.limit_speed(0.2)
        vehicle.hold(True)
        assert vehicle.disabled
        reasons = [partial(vehicle.hold, False), partial(vehicle.limit_speed, None)]
        first, last = reasons if released_first else reasons[::-1]
        first()
        assert vehicle.disabled
        last()
        assert not vehicle.disabled
        simulation.advance(simulation.clock.now + 9.0)


def test_only_moves_of_the_machine_itself_count_as_the_last_move():
    simulation = external_vehicles((3, 4, 0))
    drive = simulation.machines["v0"]._drive
    drive.move((9.0, 4.0, 0.0), 0.5)
    assert drive.last_move == ((9.0, 4.0, 0.0), 0.5)
    drive.move((12.0, 4.0, 0.0), command=drive.begin())
    assert drive.last_move is None and drive.target == (12.0, 4.0, 0.0)
