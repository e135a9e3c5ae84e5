"""Machines of any kind: a custom kind, several gantries, an AGV of a trial."""

import json
import re
import shutil
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import shapely
from run_events import record

import floorplan
import navigation
import sim

EXAMPLES = Path(__file__).resolve().parents[2] / "examples"
TWO_GANTRIES = """
floorplan: ariac2023
duration: 60
rules: {rules}
people: [{{name: ada, personality: antagonistic}}]
gantry: {{controller: oblivious, at: [-4.0, 1.0, 0.0], jobs: [{{move: [-6.0, 2.0, 0.0]}}]}}
machines:
  north:
    kind: gantry
    x: [-14.0, -8.0]
    at: [-9.0, 3.0, 0.0]
    controller: oblivious
    jobs: [{{move: [-12.0, 0.0, 0.0]}}, {{wait: 2.0}}]
    repeat: true
"""


@pytest.fixture(scope="module")
def recorded(tmp_path_factory):
    """The run of the example of a custom kind, and its recording."""
    folder = tmp_path_factory.mktemp("tugger")
    run = record(sim.Trial.load(EXAMPLES / "tugger.trial.yaml"), folder)
    return run, folder


def test_a_custom_kind_is_monitored_and_can_be_expected(recorded):
    run, _ = recorded
    assert run.unmet == []
    assert run.summary["machines"]["train"] == {"kind": "tugger", "rounds": 7}
    violations = [event for event in run.events if event.get("with") == "train"]
    assert {event["cause"] for event in violations} == {"tugger"}
    assert run.summary["agv_violations"] == len(violations) > 0
    assert run.violations["operator", "train"]
    for event in violations:
        t = event["t"]
        law = run.scene.rules.agv_law
        just_before = run.distance("operator", "train", t - 1e-9)
        assert just_before == pytest.approx(event["distance"], abs=1e-6)
        assert event["distance"] <= law.distance(event["human_speed"], event["robot_speed"]) + 1e-6
    one = replace(run.trial, expect={"agv_violations": 1})
    assert [verdict.time for verdict in sim.run(one).verdicts] == [violations[-1]["t"]]
    few = replace(run.trial, expect={"machines.train.rounds": "< 7", "machines.train.wheels": 4})
    assert [verdict.met for verdict in sim.run(few).verdicts] == [False, False]
    slip = replace(run.trial, expect={"machines.train.round": 7})
    assert "'rounds'" in sim.run(slip).verdicts[0].found
    with pytest.raises(sim.TrialError, match="'train'"):
        sim.run(replace(run.trial, expect={"machines.trian.rounds": 7}))
    wrong = replace(run.trial, expect={"timeline": [{"never": {"kind": "violation", "by": "x"}}]})
    with pytest.raises(sim.TrialError, match="no field 'by'"):
        sim.run(wrong)


def test_the_command_prints_figures_of_a_custom_kind_and_not_of_an_absent_gantry(
    tmp_path, floorwalker
):
    shutil.copy(EXAMPLES / "tugger.py", tmp_path)
    (tmp_path / "yard.trial.yaml").write_text(
        "floorplan: {boundary: [[0, 0], [20, 0], [20, 9], [0, 9]], stations: {a: [1, 1]}}\n"
        "duration: 60\npeople: [{name: eve, at: [10, 8]}]\n"
        "machines: {train: {kind: 'tugger:Tugger', course: [[3, 3], [9, 3], [9, 5]]}}\n"
    )
    done = floorwalker("run", "yard.trial.yaml", "--out", "run", cwd=tmp_path)
    rows = [re.split(r"\s{2,}", line.strip()) for line in done.stdout.splitlines()]
    figures = dict(row for row in rows if len(row) == 2)
    assert figures["train"] == "rounds 2" and "jobs done" not in figures
    with pytest.raises(sim.TrialError, match="minimum_separation: a run has no such figure"):
        sim.Trial.parse(
            "{floorplan: warehouse, people: [{name: a}], expect: {minimum_separation: 1}}"
        )


def test_a_custom_kind_is_recorded_and_read_back(recorded):
    run, folder = recorded
    back = sim.load_run(folder)
    shape = back.scene.machine("train")
    assert shape == run.scene.machine("train")
    assert (shape.kind, shape.category) == ("tugger", "vehicle")
    assert back.motions["train"] == run.motions["train"]
    assert set(back.sample(1.0)) == {"t", *run.motions}
    assert "train" in run.metrics["machines"]
    page = (folder / "replay.html").read_text("utf-8")
    assert '"name":"train"' in page.replace(" ", "")


