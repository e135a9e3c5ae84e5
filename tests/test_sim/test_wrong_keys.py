"""Errors of wrong keys and values, with the lines of the files."""

import pytest
from small_floors import GANTRY, LANE, on_floor

import floorplan
import sim

ROOM = """\
boundary: [[0, 0], [9, 0], [9, 9], [0, 9]]
stations: {press: [2, 2]}
obstacles: {wall: {x: [7, 8], y: [4, 5], z: [0, 1]}}
"""
FLOORS = {
    "doors: {a: {between: [[1, 1], [1, 1]]}}": "its two ends are one place",
    "doors: {a: {between: [[1, 1], [1, 3]]}, b: {between: [[0, 2], [2, 2]]}}": "overlaps the door",
    "doors: {a: {between: [[1, 1], [1, 13]]}}": "(1, 13) is outside the boundary",
    "zones: {a: {x: [1, 2], y: [1, 2]}}": "give forbidden: true, or max_speed (m/s)",
    "zones: {a: {x: [1, 3], y: [1, 3], forbidden: true}}": "the station 'press' is in it",
    "zones: {a: {polygon: [[1, 1], [3, 3], [3, 1], [1, 3]], max_speed: 1}}": "not a simple polygon",
    "zones: {wall: {x: [5, 6], y: [5, 6], max_speed: 1}}": "something else is called 'wall'",
    "gates: {a: {between: [[1, 1], [1, 1]], towards: [2, 2]}}": "its two ends are one place",
    "gates: {a: {between: [[0, 1], [9, 1]], towards: [5, 1]}}": "(5, 1) is on its line",
    "gates: {a: {between: [[0, 1], [8, 1]], towards: [5, 2]}}": "1.000 m from the nearest wall",
    "gates: {a: {between: [[0, 1], [9, 1]], towards: [5, 2]},"
    " b: {between: [[0, 2], [9, 0]], towards: [5, 2]}}": "meets the gate 'a'",
    "gates: {a: {between: [[0, 1], [9, 1]]}}": "towards: is missing",
    "gates: {a: {between: [[0, 1], [9, 1]], towards: [5, 2], width: 1}}": "width: unknown key",
    "gates: {a: {between: [[0, 1], [9, 1]], towards: press}}": "a position [x, y]",
    "safe_zone: {at: press}": "a position [x, y]",
    "safe_zone: {at: [4, 4], heading: 90}": "heading: expected radians, found 90: 90° are 1.5708",
    "gates: {wall: {between: [[0, 1], [9, 1]], towards: [5, 2]}}": "else is called 'wall'",
}

