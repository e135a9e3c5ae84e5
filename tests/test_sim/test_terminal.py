"""Whatever names and messages hold: no control character of theirs reaches the terminal."""

import ast
import json
import re
from pathlib import Path

import pytest
from run_events import record

import sim
from sim.commands.terminal import plain_console, visible

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
def test_control_characters_are_shown_and_not_obeyed(folder, floorwalker, arguments, shown):
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
    assert printing == {"commands/terminal.py"}
