"""Documents: their examples run, and their links lead somewhere."""

import dataclasses
import importlib
import inspect
import pkgutil
import re
import sys
from dataclasses import replace
from pathlib import Path

import pytest
import yaml

import bdi
import floorplan
import sim
from floorplan.building import FloorplanSchema
from floorplan.files.forms import fields_of, form_keys, forms
from sim.studies.design import _StudyKeys as StudyKeys
from sim.trials import feasibility
from sim.trials.keys import TrialKeys
from sim.trials.rules_file import RuleForm

ROOT = Path(__file__).resolve().parents[1]
DOCUMENTS = [ROOT / "README.md", *sorted((ROOT / "docs").glob("*.md"))]
BLOCK = re.compile(r"(?P<before>[^\n]*\n(?:[^\n]*\n)?)\n?```(?P<kind>\w+)\n(?P<text>.*?)```", re.S)
NEEDS_PYTHON = {"pedpy": (3, 11)}
"""Imports of examples that cannot be installed with every Python."""
SHOWN = ("yaml", "python", "agentspeak", "asl")
"""Kinds of blocks that may be files."""
DOTTED = re.compile(r"(?<![\w./-])(?:sim|bdi|floorplan|navigation)(?:\.[A-Za-z_]\w*)+")
NAMED = re.compile(r"`([\w.]+\.(?:yaml|asl|py|wkt|jsonl))`")


def blocks(document, kind):
    """Return the blocks of one kind, each with the file name in the lines before it, if any."""
    for block in BLOCK.finditer(document.read_text(encoding="utf-8")):
        if block["kind"] == kind:
            names = NAMED.findall(block["before"])
            yield (names[-1] if names else None), block["text"]


def showing(*kinds):
    """Return the documents that have blocks of some kinds."""
    return [page for page in DOCUMENTS if any(list(blocks(page, kind)) for kind in kinds)]


def test_names_in_the_text_are_there():
    gone = []
    for document in DOCUMENTS:
        for code in re.findall(r"`([^`\n]+)`", document.read_text(encoding="utf-8")):
            for name in DOTTED.findall(code):
                try:
                    pkgutil.resolve_name(name)
                except (ImportError, AttributeError):
                    gone.append(f"{document.name}: {name}")
    assert gone == []


def test_tables_match_the_code(monkeypatch):
    """`python docs/make_tables.py` writes them."""
    monkeypatch.syspath_prepend(ROOT / "docs")
    tables = importlib.import_module("make_tables")
    texts = {document.name: document.read_text(encoding="utf-8") for document in DOCUMENTS}
    assert [name for name, text in texts.items() if tables.with_tables(text) != text] == []


