"""The pytest plugin in separate pytest runs: trial files, fixtures, markers, reports."""

import shutil
from importlib.metadata import entry_points
from pathlib import Path

import pytest

import sim

ROOT = Path(__file__).resolve().parents[2]
EXAMPLE = ROOT / "examples" / "tested_controller"

PASSES = """\
floorplan: ariac2023
duration: 20
people: [{name: operator}]
expect: {penalties: 0, visits: [station4]}
"""
FAILS = """\
floorplan: ariac2023
duration: 30
people: [{name: operator}]
gantry: {at: [-2.5, 0.5, 0.0]}
expect:
  penalties: 0
  visits: [station4]
  timeline:
    - {never: {kind: violation, with: gantry}}
"""


INSTALLED = "floorwalker" in entry_points(group="pytest11").names
PLUGIN = [] if INSTALLED else ["-p", "sim.pytest_plugin"]


@pytest.fixture(scope="module")
def everything_is_loaded():
    """Load everything once. A pytest run in this process forgets what it imports, and extensions
    cannot be loaded twice.
    """
    import sim.testing.trial_items
    import sim.testing.variations

    assert sim.testing.trial_items.TrialFile and sim.testing.variations.vary
    trial = sim.Trial.parse(FAILS.replace("duration: 30", "duration: 5"))
    sim.testing.trial_items.render(sim.testing.trial_items.replay_data(sim.run(trial)))
    return trial


@pytest.fixture
def pytester(pytester):
    """A folder with its own settings, because the temporary ones may lie inside another project."""
    pytester.makeini("[pytest]\n")
    return pytester


@pytest.fixture
def run_pytest(pytester, everything_is_loaded):
    """Run pytest in a separate folder, in this process."""
    return lambda *options: pytester.runpytest_inprocess(*PLUGIN, "--strict-markers", *options)


@pytest.fixture
def run_pytest_alone(pytester, monkeypatch):
    """Run pytest in a separate folder, in a separate process."""
    monkeypatch.setenv("PYTHONPATH", str(ROOT))
    return lambda *options: pytester.runpytest_subprocess(*PLUGIN, "--strict-markers", *options)


def write(pytester, **files):
    for name, text in files.items():
        (pytester.path / name.replace("__", ".")).write_text(text)


def is_no_test(run_pytest, message):
    """Assert that collection fails with this message, and return the result."""
    result = run_pytest()
    result.assert_outcomes(errors=1)
    result.stdout.fnmatch_lines([message])
    return result


def test_a_trial_with_expectations_is_a_test(pytester, run_pytest):
    write(
        pytester,
        good__trial__yaml=PASSES,
        silent__trial__yaml="floorplan: ariac2023\n",
        other__yaml="expect: nothing\n",
    )
    result = run_pytest("-v")
    result.assert_outcomes(passed=1)
    result.stdout.fnmatch_lines(["good.trial.yaml::good PASSED*"])


def test_a_failure_names_event_time_and_place(pytester, run_pytest):
    write(pytester, bad__trial__yaml=FAILS)
    result = run_pytest("--floorwalker-replays", "pages")
    result.assert_outcomes(failed=1)
    result.stdout.fnmatch_lines(
        [
            "*trial bad*",
            "2 of 3 expectations not met in 30 s",
            "bad.trial.yaml:6",
            "  expected: penalties = 0",
            "  happened: it is 1 (t = 23.038 s)",
            "  when:     t = 23.038 s",
            "bad.trial.yaml:9",
            "  expected: never violation (with gantry)",
            "  happened: it happened at t = 23.038 s",
            "replay: *pages*bad.trial.yaml*.html",
        ]
    )
    (page,) = (pytester.path / "pages").iterdir()
    assert "<html" in page.read_text()[:200]
    assert "Traceback" not in result.stdout.str()


def test_without_the_option_replays_are_in_the_cache(pytester, run_pytest):
    write(pytester, bad__trial__yaml=FAILS)
    run_pytest().stdout.fnmatch_lines(["replay: *.pytest_cache*.html"])
    result = run_pytest("-p", "no:cacheprovider")
    result.stdout.fnmatch_lines(["replay: none kept; give a folder with --floorwalker-replays DIR"])


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (("penalties: 0", "penaltys: 0"), "line 4, expect.penaltys: *the nearest are penalties*"),
        (("duration: 20", "duration: ["), "*is not YAML*"),
    ],
)
def test_a_typo_is_an_error_at_collection(pytester, run_pytest, change, message):
    write(pytester, bad__trial__yaml=PASSES.replace(*change))
    result = is_no_test(run_pytest, f"*bad.trial.yaml: {message}")
    assert "Traceback" not in result.stdout.str()


