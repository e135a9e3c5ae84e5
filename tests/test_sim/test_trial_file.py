"""Trial files and their errors."""

import pytest

import bdi
import floorplan
import sim

TRIAL = """\
floorplan: ariac2023
duration: 60
people:
  - name: operator
    personality: antagonistic
    start: {time: 1.5}
    beliefs: ["tired(3)"]
gantry:
  controller: oblivious
  at: [-5.0, 2.5, 0.0]
  jobs:
    - {move: [-2.5, 0.5, 0.0]}
    - {pick: bin2, place: agv1, part: purple pump}
agvs:
  agv1: [{time: 30.0, to: assembly_front}, {time: 40.0, to: 2.5}]
expect:
  penalties: 0
  visits: [station4]
  minimum_separation: ">= 1.0"
"""


def problems(text):
    with pytest.raises(sim.TrialError) as caught:
        sim.Trial.parse(text, file="t.yaml")
    return "\n".join(str(problem) for problem in caught.value.problems)


def test_all_keys_of_a_trial_are_read():
    trial = sim.Trial.parse(TRIAL, file="lunch.trial.yaml")
    assert trial.name == "lunch"
    assert trial.floorplan == floorplan.load("ariac2023")
    assert (trial.duration, trial.seed, trial.rules) == (60.0, 0, sim.PAPER)
    (person,) = trial.people
    assert (person.name, person.personality) == ("operator", "antagonistic")
    assert person.start == sim.Start(time=1.5)
    assert person.beliefs == ("tired(3)",)
    assert trial.gantry.at == (-5.0, 2.5, 0.0)
    assert [job.kind for job in trial.gantry.jobs] == ["move", "pick_place"]
    assert trial.agvs["agv1"] == (sim.AgvMove(30.0, "assembly_front"), sim.AgvMove(40.0, 2.5))
    assert trial.expect["penalties"] == 0


@pytest.mark.parametrize("name", sim.builtin_trials())
def test_every_builtin_trial_loads(name):
    assert sim.Trial.load(name).name == name


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (("duration: 60", "duration: 0"), "line 2, duration: expected more than 0, found 0"),
        (("duration: 60", "duration: 60 m"), "duration: expected a length of time as 12 min"),
        (("duration: 60", "seed: -1"), "seed: expected at least 0"),
        (("duration: 60", f"seed: {2**63}"), "line 2, seed: expected at most"),
        (("duration: 60", f"seed: 0x{'f' * 5000}"), "line 2: is not YAML: a whole number of more"),
        (("duration: 60", f"name: {'9' * 900}"), "line 2, name: expected text, found 999"),
        (("duration: 60", "name: 2026-13-01"), "line 2: is not YAML: '2026-13-01' is not what"),
        (("duration: 60", 'name: "a\\0b"'), "line 2, name: a text can't have the character U+0000"),
        (("duration: 60", f"name: {'x' * 300}"), "line 2, name: invalid folder name"),
        (("duration: 60", "rules: papper"), "did you mean 'paper'?"),
        (("floorplan: ariac2023", "floorplan: ariac2024"), "did you mean 'ariac2023'?"),
        (("personality: antagonistic", "personality: helpfull"), "did you mean 'helpful'?"),
        (("name: operator", "name: gantry"), "another body is called 'gantry' already"),
        (("name: operator", "name: a b"), "line 4, people[0].name"),
        (
            ("{time: 1.5}", "{time: 1}\n    max_speed: 1.0e-300"),
            "max_speed: must be at least 1e-06",
        ),
        (("{time: 1.5}", "{time: -1}"), "people[0].start.time: expected at least 0"),
        (("{time: 1.5}", "{}"), "give one of time, part_placed, order_submitted"),
        (('"tired(3)"', '"tired("'), "people[0].beliefs[0]: is not a belief"),
        (("at: [-5.0, 2.5, 0.0]", "at: [-5.0, 8.5, 0.0]"), "y = 8.5 is outside"),
        (("move: [-2.5, 0.5, 0.0]", "move: [3.5, 0.5, 0.0]"), "gantry.jobs[0].move: x = 3.5"),
        (
            ("place: agv1", "place: warehouse_west"),
            "gantry.jobs[1].place: the gantry can't get to 'warehouse_west': x = -21.875",
        ),
        (("{move: [-2.5, 0.5, 0.0]}", "{pick: bin1}"), "a job is one of"),
        (("agv1:", "agv9:"), "no AGV is called 'agv9'"),
        (("time: 40.0", "time: 4.0"), "put moves in order"),
        (('">= 1.0"', '">> 1.0"'), "expected a number or a comparison"),
        (("people:", "peopel:"), "line 3, peopel: unknown key; did you mean 'people'?"),
        (("controller: oblivious", "controller: oblvious"), "did you mean 'oblivious'?"),
        (("controller: oblivious", "controller: a.b:c"), "there is no a/b.py in"),
        (("controller: oblivious", "controller: a.py:c"), "without its ending: a:c"),
        (
            ("duration: 60", "until_submitted: true"),
            "line 2, until_submitted: no order is submitted",
        ),
    ],
)
def test_invalid_values_are_reported_with_their_place(change, message):
    assert TRIAL.replace(*change) != TRIAL
    assert message in problems(TRIAL.replace(*change))