def test_a_custom_kind_is_plotted_and_exported(recorded, tmp_path):
    run, _ = recorded
    pytest.importorskip("matplotlib")
    shown = run.plot.trails()
    assert len(shown.axes[0].lines) > len(run.motions)
    pytest.importorskip("foxglove")
    sim.export(run, tmp_path / "run.mcap")
    assert b"train" in (tmp_path / "run.mcap").read_bytes()


def test_people_see_a_custom_machine_and_walk_around_it(tmp_path):
    shutil.copy(EXAMPLES / "tugger.py", tmp_path)
    (tmp_path / "looks.asl").write_text(
        '+human_start <- ?machine(train, Kind, X, Y, V); .print(Kind, " ", X, " ", Y);'
        " move(-12, -5, 0).",
        encoding="utf-8",
    )
    trial = sim.Trial.parse(
        """
floorplan: ariac2023
duration: 40
rules: observe
people: [{name: ada, personality: looks.asl, at: [-12.0, -10.8]}]
machines:
  train: {kind: "tugger:Tugger", course: [[-12, -9], [-11, -9], [-11, -8]], stop: 1000.0, speed: 3}
""",
        folder=tmp_path,
    )
    run = sim.run(trial)
    (said,) = (event for event in run.events if event["kind"] == "said")
    assert said["text"] == "tugger -12 -9"
    assert any(event["kind"] == "arrived" for event in run.events)
    t = np.arange(10.0, 40.0, 0.1)
    apart = run.motions["ada"].position(t) - run.motions["train"].position(t)
    half = (1.8 / 2, 0.9 / 2)
    gap = np.hypot(*np.maximum(np.abs(apart) - half, 0.0).T)
    assert gap.min() > 0.3 - 1e-3


def test_a_protective_stop_holds_a_custom_kind(recorded):
    run, _ = recorded
    stopped = sim.run(replace(run.trial, rules=sim.RULE_SETS["protective_stop"], expect={}))
    stops = [
        e for e in stopped.events if e["kind"] == "protective_stop" and e["machine"] == "train"
    ]
    assert stops
    for event in stops:
        stop = 1.2 / 0.6
        assert stopped.motions["train"].state(event["t"] + stop).speed < 1e-5


@pytest.mark.parametrize(
    ("keys", "words"),
    [
        ("{kind: nothing}", "no kind of machine is called 'nothing'"),
        ("{kind: 'tugger:Tram'}", "tugger.py defines no class or function 'Tram'"),
        ("{kind: gantry, at: [0, 0, 0], speed: 3}", "machines.train.speed: unknown key"),
        ("{kind: gantry, at: [99, 0, 0]}", "machines.train.at: x = 99"),
        ("{kind: agv, origin: [0, 0]}", "machines.train.limits: is missing"),
        ("{course: [[0, 0]]}", "machines.train.kind: no kind"),
    ],
)
def test_errors_of_a_machine_have_their_place(tmp_path, keys, words):
    shutil.copy(EXAMPLES / "tugger.py", tmp_path)
    with pytest.raises(sim.TrialError) as refused:
        sim.Trial.parse(f"floorplan: ariac2023\nmachines:\n  train: {keys}\n", folder=tmp_path)
    assert words in str(refused.value)


def test_keys_of_a_custom_kind_are_checked_before_the_run(tmp_path):
    shutil.copy(EXAMPLES / "tugger.py", tmp_path)
    text = "floorplan: ariac2023\nmachines: {train: {kind: 'tugger:Tugger', course: 3}}\n"
    trial = sim.Trial.parse(text, folder=tmp_path)
    with pytest.raises(floorplan.UserError, match="'train': course"):
        sim.run(trial)
    text = text.replace("course: 3", "course: [[0, 0], [1, 1]]")
    with pytest.raises(floorplan.UserError, match="at least three corners"):
        sim.run(sim.Trial.parse(text, folder=tmp_path))
    with pytest.raises(sim.TrialError, match="refused"):
        sim.Trial.parse(text, folder=tmp_path, own_code=False)


