"""The cell: signals, commands and tasks of people and machines, and rejected values."""

import math

import numpy as np
import pytest
from small_floors import WORKCELL, on_floor

import sim
from sim.cell import Cell, JointPoint, JointTrajectory, Pace, Pose, Rejected

TRIAL = on_floor(
    WORKCELL,
    """\
duration: 60
seed: 3
rules: observe
people:
  - {name: ann, at: [2, 9], personality: external}
  - {name: bob, at: [18, 4], personality: indifferent}
gantry: {controller: external}
machines:
  bot: {kind: amr, at: [4, 4, 0], size: [1.0, 0.7], controller: external}
""",
)


def cell_of(text=TRIAL, *listeners):
    notices = []
    cell = Cell(sim.Simulation(sim.Trial.parse(text), *listeners), notice=notices.append)
    cell.notices = notices
    return cell


def run_until_ended(cell, *runnings):
    while not all(running.result for running in runnings) and not cell.pace.over:
        cell.pace.step(0.1)
    return [running.result for running in runnings]


def in_bytes(folder):
    return [(folder / name).read_bytes() for name in ("events.jsonl", "motions.jsonl")]


def test_a_cell_lists_signals_commands_and_tasks_of_people_and_machines():
    cell = cell_of()
    assert {"clock", "events", "floor"} < cell.signals.keys()
    for name in ("ann", "bob"):
        assert f"people/{name}/pose" in cell.signals
        assert {f"people/{name}/{task}" for task in ("go_to", "go_through")} < cell.tasks.keys()
        assert f"monitor/{name}/bot" in cell.signals
    assert "people/ann/act" in cell.commands and "people/bob/act" not in cell.commands
    assert {"machines/bot/twist", "machines/gantry/joints", "machines/cart/drive"} < (
        cell.commands.keys()
    )
    assert {"machines/bot/go_to", "machines/gantry/trajectory", "machines/cart/go_to"} < (
        cell.tasks.keys()
    )
    for signal in cell.signals.values():
        signal.read()
    assert cell.signals["machines/bot/pose"].read() == Pose(4.0, 4.0, 0.0)
    assert cell.signals["machines/bot/scan"].read().distances.shape == (720,)
    monitor = cell.signals["monitor/ann/bot"].read()
    assert monitor.distance == pytest.approx(math.dist((2, 9), (4, 4)), abs=2.0)


def test_a_run_driven_through_the_cell_repeats_to_the_byte(tmp_path):
    recording, again = sim.Recording(tmp_path / "first"), sim.Recording(tmp_path / "second")
    cell = cell_of(TRIAL, recording)
    cell.commands["people/ann/start"].take(None)
    cell.pace.step(0.37)
    points = (JointPoint((2.0, -1.0, 0.5), time=5.0),)
    names = ("gantry_x_axis_joint", "gantry_y_axis_joint", "gantry_rotation_joint")
    tasks = [
        cell.tasks["people/ann/go_through"].start([Pose(5.0, 10.0), Pose(6.0, 9.0)]),
        cell.tasks["people/bob/go_to"].start((15.0, 3.0)),
        cell.tasks["machines/bot/go_through"].start([Pose(6.0, 4.0), Pose(8.0, 3.5, 1.0)]),
        cell.tasks["machines/cart/go_to"].start("middle"),
        cell.tasks["machines/gantry/trajectory"].start(JointTrajectory(names, points)),
    ]
    assert run_until_ended(cell, *tasks) == ["succeeded"] * 5
    drive = cell.tasks["machines/bot/go_to"].start(Pose(16.0, 4.0))
    cell.pace.step(1.0)
    assert 6.0 < drive.feedback().remaining < 9.0
    drive.cancel()
    assert drive.result == "cancelled"
    for k in range(20):
        cell.commands["machines/bot/twist"].take((0.4, 0.1 * k / 20))
        cell.pace.step(0.1)
    cell.pace.step(60.0)
    run = cell.simulation.finish()
    recording.finish(run)
    assert {command.person for command in run.trial.commands} >= {"ann"}
    assert {command.machine for command in run.trial.commands} >= {"bot", "cart", "gantry"}
    run.trial.save(tmp_path / "again.trial.yaml")
    again.finish(sim.run(sim.Trial.load(tmp_path / "again.trial.yaml"), again))
    assert in_bytes(tmp_path / "second") == in_bytes(tmp_path / "first")


