"""Study files and their errors."""

import statistics
from dataclasses import replace

import pytest
from hypothesis import given, settings, strategies as st

import sim
from sim.studies import Choice, Normal, Shuffled, Uniform, variable

TRIAL = """\
floorplan: ariac2023
duration: 20
people:
  - {name: ada}
  - {name: ben, start: {order_submitted: A}}
gantry:
  controller: oblivious
  jobs:
    - {pick: bin1, place: agv1}
    - {pick: bin2, place: agv1}
    - {pick: bin3, place: agv1}
    - {submit: A}
    - {pick: bin5, place: agv4}
    - {pick: bin6, place: agv4}
agvs:
  agv1: [{time: 5.0, to: as1}]
  agv2: [{time: 6.0, to: as1}, {time: 9.0, to: kitting}]
"""

BUSY = sim.Trial.parse(TRIAL)

STUDY = """\
trials: [ariac2023, busy.trial.yaml]
grid:
  personality: [indifferent, helpful]
  people.operator.max_speed: [0.8, 1.2]
random:
  agv_delay: {uniform: [0, 30]}
  gantry_at: {uniform: [[-10, -3, 0], [-1, 3, 0]]}
repeat: 5
seed: 3
"""


@pytest.fixture
def folder(tmp_path):
    (tmp_path / "busy.trial.yaml").write_text(TRIAL)
    return tmp_path


def one_person(text):
    return text.replace("[ariac2023, busy.trial.yaml]", "[ariac2023]")


def problems(text, folder):
    with pytest.raises(sim.StudyError) as caught:
        sim.Study.parse(text, file="s.yaml", folder=folder)
    return "\n".join(str(problem) for problem in caught.value.problems)


def test_the_rows_of_a_study(folder):
    study = sim.Study.parse(one_person(STUDY), file="lunch.study.yaml", folder=folder)
    assert (study.name, len(study)) == ("lunch", 20)
    rows = list(study.rows())
    assert [row.number for row in rows] == list(range(20))
    chosen = [
        (r.parameters["personality"], r.parameters["people.operator.max_speed"]) for r in rows
    ]
    assert chosen[:5] == [
        ("indifferent", 0.8),
        ("indifferent", 1.2),
        ("helpful", 0.8),
        ("helpful", 1.2),
        ("indifferent", 0.8),
    ]
    row = rows[6]
    assert row.parameters["repetition"] == 1
    (person,) = row.trial.people
    assert (person.personality, person.max_speed) == ("helpful", 0.8)
    assert row.trial.gantry.at == row.parameters["gantry_at"]
    delay = row.parameters["agv_delay"]
    assert row.trial.agvs["agv1"][0].time == pytest.approx(30.0 + delay)
    assert row.trial.seed == row.parameters["seed"]
    assert study.row(6) == row
    with pytest.raises(ValueError, match="has rows 0 to 19, but no row 20"):
        study.row(20)


def test_repetitions_draw_different_values_and_combinations_the_same(folder):
    rows = list(sim.Study.parse(one_person(STUDY), folder=folder).rows())
    drawn = [(row.parameters["agv_delay"], row.parameters["gantry_at"]) for row in rows]
    assert len(set(drawn)) == 5
    assert all(len(set(drawn[k : k + 4])) == 1 for k in range(0, 20, 4))
    assert len({row.trial.seed for row in rows}) == 20


@settings(max_examples=5)
@given(st.permutations(["indifferent", "helpful", "curious"]), st.integers(1, 3))
def test_a_row_does_not_depend_on_the_rest_of_the_study(personalities, repeat):
    def rows(personalities, repeat):
        text = f"trials: [ariac2023]\ngrid: {{personality: {list(personalities)}}}\n"
        text += f"random: {{agv_delay: {{uniform: [0, 9]}}}}\nrepeat: {repeat}\n"
        study = sim.Study.parse(text)
        return {
            (row.parameters["personality"], row.parameters["repetition"]): row.parameters
            for row in study.rows()
        }

    few = rows(personalities[:2], repeat)
    all_of_them = rows(["indifferent", "helpful", "curious"], 3)
    assert all(all_of_them[key] == row for key, row in few.items())


def test_seeds_stay_the_same_between_versions():
    study = sim.Study.parse("trials: [ariac2023]\nrandom: {agv_delay: {uniform: [0, 9]}}\n")
    assert study.row(0).parameters == {
        "trial": "ariac2023",
        "agv_delay": 1.680246,
        "repetition": 0,
        "seed": 1642531032097228914,
    }