HALL = on_floor(
    """\
boundary: [[0, 0], [20, 0], [20, 12], [0, 12]]
obstacles: {middle: {x: [9, 10], y: [4, 6], z: [0, 3]}}
doors: {lower: {between: [[10, 0.2], [10, 3]]}}
safe_zone: {at: [2, 8]}
"""
    + GANTRY
    + LANE,
    "",
)
TRIALS = {
    "doors: {lover: {closed: [[1, 2]]}}": "no door is called 'lover'; did you mean 'lower'?",
    "doors: {lower: {closed: [[5, 2]]}}": "ends before it begins",
    "doors: {lower: {closed: [[1, 5], [4, 9]]}}": "before the previous one ends at 5 s",
    "doors: {lower: {closed: [[500, 501]]}}": "begins at 500 s of the trial, which ends at",
    "doors: {lower: {closed: [[1, 2]], open: [[3, 4]]}}": "give one of closed and open",
    "obstacles: {middle: {x: [1, 2], y: [1, 2], z: [0, 1], there: [[1, 2]]}}": "called 'middle'",
    "obstacles: {a: {x: [1, 2], y: [1, 2], z: [0, 1]}}": "there: is missing",
    "people: [{name: e, at: [2, 6]}]\n"
    "obstacles: {a: {x: [1.9, 3], y: [5, 7], z: [0, 1], there: [[0, 2]]}}": "(2.0, 6.0) is in a, w",
    "people: [{name: e, noticing: {field_of_view: 400}}]": "must be at most 360 degrees",
    "people: [{name: e, noticing: {field_of_view: [90, 20]}}]": "low < high",
    "people: [{name: e, noticing: {reaction_time: {normal: [1]}}}]": "normal[1]: is missing",
    "people: [{name: e, noticing: {occlusion: 3}}]": "expected true or false",
    "people: [{name: e, max_speed: {gauss: [1, 2]}}]": "unknown key; there are: exponential, logn",
    "people: [{name: e, max_speed: {norml: [1, 2]}}]": "norml: unknown key; did you mean 'normal'?",
    "people: [{name: e, start: {tim: 4}}]": "start.tim: unknown key; did you mean 'time'?",
    "machines: {tug: {kind: agv, origin: [2, 2], heading: 90, limits: [0, 4]}}": "expected radians",
    "agvs: {cart: {yields: true}}": "yields: unknown key; did you mean 'yield'?",
    "machines: {van: {kind: agv, orgin: [1, 2]}}": "orgin: unknown key; did you mean 'origin'?",
    "people: [{name: e, max_speed: fast}]": "expected a number, found 'fast'",
    "people: [{name: e, at: {at: middle}}]": "the name of a station or door",
    "people: [{name: e, work: {at: middle}}]": "the name of a work list",
    "people: [{name: e, schedule: {at: middle}}]": "a list of tasks",
    "gantry: {at: middle}": "a pose [x, y, rotation]",
    "rules: {agv_law: {iso_13855: 2}}": "the terms of the law (time)",
    "rules: {agv_law: iso_13855}": "as {iso_13855: {time",
    "rules: {iso_13855: {time: 1}}": "agv_law",
    "blackouts: [{machine: car, seconds: 3}]": "no machine is called 'car'; did you mean",
    "blackouts: [{machine: cart, seconds: 0}]": "expected more than 0",
    "blackouts: [{machine: cart, start: {event: arrivd}, seconds: 1}]": "did you mean",
    "gantry: {jobs: [{pick: middle, place: cart, part: pump}], drops: [{part: pmup}]}": "no job"
    " carries a part called 'pmup'; did you mean 'pump'?",
    "gantry: {drops: [{part: pump, after: -1}]}": "expected at least 0",
    "gantry: {drops: [{part: pump, delay: -1}]}": "expected at least 0",
    "gantry: {drops: [{port: pump}]}": "unknown key; did you mean 'part'?",
}

VARIED = """\
trials: [one.trial.yaml]
grid:
"""
STUDIES = {
    "  rules.gantry_law.t7: [1]": "there is no 't7'; there are: t1, t2",
    "  rules.gantry_law: [1]": "single values",
    "  people.adam.radius: [1]": "there is no 'adam'",
    "  people.eve.radius: [wide]": "expected a",
    "  people.eve.radius: [-1]": "more than 0",
    "  rules.grace: [true]": "expected a number",
    "  gantry.max_speed: [0]": "must be more than 0",
    "  wheels.size: [1]": "nothing is called 'wheels.size' to vary",
    "  seed: [1, 2]": "each of the runs of `repeat: N` has one of its own",
}


def study(text, folder):
    (folder / "one.trial.yaml").write_text("{floorplan: ariac2023, people: [{name: eve}]}")
    return sim.Study.parse(text, folder=folder)


@pytest.mark.parametrize(
    ("read", "before", "wrong", "message"),
    [
        *((lambda text, _: floorplan.parse(text), ROOM, *one) for one in FLOORS.items()),
        *((lambda text, _: sim.Trial.parse(text), HALL, *one) for one in TRIALS.items()),
        *((study, VARIED, *one) for one in STUDIES.items()),
    ],
)
def test_a_wrong_key_or_value_is_reported_with_its_line(tmp_path, read, before, wrong, message):
    with pytest.raises(floorplan.InputError) as refused:
        read(f"{before}{wrong}\n", tmp_path)
    first = next(one for one in refused.value.problems if message in str(one))
    assert first.line - before.count("\n") in range(1, wrong.count("\n") + 2)


