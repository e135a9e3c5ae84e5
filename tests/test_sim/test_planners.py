"""Planners of people's paths in trials: by name, with parameters, and custom ones."""

import re

import ompl.geometric as og
import pytest

import sim
from navigation import PlannerError
from navigation.catalog import PlannerChoice
from navigation.roadmap_planner import RoadmapPlanner

PLANNER = """
import ompl.base as ob
import ompl.geometric as og


class Straight(ob.Planner):
    def __init__(self, information, detour=0.0):
        super().__init__(information, "Straight")
        self.detour = detour

    def solve(self, until):
        information = self.getSpaceInformation()
        start = self.getPlannerInputStates().nextStart()
        goal = self.getPlannerInputStates().nextGoal()
        middle = information.allocState()
        middle[0] = (start[0] + goal[0]) / 2
        middle[1] = (start[1] + goal[1]) / 2 + self.detour
        path = og.PathGeometric(information, [start, middle, goal])
        self.getProblemDefinition().addSolutionPath(path)
        return ob.PlannerStatus(ob.PlannerStatus.EXACT_SOLUTION)


class Wrong(Straight):
    def solve(self, until):
        return 1 / 0


class Empty(Straight):
    def solve(self, until):
        path = og.PathGeometric(self.getSpaceInformation())
        self.getProblemDefinition().addSolutionPath(path)
        return ob.PlannerStatus(ob.PlannerStatus.EXACT_SOLUTION)


class Claiming(Straight):
    def solve(self, until):
        return ob.PlannerStatus(ob.PlannerStatus.EXACT_SOLUTION)


class Bare(Straight):
    def solve(self, until):
        return ob.PlannerStatus.EXACT_SOLUTION


class Elsewhere(Straight):
    def solve(self, until):
        information = self.getSpaceInformation()
        place = information.allocState()
        place[0], place[1] = 1.0, 1.5
        self.getProblemDefinition().addSolutionPath(og.PathGeometric(information, [place, place]))
        return ob.PlannerStatus(ob.PlannerStatus.EXACT_SOLUTION)


def nothing():
    pass
"""

FLOOR = """
boundary: [[0, 0], [10, 0], [10, 10], [0, 10]]
obstacles: {{crate: {{x: [4, 6], y: [4, {top}], z: [0, 1]}}}}
stations: {{far: [9, 5]}}
safe_zone: {{at: [1, 5]}}
"""


def trial(folder, planner, *, top=5.2, seed=0, person="{name: ada, personality: go.asl}"):
    (folder / "mine.py").write_text(PLANNER)
    (folder / "hall.yaml").write_text(FLOOR.format(top=top))
    (folder / "go.asl").write_text("+!start : true <- move(9, 5, 0).\n+human_start <- !start.\n")
    text = f"floorplan: hall.yaml\nduration: 30\nseed: {seed}\nplanner: {planner}\n"
    return sim.Trial.parse(f"{text}people: [{person}]", file="t.yaml", folder=folder)


def walked(trial):
    run = sim.run(trial)
    assert run.summary["people"]["ada"]["visits"] == ["far"]
    return run.summary["people"]["ada"]["distance_walked"]


def test_every_run_goes_through_ompl(tmp_path, monkeypatch):
    queries = []

    def note(method, planner):
        def noting(solver, until):
            queries.append(type(planner(solver)))
            return method(solver, until)

        return noting

    setup, roadmap = og.SimpleSetup, RoadmapPlanner
    monkeypatch.setattr(setup, "solve", note(setup.solve, lambda one: one.getPlanner()))
    monkeypatch.setattr(roadmap, "solve", note(roadmap.solve, lambda one: one))
    shortest = walked(trial(tmp_path, "Roadmap"))
    assert queries == [RoadmapPlanner]
    assert walked(trial(tmp_path, "RRTConnect")) >= shortest
    assert queries[1:] == [og.RRTConnect]
    own = "{name: ada, personality: go.asl, planner: {name: BITstar, samples_per_batch: 50}}"
    assert walked(trial(tmp_path, "RRTConnect", person=own)) >= shortest
    assert queries[2:] == [og.BITstar]


