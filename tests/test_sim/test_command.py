"""The command as a user types it: outputs, exit codes and messages for errors."""

import csv
import itertools
import json
import os
import re
import signal
import subprocess
import sys
import webbrowser
from pathlib import Path

import numpy as np
import pytest
from processes import command_line, in_a_process, started
from run_events import record
from waiting import HANG, until

import floorplan
import floorwalker as floorwalker_module
import sim

TIMING = ("cpu_seconds", "realtime_factor")

OTHER_HASHES = {"PYTHONHASHSEED": "1"}


@pytest.fixture(scope="module")
def recorded(tmp_path_factory):
    """The main job, run once with another hash seed: the finished process and its folder."""
    folder = tmp_path_factory.mktemp("main")
    done = in_a_process("run", cwd=folder, env=OTHER_HASHES)
    return done, folder / "runs" / "ariac2023"


@pytest.fixture(scope="module")
def main_run():
    """The run of the main job in this process."""
    return sim.run(sim.Trial.load("ariac2023"))


def test_the_run_command_prints_results_and_folder(recorded):
    done, folder = recorded
    assert done.returncode == 0
    assert done.stderr == ""
    assert "penalties" in done.stdout
    assert "× real time" in done.stdout
    assert sorted(path.name for path in folder.iterdir()) == [
        "events.jsonl",
        "motions.jsonl",
        "replay.html",
        "scene.json",
        "summary.json",
        "thoughts.jsonl",
        "trajectory.csv",
        "violations.jsonl",
    ]


def test_the_summary_has_every_field(recorded):
    summary = json.loads((recorded[1] / "summary.json").read_text())
    assert summary["duration"] == 275.0
    assert summary["interrupted"] is False
    for field in ("penalties", "agv_teleports", "gantry_disabled_time", "jobs_done", *TIMING):
        assert isinstance(summary[field], int | float)
    assert summary["minimum_separation"].keys() == {"distance", "time", "required"}
    person = summary["people"]["operator"]
    assert person["visits"][:2] == ["station4", "station2"]
    assert person["distance_walked"] > 50
    assert person["time_standing"] > 8
    assert person["replans"] == 0


def test_events_are_in_order_and_whole(recorded):
    lines = (recorded[1] / "events.jsonl").read_text().splitlines()
    events = [json.loads(line) for line in lines]
    assert [event["t"] for event in events] == sorted(event["t"] for event in events)
    assert (events[0]["kind"], events[-1]["kind"]) == ("trial_started", "trial_ended")
    kinds = {event["kind"] for event in events}
    assert {"human_started", "goal", "arrived", "gantry_detected", "violation"} <= kinds
    assert {"teleport", "gantry_disabled", "gantry_enabled", "agv_moved"} <= kinds


def test_recorded_motions_are_those_of_the_run(recorded, main_run):
    """motions.jsonl alone determines every position at any time."""
    pieces = {}
    for line in (recorded[1] / "motions.jsonl").read_text().splitlines():
        motion = json.loads(line)
        assert motion["start"] == motion["pieces"][0][0]
        assert motion["end"] == motion["pieces"][-1][1]
        pieces.setdefault(motion["body"], []).extend(motion["pieces"])
    assert set(pieces) == {"operator", "gantry", "agv1", "agv2", "agv3", "agv4"}
    for name, stretches in pieces.items():
        for (_, end, *_), (begin, *_) in itertools.pairwise(stretches):
            assert begin == end
        assert (stretches[0][0], stretches[-1][1]) == (0.0, 275.0)
        for t in np.linspace(0.05, 274.95, 777):
            begin, _, x, y, _ = next(piece for piece in stretches if piece[0] <= t <= piece[1])
            u = t - begin
            at = [sum(c * u**k for k, c in enumerate(axis)) for axis in (x, y)]
            assert at == pytest.approx(main_run.motions[name].position(t), abs=1e-9)