def test_own_code_may_be_forbidden(pytester, run_pytest):
    own = PASSES.replace("expect", "gantry: {controller: 'refused:mine'}\nexpect")
    write(
        pytester, refused__py="def mine(gantry):\n    yield gantry.wait(5)\n", own__trial__yaml=own
    )
    run_pytest().assert_outcomes(passed=1)
    message = "*own.trial.yaml: line 4, gantry.controller: *code of your own is refused here*"
    is_no_test(lambda: run_pytest("--no-own-code"), message)
    (pytester.path / "own.trial.yaml").rename(pytester.path / "own.yaml")
    pytester.makepyfile(
        test_own="""
        import pytest, refused

        def test_a_file(run_trial):
            with pytest.raises(ValueError, match="is refused here"):
                run_trial("own.yaml")

        @pytest.mark.controllers.with_args(refused.mine)
        def test_markers_do_not_replace_fixtures_of_the_test(run_trial):
            run_trial()
        """
    )
    run_pytest("--no-own-code").assert_outcomes(passed=2)
    (pytester.path / "test_own.py").unlink()
    marker = "import pytest\n@pytest.mark.controllers('refused:mine')\ndef test_it(run_trial): ..."
    pytester.makepyfile(test_marker=marker)
    is_no_test(lambda: run_pytest("--no-own-code"), "*'refused:mine': code of your own is refused*")


def test_a_controller_that_fails_is_reported_in_a_sentence(pytester, run_pytest):
    write(
        pytester,
        oilless__py="def mine(gantry):\n    yield gantry.wait(5)\n    raise OSError('no oil')\n",
        bad__trial__yaml=PASSES.replace("expect", "gantry: {controller: 'oilless:mine'}\nexpect"),
    )
    result = run_pytest()
    result.assert_outcomes(failed=1)
    result.stdout.fnmatch_lines(
        [
            "the gantry controller 'oilless:mine' failed at t = 5 s (oilless.py, line 3): "
            "OSError: no oil",
            "replay:*",
        ]
    )


def test_markers_vary_the_trial(pytester, run_pytest):
    write(
        pytester,
        mine__asl="!stay.\n+!stay <- .wait(100000).\n",
        near__trial__yaml=PASSES.replace("duration: 20", "duration: 10"),
        test_varied__py="""
import pytest

import sim

def still(gantry):
    yield gantry.wait(1)

@pytest.mark.personalities("helpful", "mine.asl")
@pytest.mark.controllers(still, "parked")
@pytest.mark.rule_sets("all")
def test_all(trial):
    assert trial.name == "ariac_cell"
    assert trial.rules.name in sim.RULE_SETS
    assert trial.gantry.controller in (still, "parked")

@pytest.mark.seeds(range(2), 7)
@pytest.mark.trials("near.trial.yaml", "scene_helpful")
def test_seeds(trial, run_trial):
    assert trial.seed in (0, 1, 7)
    if trial.name == "near":
        assert run_trial().duration == 10.0

@pytest.mark.personalities("helpful")
def test_a_file(run_trial):
    assert run_trial("near.trial.yaml").trial.people[0].personality == "helpful"

def test_plain(ariac_cell, trial):
    assert trial is ariac_cell
""",
    )
    result = run_pytest("-v")
    result.assert_outcomes(passed=4 * len(sim.RULE_SETS) + 6 + 1 + 1 + 1)
    result.stdout.fnmatch_lines(
        ["*::test_all?mine-still-ariac2023? PASSED*", "*::test_seeds?near-7? PASSED*"]
    )


REPEATS = """
import pytest

@pytest.mark.seeds(range(3))
@pytest.mark.personalities("indifferent", "helpful")
@pytest.mark.parametrize("step", [1])
@pytest.mark.trials("near.trial.yaml")
def test_identical(run_trial, step):
    assert run_trial().summary["penalties"] == 0

@pytest.mark.seeds(range(3))
@pytest.mark.trials("drawn.trial.yaml")
def test_drawn(run_trial):
    assert run_trial().duration == 4.0

@pytest.mark.seeds(5)
def test_alone(run_trial, trial):
    assert run_trial("near.trial.yaml").duration == 4.0
"""


