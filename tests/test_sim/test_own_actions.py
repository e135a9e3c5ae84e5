"""Custom internal actions and functions in a trial."""

import pytest

import bdi
import sim

MODULE = """
import bdi

actions = bdi.InternalActions()

@actions.add("floor.twice", least=2, most=2)
def twice(call, x, result):
    return call.unify(result, 2 * x)

@actions.function("my.half")
def half(x):
    return x / 2
"""
PROGRAM = """+human_start <- floor.twice(3, X); .print("got ", X, " ", my.half(X) + 1)."""
TRIAL = """
floorplan: ariac2023
duration: 1
gantry: {controller: parked}
people:
  - {name: ann, personality: one.asl, actions: own.module}
  - {name: bob, personality: polite, at: [-18.0, 0.0]}
"""


@pytest.fixture
def folder(tmp_path):
    for name in ("own", "polite"):
        (tmp_path / name).mkdir()
    (tmp_path / "own" / "module.py").write_text(MODULE, encoding="utf-8")
    (tmp_path / "polite" / "helpers.py").write_text(MODULE, encoding="utf-8")
    (tmp_path / "polite" / "words.py").write_text("raise SystemExit", encoding="utf-8")
    for file in ("one.asl", "polite/polite.asl"):
        (tmp_path / file).write_text(PROGRAM, encoding="utf-8")
    (tmp_path / "own.trial.yaml").write_text(TRIAL, encoding="utf-8")
    return tmp_path


def said(run):
    return [(event["person"], event["text"]) for event in run.events if event["kind"] == "said"]


def test_programs_use_the_actions_that_a_trial_names_and_those_in_their_folder(folder):
    trial = sim.Trial.load(folder / "own.trial.yaml")
    assert said(sim.run(trial)) == [("ann", "got 6 4"), ("bob", "got 6 4")]
    again = sim.Trial.parse(trial.to_yaml(folder), folder=folder)
    assert again.people[0].actions == "own.module"
    polite = trial.with_personality("polite")
    assert said(sim.run(polite)) == [("ann", "got 6 4"), ("bob", "got 6 4")]


def test_actions_of_a_person_or_folder_precede_those_of_the_trial(folder):
    everybody = (
        MODULE.replace("2 * x", "x").replace("x / 2", "x")
        + """
@actions.add("my.name", least=1, most=1)
def name(call, result):
    return call.unify(result, call.agent.name)
"""
    )
    (folder / "everybody.py").write_text(everybody, encoding="utf-8")
    (folder / "two.asl").write_text(PROGRAM[:-1] + "; my.name(N); .print(N).", encoding="utf-8")
    (folder / "all.trial.yaml").write_text(
        f"actions: everybody\n{TRIAL}"
        "  - {name: cyd, personality: two.asl, at: [-17.0, 2.0]}\n"
        "  - name: dan\n"
        "    at: [-17.0, 4.0]\n"
        "    changes: [{when: {time: 0.5}, personality: late.asl}]\n",
        encoding="utf-8",
    )
    (folder / "late.asl").write_text("!go. +!go <- my.name(N); .print(N).", encoding="utf-8")
    trial = sim.Trial.load(folder / "all.trial.yaml")
    expected = [
        ("ann", "got 6 4"),
        ("bob", "got 6 4"),
        ("cyd", "got 3 4"),
        ("cyd", "cyd"),
        ("dan", "dan"),
    ]
    assert said(sim.run(trial)) == expected
    again = sim.Trial.parse(trial.to_yaml(folder), folder=folder)
    assert said(sim.run(again)) == expected
    with pytest.raises(
        sim.TrialError,
        match=r"line 1, actions: the actions of 'everybody': code of your own is refused",
    ):
        sim.Trial.load(folder / "all.trial.yaml", own_code=False)
    elsewhere = f"folder: ../{folder.name}\n{trial.to_yaml(folder)}"
    with pytest.raises(sim.TrialError, match=r"its code, everybody, own\.module, stands in"):
        sim.Trial.parse(elsewhere, folder=folder.parent / "elsewhere")


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (("own.module", "own.nothing"), "there is no own/nothing.py"),
        (("own.module", "a" * 300), "line 6, people[0].actions: the actions of 'aaaa"),
        (("own.module", "polite.words"), "has no function with @actions.add"),
        (("floor.twice", "floor.thrice"), "there is no internal action floor.twice"),
    ],
)
def test_missing_actions_are_reported_with_their_place(folder, change, message):
    for file in ("own.trial.yaml", "own/module.py"):
        path = folder / file
        path.write_text(path.read_text(encoding="utf-8").replace(*change), encoding="utf-8")
    with pytest.raises((sim.TrialError, bdi.ProgramError)) as error:
        sim.Trial.load(folder / "own.trial.yaml")
    assert message in str(error.value)


def test_custom_actions_are_rejected_without_permission_for_custom_code(folder):
    with pytest.raises(sim.TrialError) as error:
        sim.Trial.load(folder / "own.trial.yaml", own_code=False)
    assert str(error.value).count("code of your own is refused here") == 2


FAULTS = {
    "    x = []\n    return x[5]": r"failed at t = 0 s \(module.py, line 9\): IndexError",
    '    return "done"': "floor.twice returned 'done', not True, False",
}


@pytest.mark.parametrize("body", FAULTS)
def test_a_failing_action_is_named_with_its_line(folder, body):
    text = MODULE.replace("    return call.unify(result, 2 * x)", body)
    (folder / "own" / "module.py").write_text(text, encoding="utf-8")
    (folder / "polite" / "helpers.py").write_text(MODULE, encoding="utf-8")
    with pytest.raises(ValueError, match=FAULTS[body]):
        sim.run(sim.Trial.load(folder / "own.trial.yaml"))


def test_a_function_that_accepts_no_numbers_is_reported_as_failing(folder):
    text = MODULE.replace("x / 2", 'x / "2"')
    (folder / "own" / "module.py").write_text(text, encoding="utf-8")
    with pytest.raises(ValueError, match=r"\(module.py, line 12\): TypeError"):
        sim.run(sim.Trial.load(folder / "own.trial.yaml"))