def test_the_trajectory_is_the_sampled_run(recorded, main_run):
    rows = list(csv.DictReader((recorded[1] / "trajectory.csv").read_text().splitlines()))
    samples = main_run.sample(rate=10.0)
    mine = [row for row in rows if row["body"] == "operator"]
    teleports = [row for row in mine if float(row["t"]) * 10 % 1]
    assert len(teleports) == 2 * 9
    mine = [row for row in mine if row not in teleports]
    assert len(mine) == len(samples["t"]) == 2751
    written = np.array(
        [[float(row[c]) for c in ("x", "y", "rotation", "vx", "vy")] for row in mine]
    )
    assert np.abs(written - samples["operator"]).max() < 1e-6
    assert [float(row["t"]) for row in mine] == pytest.approx(samples["t"], abs=1e-9)


def test_a_run_counts_the_notices_that_check_lists(tmp_path, floorwalker):
    square = {"type": "Polygon", "coordinates": [[[0, 0], [9, 0], [9, 9], [0, 9], [0, 0]]]}
    features = [
        {"type": "Feature", "properties": {"layer": layer}, "geometry": square}
        for layer in ("hall", "dim", "text")
    ]
    drawn = {"type": "FeatureCollection", "units": "m", "features": features}
    (tmp_path / "hall.geojson").write_text(json.dumps(drawn))
    (tmp_path / "hall.yaml").write_text("base: hall.geojson\nlayers: {boundary: [hall]}\n")
    (tmp_path / "a.trial.yaml").write_text("floorplan: hall.yaml\nduration: 1\n")
    listed = floorwalker("check", "a.trial.yaml", cwd=tmp_path)
    assert listed.stderr.count("is on a layer that no group has") == 2
    done = floorwalker("run", "a.trial.yaml", cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    pointer = "hall: 2 notices about the drawing; `floorwalker check a.trial.yaml` lists them"
    assert done.stderr.splitlines()[0] == pointer
    assert "layer" not in done.stderr


def test_a_second_run_gets_another_folder(recorded, floorwalker):
    folder = recorded[1].parent
    again = floorwalker("run", "--duration", "5", cwd=folder.parent)
    assert again.returncode == 0
    assert (folder / "ariac2023-2" / "summary.json").exists()
    taken = floorwalker("run", "--out", folder / "ariac2023", cwd=folder.parent)
    assert taken.returncode == 1
    assert "already contains a run" in taken.stderr


@pytest.mark.parametrize("trial", ["ariac2023", "scene_helpful"])
def test_the_same_trial_gives_the_same_bytes_in_any_process(trial, recorded, tmp_path):
    """The bytes depend neither on the hash seed nor on earlier runs in the process."""
    there, here = recorded[1], tmp_path / "here"
    if trial != there.name:
        there = tmp_path / "there"
        done = in_a_process("run", trial, "--out", there, cwd=tmp_path, env=OTHER_HASHES)
        assert done.returncode == 0, done.stderr
    assert sim.run(sim.Trial.load("scene_antagonistic")).events
    record(sim.Trial.load(trial), here)
    files = {path.name for path in there.iterdir()}
    assert files == {path.name for path in here.iterdir()}
    for file in files - {"summary.json"}:
        assert (there / file).read_bytes() == (here / file).read_bytes(), file
    one, other = (json.loads((run / "summary.json").read_text()) for run in (there, here))
    assert one | dict.fromkeys(TIMING) == other | dict.fromkeys(TIMING)


def test_people_who_wait_for_a_client_are_reported(tmp_path, floorwalker):
    done = floorwalker(
        "run",
        "--personality",
        "external",
        "--controller",
        "external",
        "--duration",
        "1",
        cwd=tmp_path,
    )
    assert done.returncode == 0
    assert done.stderr == (
        "ariac2023: operator and the gantry will not move, because external programs control them;"
        " `floorwalker bridge` serves the trial to such programs\n"
    )


def test_a_person_with_commands_does_not_wait_for_a_client(tmp_path, floorwalker):
    command = {"time": 0.1, "call": "act", "person": "operator"}
    command["arguments"] = {"action": "move(-14, -10)"}
    (tmp_path / "commands.yaml").write_text(json.dumps({"commands": [command]}))
    options = ("--personality", "external", "--duration", "1", "--commands", "commands.yaml")
    done = floorwalker("run", *options, cwd=tmp_path)
    assert (done.returncode, done.stderr) == (0, "")


def test_the_files_of_the_built_in_floors_are_floors(floorwalker):
    folder = Path(floorplan.__file__).parent / "data"
    done = floorwalker("check", *sorted(folder.glob("*.yaml")), cwd=folder)
    assert done.returncode == 0
    assert done.stdout.count(": a floorplan of ") == len(floorplan.builtin())


def test_an_expectation_that_is_not_met_is_reported_and_exits_1(tmp_path, floorwalker):
    path = tmp_path / "t.trial.yaml"
    path.write_text(
        "floorplan: ariac2023\nduration: 30\npeople: [{name: a}]\n"
        "gantry: {at: [-2.5, 0.5, 0.0]}\nexpect: {penalties: 0, visits: [station1]}\n"
    )
    done = floorwalker("run", path, cwd=tmp_path)
    assert done.returncode == 1
    assert "expectations met" in done.stdout and "0 of 2" in done.stdout
    assert "expected penalties = 0, but it is 1" in done.stderr
    assert "expected visits to begin with station1, but they were station4, station2" in done.stderr
    assert (tmp_path / "runs" / "t" / "replay.html").exists()


BAD = {
    "missing.yaml": (None, "there is no such file"),
    "unknown.yaml": ("floorplan: ariac2023\nfoo: 1\n", "line 2, foo: "),
    "floor.yaml": ("boundary: [[0, 0], [9, 9], [9, 0], [0, 9]]\n", "edges cross"),
    "syntax.asl": ("!go.\n+!go <- .print(1;\n", "2"),
}


@pytest.mark.parametrize("name", BAD)
def test_invalid_files_cause_one_clear_message(name, tmp_path, floorwalker):
    text, message = BAD[name]
    if text is not None:
        (tmp_path / name).write_text(text)
    for command in ("check", "run")[: 2 if name in ("missing.yaml", "unknown.yaml") else 1]:
        done = floorwalker(command, name, cwd=tmp_path)
        assert done.returncode == 1
        assert name in done.stderr
        assert message in done.stderr
        assert "Traceback" not in done.stderr
    assert not (tmp_path / "runs").exists()


@pytest.mark.parametrize(
    ("arguments", "code", "message"),
    [
        (["run", "--duration", "-5"], 1, "at most 1e+10, not -5"),
        (["run", "--duration", "nan"], 1, "at most 1e+10, not nan"),
        (["run", "--duration", "long"], 2, "duration"),
        (["run", "--duration", "1e12"], 1, "duration: must be at most 2,678,400 s"),
        (["run", "--personality", "angry"], 1, "'angry'"),
        (["run", "--rules", "papper"], 1, "did you mean 'paper'?"),
        (["run", "nowhere"], 1, "built-in trial"),
        (["run", "--speed", "2"], 2, "needs --watch"),
        (["replay", "x", "--port", "80"], 2, "needs --serve"),
        (["agent", "helpful", "--seed", "-1"], 2, "--seed"),
        (["plan", "warehouse", "1", "1", "2", "2", "--seed", "-1"], 2, "--seed"),
        (["plan", "ariac2023", "1e300", "0", "1", "1"], 1, "is outside the boundary"),
        (["benchmark", "--out", __file__], 1, f"can't write {__file__}: "),
        (["export", "ariac2023", "--out", "x.csv", "--rate", "1e9"], 1, "more than 100,000,000 in"),
        (["jump"], 2, "jump"),
        (["check"], 2, "FILE..."),
    ],
)
def test_wrong_usage_is_reported(arguments, code, message, tmp_path, floorwalker):
    done = floorwalker(*arguments, cwd=tmp_path)
    assert done.returncode == code
    assert message in done.stderr
    assert "Traceback" not in done.stderr
    assert list(tmp_path.iterdir()) == []


def test_check_prints_the_kind_of_each_file(tmp_path, floorwalker):
    done = floorwalker("check", "ariac2023", "scene_helpful", "helpful", "warehouse", cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    lines = done.stdout.splitlines()
    assert "a trial of 275 s on ariac2023 with operator" in lines[0]
    assert "gantry, agv1 (agv), agv2 (agv)" in lines[0]
    assert "32 obstacles, 4 stations, 4 AGVs and a gantry" in lines[0]
    assert "a program of" in lines[2]
    assert "and no gantry" in lines[3]


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="needs /dev/full, as Linux has it")
@pytest.mark.parametrize("words", [["list"], ["run", "--duration", "1"]])
def test_output_to_a_full_disk_is_reported(tmp_path, words):
    with Path("/dev/full").open("w") as full:
        done = subprocess.run(
            command_line(*words), stdout=full, stderr=subprocess.PIPE, cwd=tmp_path, text=True
        )
    assert done.returncode == 1
    assert done.stderr == "floorwalker: No space left on device\n"


def test_terminals_without_some_characters_get_the_others(tmp_path):
    ascii_only = {"PYTHONIOENCODING": "ascii"}
    done = in_a_process("run", "--duration", "1", cwd=tmp_path, env=ascii_only)
    assert (done.returncode, done.stderr) == (0, "")
    assert "? real time" in done.stdout


def test_names_are_printed_unchanged_and_give_one_plain_folder(tmp_path, floorwalker):
    for name, folder in (("a/b[old]", "a-b[old]"), ("..", "unnamed"), ("", "unnamed-2")):
        text = f"name: '{name}'\nfloorplan: ariac2023\nduration: 1\npeople: [{{name: ada}}]\n"
        (tmp_path / "t.trial.yaml").write_text(text)
        done = floorwalker("run", "t.trial.yaml", cwd=tmp_path)
        assert (done.returncode, done.stderr) == (0, "")
        assert f"Replay: runs/{folder}/replay.html\n" in done.stdout
        assert done.stdout.startswith(f"{name} on ariac2023")
        assert (tmp_path / "runs" / folder / "replay.html").exists()


def test_tables_contain_unchanged_names(tmp_path, floorwalker):
    (tmp_path / "m[x]:x:.yaml").write_text("floorplan: ariac2023\nduration: 1\n")
    (tmp_path / "s.study.yaml").write_text(
        "name: 'a/b [red]'\ntrials: ['m[x]:x:.yaml', scene_helpful]\ngrid: {duration: [1]}\n"
    )
    done = floorwalker("study", "s.study.yaml", "--jobs", "1", cwd=tmp_path)
    assert (done.returncode, done.stderr) == (0, "")
    assert "a/b [red]" in done.stdout
    assert "m[x]:x:" in done.stdout
    assert "Report: studies/a-b [red]/report.html" in done.stdout


def test_a_table_of_a_study_breaks_no_word_and_names_omitted_measures(tmp_path, floorwalker):
    (tmp_path / "t.trial.yaml").write_text(
        "floorplan: ariac2023\nduration: 20\nagvs: {agv1: [{time: 1, to: assembly_front}]}\n"
        "people: [{name: ada, personality: worker, work: line, count: 3}]\n"
        "work: {line: [{at: station4, duration: 2, every: 5}]}\n"
        "gantry: {controller: oblivious, jobs: [{move: [-2.5, 0.5, 0.0]}, {wait: 1}]}\n"
    )
    manners = (f"  people.*.manners.{key}: [1, 2]\n" for key in ("foresight", "patience"))
    grid = "  people.*.noticing.reaction_time: [1, 2]\n" + "".join(manners)
    (tmp_path / "s.study.yaml").write_text(f"trials: [t.trial.yaml]\ngrid:\n{grid}")
    done = floorwalker("study", "s.study.yaml", "--jobs", "1", cwd=tmp_path)
    assert (done.returncode, done.stderr) == (0, "")
    study = sim.Study.load(tmp_path / "s.study.yaml")
    results = sim.run_study(study, tmp_path / "studies" / "s", jobs=1)
    labels = [measure.label for measure in results.comparison.spreads]
    words = {word for label in (*labels, *results.comparison.factors) for word in label.split()}
    heading = [line for line in done.stdout.splitlines() if line.startswith("┃")]
    assert {*" ".join(heading).replace("┃", " ").split()} <= words | {"Runs"}
    left_out = done.stdout.partition("Only in the report: ")[2].partition("\n0 in all rows")[0]
    assert "throughput" in left_out.replace("\n", " ").split(", ")


def test_a_folder_named_like_a_personality_is_ignored(tmp_path, floorwalker):
    (tmp_path / "helpful").mkdir()
    for name, code in (("helpful", 0), ("x" * 300, 1)):
        out = ("--duration", "1", "--out", tmp_path / "out")
        done = floorwalker("run", "--personality", name, *out, cwd=tmp_path)
        assert done.returncode == code, done.stderr
    assert "no personality and no .asl file is called" in done.stderr


def test_a_missing_program_is_suggested_from_its_folder(tmp_path, floorwalker):
    (tmp_path / "sweeper.asl").write_text("+human_start.\n")
    text = "floorplan: ariac2023\npeople: [{name: ada, personality: sweper.asl}]\n"
    (tmp_path / "t.trial.yaml").write_text(text)
    done = floorwalker("check", "t.trial.yaml", cwd=tmp_path)
    assert done.returncode == 1 and "'sweeper.asl'" in done.stderr


def test_jobs_of_a_parked_gantry_are_reported(tmp_path, floorwalker):
    text = "floorplan: ariac2023\nduration: 1\ngantry: {jobs: [{wait: 0.5}]}\n"
    (tmp_path / "t.trial.yaml").write_text(text)
    notice = "t: the gantry is parked and does no jobs; choose another --controller\n"
    for more, stderr in (((), notice), (("--controller", "oblivious"), "")):
        done = floorwalker("run", "t.trial.yaml", *more, cwd=tmp_path)
        assert (done.returncode, done.stderr) == (0, stderr)


def test_check_knows_rule_sets_by_name_and_by_any_of_their_keys(tmp_path, floorwalker):
    (tmp_path / "ours.yaml").write_text("name: ours\ngrace: 3.0\npause_after_violation: 2.0\n")
    (tmp_path / "bad.yaml").write_text("pause_after_agv: soon\n")
    done = floorwalker("check", "paper", "ours.yaml", "ariac2023", cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    lines = done.stdout.splitlines()
    assert lines[:2] == ["paper: the rule set paper", "ours.yaml: the rule set ours"]
    assert lines[2].endswith("; the rule set ariac2023")
    done = floorwalker("check", "bad.yaml", cwd=tmp_path)
    assert (done.returncode, done.stdout) == (1, "")
    assert done.stderr.startswith("bad.yaml: line 1, pause_after_agv: expected a number")


def test_missing_internal_actions_are_reported_before_a_run(tmp_path, floorwalker):
    (tmp_path / "b.asl").write_text("// nothing\n+never <- .nonsense(3).\n")
    person = "people: [{name: a, personality: b.asl}]\n"
    (tmp_path / "t.trial.yaml").write_text(f"floorplan: ariac2023\n{person}")
    for arguments in (["check", "b.asl"], ["check", "t.trial.yaml"], ["run", "t.trial.yaml"]):
        done = floorwalker(*arguments, cwd=tmp_path)
        assert (done.returncode, done.stdout) == (1, ""), arguments
        assert "b.asl:2:11: there is no internal action .nonsense" in done.stderr
    assert not (tmp_path / "runs").exists()


def test_list_names_all_built_in_items(tmp_path, floorwalker):
    done = floorwalker("list", cwd=tmp_path)
    assert done.returncode == 0
    assert done.stderr == ""
    for name in ("ariac2023", "warehouse", "RRTConnect", "helpful", "oblivious", "paper"):
        assert f"  {name} " in done.stdout


def test_an_interrupted_run_is_recorded(tmp_path):
    """After Ctrl-C during a long trial, the files are complete up to that time."""
    out = tmp_path / "out"
    process = started("run", "--duration", "2e6", "--out", out, cwd=tmp_path)
    events = out / "events.jsonl"
    until(lambda: events.exists() and events.stat().st_size > 20_000, process)
    process.send_signal(signal.SIGINT)
    _, stderr = process.communicate(timeout=HANG)
    assert process.returncode == 130
    assert "The recording up to then is kept" in stderr
    assert "Traceback" not in stderr
    summary = json.loads((out / "summary.json").read_text())
    assert summary["interrupted"] is True
    assert 0 < summary["duration"] < 1e7
    recorded_events = [json.loads(line) for line in events.read_text().splitlines()]
    assert recorded_events[-1]["kind"] == "trial_ended"
    assert recorded_events[-1]["t"] == pytest.approx(summary["duration"])
    for line in (out / "motions.jsonl").read_text().splitlines():
        json.loads(line)
    assert (out / "replay.html").read_text().rstrip().endswith("</html>")


def test_one_interrupt_ends_an_endless_loop_in_custom_code(tmp_path):
    (tmp_path / "stuck.py").write_text(
        "from pathlib import Path\n\n\nclass Stuck:\n"
        "    def replan(self, body, neighbours, outlook):\n"
        "        Path('there').touch()\n        while True:\n            pass\n"
    )
    (tmp_path / "stuck.trial.yaml").write_text(
        "floorplan: warehouse\nsteering: 'stuck:Stuck'\n"
        "people: [{name: a, count: 2, at: anywhere}]\n"
    )
    process = started("run", "stuck.trial.yaml", "--out", "out", cwd=tmp_path)
    until((tmp_path / "there").exists, process)
    process.send_signal(signal.SIGINT)
    _, stderr = process.communicate(timeout=HANG)
    assert process.returncode == 1
    assert re.search(r"\(stuck\.py, line [78]\)", stderr) and "Traceback" not in stderr
    assert json.loads((tmp_path / "out" / "summary.json").read_text())["interrupted"] is True


def test_help_and_version(tmp_path):
    done = in_a_process("--help", cwd=tmp_path)
    assert done.returncode == 0
    for command in ("run", "plan", "check", "agent", "benchmark", "export", "list"):
        assert command in done.stdout


def test_convert_reports_parts_that_the_format_lacks(tmp_path, floorwalker):
    done = floorwalker("convert", "ariac2023", tmp_path / "hall.wkt")
    assert done.returncode == 0
    assert "cannot contain: AGVs, the gantry" in done.stderr
    back = floorwalker("convert", tmp_path / "hall.wkt", tmp_path / "hall.yaml")
    assert (back.returncode, back.stderr) == (0, "")
    assert floorplan.load(tmp_path / "hall.yaml") == floorplan.load(tmp_path / "hall.wkt")


@pytest.mark.parametrize("options", [["hall.pgm"], ["hall.yaml", "--resolution", 0.5]])
def test_convert_does_not_write_over_the_floor_that_it_reads(tmp_path, floorwalker, options):
    """A ROS map has two files, one of which may have the name of the floor."""
    floorplan.load("warehouse").save(tmp_path / "hall.yaml")
    before = (tmp_path / "hall.yaml").read_bytes()
    done = floorwalker("convert", tmp_path / "hall.yaml", tmp_path / options[0], *options[1:])
    assert (done.returncode, done.stdout) == (1, "")
    assert "hall.yaml would replace IN" in done.stderr
    assert [file.name for file in tmp_path.iterdir()] == ["hall.yaml"]
    assert (tmp_path / "hall.yaml").read_bytes() == before
    done = floorwalker("convert", tmp_path / "hall.yaml", tmp_path / "map.pgm")
    assert done.stdout == f"Wrote {tmp_path / 'map.pgm'} and {tmp_path / 'map.yaml'}\n"


@pytest.mark.skipif(sys.platform == "win32", reason="pseudo-terminals are POSIX's")
@pytest.mark.parametrize(
    ("on_a_terminal", "options", "environ", "opens"),
    [
        (True, [], {"CI": ""}, True),
        (True, [], {"CI": "true"}, False),
        (True, ["--no-open"], {"CI": ""}, False),
        (False, [], {"CI": ""}, False),
        (False, ["--open"], {"CI": "true"}, True),
    ],
)
def test_the_page_opens_if_there_is_a_screen(
    on_a_terminal, options, environ, opens, tmp_path, monkeypatch, floorwalker
):
    browser = tmp_path / "browser"
    browser.write_text('#!/bin/sh\necho "$1" > "$0.opened"\n', encoding="utf-8")
    browser.chmod(0o755)
    for name, value in {**environ, "BROWSER": str(browser)}.items():
        monkeypatch.setenv(name, value)
    monkeypatch.setattr(webbrowser, "_tryorder", None)  # built once, from BROWSER
    arguments = ["run", "people_frontal", "--duration", "5", "--out", "run", *options]
    if on_a_terminal:
        at, terminal = os.openpty()
        monkeypatch.chdir(tmp_path)
        monkeypatch.setattr(sys, "argv", ["floorwalker", *arguments])
        with os.fdopen(terminal, "w") as stdout, pytest.raises(SystemExit):
            monkeypatch.setattr(sys, "stdout", stdout)
            floorwalker_module.main()
        monkeypatch.undo()
        os.close(at)
    else:
        floorwalker(*arguments, cwd=tmp_path)
    page = (tmp_path / "run" / "replay.html").as_uri()
    opened = tmp_path / "browser.opened"
    if opens:
        address = until(lambda: opened.exists() and opened.read_text(encoding="utf-8"))
        assert address == f"{page}\n"
    else:
        assert not opened.exists()


@pytest.mark.parametrize(("words", "code"), [("--version", 0), ("list --wrong", 2)])
def test_exit_handlers_run_at_the_end(words, code, tmp_path):
    (tmp_path / "floorwalker").write_text(
        "import atexit\natexit.register(print, 'the end')\nfrom floorwalker import main\nmain()\n"
    )
    begun = [sys.executable, tmp_path / "floorwalker", *words.split()]
    done = subprocess.run(begun, capture_output=True, text=True, timeout=HANG)
    assert done.returncode == code
    assert done.stdout.endswith("the end\n")
    assert "leaked" not in done.stderr


def test_an_internal_error_shows_its_traceback(monkeypatch, tmp_path, capsys):
    def broken(*_):
        return (1, 2).index(3)

    monkeypatch.setattr(sim.Simulation, "advance", broken)
    monkeypatch.setattr(sys, "argv", ["floorwalker", "run", "--out", str(tmp_path / "run")])
    with pytest.raises(SystemExit) as ended:
        floorwalker_module.main()
    assert ended.value.code == 1
    *_, error, last = capsys.readouterr().err.splitlines()
    assert error == "ValueError: tuple.index(x): x not in tuple"
    assert "defect of Floorwalker" in last
    assert "report it" in last


def test_check_does_not_list_a_defect_as_a_fault_of_the_file(monkeypatch, tmp_path, capsys):
    def broken(*_, **__):
        raise ValueError("inside")

    (tmp_path / "one.trial.yaml").write_text("floorplan: ariac2023\n")
    monkeypatch.setattr(sim.Trial, "load", broken)
    monkeypatch.setattr(sys, "argv", ["floorwalker", "check", str(tmp_path / "one.trial.yaml")])
    with pytest.raises(SystemExit) as ended:
        floorwalker_module.main()
    assert ended.value.code == 1
    assert "Traceback" in (said := capsys.readouterr().err)
    assert "defect of Floorwalker" in said