def test_problems_of_several_kinds_are_reported_together():
    text = TRIAL.replace("personality: antagonistic", "personality: nobody")
    text = text.replace("agv1:", "agv9:").replace("penalties: 0", "penaltys: 0")
    reported = problems(text)
    assert [place in reported for place in ("line 5", "agvs.agv9", "expect.penaltys")] == [True] * 3


def test_a_person_without_a_place_to_start_from(tmp_path):
    (tmp_path / "room.yaml").write_text("boundary: [[0, 0], [9, 0], [9, 9], [0, 9]]\n")
    text = "floorplan: room.yaml\npeople: [{name: a}]\n"
    with pytest.raises(sim.TrialError, match=r"no safe zone to start in; give at: \[x, y\]"):
        sim.Trial.parse(text, folder=tmp_path)
    trial = sim.Trial.parse(text.replace("{name: a}", "{name: a, at: [5, 5]}"), folder=tmp_path)
    assert trial.people[0].at == (5, 5)
    crew = sim.run(
        sim.Trial.parse(text.replace("a}", "a, count: 3, at: anywhere}"), folder=tmp_path)
    )
    assert crew.summary["overlaps"] == 0


def test_people_start_and_are_at_home_at_places_by_name():
    text = "floorplan: ariac2023\npeople: [{name: a, at: station1, home: station4}]\nduration: 60\n"
    run = sim.run(sim.Trial.parse(text))
    stations = run.floorplan.stations
    assert run.motions["a"].position(0.0) == pytest.approx(stations["station1"].position)
    put = [event for event in run.events if event["kind"] == "teleport"]
    assert put == [] or put[0]["to"] == pytest.approx(stations["station4"].position)


@pytest.mark.parametrize("key", ["at", "home"])
def test_an_unknown_name_of_a_place_is_reported(key):
    message = f"people[0].{key}: no station or door is called 'station11'; did you mean 'station1'"
    assert message in problems(f"floorplan: ariac2023\npeople: [{{name: a, {key}: station11}}]\n")


def test_files_are_looked_up_beside_the_trial(tmp_path):
    (tmp_path / "mine.asl").write_text("!wait. +!wait <- .wait(1000).\n")
    path = tmp_path / "a.trial.yaml"
    path.write_text("floorplan: ariac2023\npeople: [{name: a, personality: mine.asl}]\n")
    assert sim.run(sim.Trial.load(path)).duration == 275.0


def test_a_program_with_a_fault_is_reported_with_line_and_column(tmp_path):
    (tmp_path / "mine.asl").write_text("!start.\n+!start <- .wait(1000;\n")
    path = tmp_path / "a.trial.yaml"
    path.write_text("floorplan: ariac2023\npeople: [{name: a, personality: mine.asl}]\n")
    with pytest.raises((sim.TrialError, bdi.ProgramError), match=r"mine.asl.*2"):
        sim.Trial.load(path)


@pytest.mark.parametrize(
    ("name", "text", "words"),
    [
        ("a.yaml", "trials: [x]", "is a study, not a trial"),
        ("a.yaml", "boundary: [[0, 0]]", "is a floorplan, not a trial"),
        ("a.asl", "+a <- b.", "is a program, not a trial"),
    ],
)
def test_a_file_of_another_kind_is_named_by_its_kind(tmp_path, name, text, words):
    (tmp_path / name).write_text(text)
    with pytest.raises(sim.TrialError, match=words):
        sim.Trial.load(tmp_path / name)
    (tmp_path / "trial.yaml").write_text("floorplan: ariac2023")
    with pytest.raises(sim.StudyError, match="is a trial, not a study"):
        sim.Study.load(tmp_path / "trial.yaml")


@pytest.mark.parametrize("name", ["Jörg", "ŁUKASZ", "anna-2", "李"])
def test_names_have_letters_of_any_language(name):
    text = f"floorplan: ariac2023\npeople: [{{name: {name}}}]\n"
    assert sim.Trial.parse(text).people[0].name == name
    for odd in ("2anna", "_anna", "an na", "an.na"):
        assert "letter" in problems(text.replace(name, odd))
