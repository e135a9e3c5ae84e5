"""Every public name is explained where it is defined, and behaves as Python does."""

import ast
import copy
import importlib
import inspect
import pickle
import re
from dataclasses import replace
from pathlib import Path
from typing import get_origin, get_type_hints

import pytest
from IPython.core.completer import IPCompleter, provisionalcompleter

import sim

PACKAGES = ("floorplan", "navigation", "bdi", "sim")
NAMES = [
    f"{package}.{name}" for package in PACKAGES for name in importlib.import_module(package).__all__
]


def value(name):
    package, _, attribute = name.partition(".")
    return getattr(importlib.import_module(package), attribute)


def is_class(of):
    """Return True for a class; on Python 3.10 `dict[str, Any]` says that it is one, too."""
    return inspect.isclass(of) and get_origin(of) is None


def own_docstring(of):
    """A docstring that somebody wrote: dataclasses make one of their signature."""
    text = of.__doc__ or ""
    made = inspect.isclass(of) and text.startswith(f"{of.__name__}(")
    return "" if made else text.strip()


def public_members(cls):
    for name, member in vars(cls).items():
        if name.startswith("_"):
            continue
        function = getattr(member, "__func__", getattr(member, "fget", member))
        if inspect.isfunction(function):
            yield f"{cls.__name__}.{name}", function


def test_packages_say_what_they_are_for():
    assert [name for name in PACKAGES if not importlib.import_module(name).__doc__] == []


def test_classes_and_their_methods_have_docstrings():
    classes = [name for name in NAMES if is_class(value(name))]
    assert [name for name in classes if not own_docstring(value(name))] == []
    members = [member for name in classes for member in public_members(value(name))]
    assert [member for member, function in members if not own_docstring(function)] == []


def test_functions_say_what_each_parameter_is():
    functions = [name for name in NAMES if inspect.isfunction(value(name))]
    assert [name for name in functions if not own_docstring(value(name))] == []
    unnamed = [
        f"{parameter} of {name}"
        for name in functions
        for parameter in inspect.signature(value(name)).parameters
        if not re.search(rf"\b{parameter}\b", own_docstring(value(name)))
    ]
    assert unnamed == []


def public_callables(module):
    """Every function, class and public method that a package offers, by its name."""
    for name in module.__all__:
        found = getattr(module, name)
        if inspect.ismodule(found):
            yield from public_callables(found)
        elif inspect.isfunction(found) or is_class(found):
            yield f"{module.__name__}.{name}", found
        if is_class(found):
            yield from ((member, function) for member, function in public_members(found))
            yield f"{name}.__init__", found.__init__


def completions(text):
    """What IPython offers after `text`."""
    completer = IPCompleter(namespace={"sim": sim}, use_jedi=False)
    with provisionalcompleter():
        return {one.text for one in completer.completions(text, len(text))}


@pytest.mark.parametrize("package", PACKAGES)
def test_names_of_the_reference_are_those_that_are_loaded(package):
    """Type checkers and the reference go by `__all__` in the stub, Python by its imports."""
    module = importlib.import_module(package)
    stub = ast.parse(Path(module.__file__).with_suffix(".pyi").read_text(encoding="utf-8"))
    (listed,) = [node.value for node in stub.body if isinstance(node, ast.Assign)]
    assert sorted(ast.literal_eval(listed)) == sorted(module.__all__)


def test_completion_offers_every_public_name_of_sim():
    assert set(sim.__all__) <= set(dir(sim))
    assert {f".{name}" for name in sim.__all__} <= completions("sim.")
    assert {f".{name}" for name in sim.plots.__all__} <= completions("sim.plots.")


def test_annotations_of_sim_can_be_read():
    for name, function in public_callables(sim):
        if inspect.isfunction(function) or is_class(function):
            assert isinstance(get_type_hints(function), dict), name


TRIAL = sim.Trial.load("ariac2023")
VALUES = (
    TRIAL,
    TRIAL.people[0],
    TRIAL.gantry,
    sim.Job("move", target=(-3.0, 1.0, 0.0)),
    sim.Start(3.0),
    sim.WorkTask("dock", sim.Duration("fixed", (5.0,))),
    sim.PAPER,
    sim.Study("one", (TRIAL,), repeat=2),
    sim.OutputError("there is a file"),
)


@pytest.mark.parametrize("value", VALUES, ids=lambda value: type(value).__name__)
def test_values_can_be_copied_and_pickled(value):
    for twin in (copy.deepcopy(value), pickle.loads(pickle.dumps(value))):
        assert type(twin) is type(value)
        assert str(twin) == str(value) if isinstance(value, Exception) else twin == value


def test_runs_can_be_copied_and_pickled():
    run = sim.run(replace(TRIAL, duration=3.0))
    for twin in (copy.deepcopy(run), pickle.loads(pickle.dumps(run))):
        assert (twin.trial, twin.summary, twin.events) == (run.trial, run.summary, run.events)


@pytest.fixture(params=["Simulation", "GantryRobot", "Body", "Recording", "LiveRun"])
def part_of_a_run(request, tmp_path):
    """Something that goes on while a run does."""
    simulation = sim.Simulation(TRIAL)
    match request.param:
        case "Simulation":
            yield simulation
        case "GantryRobot":
            yield simulation.gantry
        case "Body":
            yield simulation.bodies[0]
        case "Recording":
            recording = sim.Recording(tmp_path / "run")
            yield recording
            recording.close()
        case "LiveRun":
            live = sim.LiveRun(TRIAL.duration)
            with live.server:
                yield live


def test_parts_of_a_run_say_why_they_cannot_be_copied(part_of_a_run):
    message = f"a {type(part_of_a_run).__name__} cannot be copied .* run in progress"
    for copied in (copy.copy, copy.deepcopy, pickle.dumps):
        with pytest.raises(TypeError, match=message):
            copied(part_of_a_run)
