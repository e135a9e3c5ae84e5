"""The rooms of the house and the direction of its imports; what a wheel contains."""

import ast
import os
import re
import subprocess
import sys
import venv
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]
PACKAGES = {
    "floorplan": set(),
    "navigation": {"floorplan"},
    "bdi": set(),
    "sim": {"floorplan", "navigation", "bdi"},
}
HEAVY = {"matplotlib", "pandas", "pyarrow", "ezdxf", "PIL", "foxglove", "rosbags"}
LOADED_WHEN_USED = re.compile(r"sim/exports/(\w+_file|ros_\w+)\.py$")


def imports(path):
    """The (top package, module-level, line) of every absolute import in a file."""
    tree = ast.parse(path.read_text(encoding="utf-8"))
    top_level = set(map(id, tree.body))
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            names = [alias.name for alias in node.names]
        elif isinstance(node, ast.ImportFrom) and node.level == 0:
            names = [node.module]
        else:
            continue
        for name in names:
            yield name, id(node) in top_level, node.lineno


@pytest.mark.parametrize("package", PACKAGES)
def test_imports_go_in_one_direction(package):
    for path in (ROOT / package).rglob("*.py"):
        for name, _, line in imports(path):
            top = name.partition(".")[0]
            if top in PACKAGES and top != package:
                assert top in PACKAGES[package], f"{path}:{line} imports {name}"


@pytest.mark.parametrize("package", PACKAGES)
def test_heavy_parts_are_imported_where_they_are_used(package):
    for path in (ROOT / package).rglob("*.py"):
        for name, at_top, line in imports(path):
            at_once = at_top and not LOADED_WHEN_USED.search(path.as_posix())
            assert not (at_once and name.partition(".")[0] in HEAVY), (
                f"{path}:{line} imports {name}"
            )


@pytest.mark.parametrize("package", PACKAGES)
def test_public_names_are_there(package):
    module = __import__(package)
    assert sorted(module.__all__) == sorted(set(module.__all__))
    for name in module.__all__:
        assert getattr(module, name) is not None


def test_writers_of_exports_are_loaded_when_they_are_used():
    code = f"import sys, sim.exports; print(sorted({HEAVY} & set(sys.modules)))"
    done = subprocess.run(
        [sys.executable, "-c", code], cwd=ROOT, capture_output=True, text=True, check=True
    )
    assert done.stdout.strip() == "[]"


def test_the_help_loads_no_planner_and_no_geometry():
    code = (
        "import sys, sim.cli; heavy = {'numpy', 'shapely', 'ompl', 'fcl', 'ruckig', 'simpy'};"
        "print(sorted(heavy & set(sys.modules)))"
    )
    done = subprocess.run(
        [sys.executable, "-c", code], cwd=ROOT, capture_output=True, text=True, check=True
    )
    assert done.stdout.strip() == "[]"


def recorded_kinds():
    """The file, kind and fields of every event that the sources record."""
    for file in (ROOT / "sim").rglob("*.py"):
        for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
            if not (isinstance(node, ast.Call) and ast.unparse(node.func).endswith("record")):
                continue
            if node.args and isinstance(node.args[0], ast.Constant):
                fields = {keyword.arg for keyword in node.keywords} - {None}
                yield file.name, node.args[0].value, fields


def test_every_kind_of_event_is_known():
    """Trials can expect whatever is recorded: see `sim/trials/event_kinds.py`."""
    from sim.trials.event_kinds import EVENT_KINDS

    found = list(recorded_kinds())
    assert len(found) > 10
    for file, kind, fields in found:
        assert kind in EVENT_KINDS, f"{file} records {kind}"
        assert fields <= set(EVENT_KINDS[kind]), f"{file} records {kind} with {fields}"


@pytest.mark.slow
def test_a_wheel_installs_and_runs_in_an_empty_environment(tmp_path):
    source = tmp_path / "source"
    subprocess.run(["git", "clone", "-q", str(ROOT), str(source)], check=True)
    environment = tmp_path / "environment"
    venv.create(environment, with_pip=True)
    python = environment / ("Scripts" if os.name == "nt" else "bin") / "python"
    pip = [str(python), "-m", "pip", "--quiet", "--disable-pip-version-check"]
    subprocess.run([*pip, "wheel", "--no-deps", "-w", str(tmp_path), str(source)], check=True)
    (wheel,) = tmp_path.glob("floorwalker-*.whl")
    subprocess.run([*pip, "install", str(wheel)], check=True)
    clean = {k: v for k, v in os.environ.items() if k != "PYTHONPATH"}
    command = str(python.parent / "floorwalker")
    for arguments in (["run", "--out", str(tmp_path / "out")], ["list"], ["--version"]):
        done = subprocess.run(
            [command, *arguments], cwd=tmp_path, env=clean, capture_output=True, text=True
        )
        assert (done.returncode, done.stderr) == (0, "")
    assert (tmp_path / "out" / "replay.html").stat().st_size > 50_000