OWN = """
import dataclasses

import navigation
import sim
from tugger import Train, Tugger


class Stops(Train):
    def begin(self):
        self._rest.set(5.0)

    def _stands(self):
        {}["a"]


class Counts(Train):
    def figures(self, motion, now):
        return {"rounds": {1, 2}}


@dataclasses.dataclass(frozen=True)
class Failing(Tugger):
    def make(self, name, stage):
        return Stops(self, name, stage)


@dataclasses.dataclass(frozen=True)
class Counting(Tugger):
    def make(self, name, stage):
        return Counts(self, name, stage)


class Jumps(Train):
    def begin(self):
        self.body.follow(navigation.standing((3.0, 3.0)))


@dataclasses.dataclass(frozen=True)
class Jumping(Tugger):
    def make(self, name, stage):
        return Jumps(self, name, stage)


class Asks(Train):
    def begin(self):
        planner = navigation.PathPlanner(navigation.CollisionWorld(self._stage.floorplan), 0.3)
        planner.plan(self.body.at, (-100.0, 0.0))


@dataclasses.dataclass(frozen=True)
class Asking(Tugger):
    def make(self, name, stage):
        return Asks(self, name, stage)


class Rushes(Train):
    def begin(self):
        self.body.follow(navigation.walk([self.body.at, (-2.0, -9.0)], max_speed=2.0))


@dataclasses.dataclass(frozen=True)
class Rushing(Tugger):
    def make(self, name, stage):
        return Rushes(self, name, stage)


class Mute(Train):
    def figures(self, motion, now):
        pass


@dataclasses.dataclass(frozen=True)
class Uncounted(Tugger):
    def make(self, name, stage):
        return Mute(self, name, stage)


@dataclasses.dataclass(frozen=True)
class Flying(Tugger):
    def shape(self, name, plan):
        return dataclasses.replace(super().shape(name, plan), category="drone")


@dataclasses.dataclass(frozen=True)
class Nothing(Tugger):
    def make(self, name, stage):
        return 3


@dataclasses.dataclass(frozen=True)
class Half(sim.MachineModel):
    def make(self, name, stage):
        pass
"""


@pytest.mark.parametrize(
    ("kind", "words"),
    [
        ("Failing", r"code of your own failed at t = 5 s \(own.py, line 14\): KeyError: 'a'"),
        (
            "Asking",
            r"code of your own failed at t = 0 s \(own.py, line \d+\): PlanningError: .*goal",
        ),
        ("Counting", "the figures of the machine 'train': Object of type set"),
        ("Jumping", "the machine 'train' jumps at t = 0 s"),
        ("Rushing", r"'train' is faster at t = 0.48\d* s than the top speed of its shape, 1.2 m/s"),
        ("Uncounted", "the figures of the machine 'train': expected a dict, found None"),
        ("Flying", r"own.py, line \d+\).*category of a machine is robot or vehicle, not .drone."),
        ("Nothing", "the machine 'train': make returned 3, not a sim.Machine"),
        ("Half", "is no machine: a machine is a dataclass derived from sim.MachineModel"),
    ],
)
def test_errors_of_a_custom_kind_have_their_place(tmp_path, kind, words):
    shutil.copy(EXAMPLES / "tugger.py", tmp_path)
    (tmp_path / "own.py").write_text(OWN, encoding="utf-8")
    text = f"floorplan: ariac2023\nduration: 9\nmachines: {{train: {{kind: 'own:{kind}',"
    trial = sim.Trial.parse(f"{text} course: [[-10, -9], [0, -9], [0, -7]]}}}}", folder=tmp_path)
    with pytest.raises(ValueError, match=words):
        sim.run(trial)


@pytest.mark.parametrize("rules", ["paper", "protective_stop"])
def test_several_gantries_work_on_one_floor(rules):
    trial = sim.Trial.parse(TWO_GANTRIES.format(rules=rules))
    assert sim.Trial.parse(trial.to_yaml()) == trial
    run = sim.run(trial)
    machines = run.summary["machines"]
    assert machines["gantry"]["jobs_done"] == 1
    assert machines["north"]["jobs_done"] > 2
    assert (
        run.summary["jobs_done"] == machines["gantry"]["jobs_done"] + machines["north"]["jobs_done"]
    )
    x = run.motions["north"].position(np.linspace(0.0, 60.0, 601))[:, 0]
    assert x.min() >= -14.0 - 1e-9 and x.max() <= -8.0 + 1e-9
    named = {e.get("machine", "gantry") for e in run.events if e["kind"] == "job_done"}
    assert named == {"gantry", "north"}
    assert {name for _, name in run.violations} >= {"gantry", "north"}
    disabled = run.summary["gantry_disabled_time"]
    assert disabled == pytest.approx(sum(machines[m]["disabled_time"] for m in ("gantry", "north")))


