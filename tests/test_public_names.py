"""Public names: documented, with resolvable types, made by keyword, listed, and copied."""

import ast
import copy
import dataclasses
import doctest
import importlib
import inspect
import pickle
import re
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import get_origin, get_type_hints

import griffe
import pytest
from IPython.core.completer import IPCompleter, provisionalcompleter

import bdi
import floorplan
import navigation
import sim

ROOT = Path(__file__).parents[1]
PACKAGES = ("floorplan", "navigation", "bdi", "sim")
NAMES = [
    f"{package}.{name}" for package in PACKAGES for name in importlib.import_module(package).__all__
]


def value(name):
    package, _, attribute = name.partition(".")
    return getattr(importlib.import_module(package), attribute)


def is_class(of):
    """Return True for a class. On Python 3.10, `dict[str, Any]` also claims to be one."""
    return inspect.isclass(of) and get_origin(of) is None


def own_docstring(of):
    """Return a written docstring. Dataclasses create one from their signature."""
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


def test_packages_have_docstrings():
    assert [name for name in PACKAGES if not importlib.import_module(name).__doc__] == []


def test_classes_and_their_methods_have_docstrings():
    classes = [name for name in NAMES if is_class(value(name))]
    assert [name for name in classes if not own_docstring(value(name))] == []
    members = [member for name in classes for member in public_members(value(name))]
    own = [member for member in members if not getattr(member[1], "__override__", False)]
    assert [member for member, function in own if not own_docstring(function)] == []


def test_functions_document_each_parameter():
    functions = [name for name in NAMES if inspect.isfunction(value(name))]
    assert [name for name in functions if not own_docstring(value(name))] == []
    unnamed = [
        f"{parameter} of {name}"
        for name in functions
        for parameter in inspect.signature(value(name)).parameters
        if not re.search(rf"\b{parameter}\b", own_docstring(value(name)))
    ]
    assert unnamed == []


@cache
def documented_members(package):
    """Return the public functions and methods of a package, as its API page finds them."""
    dataclasses_extension = str(ROOT / "docs/griffe_dataclasses.py")
    extensions = griffe.load_extensions("griffe_inherited_docstrings", dataclasses_extension)
    module = importlib.import_module(package)
    folder = Path(module.__file__).parents[1]  # of the sources, or where the package is installed
    package_docs = griffe.load(
        package, search_paths=[folder], docstring_parser="numpy", extensions=extensions
    )
    functions = []
    for name in module.__all__:
        of = package_docs[name].final_target if package_docs[name].is_alias else package_docs[name]
        if of.is_function:
            functions.append((name, of))
        elif of.is_class:
            members = ((key, of.all_members[key]) for key in of.all_members if key[0] != "_")
            functions += [(f"{name}.{key}", one) for key, one in members if one.is_function]
    return functions


def sections(of):
    return (
        {one.kind.value: one.value for one in of.docstring.parse("numpy")} if of.docstring else {}
    )


@pytest.mark.parametrize("package", ["bdi", "sim"])
def test_sections_have_every_parameter(package):
    undocumented = {}
    for name, of in documented_members(package):
        documented = sections(of).get("parameters", [])
        wanted = [p.name for p in of.parameters if p.name not in ("self", "cls")]
        if [one.name.lstrip("*") for one in documented] != wanted:
            undocumented[name] = wanted
    assert undocumented == {}


@pytest.mark.parametrize("package", ["bdi", "sim"])
def test_sections_have_results(package):
    silent = [
        name
        for name, of in documented_members(package)
        if str(of.returns) not in ("None", "NoReturn")
        if not {"returns", "yields"} & sections(of).keys()
        if not of.docstring.value.startswith("Return ")
    ]
    assert silent == []


@pytest.mark.parametrize("name", [name for name in NAMES if ">>>" in own_docstring(value(name))])
def test_examples_in_docstrings_run(name):
    names = {"bdi": bdi, "sim": sim, "floorplan": floorplan, "navigation": navigation}
    finder = doctest.DocTestFinder(recurse=False)
    runner = doctest.DocTestRunner(optionflags=doctest.NORMALIZE_WHITESPACE)
    examples = finder.find(value(name), name, globs={**names, "replace": replace})
    results = [runner.run(example) for example in examples]
    assert sum(one.attempted for one in results) > 0
    assert sum(one.failed for one in results) == 0


