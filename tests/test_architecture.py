"""The rooms of the house and the direction of its imports."""

import ast
import re
import subprocess
import sys
from importlib.util import find_spec
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


def sources(package):
    """The files of a package, wherever it is installed."""
    return Path(find_spec(package).origin).parent.rglob("*.py")


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
    for path in sources(package):
        for name, _, line in imports(path):
            top = name.partition(".")[0]
            if top in PACKAGES and top != package:
                assert top in PACKAGES[package], f"{path}:{line} imports {name}"


@pytest.mark.parametrize("package", PACKAGES)
def test_heavy_parts_are_imported_where_they_are_used(package):
    for path in sources(package):
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
    for file in sources("sim"):
        for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
            if not (isinstance(node, ast.Call) and ast.unparse(node.func).endswith("record")):
                continue
            if node.args and isinstance(node.args[0], ast.Constant):
                fields = {keyword.arg for keyword in node.keywords} - {None}
                yield file.name, node.args[0].value, fields


def test_every_kind_of_event_is_known():
    """Trials can expect whatever is recorded: see `sim/core/event_kinds.py`."""
    from sim.core.event_kinds import EVENT_KINDS

    found = list(recorded_kinds())
    assert len(found) > 10
    for file, kind, fields in found:
        assert kind in EVENT_KINDS, f"{file} records {kind}"
        assert fields <= set(EVENT_KINDS[kind]), f"{file} records {kind} with {fields}"
