"""Output: atomic writing of files, text without control characters, and topic names."""

import ast
import json
import os
import re
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from threading import Barrier

import pytest
from hypothesis import given, strategies as st
from run_events import record

import sim
from sim.commands.terminal import plain_console, visible
from sim.exports.ros_bag import topic_names
from sim.record.output import replacing, write_whole

TRIAL = "floorplan: ariac2023\nduration: 3.0\npeople: [{name: ada}]\n"


@pytest.fixture(scope="module")
def recorded(tmp_path_factory):
    folder = tmp_path_factory.mktemp("recorded")
    record(sim.Trial.parse(TRIAL), folder / "run")
    return folder / "run"


@pytest.mark.parametrize(
    ("command", "file"),
    [
        ("replay {run} --no-open --out {file}", "page.html"),
        ("export {run} --out {file}", "table.csv"),
        ("export {run} --out {file}", "people.sqlite"),
    ],
)
def test_a_full_disk_leaves_the_previous_file(
    recorded, tmp_path, floorwalker, room_for, command, file
):
    (tmp_path / file).write_text("the one before")
    with room_for(4000):
        done = floorwalker(*command.format(run=recorded, file=file).split(), cwd=tmp_path)
    assert done.returncode == 1
    assert done.stderr.startswith(f"floorwalker: can't write {file}: ")
    assert [path.name for path in tmp_path.iterdir()] == [file]
    assert (tmp_path / file).read_text() == "the one before"


def test_a_file_replaces_another_atomically(tmp_path):
    (tmp_path / "a").write_text("before")
    (tmp_path / "link").symlink_to(tmp_path / "a")
    with pytest.raises(KeyError), replacing(tmp_path / "a") as unfinished:
        unfinished.write_text("half")
        raise KeyError
    assert (tmp_path / "a").read_text() == "before"
    write_whole(tmp_path / "link", "after")
    assert (tmp_path / "link").is_symlink() and (tmp_path / "a").read_text() == "after"
    assert {path.name for path in tmp_path.iterdir()} == {"a", "link"}
    write_whole(Path(os.devnull), "nothing")


def test_simultaneous_runs_get_separate_folders(tmp_path):
    scene = sim.run(sim.Trial.parse(TRIAL)).scene
    together = Barrier(8)

    def begin():
        recording = sim.Recording(tmp_path / "runs" / "t", numbered=True)
        together.wait()
        recording.begin(scene)
        recording.close()
        return recording.folder.name

    with ThreadPoolExecutor(8) as threads:
        taken = [thread.result() for thread in [threads.submit(begin) for _ in range(8)]]
    assert sorted(taken) == sorted(["t", *(f"t-{k}" for k in range(2, 9))])
    (tmp_path / "file").write_text("")
    with pytest.raises(sim.OutputError):
        sim.Recording(tmp_path / "file" / "t", numbered=True).begin(scene)


@pytest.mark.parametrize(
    ("out", "why"), [("file", "it is not a folder"), ("file/inside", "Not a directory")]
)
def test_a_run_that_cannot_be_written_is_reported(tmp_path, floorwalker, out, why):
    (tmp_path / "file").write_text("")
    done = floorwalker("run", "--duration", "2", "--out", out, cwd=tmp_path)
    assert done.returncode == 1 and done.stdout == ""
    assert done.stderr == f"floorwalker: can't write to {out}: {why}\n"


def test_a_run_needs_no_stdout(tmp_path, floorwalker, monkeypatch):
    monkeypatch.setattr("sys.stdout", None)
    monkeypatch.setattr("sys.__stdout__", None)
    done = floorwalker("run", "--duration", "2", "--out", "run", cwd=tmp_path)
    assert (done.returncode, done.stderr) == (0, "")
    assert sim.load_run(tmp_path / "run").duration == 2.0


RED = "\x1b[31mred\x9b0m"
CONTROL = re.compile("[\0-\x08\x0b-\x1f\x7f-\x9f]")


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A folder with files of all kinds that have control characters in them."""
    folder = tmp_path_factory.mktemp("folder")
    trial = sim.Trial.parse("{floorplan: ariac2023, duration: 1.0, people: [{name: ada}]}")
    record(trial, folder / "run")
    for path in (folder / "run").glob("*.json*"):
        path.write_text(path.read_text().replace('"ada"', json.dumps(f"ada{RED}")))
    (folder / "said.asl").write_text(f'!go. +!go <- .print("{RED}"); do("{RED}").')
    (folder / "wrong.asl").write_text(f"!go. {RED}")
    (folder / "floor.wkt").write_text(f"POLYGON {RED}")
    (folder / "percepts.jsonl").write_text(f"{RED}\n")
    (folder / f"{RED}.asl").write_text("!go. +!go.")
    return folder


@pytest.mark.parametrize(
    ("arguments", "shown"),
    [
        (("agent", "said.asl", "--trace"), r"\u001b[31mred\u009b0m"),
        (("agent", "said.asl", "--percepts", "percepts.jsonl"), r"\u001b[31m"),
        (("check", "wrong.asl"), "wrong.asl"),
        (("check", "floor.wkt"), "floor.wkt"),
        (("check", f"{RED}.asl"), r"\u001b[31mred\u009b0m.asl: a program"),
        (("metrics", "run"), r"\u001b"),
        (("metrics", "run", "--json"), r"\u009b0m"),
    ],
)
def test_control_characters_are_escaped(folder, floorwalker, arguments, shown):
    done = floorwalker(*arguments, cwd=folder)
    said = done.stdout + done.stderr
    assert shown in said
    assert not CONTROL.search(said)


@pytest.mark.parametrize("text", ['name: "a\\e[31mred"', '"\\e[2Jkey": 1', 'name: "a\\x9b0m"'])
def test_files_that_people_write_have_no_control_characters(text):
    with pytest.raises(sim.TrialError, match=r"line 2.*: a text can't have the character U\+00"):
        sim.Trial.parse(f"floorplan: ariac2023\n{text}\n")


def test_tables_show_control_characters(capsys):
    plain_console(40).print(RED)
    assert capsys.readouterr().out == f"{visible(RED)}\n"
    assert json.loads(visible(json.dumps(RED, ensure_ascii=False))) == RED


def test_commands_print_in_one_place():
    package = Path(sim.__file__).parent
    printing = {
        path.relative_to(package).as_posix()
        for path in package.rglob("*.py")
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8")))
        if isinstance(node, ast.Call) and ast.unparse(node.func) in ("print", "typer.echo")
    }
    assert printing == {"commands/terminal.py", "core/compilation.py"}


NAMES = st.lists(st.text(max_size=8), unique=True)


@given(NAMES)
def test_topic_names_are_allowed_and_different(names):
    topics = topic_names(names)
    assert list(topics) == names
    assert len(set(topics.values())) == len(names)
    for name in topics.values():
        assert re.fullmatch(r"[A-Za-z][A-Za-z0-9_]*", name)