@pytest.mark.parametrize(
    ("wrong", "message"),
    [
        ("at: 5", "at: expected a list or text, found 5"),
        ("at: [1]", "at[1]: is missing"),
        ("sink: {at: 3}", "sink: expected a list or text, found {'at': 3}"),
        ("manners: {patience: -3}", "manners.patience: expected more than 0, found -3"),
        ("manners: {comfort: [2, 1]}", "comfort: must be [low, high] with low < high, found [2.0,"),
    ],
)
def test_a_value_that_may_have_several_forms_is_one_problem(wrong, message):
    with pytest.raises(sim.TrialError) as refused:
        sim.Trial.parse(f"{HALL}people: [{{name: e, {wrong}}}]")
    (problem,) = refused.value.problems
    assert message in str(problem)


def test_a_station_at_a_name_is_a_problem():
    with pytest.raises(floorplan.FloorplanError, match=r"office: .*a position \[x, y\]"):
        floorplan.parse(ROOM.replace("press: [2, 2]", "press: [2, 2], office: {at: press}"))


def test_problems_are_in_the_order_of_their_lines():
    text = "sed: 1\npeople:\n  - {name: e, radius: -1}\n  - {nam: f}\nduration: 0\n"
    with pytest.raises(sim.TrialError) as refused:
        sim.Trial.parse(f"floorplan: ariac2023\n{text}")
    assert [problem.line for problem in refused.value.problems] == [2, 4, 5, 5, 6]


@pytest.mark.parametrize(
    ("text", "line", "message"),
    [
        ("floorplan: ariac2023\nrules: {laws: {agx: {fixed: 1}}}", 2, "'agx'; did you mean 'agv"),
        ("floorplan: ariac2023\nrules: {laws: {gantry: {fixed: 1}, agv2: {fixed: 1}}}", 0, ""),
        ("floorplan: ariac2023\nrules: {laws: {agv: {fixed: 1}}}", 0, ""),
        ("floorplan: ariac2023\npeople: [{name: e, max_speed: 5}]", 2, "5 m/s are 18 km/h"),
        ("floorplan: ariac2023\nrules:\n  agv_law: {fixed: 2100}", 3, "agv_law asks for 2,100 m"),
        (
            "people: [{name: guest, count: 2}]\nfloorplan:\n  base: warehouse\n  zones:\n"
            "    a: {x: [1, 2], y: [6, 7], max_speed: 1, concerns: [guest*, tug1, gest1]}",
            5,
            "nobody is called 'gest1'; did you mean 'guest1'?",
        ),
        (
            "floorplan: warehouse\npeople:\n  - {name: e, sink: [2, 2]}\n"
            "  - {name: f, sink: aisle1}\n  - {name: g, sink: [2, 2], personality: visitor}",
            3,
            "those of the personality visitor do",
        ),
        (
            "people: [{name: e}]\nfloorplan:\n  base: warehouse\n  zones:\n"
            "    a: {x: [1, 2], y: [6, 7], max_speed: 1}",
            0,
            "",
        ),
    ],
)
def test_a_likely_mistake_is_noticed(text, line, message):
    reported = sim.Trial.parse(text).notices
    assert [notice.line for notice in reported] == [line] * bool(message)
    assert message in "".join(map(str, reported))


def test_a_name_that_yaml_reads_as_a_flag_is_reported():
    with pytest.raises(floorplan.FloorplanError, match=r"line 4, zones.*put them in quotes"):
        floorplan.parse(f"{ROOM}zones: {{no: {{x: [1, 2], y: [1, 2], max_speed: 1}}}}")
    with pytest.raises(sim.TrialError, match=r"people\[0\].name: .*put them in quotes"):
        sim.Trial.parse("{floorplan: warehouse, people: [{name: on}]}")