@pytest.mark.parametrize("document", showing("python"), ids=lambda path: path.name)
def test_python_examples_run(document, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    for kind in ("yaml", "agentspeak", "asl", "prolog"):
        for name, text in blocks(document, kind):
            if name:
                (tmp_path / name).write_text(text, encoding="utf-8")
    namespace = {}
    for _, text in blocks(document, "python"):
        try:
            exec(compile(text, f"{document.name}", "exec"), namespace)
        except ModuleNotFoundError as missing:
            if sys.version_info >= NEEDS_PYTHON.get(missing.name, (3, 0)):
                raise
            pytest.skip(f"{missing.name} can't be installed with this Python")


@pytest.mark.parametrize("document", showing(*SHOWN), ids=lambda path: path.name)
def test_shown_files_load(document, tmp_path):
    saved = []
    for kind in SHOWN:
        for name, text in blocks(document, kind):
            if name and name.endswith(("yaml", "py", "asl")):
                (tmp_path / name).write_text(text, encoding="utf-8")
                saved.append(tmp_path / name)
    for path in saved:
        if path.name.endswith(".trial.yaml"):
            sim.Trial.load(path)
        elif path.suffix == ".yaml" and "boundary" in path.read_text(encoding="utf-8"):
            floorplan.load(path)
        elif path.suffix == ".yaml" and "based_on" in path.read_text(encoding="utf-8"):
            sim.load_rules(path)
        elif path.suffix == ".asl":
            bdi.parse_file(path)


CONTROLLERS_SHOWN = {
    found[1]: text
    for page in ("write-a-controller.md", "tutorial.md")
    for _, text in blocks(ROOT / "docs" / page, "python")
    for found in [re.search(r"def (\w+)\(gantry\)", text)]
    if found
}


@pytest.mark.parametrize("people", [2, 5])
@pytest.mark.parametrize("name", CONTROLLERS_SHOWN)
def test_shown_controllers_work_beside_people(name, people):
    """Run them unchanged, beside any number of people and with any interruptions."""
    exec(compile(CONTROLLERS_SHOWN[name], name, "exec"), namespace := {})
    minds = ["antagonistic", "curious", "indifferent", "helpful", "scared"][:people]
    trial = sim.Trial.parse(
        f"""
floorplan: ariac2023
duration: 120.0
people: [{", ".join(f"{{name: {p}, personality: {p}}}" for p in minds)}]
gantry: {{jobs: [{{move: [-2.3, 3.0, 0.0]}}, {{pick: bin6, place: agv4}}]}}
"""
    )
    rate = None if inspect.isgeneratorfunction(namespace[name]) else 5.0
    gantry = replace(trial.gantry, controller=namespace[name], rate=rate)
    simulation = sim.Simulation(replace(trial, gantry=gantry))
    for t in range(8, 120, 13):
        simulation.clock.call_at(t, lambda: simulation.gantry.interrupt("person_close"))
        simulation.clock.call_at(t + 0.01, lambda: simulation.gantry.interrupt("person_close"))
    simulation.advance(120.0)
    motion = simulation.finish().motions["gantry"]
    assert motion.position(0.0) == pytest.approx((-7.0, 0.0))
    assert abs(motion.position(range(120))[:, 0] - -7.0).max() > 1.0


def keys(model, above=()):
    """Return the keys of a part of a file, and of the parts in it that are not `above`."""
    for name, annotation in form_keys(model):
        yield name
        for part in forms(annotation):
            if part not in above:
                yield from keys(part, (*above, part))


REFERENCE = {
    FloorplanSchema: ("floorplan-formats.md",),
    TrialKeys: (
        "trials.md",
        "work.md",
        "recorded-people.md",
        "changes.md",
        "people-among-people.md",
        "rules.md",
        "floorplan-formats.md",
        "protective-fields.md",
    ),
    RuleForm: ("rules.md",),
    StudyKeys: ("studies.md", "search.md"),
}
WRITTEN_ONLY = {RuleForm: {"source"}, StudyKeys: {"word"}, TrialKeys: {"stream", "number"}}
"""Keys that replace a text, or that only `to_yaml` writes."""


@pytest.mark.parametrize("model", REFERENCE, ids=lambda model: model.__name__)
def test_the_reference_has_every_key(model):
    text = "".join((ROOT / "docs" / page).read_text(encoding="utf-8") for page in REFERENCE[model])
    names = {*keys(model)} - WRITTEN_ONLY.get(model, set())
    mention = r"`([\w.]+\.)?{0}[`:]|\b{0}:|(?m:^#+ .*\b{0}\b)"
    missing = {name for name in names if not re.search(mention.format(name), text)}
    assert missing == set()


def required(form):
    """Return the keys of a form that have no default."""
    if not dataclasses.is_dataclass(form):
        return [name for name, info in form.model_fields.items() if info.is_required()]
    needed = [key for key in fields_of(form) if key.default is dataclasses.MISSING]
    inner = {key.composed.form for key in needed if key.composed}
    names = [key.name for key in needed if not key.composed]
    return [*names, *(name for part in inner for name in required(part))]


def test_the_reference_marks_the_required_keys_of_machines():
    text = (ROOT / "docs" / "floorplan-formats.md").read_text(encoding="utf-8")
    rows = [row for row in text.splitlines() if "| required" in row]
    for key in ("agvs", "gantry"):
        (part,) = forms(dict(form_keys(FloorplanSchema))[key])
        needed = {f"{key}.{name}" for name in required(part)}
        mentioned = {name for row in rows for name in re.findall(rf"`({key}\.\w+)[`.]", row)}
        assert mentioned == needed


def test_links_lead_somewhere():
    links = [
        (document, link)
        for document in DOCUMENTS
        for link in re.findall(r"\]\(([^)#\s]+)(?:#[^)]*)?\)", document.read_text(encoding="utf-8"))
        if not link.startswith("http")
    ]
    lost = [(page.name, link) for page, link in links if not (page.parent / link).exists()]
    assert lost == []


def test_every_study_in_the_examples_can_be_run():
    studies = sorted((ROOT / "examples").glob("*.study.yaml"))
    assert studies
    for study in studies:
        assert sim.run(sim.Study.load(study).row(0).trial).duration > 0


LONG = ("traffic.trial.yaml", "vehicles.trial.yaml")
"""Examples that take seconds, because several vehicles plan paths around each other."""


@pytest.mark.parametrize(
    "name",
    [
        pytest.param(path.name, marks=pytest.mark.slow if path.name in LONG else ())
        for path in sorted((ROOT / "examples").glob("*.trial.yaml"))
    ],
)
def test_every_example_in_the_folder_runs(name, capsys):
    assert sim.run(sim.Trial.load(ROOT / "examples" / name)).unmet == []


def pages(entries):
    """Return the files that a navigation leads to."""
    for entry in entries:
        if isinstance(entry, str):
            yield entry
        else:
            for inner in entry.values():
                yield from pages([inner] if isinstance(inner, str) else inner)


def test_the_navigation_lists_every_page_once():
    site = yaml.safe_load((ROOT / "mkdocs.yml").read_text(encoding="utf-8"))
    listed = list(pages(site["nav"]))
    there = {page.name for page in (ROOT / "docs").glob("*.md")}
    assert there - set(listed) == set(), "list it under nav in mkdocs.yml"
    assert sorted(listed) == sorted(there)


def test_the_page_on_trial_files_has_the_budget():
    page = (ROOT / "docs" / "trials.md").read_text(encoding="utf-8")
    (section,) = [part for part in page.split("\n## ") if part.startswith("Limits\n")]
    for most in (
        feasibility.LONGEST,
        feasibility.MOST_PEOPLE,
        feasibility.MOST_PERSON_SECONDS,
        feasibility.MOST_TASKS,
        feasibility.MOST_JOBS,
        feasibility.MOST_MOVES,
        feasibility.MOST_REPORTS,
    ):
        assert f" {most:,} " in section
