"""A planner by name with parameters, as files, options and Python write it."""

import re

import pytest

import floorplan
from navigation import CollisionWorld, PathPlanner
from navigation.catalog import PlannerChoice


@pytest.mark.parametrize(
    ("given", "name", "parameters"),
    [
        ("RRTConnect", "RRTConnect", {}),
        ("BITstar: {samples_per_batch: 50}", "BITstar", {"samples_per_batch": 50}),
        ({"name": "RRTConnect", "range": 1.0}, "RRTConnect", {"range": 1.0}),
        ("{name: PRM, simplify: false}", "PRM", {"simplify": False}),
        ("my_planner:Straight", "my_planner:Straight", {}),
        ("my_planner:Straight: {step: 0.5}", "my_planner:Straight", {"step": 0.5}),
    ],
)
def test_forms_of_a_choice(given, name, parameters):
    choice = PlannerChoice.of(given)
    assert (choice.name, dict(choice.parameters)) == (name, parameters)
    assert PlannerChoice.of(str(choice)) == choice


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ("", "a planner is a name, or {name: RRTConnect, range: 1.0}; found ''"),
        ("{{", "is not YAML"),
        ({"name": 3}, "found 3 as its name"),
        ("RRT: [1]", "the parameters of RRT are {name: value, …}; found [1]"),
        ({"RRT": {"range": {}}}, "parameter 'range' of RRT must be a value"),
        ("RRTConect", "no planner is called 'RRTConect'; did you mean 'RRTConnect'?"),
        ("STRRTstar", "STRRTstar plans in space and time; navigation.plan_among"),
        ("RRT: {rnge: 1}", "RRT has no parameter 'rnge'; did you mean 'range'?"),
        ("RRT: {range: .nan}", "parameter 'range' must be a number, 0 or more, found nan"),
        ("BITstar: {iterations: 0}", "parameter 'iterations' must be a whole number above 0"),
        ("Roadmap: {range: 1}", "Roadmap has no parameters, found range"),
    ],
)
def test_choices_that_make_no_sense(given, message):
    with pytest.raises(ValueError, match=re.escape(message)):
        PlannerChoice.of(given).check()


def test_a_path_planner_keeps_to_its_choice():
    planner = PathPlanner(
        CollisionWorld(floorplan.load("ariac2023")), planner="RRTConnect: {range: 1.0}"
    )
    question = ((-15.0, -10.0), (-19.0, 0.0))
    path = planner.plan(*question)
    assert path.planner == "RRTConnect"
    other = PathPlanner(planner.world).plan(
        *question, planner="RRTConnect", parameters={"range": 1.0}
    )
    assert path.points.tolist() == other.points.tolist()
    assert planner.plan(*question, planner="Roadmap").planner == "Roadmap"