def test_samples_depend_on_the_seed_of_the_trial(tmp_path):
    planner = "{name: RRT, simplify: false}"
    assert walked(trial(tmp_path, planner)) == walked(trial(tmp_path, planner))
    assert walked(trial(tmp_path, planner)) != walked(trial(tmp_path, planner, seed=2**63 - 1))


def test_a_custom_planner_with_parameters(tmp_path):
    custom = trial(tmp_path, "{name: 'mine:Straight', detour: 3.0, simplify: false}")
    assert walked(custom) == pytest.approx(10.0, abs=0.01)
    again = sim.Trial.parse(custom.to_yaml(tmp_path), folder=tmp_path)
    assert again.planner == custom.planner


@pytest.mark.parametrize(
    ("planner", "message"),
    [
        ("mine:Wrong", r"mine:Wrong failed \(mine.py, line \d+\): ZeroDivisionError"),
        ("mine:Empty", r"mine:Empty found a path without any place"),
        ("mine:Bare", r"Bare failed \(mine.py, line \d+\): as OMPL asked it; it must .*bad_cast"),
        ("mine:Claiming", r"mine:Claiming returned EXACT_SOLUTION, but added no path"),
        ("mine:Elsewhere", r"starts at \(1.000, 1.500\), not at \(1.000, 5.000\)"),
        ("mine:Straight", r"not free from \(1.000, 5.000\) to \(5.000, 5.000\)"),
        ("'mine:nothing'", r"\(mine.py, line \d+\) is no planner: a planner is a subclass of ompl"),
        ("{name: 'mine:Straight', detur: 1}", r"keyword argument 'detur'; did you mean 'detour'\?"),
        ("{name: 'mine:Straight', detour: x}", r"mine:Straight failed \(mine.py, line \d+\)"),
    ],
)
def test_custom_planners_that_fail(tmp_path, planner, message):
    with pytest.raises(PlannerError, match=message):
        sim.run(trial(tmp_path, planner))


@pytest.mark.parametrize(
    ("planner", "message"),
    [
        ("RRTConect", "line 4, planner: no planner is called 'RRTConect'; did you mean"),
        ("{name: RRT, rnge: 1}", "RRT has no parameter 'rnge'; did you mean 'range'?"),
        ("{name: RRT, range: .nan}", "'range' must be a number, 0 or more, found nan"),
        ("[RRT]", "line 4, planner: a planner is a name, or {name: RRTConnect, range: 1.0}"),
        ("'mine:Strait'", "did you mean 'Straight'?"),
        ("{name: 'mine:Straight', iterations: 0}", "must be a whole number above 0, found 0"),
    ],
)
def test_invalid_planners_are_rejected(tmp_path, planner, message):
    with pytest.raises(sim.TrialError, match=re.escape(message)):
        trial(tmp_path, planner)


def test_custom_code_is_rejected_if_it_is_not_allowed(tmp_path):
    text = trial(tmp_path, "'mine:Straight'").to_yaml(tmp_path)
    with pytest.raises(sim.TrialError, match="code of your own is refused here"):
        sim.Trial.parse(text, folder=tmp_path, own_code=False)


def test_planners_are_varied_in_studies(tmp_path):
    trial(tmp_path, "Roadmap")
    (tmp_path / "t.trial.yaml").write_text(
        "floorplan: hall.yaml\nduration: 30\npeople: [{name: ada, personality: go.asl}]\n"
    )
    study = tmp_path / "s.study.yaml"
    study.write_text(
        "trials: [t.trial.yaml]\n"
        "grid: {planner: [Roadmap, 'RRT: {simplify: false}', 'mine:Straight: {detour: 3.0}']}\n"
    )
    choices = [c.trial.people[0].planner for c in sim.Study.load(study).combinations]
    assert choices[1] == PlannerChoice("RRT", (("simplify", False),))
    assert [choice.name for choice in choices] == ["Roadmap", "RRT", "mine:Straight"]
    study.write_text("trials: [t.trial.yaml]\ngrid: {planner: [RRTConect]}\n")
    with pytest.raises(ValueError, match="no planner is called 'RRTConect'"):
        sim.Study.load(study)