def personalities(trial):
    return [person.personality for person in trial.people]


def speeds(trial):
    return [person.max_speed for person in trial.people]


def picks(trial):
    return "".join(job.pick[-1:] or "-" for job in trial.gantry.jobs)


def times(trial):
    return [move.time for moves in trial.agvs.values() for move in moves]


@pytest.mark.parametrize(
    ("name", "value", "figure", "expected"),
    [
        ("personality", "curious", personalities, ["curious", "curious"]),
        ("people.ben.personality", "curious", personalities, ["indifferent", "curious"]),
        ("max_speed", 1.4, speeds, [1.4, 1.4]),
        ("people.ada.max_speed", 1.4, speeds, [1.4, None]),
        ("start_time", 7.0, lambda trial: [p.start.time for p in trial.people], [7.0, None]),
        ("controller", "parked", lambda trial: trial.gantry.controller, "parked"),
        ("gantry_at", (-5, 2, 1), lambda trial: trial.gantry.at, (-5.0, 2.0, 1.0)),
        ("job_order", "given", picks, "123-56"),
        ("job_order", "reversed", picks, "321-65"),
        ("job_order", (5, 4, 3, 2, 1, 0), picks, "65-321"),
        ("agv_delay", -5.5, times, [0.0, 0.5, 3.5]),
        ("agvs.agv2.delay", 1.0, times, [5.0, 7.0, 10.0]),
        ("rules", "ariac2023", lambda trial: trial.rules, sim.RULE_SETS["ariac2023"]),
        ("duration", 5, lambda trial: trial.duration, 5.0),
    ],
)
def test_values_of_a_trial_can_be_varied(folder, name, value, figure, expected):
    assert value == "given" or figure(BUSY) != expected
    assert figure(variable(name).put(BUSY, value, folder)) == expected


@pytest.mark.parametrize(
    ("name", "own", "value", "values", "figure", "expected"),
    [
        ("personality", "people.ben", "helpful", ("scared", "curious"), personalities, "helpful"),
        ("max_speed", "people.ben", 1.5, (0.5, 0.6), speeds, 1.5),
    ],
)
@pytest.mark.parametrize("places", ["gg", "gr", "rg", "rr"])
@pytest.mark.parametrize("own_first", [True, False])
def test_a_value_of_one_person_takes_precedence_over_that_of_all(
    name, own, value, values, figure, expected, places, own_first
):
    own = f"{own}.{name}"
    entries = [(variable(own), values, places[0]), (variable(name), (value,), places[1])]
    entries = entries if own_first else entries[::-1]
    study = sim.Study(
        "s",
        (BUSY,),
        grid={what: choices for what, choices, place in entries if place == "g"},
        random={what: Choice(choices) for what, choices, place in entries if place == "r"},
        repeat=3,
    )
    for row in study.rows():
        assert figure(row.trial) == [expected, row.parameters[own]]


def test_the_delay_of_one_agv_is_not_added_to_that_of_all():
    study = sim.Study(
        "s", (BUSY,), grid={variable("agvs.agv2.delay"): (1.0,), variable("agv_delay"): (5.0,)}
    )
    assert times(study.row(0).trial) == [10.0, 7.0, 10.0]


def test_an_unknown_variable_lists_the_known_ones():
    from sim.studies import KINDS

    with pytest.raises(ValueError, match=r"'weather' to vary; there are.*path.*machines"):
        variable("weather")
    for kind in KINDS:
        assert variable(kind).name == kind


@given(st.integers(0, 2**63 - 1))
def test_shuffled_jobs_stay_before_their_order(seed):
    order = Shuffled().draw(seed, BUSY)
    assert sorted(order[:3]) == [0, 1, 2]
    assert order[3] == 3
    assert sorted(order[4:]) == [4, 5]


@given(st.integers(0, 2**63 - 1))
def test_draws_stay_within_their_bounds(seed):
    assert 0.5 <= Uniform(0.5, 0.6).draw(seed, BUSY) <= 0.6
    x, y = Uniform((0.0, 5.0), (1.0, 6.0)).draw(seed, BUSY)
    assert 0 <= x <= 1 and 5 <= y <= 6
    assert 0.9 <= Normal(1.0, 5.0, 0.9, 1.2).draw(seed, BUSY) <= 1.2
    assert Choice(("a", 2.0)).draw(seed, BUSY) in ("a", 2.0)


