"""Controllers of vehicles: functions and classes, their state, their missions and their errors."""

import math
import sys
from dataclasses import replace

import pytest
from typer.testing import CliRunner

import sim
from sim.cli import app

TRIAL = """
floorplan: warehouse
duration: 60
machines:
  fork:
    kind: amr
    at: [8.5, 10.0, 1.5708]
    missions: [{{go: dock}}, {{go: [3.0, 6.0]}}]
    controller: "drive:{name}"
    on_contact: report
    {rate}
"""

DRIVE = '''
import math

calls = []


class Patrol:
    """Drive to one mission after the other."""

    def __init__(self):
        self.ticks = 0

    def __call__(self, vehicle):
        self.ticks += 1
        calls.append(self.ticks)
        if not vehicle.missions:
            return (0.0, 0.0)
        x, y, heading = vehicle.position
        goal = vehicle.missions[0].go
        if math.dist((x, y), goal[:2]) < 0.3:
            vehicle.complete()
            return None
        error = math.remainder(math.atan2(goal[1] - y, goal[0] - x) - heading, math.tau)
        return 1.0 if abs(error) < 0.5 else 0.0, max(-0.8, min(0.8, 2.0 * error))


class OfVehicle(Patrol):
    def __init__(self, vehicle):
        super().__init__()
        self.name = vehicle.name


def counting(vehicle):
    calls.append(1)
    return 0.1 * min(len(calls), 10), 0.0


def failing(vehicle):
    return helper() if vehicle.now > 1.0 else (0.5, 0.0)


def helper():
    return {}["a"]


def generator(vehicle):
    yield vehicle.stop()


class Silent:
    pass
'''


@pytest.fixture
def beside(tmp_path):
    (tmp_path / "drive.py").write_text(DRIVE)
    return tmp_path


def trial(folder, name, rate="rate: 10"):
    return sim.Trial.parse(TRIAL.format(name=name, rate=rate), folder=folder)


def in_bytes(run):
    motion = run.motions["fork"]
    return repr(run.events) + repr([tuple(piece) for piece in motion.pieces])


@pytest.mark.parametrize("name", ["Patrol", "OfVehicle"])
def test_a_class_with_a_rate_is_made_for_each_run_and_gets_the_missions(beside, name):
    first, second = (sim.run(trial(beside, name)) for _ in range(2))
    assert in_bytes(first) == in_bytes(second)
    done = [event["kind"] for event in first.events if event["kind"].startswith("job_")]
    assert done == ["job_started", "job_done"] * 2
    assert first.summary["machines"]["fork"]["jobs_done"] == 2
    assert math.dist(first.motions["fork"].position(60.0), (3.0, 6.0)) < 1.0


def test_a_function_that_keeps_state_in_its_module_repeats_its_run(beside):
    runs = [in_bytes(sim.run(trial(beside, "counting"))) for _ in range(3)]
    assert runs[0] == runs[1] == runs[2]


def test_two_simulations_at_once_do_not_share_modules(beside):
    alone = in_bytes(sim.run(trial(beside, "counting")))
    one, other = (sim.Simulation(trial(beside, "counting")) for _ in range(2))
    for t in range(1, 61):
        one.advance(t)
        other.advance(t)
    assert in_bytes(one.finish()) == in_bytes(other.finish()) == alone


def test_all_machines_of_a_run_share_a_module(beside, monkeypatch):
    monkeypatch.delitem(sys.modules, "drive", raising=False)
    text = TRIAL.format(name="counting", rate="rate: 10")
    text += '  other: {kind: amr, at: [1.5, 2.0, 0.0], controller: "drive:counting", rate: 10}\n'
    sim.run(replace(sim.Trial.parse(text, folder=beside), duration=2.0))
    assert len(sys.modules["drive"].calls) == 40


def test_completing_without_a_mission_is_an_error():
    def eager(vehicle):
        vehicle.complete()

    with pytest.raises(sim.ControllerError, match=r"vehicle_controllers.py, line.*no mission"):
        sim.run(of_python(eager, rate=10.0, missions=[]))


def of_python(controller, **keys):
    cart = {"at": (8.5, 10.0, 1.5708), "missions": ({"go": "dock"},), "controller": controller}
    machines = {"fork": sim.MachineEntry("amr", cart | keys)}
    warehouse = sim.Trial.parse("floorplan: warehouse").floorplan
    return sim.Trial(warehouse, duration=60.0, machines=machines)


