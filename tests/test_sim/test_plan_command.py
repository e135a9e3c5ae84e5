import json

import pytest


@pytest.fixture
def floorwalker(floorwalker):
    def called(*words, ok=True):
        done = floorwalker(*words)
        if ok:
            assert done.returncode == 0, done.stderr
        return done

    return called


def test_a_path_in_words(floorwalker):
    done = floorwalker("plan", "ariac2023", -15, -10, -5, 3.75)
    lines = done.stdout.splitlines()
    assert lines[0].startswith("Roadmap: length 17.002 m, clearance 0.997 m")
    assert lines[1].split() == ["-15.000", "-10.000"]
    assert lines[-1].split() == ["-5.000", "3.750"]
    assert done.stderr == ""


def test_a_path_as_json_with_options(floorwalker):
    done = floorwalker(
        *("plan", "ariac2023", -11.3, 6, -11.3, 3.5, "--json", "--radius", 0.25),
        *("--planner", "RRTConnect: {range: 2}", "--seed", 3, "--agv", "agv1=9.0"),
    )
    way = json.loads(done.stdout)
    assert way["points"][0] == [-11.3, 6.0]
    assert way["points"][-1] == [-11.3, 3.5]
    assert way["planner"] == "RRTConnect"
    assert way["length"] > 2.6
    assert way["clearance"] >= 0.25
    assert way["cpu_seconds"] > 0
    assert done.stderr == ""


def test_no_path_is_one_sentence_and_exit_1(floorwalker):
    done = floorwalker("plan", "ariac2023", -15, -10, -7.5, 3, ok=False)
    assert done.returncode == 1
    assert done.stdout == ""
    assert done.stderr == "floorwalker: the goal (-7.5, 3) is inside assembly_table1\n"


@pytest.mark.parametrize(
    ("words", "why"),
    [
        (("--planner", "RTConnect"), "did you mean 'RRTConnect'?"),
        (("--planner", "Roadmap: {range: 1}"), "Roadmap has no parameters, found range"),
        (("--agv", "agv9=1"), "'agv9'"),
        (("--agv", "agv1=99"), "its lane runs from 0 to 18"),
        (("--radius", "-1"), "a radius must be positive"),
    ],
)
def test_senseless_input_is_exit_1(words, why, floorwalker):
    done = floorwalker("plan", "ariac2023", -15, -10, -5, 3.75, *words, ok=False)
    assert done.returncode == 1
    assert why in done.stderr
    assert "Traceback" not in done.stderr


def test_wrong_usage_is_exit_2(floorwalker):
    assert floorwalker("plan", "ariac2023", -15, -10, ok=False).returncode == 2
    wrong = floorwalker("plan", "ariac2023", -15, -10, -5, 3.75, "--agv", "agv1", ok=False)
    assert wrong.returncode == 2


def test_a_plot(tmp_path, floorwalker):
    pytest.importorskip("matplotlib")
    floorwalker("plan", "ariac2023", -15, -10, -5, 3.75, "--plot", tmp_path / "way.svg")
    assert (tmp_path / "way.svg").read_text().startswith("<?xml")
    wrong = floorwalker(
        "plan", "ariac2023", -15, -10, -5, 3.75, "--plot", tmp_path / "way.txt2", ok=False
    )
    assert wrong.returncode == 1
    assert "way.txt2" in wrong.stderr
