"""Worked examples: their files are sound, and the commands of their pages run."""

import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

import floorplan
import sim

pytest.importorskip("ezdxf")

ROOT = Path(__file__).resolve().parents[2]
EXAMPLES = {"press_hall": "example-press-hall.md", "picking_hall": "example-picking-hall.md"}


@pytest.mark.parametrize("name", EXAMPLES)
def test_files_of_worked_examples_are_sound(name):
    """Floors have no notices, laws assume long enough stops, and speeds have a source."""
    folder = ROOT / "examples" / name
    trial = sim.Trial.load(folder / "shift.trial.yaml")
    assert trial.floorplan.notices == () and trial.sources["max_speed"]
    assert sim.Simulation(trial).finish().summary["law_audit"] == []
    (study,) = folder.glob("*.study.yaml")
    assert len(sim.Study.load(study)) >= 20


@pytest.mark.slow
@pytest.mark.parametrize("name", EXAMPLES)
def test_commands_of_worked_examples_run(name, floorwalker, tmp_path):
    folder = tmp_path / name
    shutil.copytree(ROOT / "examples" / name, folder)
    page = (ROOT / "docs" / EXAMPLES[name]).read_text(encoding="utf-8")
    commands = [
        line
        for block in re.findall(r"```sh\n(.*?)```", page, re.S)
        for line in block.splitlines()
        if line.startswith("floorwalker ")
    ]
    assert len(commands) > 3
    for command in commands:
        done = floorwalker(*command.split()[1:], cwd=folder)
        assert done.returncode == 0, done.stderr
    drawn = floorplan.load(folder / "hall.yaml")
    (folder / "hall.dxf").unlink()
    subprocess.run([sys.executable, folder / "draw.py"], check=True)
    assert floorplan.load(folder / "hall.yaml") == drawn