def test_the_minimum_separation_is_to_the_nearest_of_several_gantries():
    """The first gantry is near the person, and the second is far away."""
    text = TWO_GANTRIES.format(rules="observe").replace("{name: ada", "{name: ada, at: [-3, 0]")
    run = sim.run(sim.Trial.parse(text.replace("duration: 60", "duration: 3")))
    t = np.linspace(0.0, 3.0, 3001)
    least = min(run.distance("ada", name, t).min() for name in ("gantry", "north"))
    separation = run.summary["people"]["ada"]["minimum_separation"]
    assert separation["distance"] == pytest.approx(least, abs=1e-3)
    assert run.summary["minimum_separation"] == separation


def test_a_trial_adds_an_agv_and_a_law():
    trial = sim.Trial.parse(
        """
floorplan: ariac2023
duration: 30
rules: {laws: {cart: {fixed: 0.7}}}
people: [{name: ada}]
machines:
  cart:
    kind: agv
    origin: [-12.0, -9.0]
    limits: [0.0, 10.0]
    locations: {far: 8.0}
    moves: [{time: 2.0, to: far}]
expect: {timeline: [{eventually: {kind: agv_moved, agv: cart}}]}
"""
    )
    assert trial.rules.laws == {"cart": navigation.FixedDistance(0.7)}
    assert sim.Trial.parse(trial.to_yaml()) == trial
    run = sim.run(trial)
    assert run.unmet == []
    assert run.motions["cart"].position(30.0) == pytest.approx([-4.0, -9.0])
    assert run.required("ada", "cart", [1.0, 5.0]) == pytest.approx([0.7, 0.7])
    assert json.loads(json.dumps(run.summary))["machines"]["cart"] == {"kind": "agv"}


def moves_at(run, agv):
    return [(e["t"], e["to"]) for e in run.events if e["kind"] == "agv_moved" and e["agv"] == agv]


def test_moves_are_repeated_on_every_lane():
    text = """
floorplan: ariac2023
duration: 60
people: [{name: ada}]
agvs: {agv1: MOVES}
machines:
  cart: {kind: agv, origin: [-12.0, -9.0], limits: [0.0, 10.0], locations: {far: 1.0}, moves: MOVES}
"""
    again = "[{time: 15, to: 0.0, every: 20}, {time: 5, to: 1.0, every: 20}]"
    once = ", ".join(f"{{time: {5 + 10 * k}, to: {1.0 - k % 2}}}" for k in range(6))
    one, other = (sim.Trial.parse(text.replace("MOVES", moves)) for moves in (again, f"[{once}]"))
    assert sim.Trial.parse(one.to_yaml()) == one
    run = sim.run(one)
    assert run.events == sim.run(other).events
    assert len(moves_at(run, "cart")) == len(moves_at(run, "agv1")) == 6
    made = replace(one, agvs={"agv1": (sim.AgvMove(15, 0.0, 20), sim.AgvMove(5, 1.0, 20))})
    assert sim.run(made).events == run.events
    assert sim.Trial.parse(made.to_yaml()).agvs == one.agvs


def test_no_event_comes_before_the_start():
    heard = []

    class Ears(sim.Listener):
        def begin(self, scene):
            heard.append(scene)

        def event(self, event):
            heard.append(event["kind"])

    simulation = sim.Simulation(sim.Trial.load("ariac2023"), Ears())
    assert heard == [] and simulation.events == []
    simulation.start()
    assert heard == [simulation.scene, "trial_started"]
    simulation.start()
    assert len(heard) == 2


def test_people_cannot_start_inside_a_custom_machine(tmp_path):
    """The train covers most of a short hall, and stands where its course begins."""
    shutil.copy(EXAMPLES / "tugger.py", tmp_path)
    text = """
floorplan:
  boundary: [[0, 0], [4, 0], [4, 3], [0, 3]]
duration: 0.01
people: [{name: p, count: 3, radius: 0.2, at: anywhere, personality: external}]
machines:
  train: {kind: "tugger:Tugger", course: [[1.2, 1], [2.8, 1], [2.8, 2]]}
"""
    trial = sim.Trial.parse(text, folder=tmp_path)
    for seed in range(10):
        run = sim.run(replace(trial, seed=seed))
        x, y, turned = run.motions["train"].state(0.0).position
        body = run.scene.machine("train").footprint((x, y), turned)
        for k in (1, 2, 3):
            at = shapely.Point(run.motions[f"p{k}"].position(0.0))
            assert body.distance(at) >= 0.2