@pytest.mark.parametrize(
    ("name", "value", "word"),
    [
        ("machines/bot/twist", (math.nan, 0.0), "finite"),
        ("machines/bot/twist", (math.inf, 0.0), "finite"),
        ("machines/bot/twist", (99.0, 0.0), "99"),
        ("machines/bot/twist", "fast", "fast"),
        ("machines/bot/pose", Pose(1.0, 1.0), "at"),
        ("machines/bot/go_to", Pose(10.0, 6.5), "10"),
        ("machines/bot/go_to", Pose(99.0, 6.5), "99"),
        ("machines/bot/go_through", [], "pose"),
        ("machines/cart/go_to", "moon", "west"),
        ("machines/cart/drive", "moon", "moon"),
        ("machines/gantry/go_to", Pose(50.0, 5.0), "50"),
        ("machines/gantry/joints", (1.0, 2.0), "JointTrajectory"),
        ("machines/gantry/trajectory", None, "JointTrajectory"),
        ("machines/bot/go_to", None, "None"),
        ("machines/bot/twist", None, "None"),
        ("people/ann/goal", None, "None"),
        ("people/ann/go_to", Pose(10.0, math.nan), "finite"),
        ("people/ann/go_to", Pose(10.0, 6.5), "no room"),
        ("people/ann/goal", (-3.0, 6.5), "outside"),
        ("people/ann/act", "fly(1)", "fly"),
        ("people/ann/act", "fly(", "fly"),
        ("people/ann/act", None, "text"),
        ("people/ann/act", b"stop_movement", "text"),
        ("people/ann/goal", "12", "Pose"),
        ("people/ann/goal", {1.0, 2.0}, "Pose"),
        ("people/ann/goal", Pose(1.0, 2.0, "north"), "north"),
        ("people/ann/goal", np.ones((2, 2)), "1."),
        ("machines/bot/go_to", Pose("west", 1.0), "west"),
        ("machines/bot/go_to", Pose(1.0, None), "None"),
        ("machines/bot/go_to", (10**5000, 1.0), "finite"),
        ("machines/bot/twist", Pose, "Pose"),
    ],
)
def test_a_rejected_value_causes_one_line_with_its_name_and_no_change(name, value, word):
    cell = cell_of()
    cell.commands["people/ann/start"].take(None)
    before = [*cell.simulation.commands]
    port = cell.tasks[name].start if name in cell.tasks else cell.commands[name].take
    with pytest.raises(Rejected, match=name) as why:
        port(value)
    assert word in str(why.value) and "\n" not in str(why.value)
    assert cell.notices == [str(why.value)]
    assert cell.simulation.commands == before


@pytest.mark.parametrize("period", [0.0, -1.0, math.nan, math.inf])
def test_a_period_without_end_or_beginning_is_an_error(period):
    with pytest.raises(ValueError, match="period"):
        cell_of().pace.every(period, print)


def test_a_flood_on_one_command_leaves_the_others_undisturbed():
    cell = cell_of()
    rejected = 0
    for k in range(1000):
        try:
            cell.commands["people/bob/stop"].take(k)
        except Rejected as why:
            rejected += 1
            assert "more than 300" in str(why)
    assert rejected == 700
    assert len(cell.notices) == 1 and "people/bob/stop" in cell.notices[0]
    cell.commands["machines/bot/twist"].take((0.1, 0.0))


def test_two_publishers_of_one_command_are_reported_once_and_the_last_one_counts():
    cell = cell_of()
    for k in range(10):
        cell.commands["machines/bot/twist"].take((0.1 * (k % 2), 0.0), source=f"client{k % 2}")
    (notice,) = cell.notices
    assert "machines/bot/twist" in notice and "client0" in notice and "client1" in notice
    cell.pace.step(0.3)
    assert cell.signals["machines/bot/twist"].read().forwards > 0


def test_an_agv_goes_through_poses_near_its_lane_and_places_on_it():
    cell = cell_of()
    drive = cell.tasks["machines/cart/go_through"].start(
        [Pose(5.0, 1.5, 2.0), "middle", (4.0, 1.0)]
    )
    assert run_until_ended(cell, drive) == ["succeeded"]
    assert cell.signals["machines/cart/pose"].read() == Pose(pytest.approx(4.0), 1.2, 0.0)
    for task, goal in (("go_to", Pose(5.0, 2.0)), ("follow", [(5.0, 1.2), (30.0, 1.2)])):
        with pytest.raises(Rejected, match="the lane of cart"):
            cell.tasks[f"machines/cart/{task}"].start(goal)