@pytest.fixture
def repeats(pytester):
    """Tests with three seeds, of which only one draws something."""
    near = PASSES.replace("duration: 20", "duration: 4").replace(", visits: [station4]", "")
    write(
        pytester,
        near__trial__yaml=near,
        drawn__trial__yaml=near.replace("{name: operator}", "{name: operator, at: anywhere}"),
        test_same__py=REPEATS,
    )


IDENTICAL = [
    f"test_same.py::test_identical[near-{named}]: the runs with 3 seeds are identical, because"
    " nothing is drawn in them. They count as one."
    for named in ("helpful-1", "indifferent-1")
]


def identical(result):
    return sorted(line for line in result.outlines if "seeds are identical" in line)


def test_identical_repeats_are_reported_and_count_as_one(repeats, run_pytest):
    result = run_pytest("-q", "test_same.py")
    result.assert_outcomes(passed=10)
    assert identical(result) == IDENTICAL


@pytest.mark.slow
def test_identical_repeats_are_reported_on_several_processes(repeats, run_pytest_alone):
    result = run_pytest_alone("-n", "2", "test_same.py")
    assert identical(result) == IDENTICAL


@pytest.mark.parametrize(
    ("marker", "message"),
    [
        ('personalities("helpfull")', "*did you mean 'helpful'?*"),
        ('controllers("nowhere:mine")', "*there is no nowhere.py in*"),
        ("personalities(3)", "*expected a name or a file, found 3"),
        ("rule_sets(lambda: 1, 'papr')", "*did you mean 'paper'?*"),
        ("rule_sets(lambda: 1, 'papr')", "*expected a name or a file, found <function*"),
        ("seeds(-1)", "*expected whole numbers of at least 0*"),
        ("seeds()", "*@pytest.mark.seeds needs one value or more*"),
        ('trials("nowhere")', "*nowhere*no such file*"),
        ('personality("helpful")', "*'personality' not found in `markers`*"),
    ],
)
def test_a_marker_that_makes_no_sense_is_an_error_at_collection(
    pytester, run_pytest, marker, message
):
    text = f"import pytest\n\n@pytest.mark.{marker}\ndef test_it(trial): pass\n"
    write(pytester, test_varied__py=text)
    is_no_test(run_pytest, message)


@pytest.mark.parametrize("where", ["here", "elsewhere"])
@pytest.mark.parametrize("test", ["def test_it(trial): pass", "class TestIt: pass"])
def test_one_function_as_a_marker_s_only_value_does_not_lose_the_test(
    pytester, run_pytest, where, test
):
    shy = "def shy(gantry):\n    yield gantry.wait(1)\n"
    write(pytester, ctl__py=shy)
    name = "shy" if where == "here" else "ctl.shy"
    here = shy if where == "here" else "import ctl\n"
    text = f"import pytest\n{here}\n@pytest.mark.controllers({name})\n{test}\n"
    write(pytester, test_varied__py=text)
    is_no_test(run_pytest, "*write @pytest.mark.controllers.with_args(...)")


def test_markers_accept_objects_of_the_library(pytester, run_pytest):
    write(
        pytester,
        near__trial__yaml=PASSES,
        pack__py="def c(gantry):\n    yield gantry.wait(1)\n",
        test_varied__py="""
import pytest
import sim
import pack

CELL = sim.Trial.parse("name: mine\\nfloorplan: ariac2023\\nduration: 5.0\\n")

@pytest.mark.trials(CELL)
@pytest.mark.rule_sets(sim.RULE_SETS["ariac2023"])
@pytest.mark.controllers.with_args(pack.c)
def test_it(trial, run_trial):
    assert (trial.name, trial.rules) == ("mine", sim.RULE_SETS["ariac2023"])
    assert trial.gantry.controller is pack.c
    assert run_trial("near.trial.yaml").trial.name == "near"
    assert run_trial("scene_helpful").trial.rules == sim.RULE_SETS["ariac2023"]
    assert run_trial(CELL).trial == CELL

@pytest.mark.controllers("pack:c", "parked")
def test_ids(trial):
    pass
""",
    )
    result = run_pytest("-v")
    result.assert_outcomes(passed=4)
    result.stdout.fnmatch_lines(["*test_it?mine-c-ariac2023?*", "*test_ids?pack:c?*"])