GEOMETRY = ("floorplan", "navigation")

MOST_POSITIONAL = 3
"""Values with more fields are made by keyword."""


def names_of(package):
    return importlib.import_module(package).__all__


def classes_of(package):
    values = [getattr(importlib.import_module(package), name) for name in names_of(package)]
    return [of for of in values if is_class(of)]


def callables_of(package):
    """Return the functions, classes and public methods of a package, by name."""
    for name in names_of(package):
        of = value(f"{package}.{name}")
        if is_class(of):
            yield name, of
            yield name, of.__init__
            yield from public_members(of)
        elif inspect.isfunction(of):
            yield name, of


@pytest.mark.parametrize("package", PACKAGES)
def test_types_of_all_callables_can_be_resolved(package):
    unknown = []
    for name, of in callables_of(package):
        try:
            get_type_hints(of)
        except NameError as why:
            unknown.append(f"{name}: {why}")
    assert unknown == []


@pytest.mark.parametrize("package", PACKAGES)
def test_values_of_many_fields_are_made_by_keyword(package):
    positional = {
        of.__name__: names
        for of in classes_of(package)
        if dataclasses.is_dataclass(of)
        for names in [[f.name for f in dataclasses.fields(of) if f.init and not f.kw_only]]
        if len(names) > MOST_POSITIONAL
    }
    assert positional == {}


PLAN = floorplan.load("ariac2023")
LANE, GANTRY = PLAN.lanes[0], PLAN.gantry
WORLD = navigation.CollisionWorld(PLAN)
PERSON = navigation.walk([(-15.0, -10.0), (-13.0, -10.0), (-13.0, -8.0)])
MOVE = navigation.gantry_move((-7.0, 0.0, 0.0), (-2.5, 0.5, 0.0))
LAW = navigation.SeparationLaw(t1=1.0, t2=1.5, stopping=0.0, intrusion=1.0)
TORSO = navigation.Box.of_torso(GANTRY)
DOOR = floorplan.Door(name="door", ends=((0.0, 0.0), (1.0, 0.0)))
GATE = floorplan.Gate(name="gate", ends=((0.0, 0.0), (1.0, 0.0)), towards=(0.0, 1.0))
FIELDS = navigation.ProtectiveFields(
    sets=[navigation.FieldSet(name="all", protective=[(0.0, 0.0), (1.0, 0.0), (0.0, 1.0)])]
)
INTEGRAL = navigation.IntegralLaw(t1=0.1, t2=0.5, stopping=0.2, intrusion=0.1)

SAMPLES = {
    "floorplan": [
        *(PLAN, LANE, GANTRY, GANTRY.x, PLAN.human, PLAN.safe_zone, DOOR, GATE),
        *(PLAN.obstacles[0], PLAN.stations[0], floorplan.Problem("is missing", "boundary", 1)),
        floorplan.Zone(name="zone", area=PLAN.boundary, max_speed=1.0),
    ],
    "navigation": [
        *(PERSON, MOVE, PERSON.pieces[0], LAW, INTEGRAL, navigation.ApproachLaw(time=0.5)),
        *(navigation.FixedDistance(1.0), navigation.Scaled(LAW, 2.0), navigation.TooClose(LAW)),
        *(navigation.TooClose(LAW) & ~navigation.Approaching(), navigation.Moving()),
        *(
            navigation.Approaching(),
            navigation.Apart(1.0),
            navigation.Overlapping(TORSO, TORSO),
            TORSO,
        ),
        *(navigation.Cylinder.of_arm(GANTRY), navigation.Shapes(machine=(TORSO,))),
        navigation.Prism(footprint=((0.0, 0.0), (1.0, 0.0), (0.0, 1.0)), top=1.0),
        *(navigation.Enclosure(value=1.0), navigation.Disc((0.0, 0.0), 0.3)),
        *(navigation.VehicleLimits(), FIELDS, FIELDS.sets[0], navigation.FieldSupplements()),
    ],
}
"""Values to copy, which are compared by their contents."""