def test_draws_follow_their_distributions():
    normal = [Normal(1.0, 0.2, 0.4, 1.6).draw(seed, BUSY) for seed in range(4000)]
    assert statistics.mean(normal) == pytest.approx(1.0, abs=0.02)
    assert statistics.stdev(normal) == pytest.approx(0.2, abs=0.01)
    assert str(Normal(1.2, 0.2, 1.2 - 3 * 0.2, 1.8)) == "normal, 1.2 ± 0.2, from 0.6 to 1.8"
    uniform = [Uniform(0.0, 1.0).draw(seed, BUSY) for seed in range(4000)]
    assert statistics.mean(uniform) == pytest.approx(0.5, abs=0.02)
    assert statistics.stdev(uniform) == pytest.approx(12**-0.5, abs=0.01)
    orders = {Shuffled().draw(seed, BUSY) for seed in range(200)}
    assert len(orders) == 12


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (("trials: [ariac2023, busy.trial.yaml]", "trials: []"), "line 1, trials: expected a list"),
        (("trials: [ariac2023, ", "trials: [ariac, "), "line 1, trials[0]: ariac: no such file"),
        (("trials: [ariac2023, ", "trials: [busy.trial.yaml, "), "'busy.trial.yaml' stands twice"),
        (("[ariac2023, ", "[./busy.trial.yaml, "), "another trial is called 'busy'"),
        (("busy.trial.yaml", "none.trial.yaml"), "there is no such file"),
        (("grid:", "girds:"), "girds: unknown key; did you mean 'grid'?"),
        (("[indifferent, helpful]", "[]"), "line 3, grid.personality: has no values"),
        (("[indifferent, helpful]", "[helpful, helpful]"), "grid.personality[1]: 'helpful' stands"),
        (("[indifferent, helpful]", "[helpfull]"), "did you mean 'helpful'?"),
        (("[indifferent, helpful]", "helpful"), "grid.personality: expected a list"),
        (("personality:", "personalty:"), "did you mean 'personality'?"),
        (("[0.8, 1.2]", "[0.8, -1.2]"), "line 4, grid.people.operator.max_speed[1]"),
        (("people.operator", "people.nobody"), "there is no 'nobody'"),
        (("[0, 30]}", "[30, 0]}"), "line 6, random.agv_delay: uniform has to be [low, high]"),
        (("{uniform: [0, 30]}", "{uniform: [0, 30], choice: [1]}"), "give one of uniform"),
        (("{uniform: [0, 30]}", "{normal: [0, 30], within: [1, 2]}"), "within has to be"),
        (("{uniform: [0, 30]}", "{normal: [0, -3]}"), "random.agv_delay.normal[1]: expected more"),
        (("{uniform: [0, 30]}", "{choice: []}"), "random.agv_delay.choice"),
        (("{uniform: [0, 30]}", "shuffled"), "expected uniform, normal or choice"),
        (("agv_delay: {uniform", "job_order: {uniform"), "random.job_order"),
        (("agv_delay: {uniform", "personality: {uniform"), "stands in the grid as well"),
        (("[-1, 3, 0]]", "[-1, 3]]"), "random.gantry_at: uniform has to be"),
        (("[-1, 3, 0]]", "[-1, 8, 0]]"), "y = 8 is outside the gantry's range"),
        (("repeat: 5", "repeat: 0"), "repeat: expected at least 1"),
        (("repeat: 5", "repeat: 5000000"), "rows are more than the 1,000,000"),
        (("seed: 3", "seed: -3"), "seed: expected at least 0"),
    ],
)
def test_invalid_values_are_reported_with_their_place(folder, change, message):
    keep = "people.nobody" in change[1] or "busy" in change[0] + change[1]
    text = STUDY if keep or change[0].startswith("trials") else one_person(STUDY)
    assert text.replace(*change) != text
    assert message in problems(text.replace(*change), folder)


def test_all_problems_are_reported_at_once(folder):
    text = one_person(STUDY).replace("helpful", "helpfull").replace("[0, 30]", "[30, 0]")
    text = text.replace("0.8", "-0.8").replace("[ariac2023]", "[ariac2023, nothing.yaml]")
    reported = problems(text, folder)
    assert [f"line {k}" in reported for k in (1, 3, 4, 6)] == [True] * 4


