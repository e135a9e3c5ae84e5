"""Completion on the command line, requested as shells do."""

import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

import bdi
import floorplan
import navigation
import sim

ROOT = Path(__file__).resolve().parents[2]
HEAVY = ("numpy", "shapely", "ompl", "fcl", "lark", "rich", "bdi", "floorplan")


@pytest.fixture
def completions(floorwalker, monkeypatch):
    """Return a function that requests completions in this process by the variables of a shell."""

    def completions(folder, **variables):
        with monkeypatch.context() as now:
            for name, value in variables.items():
                now.setenv(name, value)
            done = floorwalker(cwd=folder)
        assert (done.returncode, done.stderr) == (0, "")
        return done.stdout

    return completions


@pytest.fixture
def in_bash(completions, folder):
    def offered(line):
        variables = {"COMP_WORDS": line, "COMP_CWORD": str(line.count(" "))}
        return completions(folder, _FLOORWALKER_COMPLETE="complete_bash", **variables).split()

    return offered


@pytest.fixture
def folder(tmp_path):
    """A typical folder of a user."""
    (tmp_path / "mine.trial.yaml").touch()
    (tmp_path / "mine.asl").touch()
    (tmp_path / "notes.txt").touch()
    (tmp_path / "two words.yaml").touch()
    (tmp_path / "runs" / "lunch").mkdir(parents=True)
    (tmp_path / "runs" / "dinner").mkdir()
    return tmp_path


def test_commands_and_options(in_bash):
    assert in_bash("floorwalker re") == ["replay", "render", "report"]
    assert in_bash("floorwalker plot sp") == ["spacetime"]
    assert in_bash("floorwalker run --per") == ["--personality"]


@pytest.mark.parametrize(
    ("line", "offered"),
    [
        ("run ", [*sim.builtin_trials(), "mine.trial.yaml", "runs/"]),
        ("run scene_h", ["scene_helpful"]),
        ("run --personality ", [*bdi.programs(), "mine.asl", "runs/"]),
        ("run --personality an", ["antagonistic"]),
        ("run --controller p", ["parked", "pausing"]),
        ("run --rules a", ["ariac2023"]),
        ("plan w", ["warehouse"]),
        ("plan warehouse 0 0 1 1 --planner RRTC", ["RRTConnect"]),
        ("check mine", ["mine.asl", "mine.trial.yaml"]),
        ("study ", ["mine.trial.yaml", "runs/"]),
        ("study s.yaml --backend d", ["dask"]),
        ("metrics ru", ["runs/dinner/", "runs/lunch/"]),
        ("export runs/l", ["runs/lunch/"]),
        ("export runs/lunch --format m", ["mcap"]),
        ("plot trails runs/", ["runs/dinner/", "runs/lunch/"]),
        ("check nowhere/", []),
    ],
)
def test_values(line, offered, in_bash):
    assert in_bash(f"floorwalker {line}") == offered


def test_the_shell_completes_files_of_any_kind(in_bash):
    assert in_bash("floorwalker export runs/lunch --out m") == []


@pytest.mark.skipif(shutil.which("bash") is None, reason="no bash on this machine")
def test_the_script_for_bash_works_in_bash(completions, folder):
    script = completions(folder, _FLOORWALKER_COMPLETE="source_bash")
    function = re.search(r"^(\w+)\(\)", script, re.M)[1]
    wrapper = folder / "floorwalker"
    wrapper.write_text(f'#!/bin/sh\nexec {sys.executable} -m sim.cli "$@"\n')
    wrapper.chmod(0o755)
    tab = (
        f"{script}\nCOMP_WORDS=(floorwalker run --rules pa); COMP_CWORD=3;"
        f' {function} "{wrapper}"; printf "%s\\n" "${{COMPREPLY[@]}}"'
    )
    done = subprocess.run(["bash", "--norc", "-c", tab], capture_output=True, text=True)
    assert (done.stdout, done.stderr) == ("paper\n", "")


def test_completion_works_in_zsh_and_fish(completions, folder):
    words = "floorwalker run --controller pau"
    zsh = completions(folder, _FLOORWALKER_COMPLETE="complete_zsh", _TYPER_COMPLETE_ARGS=words)
    assert re.fullmatch(r"""_arguments '\*: :\(\("?pausing"?\)\)'\n""", zsh)
    fish = completions(
        folder,
        _FLOORWALKER_COMPLETE="complete_fish",
        _TYPER_COMPLETE_ARGS=words,
        _TYPER_COMPLETE_FISH_ACTION="get-args",
    )
    assert fish == "pausing\n"


def test_completion_offers_existing_names(in_bash, floorwalker):
    listed = floorwalker("list").stdout.split("\ncontrollers\n")[1].split("\nrule sets\n")[0]
    controllers = [line.split()[0] for line in listed.splitlines()]
    assert len(controllers) > 4
    assert sorted(in_bash("floorwalker run --controller ")) == sorted(controllers)
    rules = [name for name in in_bash("floorwalker run --rules ") if name.isidentifier()]
    assert sorted(rules) == sorted(sim.RULE_SETS)
    planners = in_bash("floorwalker plan ariac2023 0 0 1 1 --planner ")
    assert planners and {info.name for info in navigation.planners()} >= set(planners)
    floors = in_bash("floorwalker plan ")
    assert floors[: len(floorplan.builtin())] == list(floorplan.builtin())
    assert set(bdi.programs()) <= set(in_bash("floorwalker run --personality "))


def test_completion_loads_no_heavy_packages(folder):
    code = (
        "import sys\n"
        "try:\n    from sim.cli import main; main()\n"
        f"finally:\n    print(sorted({set(HEAVY)} & set(sys.modules)), file=sys.stderr)"
    )
    env = {
        **os.environ,
        "_FLOORWALKER_COMPLETE": "complete_bash",
        "COMP_WORDS": "floorwalker check ",
        "COMP_CWORD": "2",
    }
    command = [sys.executable, "-c", code]
    done = subprocess.run(command, cwd=folder, env=env, capture_output=True, text=True)
    assert "helpful" in done.stdout
    assert done.stderr.strip() == "[]"