COPIES = {
    "deepcopy": copy.deepcopy,
    "pickle": lambda original: pickle.loads(pickle.dumps(original)),
}


@pytest.mark.parametrize("way", COPIES)
@pytest.mark.parametrize("package", GEOMETRY)
def test_copies_are_equal(package, way):
    navigation.first_time(navigation.TooClose(LAW), PERSON, MOVE, 0.0, 10.0)
    navigation.intrusions(FIELDS, MOVE, PERSON, 0.3, 0.0, 10.0)
    different = [
        type(original).__name__
        for original in SAMPLES[package]
        if type(copied := COPIES[way](original)) is not type(original) or copied != original
    ]
    assert different == []


@pytest.mark.parametrize("way", COPIES)
@pytest.mark.parametrize("law", [LAW, INTEGRAL])
def test_conditions_are_copied_after_use(law, way):
    condition = ~navigation.TooClose(law) & navigation.Moving(reach=1.0)
    navigation.first_time(condition, PERSON, MOVE, 0.0, 10.0)
    copied = COPIES[way](condition)
    assert copied == condition and hash(copied) == hash(condition)
    assert repr(copied) == repr(condition)


def test_every_value_is_copied():
    for package, samples in SAMPLES.items():
        kinds = {type(sample) for sample in samples}
        values = {
            of
            for of in classes_of(package)
            if dataclasses.is_dataclass(of) and of.__dataclass_params__.eq
        }
        assert values - kinds == set()


@pytest.mark.parametrize("way", COPIES)
def test_paths_movers_and_errors_are_copied(way):
    planner = navigation.PathPlanner(WORLD, radius=0.3)
    path = planner.plan((-15.0, -10.0), (-5.0, 3.75))
    copied = COPIES[way](path)
    assert (copied.points.tolist(), copied.clearance) == (path.points.tolist(), path.clearance)
    mover = COPIES[way](navigation.Mover("agv", MOVE, TORSO))
    assert (mover.name, mover.motion, mover.solid) == ("agv", MOVE, TORSO)
    with pytest.raises(navigation.PlanningError) as raised:
        planner.plan((-15.0, -10.0), (99.0, 0.0))
    for error in (raised.value, floorplan.FloorplanError("f", [floorplan.Problem("is missing")])):
        assert type(COPIES[way](error)) is type(error)
        assert str(COPIES[way](error)) == str(error)


@pytest.mark.parametrize("way", COPIES)
def test_worlds_explain_why_they_are_not_copied(way):
    for original in (WORLD, navigation.PathPlanner(WORLD), navigation.GantryPlanner(PLAN)):
        with pytest.raises(TypeError, match="holds FCL's geometry, which can't be copied"):
            COPIES[way](original)


def completions(text):
    """Return the completions of IPython after a text."""
    completer = IPCompleter(namespace={"sim": sim}, use_jedi=False)
    with provisionalcompleter():
        return {one.text for one in completer.completions(text, len(text))}


@pytest.mark.parametrize("package", PACKAGES)
def test_names_of_the_reference_equal_the_loaded_ones(package):
    """Type checkers and the reference use `__all__` of the stub, and Python its imports."""
    module = importlib.import_module(package)
    stub = ast.parse(Path(module.__file__).with_suffix(".pyi").read_text(encoding="utf-8"))
    (listed,) = [node.value for node in stub.body if isinstance(node, ast.Assign)]
    assert sorted(ast.literal_eval(listed)) == sorted(module.__all__)


def test_completion_offers_every_public_name_of_sim():
    assert set(sim.__all__) <= set(dir(sim))
    assert {f".{name}" for name in sim.__all__} <= completions("sim.")
    assert {f".{name}" for name in sim.plots.__all__} <= completions("sim.plots.")


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
    """Object that exists only during a run."""
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


def test_parts_of_a_run_explain_why_they_cannot_be_copied(part_of_a_run):
    message = f"a {type(part_of_a_run).__name__} cannot be copied .* run in progress"
    for copied in (copy.copy, copy.deepcopy, pickle.dumps):
        with pytest.raises(TypeError, match=message):
            copied(part_of_a_run)