def test_a_trial_with_a_fault_is_reported_with_its_own_lines(folder):
    (folder / "busy.trial.yaml").write_text(TRIAL.replace("bin1", "bin99"))
    reported = problems("trials: [busy.trial.yaml]\n", folder)
    assert "busy.trial.yaml: line 9, gantry.jobs[0].pick: no obstacle" in reported


def test_a_value_that_some_trials_cannot_have_is_reported_with_the_trial(folder):
    reported = problems("trials: [ariac2023, warehouse.yaml]\ngrid: {duration: [5]}\n", folder)
    assert "no such file" in reported
    (folder / "aisles.trial.yaml").write_text("floorplan: warehouse\n")
    reported = problems("trials: [ariac2023, aisles.trial.yaml]\ngrid: {max_speed: [1]}\n", folder)
    assert "the trial 'aisles' can't have it: there is nothing in 'people'" in reported
    varied = "grid: {controller: [pausing], duration: [5, 1.0e+12]}"
    reported = problems(f"trials: [aisles.trial.yaml]\n{varied}\n", folder)
    assert "line 2, grid.controller[0]: gantry: the floorplan has no gantry" in reported
    assert "line 2, grid.duration[1]: duration: must be at most 2,678,400 s" in reported


def test_paths_of_files_are_relative_to_the_study(folder):
    (folder / "deep").mkdir()
    (folder / "deep" / "busy.trial.yaml").write_text(TRIAL)
    (folder / "mine.asl").write_text("!rest. +!rest <- .wait(1000).\n")
    (folder / "strict.yaml").write_text("based_on: paper\nname: strict\ngantry_disabled: 99\n")
    text = "trials: [deep/busy.trial.yaml]\ngrid: {personality: [mine.asl], rules: [strict.yaml]}\n"
    row = sim.Study.parse(text, folder=folder).row(0)
    assert row.parameters["personality"] == "mine.asl"
    assert row.trial.people[0].personality == "../mine.asl"
    assert row.trial.rules.gantry_disabled == 99.0
    row.trial.save(folder / "again.yaml")
    again = sim.Trial.load(folder / "again.yaml")
    assert replace(again, folder=row.trial.folder) == row.trial


TUG = """
import dataclasses

import sim


@dataclasses.dataclass(frozen=True)
class Tug(sim.MachineModel):
    length: float = 1.0
    careful: bool = True

    def shape(self, name, plan): ...

    def make(self, name, stage): ...
"""


def test_omitted_keys_of_machines_can_be_varied(tmp_path):
    (tmp_path / "own.py").write_text(TUG, encoding="utf-8")
    (tmp_path / "yard.trial.yaml").write_text(
        "floorplan: warehouse\npeople: [{name: a}, {name: b}]\nmachines:\n"
        "  tug: {kind: 'own:Tug'}\n  cart: {kind: agv, origin: [1, 8], limits: [0, 3]}\n"
    )
    varied = "machines.tug.careful: [false], machines.tug.length: [2], machines.cart.max_speed: [1]"
    grid = f"grid: {{{varied}, people.*.max_speed: [0.5]}}"
    study = sim.Study.parse(f"trials: [yard.trial.yaml]\n{grid}", folder=tmp_path)
    trial = study.row(0).trial
    assert trial.machines["tug"].keys == {"careful": False, "length": 2}
    assert trial.machines["cart"].keys["max_speed"] == 1
    assert [person.max_speed for person in trial.people] == [0.5, 0.5]
    grid = "trials: [yard.trial.yaml]\ngrid: {{machines.{}: [1]}}".format
    with pytest.raises(sim.StudyError, match="did you mean 'max_speed'"):
        sim.Study.parse(grid("cart.maxspeed"), folder=tmp_path)
    study = sim.Study.parse(grid("tug.carefull"), folder=tmp_path)
    with pytest.raises(ValueError, match="carefull: unknown key; did you mean 'careful'"):
        sim.run(study.row(0).trial)


def test_the_seed_of_a_run_does_not_contain_its_controller():
    study = sim.Study.parse("trials: [ariac2023]\ngrid: {controller: [pausing, avoiding]}\n")
    assert len({row.trial.seed for row in study.rows()}) == 1
    assert variable("machines.m.controller").is_controller
