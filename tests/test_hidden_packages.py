"""A user's file with the name of a package: named by the command, harmless to pytest."""

import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]


@pytest.fixture
def in_folder(tmp_path):
    """Run Python in a folder that has a sim.py and a test."""
    (tmp_path / "sim.py").write_text("MINE = 1\n")
    (tmp_path / "test_mine.py").write_text("from sim import MINE\n\ndef test_it(): assert MINE\n")

    def run(*arguments):
        return subprocess.run(
            [sys.executable, *arguments],
            cwd=tmp_path,
            capture_output=True,
            text=True,
        )

    return run


@pytest.mark.parametrize("package", ["floorplan", "navigation", "bdi"])
@pytest.mark.parametrize("form", ["{}.py", "{}/__init__.py", "{}/notes.txt"])
def test_a_script_reports_the_file_or_folder_that_hides_a_package(tmp_path, package, form):
    hiding = tmp_path / form.format(package)
    hiding.parent.mkdir(exist_ok=True)
    hiding.write_text("")
    (tmp_path / "script.py").write_text("import sim\nprint(sim.Trial)\n")
    done = subprocess.run(
        [sys.executable, "script.py"], cwd=tmp_path, capture_output=True, text=True
    )
    is_hidden = f"hides Floorwalker's package {package}" in done.stderr
    # Python prefers a package elsewhere to a folder without modules, unless it is editable.
    assert is_hidden or (form == "{}/notes.txt" and done.returncode == 0), done.stderr


@pytest.mark.parametrize("package", ["floorplan", "navigation", "bdi", "sim"])
def test_the_command_names_the_folder_that_hides_a_package(tmp_path, package):
    (tmp_path / package).mkdir()
    (tmp_path / package / "__init__.py").write_text("")
    done = subprocess.run(
        [sys.executable, "-m", "floorwalker", "list"], cwd=tmp_path, capture_output=True, text=True
    )
    assert done.returncode == 1 and "Traceback" not in done.stderr
    assert f"hides Floorwalker's package {package}" in done.stderr


def test_the_command_names_the_file_that_hides_a_package(in_folder):
    done = in_folder("-m", "floorwalker", "list")
    assert done.returncode == 1 and done.stdout == ""
    assert "sim.py hides" in done.stderr and "Traceback" not in done.stderr


def test_pytest_continues_without_the_plugin(in_folder):
    done = in_folder("-m", "pytest", "-p", "floorwalker", "-p", "no:cacheprovider", "test_mine.py")
    assert done.returncode == 0, done.stdout + done.stderr
    assert "sim.py hides" in done.stdout