def going(vehicle):
    while (task := (yield vehicle.next_task())) is not None:
        yield vehicle.do(task)


class Going:
    def __init__(self, vehicle):
        self.vehicle = vehicle

    def __iter__(self):
        return going(self.vehicle)


@pytest.mark.parametrize("controller", [going, Going, lambda vehicle: going(vehicle)])
def test_a_generator_or_a_class_in_python_is_a_controller(controller):
    run = sim.run(of_python(controller))
    assert run.summary["machines"]["fork"]["jobs_done"] == 1


def test_a_function_or_an_object_in_python_is_called_at_a_rate():
    class Slow:
        def __call__(self, vehicle):
            return 0.5, 0.0

    for controller in (lambda vehicle: (0.5, 0.0), Slow, Slow()):
        run = sim.run(of_python(controller, rate=10.0))
        assert run.motions["fork"].position(3.0)[1] > 10.5


def test_a_controller_of_python_is_written_by_its_name(beside, monkeypatch):
    monkeypatch.syspath_prepend(beside)
    monkeypatch.delitem(sys.modules, "drive", raising=False)
    import drive

    try:
        patrolling = replace(of_python(drive.Patrol, rate=10.0), folder=beside)
        again = sim.Trial.parse(patrolling.to_yaml(beside), folder=beside)
        assert again.machines["fork"].keys["controller"] == "drive:Patrol"
        with pytest.raises(ValueError, match=r"its vehicle controller .* is in no module"):
            of_python(lambda vehicle: None, rate=10.0).to_yaml()
    finally:
        sys.modules.pop("drive")


@pytest.mark.parametrize(
    ("name", "rate", "message"),
    [
        ("failing", "rate: 10", r"failed at t = 1.1 s \(drive.py, line \d+\): KeyError: 'a'"),
        ("failing", "", "line 9, machines.fork.controller: .*is no generator; give rate"),
        ("Patrol", "", "is no generator; give rate"),
        ("OfVehicle", "", r"drive.py, line \d+\) is no generator function.*give rate"),
        ("generator", "rate: 10", r"drive.py, line \d+\) is no function .*omit rate"),
        ("Silent", "rate: 10", "nor a class with a method __call__"),
    ],
)
def test_a_controller_that_fails_or_lacks_a_rate_is_named_with_its_place(
    beside, name, rate, message
):
    with pytest.raises(ValueError, match=message):
        sim.run(trial(beside, name, rate))


def test_a_python_function_without_a_rate_is_an_error():
    with pytest.raises(sim.ControllerError, match=r"\(0.5, 0.0\), is not a generator; .*rate"):
        sim.run(of_python(lambda vehicle: (0.5, 0.0)))


@pytest.mark.parametrize(
    ("options", "controllers", "rate"),
    [
        (["pausing"], ["pausing", "pausing"], None),
        (["fork=drive:Patrol"], ["drive:Patrol", "oblivious"], 10),
        (["pausing", "b=parked"], ["pausing", "parked"], None),
    ],
)
def test_the_command_chooses_controllers_of_vehicles(beside, options, controllers, rate):
    from sim.commands.run import changed

    text = TRIAL.format(name="counting", rate="rate: 10")
    text += "  b: {kind: amr, at: [1.5, 2.0, 0.0], controller: oblivious}\n"
    chosen = changed(sim.Trial.parse(text, folder=beside), None, None, None, None, options)
    assert [entry.keys["controller"] for entry in chosen.machines.values()] == controllers
    assert chosen.machines["fork"].keys.get("rate") == rate


def test_the_command_rejects_a_controller_of_no_machine(beside, monkeypatch):
    (beside / "a.trial.yaml").write_text(TRIAL.format(name="Patrol", rate="rate: 10"))
    monkeypatch.chdir(beside)
    outcome = CliRunner().invoke(app, ["run", "a.trial.yaml", "--controller", "spoon=parked"])
    assert outcome.exit_code == 1
    assert "'spoon'" in str(outcome.exception)


def test_a_controller_sees_few_names_of_its_vehicle(beside):
    simulation = sim.Simulation(trial(beside, "Patrol"))
    names = {name for name in dir(simulation.machines["fork"]) if not name.startswith("_")}
    assert {"name", "now", "position", "people", "missions", "twist", "move_to"} <= names
    assert len(names) <= 32
