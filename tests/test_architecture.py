"""Layers of the packages and the direction of their imports."""

import ast
import re
import subprocess
import sys
from functools import cache
from graphlib import CycleError, TopologicalSorter
from importlib.util import find_spec, resolve_name
from pathlib import Path
from typing import NamedTuple

import pytest

ROOT = Path(__file__).resolve().parents[1]
PACKAGES = {
    "floorplan": set(),
    "navigation": {"floorplan"},
    "bdi": set(),
    "sim": {"floorplan", "navigation", "bdi"},
}
HEAVY = {"matplotlib", "pandas", "pyarrow", "ezdxf", "PIL", "av", "foxglove", "rosbags"}
LOADED_WHEN_USED = re.compile(
    r"sim/(exports/(\w+_file|ros_\w+)|people/tracks/bag_file|views/plots/\w+)\.py$"
)


ROOMS = (
    ("core",),
    ("safety",),
    ("people", "machines"),
    ("orders",),
    ("record",),
    ("trials", "views", "exports"),
    ("runs",),
    ("simulation",),
    ("cell",),
    ("competition",),
    ("live", "studies", "testing"),
    ("bridge", "gym", "ros2", "searches"),
    ("commands",),
    ("cli", "pytest_plugin"),
)
"""The rooms of `sim`. Each imports only from rooms above it."""


OF_THE_LIBRARY = {
    "floorplan": {"files", "loading", "building", "checks", "model", "plan", "formats"},
    "navigation": {
        "benchmark",
        "carried",
        "contacts",
        "catalog",
        "encounter",
        "field_lengths",
        "fields",
        "freespace",
        "kernels",
        "machines",
        "measures",
        "monitor",
        "motion",
        "moving_obstacles",
        "polynomials",
        "separation",
        "vehicle_planner",
        "vehicles",
        "walking",
    },
    "bdi": {"actions", "language", "reasoning"},
}
"""Inner modules of each package that others import. They use public names otherwise."""


def sources(package):
    """Return the files of a package, wherever it is installed."""
    return Path(find_spec(package).origin).parent.rglob("*.py")


def module_name(package, path):
    """Return the dotted name of the module at `path`."""
    parts = path.relative_to(Path(find_spec(package).origin).parents[1]).with_suffix("").parts
    return ".".join(parts[:-1] if parts[-1] == "__init__" else parts)


class Parsed(NamedTuple):
    """Imports of a file, each with whether it is at the top level, and its classes with lines."""

    imports: list[tuple[ast.Import | ast.ImportFrom, bool]]
    classes: list[tuple[str, int]]


@cache
def parsed(path):
    """Return the imports and classes of a file, without its tree, because trees are large."""
    tree = ast.parse(path.read_text(encoding="utf-8"))
    top_level, nodes = set(map(id, tree.body)), [*ast.walk(tree)]
    imports = [node for node in nodes if isinstance(node, ast.Import | ast.ImportFrom)]
    classes = [(node.name, node.lineno) for node in nodes if isinstance(node, ast.ClassDef)]
    return Parsed([(node, id(node) in top_level) for node in imports], classes)


def imported(name, path, modules):
    """Return those of `modules` that a module imports, also for types alone and in functions."""
    package = name if path.name == "__init__.py" else name.rpartition(".")[0]
    for node, _ in parsed(path).imports:
        if isinstance(node, ast.Import):
            wanted = [alias.name for alias in node.names]
        else:
            relative = "." * node.level + (node.module or "")
            base = resolve_name(relative, package)
            wanted = [f"{base}.{alias.name}" for alias in node.names]
        for module in wanted:
            while module and module not in modules:
                module = module.rpartition(".")[0]
            if module and module != name:
                yield module


@pytest.fixture(scope="module")
def graph():
    """Return the modules that each module of the four packages imports from them."""
    files = {module_name(package, path): path for package in PACKAGES for path in sources(package)}
    return {name: set(imported(name, path, files)) for name, path in files.items()}


def test_no_files_import_each_other_in_a_circle(graph):
    try:
        TopologicalSorter(graph).prepare()
    except CycleError as why:
        circle = why.args[1]
    else:
        circle = []
    assert circle == []


def test_rooms_import_only_from_rooms_above_them(graph):
    level = {room: k for k, rooms in enumerate(ROOMS) for room in rooms}
    for module, others in graph.items():
        for other in others:
            if module.startswith("sim.") and other.startswith("sim."):
                mine, its = (name.split(".")[1] for name in (module, other))
                assert mine == its or level[its] < level[mine], f"{module} imports {other}"


def imports(path):
    """Return (top package, module-level, line) of every absolute import in a file."""
    for node, at_top in parsed(path).imports:
        if isinstance(node, ast.Import):
            names = [alias.name for alias in node.names]
        elif node.level == 0:
            names = [node.module]
        else:
            continue
        for name in names:
            yield name, at_top, node.lineno


@pytest.mark.parametrize("package", PACKAGES)
def test_imports_go_in_one_direction(package):
    for path in sources(package):
        for name, _, line in imports(path):
            top = name.partition(".")[0]
            if top in PACKAGES and top != package:
                assert top in PACKAGES[package], f"{path}:{line} imports {name}"


@pytest.mark.parametrize("package", PACKAGES)
def test_only_listed_inner_modules_are_imported_by_other_packages(package):
    for path in sources(package):
        for name, _, line in imports(path):
            top, _, inner = name.partition(".")
            if top in PACKAGES and top != package and inner:
                listed = OF_THE_LIBRARY[top]
                assert inner.partition(".")[0] in listed, f"{path}:{line} imports {name}"


def test_no_class_name_occurs_twice():
    places = {}
    for package in PACKAGES:
        for path in sources(package):
            for name, line in parsed(path).classes:
                places.setdefault(name, []).append(f"{path}:{line}")
    assert {name: where for name, where in places.items() if len(where) > 1} == {}


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


def printed_by(code: str) -> str:
    """Return the output of a program in a separate process."""
    done = subprocess.run(
        [sys.executable, "-c", code], cwd=ROOT, capture_output=True, text=True, check=True
    )
    return done.stdout.strip()


def test_writers_of_exports_are_loaded_when_they_are_used():
    code = f"import sys, sim.exports; print(sorted({HEAVY} & set(sys.modules)))"
    assert printed_by(code) == "[]"


def test_the_help_loads_no_planner_and_no_geometry():
    code = (
        "import sys, sim.cli; heavy = {'numpy', 'shapely', 'ompl', 'fcl', 'ruckig', 'simpy'};"
        "print(sorted(heavy & set(sys.modules)))"
    )
    assert printed_by(code) == "[]"


def test_the_parser_is_loaded_with_the_first_program_that_is_read():
    code = (
        "import sys, sim, bdi; before = 'lark' in sys.modules;"
        "bdi.parse('!go.'); print(before, 'lark' in sys.modules)"
    )
    assert printed_by(code) == "False True"