def test_a_task_under_way_ends_with_the_run():
    cell = cell_of()
    drive = cell.tasks["machines/bot/go_to"].start(Pose(15.0, 4.0))
    cell.pace.step(1.0)
    assert drive.result is None
    cell.pace.end()
    assert "over" in drive.result


def test_a_new_goal_replaces_the_current_goal():
    cell = cell_of()
    first = cell.tasks["machines/bot/go_to"].start(Pose(15.0, 4.0))
    ends = []
    first.on_end(ends.append)
    cell.pace.step(1.0)
    second = cell.tasks["machines/bot/go_to"].start(Pose(6.0, 4.0))
    assert "replaced" in first.result and ends == [first.result]
    cell.commands["machines/bot/twist"].take((0.0, 0.1))
    assert "replaced" in second.result


def test_signals_on_change_are_sent_to_subscribers():
    cell = cell_of()
    states, percepts, kinds = [], [], []
    cell.signals["machines/bot/state"].watch(states.append)
    cell.signals["people/ann/percept"].watch(percepts.append)
    cell.signals["events"].watch(lambda event: kinds.append(event["kind"]))
    cell.pace.step(0.1)
    cell.tasks["people/ann/go_to"].start((4.0, 9.0))
    cell.commands["machines/bot/hold"].take(True)
    drive = cell.tasks["machines/bot/go_to"].start((6.0, 4.0))
    cell.pace.step(1.0)
    assert states == ["stopped"] and drive.result is None
    cell.commands["machines/bot/hold"].take(False)
    cell.pace.step(10.0)
    assert states[1:] == ["moving", "idle"]
    assert percepts[0] == "human_start" and "work_completed" in percepts
    assert "arrived" in kinds


def test_a_pace_follows_real_time_and_can_be_paused_held_and_stepped():
    real = [0.0]
    simulation = sim.Simulation(sim.Trial.parse(TRIAL))
    pace = Pace(simulation, speed=2.0, now=lambda: real[0])
    ticks = []
    pace.every(0.5, lambda: ticks.append(simulation.clock.now))
    pace.catch_up()
    real[0] = 1.0
    pace.catch_up()
    assert simulation.clock.now == 2.0
    assert ticks == [0.5, 1.0, 1.5, 2.0]
    pace.change(paused=True)
    real[0] = 2.0
    pace.catch_up()
    assert simulation.clock.now == 2.0
    pace.step(0.25)
    assert simulation.clock.now == 2.25
    pace.change(paused=False, speed=1.0)
    assert pace.hold("nobody is there") and not pace.hold("nobody is there")
    real[0] = 3.0
    pace.catch_up()
    assert simulation.clock.now == 2.25
    assert pace.release()
    real[0] = 3.5
    pace.catch_up()
    assert simulation.clock.now == 2.75
    for wrong in (-1.0, math.nan, math.inf):
        with pytest.raises(ValueError, match="step"):
            pace.step(wrong)


def test_a_cell_continues_with_another_simulation_from_its_start(tmp_path):
    trial = sim.Trial.parse(TRIAL)
    recordings = [sim.Recording(tmp_path / name) for name in ("first", "second")]
    cell = Cell(sim.Simulation(trial, recordings[0]))
    first, events = cell.simulation, []
    pose, goal = cell.signals["machines/bot/pose"], (4.0, 10.0)
    cell.signals["events"].watch(lambda event: events.append((event["t"], event["kind"])))
    drive = cell.tasks["machines/bot/go_to"].start(goal)
    cell.pace.step(7.3)
    assert pose.read() != Pose(4.0, 4.0, 0.0)
    cell.continue_with(sim.Simulation(first.trial, recordings[1]))
    assert (cell.now, pose.read()) == (0.0, Pose(4.0, 4.0, 0.0))
    assert drive.result.startswith("failed") and events[-1][0] == 0.0
    assert events.count((0.0, "trial_started")) == 1
    again = cell.tasks["machines/bot/go_to"].start(goal)
    assert run_until_ended(cell, again) == ["succeeded"]
    for recording, simulation in zip(recordings, (first, cell.simulation), strict=True):
        recording.finish(simulation.finish())
    before, after = (
        (recording.folder / "events.jsonl").read_bytes().splitlines() for recording in recordings
    )
    assert before[:-1] == after[: len(before) - 1] and b"trial_ended" in before[-1]