def test_a_run_that_fails_before_the_test_is_reported_as_well(pytester, run_pytest):
    write(
        pytester,
        endless__asl="!go(a).\n+!go(X) <- !go(f(X)).\n",
        test_early__py="""
import pytest

@pytest.fixture
def ran(run_trial):
    run = run_trial()
    assert run.summary["penalties"] == 99
    return run

def test_early(ran):
    pass

@pytest.mark.personalities("endless.asl")
def test_endless(run_trial):
    run_trial()
""",
    )
    result = run_pytest()
    result.assert_outcomes(errors=1, failed=1)
    result.stdout.fnmatch_lines(["ariac_cell on ariac2023, 120 s:*", "replay: *test_early*"])
    result.stdout.fnmatch_lines(["*endless.asl:2:*"])
    assert "simpy" not in result.stdout.str()
    assert "agent.py" not in result.stdout.str()


def test_a_marker_on_a_test_that_takes_no_trial(pytester, run_pytest):
    text = "import pytest\n\n@pytest.mark.seeds(1)\ndef test_it(): pass\n"
    write(pytester, test_varied__py=text)
    is_no_test(run_pytest, "*takes none; let it take trial or run_trial")


def test_a_failed_test_reports_its_runs(pytester, run_pytest):
    write(
        pytester,
        bad__trial__yaml=FAILS.partition("expect")[0],
        test_varied__py="""
def test_it(run_trial):
    assert run_trial("bad.trial.yaml").summary["penalties"] == 0
""",
    )
    result = run_pytest("--floorwalker-replays", "pages")
    result.assert_outcomes(failed=1)
    result.stdout.fnmatch_lines(
        [
            "*Floorwalker*",
            "bad on ariac2023, 30 s: operator (indifferent); gantry parked; rules paper; seed 0",
            "violation at t = 23.038 s: operator and gantry just under 3.50 m apart, 3.50 m *",
            "replay: *pages*test_varied.py_test_it*.html",
        ]
    )
    assert len(list((pytester.path / "pages").iterdir())) == 1


def test_a_failed_test_of_many_people_reports_their_results_and_names_the_first(
    pytester, run_pytest
):
    write(
        pytester,
        crowd__trial__yaml="""
floorplan: ariac2023
duration: 5
people: [{name: crew, count: 15, at: anywhere}]
""",
        test_crowd__py="""
def test_it(run_trial):
    assert run_trial("crowd.trial.yaml").summary["overlaps"] == 1
""",
    )
    result = run_pytest("--floorwalker-replays", "pages")
    result.assert_outcomes(failed=1)
    result.stdout.fnmatch_lines(["crowd on *crew12 (indifferent), 3 more; *"])
    result.stdout.fnmatch_lines(["*least gap between people * m (crew* and crew*) at *"])


@pytest.mark.slow
def test_the_example_project_passes_on_several_processes(pytester, run_pytest_alone):
    shutil.copytree(EXAMPLE, pytester.path, dirs_exist_ok=True)
    result = run_pytest_alone("-n", "2")
    result.assert_outcomes(passed=12)


def test_suites_without_trials_load_no_simulation(pytester, run_pytest_alone):
    write(
        pytester,
        notes__yaml="expect: x\n",
        test_it__py="""
import sys

def test_nothing_is_loaded():
    heavy = {"numpy", "shapely", "ompl", "fcl", "ruckig", "simpy", "lark", "yaml", "pydantic"}
    assert not heavy & set(sys.modules)
    assert not {"floorplan", "navigation", "bdi"} & set(sys.modules)
""",
    )
    run_pytest_alone().assert_outcomes(passed=1)


@pytest.mark.slow
def test_runs_that_passed_are_released(pytester, run_pytest_alone):
    write(pytester, one__trial__yaml=PASSES, two__trial__yaml=PASSES)
    pytester.makepyfile(
        test_what_is_left="""
        import gc
        import sim

        def test_nothing_is_left():
            gc.collect()
            assert not [thing for thing in gc.get_objects() if isinstance(thing, sim.Run)]
        """
    )
    run_pytest_alone().assert_outcomes(passed=3)
