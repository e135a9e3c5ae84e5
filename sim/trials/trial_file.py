"""Trial files: their keys and values, what can be wrong with them, and how they become trials."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from importlib import resources
from pathlib import Path
from typing import Annotated, Any, TypeVar

from pydantic import Field, Strict, model_validator

import floorplan
from floorplan import Document, Floorplan, Number, Place, Positive, Problem, Strictly, suggestion

from ..core.rules import PAPER
from ..core.scenario import GantryEntry, Job, Scenario, TrialError
from ..machines.gantry.controllers import ControllerError, controller_source
from ..orders import reading
from .agvs_file import AgvKeys, agv_moves, yielding
from .checks import LARGEST_SEED, faults
from .own_names import out_of_reach
from .people_file import PersonKeys, people_of
from .rules_file import RuleKeys, build_rules

_Made = TypeVar("_Made", bound=Scenario)


def builtin_trials() -> tuple[str, ...]:
    """The names of the trials that come with Floorwalker, sorted."""
    files = resources.files("sim").joinpath("data", "trials").iterdir()
    return tuple(sorted(Path(f.name).stem for f in files if f.name.endswith(".yaml")))


def load(form: type[_Made], source: str | Path, own_code: bool) -> _Made:
    """See `Trial.load`."""
    text = str(source)
    if text in builtin_trials():
        data = resources.files("sim").joinpath("data", "trials", f"{text}.yaml")
        return parse(form, data.read_text(encoding="utf-8"), text, Path(), own_code)
    path = Path(source)
    if not path.suffix and not floorplan.is_there(path):
        message = f"no such file, nor a built-in trial; {suggestion(text, builtin_trials())}"
        raise TrialError(text, [Problem(message)])
    return build(form, floorplan.read_yaml(path, TrialError), path.parent, own_code)


def parse(form: type[_Made], text: str, file: str, folder: Path, own_code: bool) -> _Made:
    """See `Trial.parse`."""
    return build(form, floorplan.parse_yaml(text, file, TrialError), folder, own_code)


class _Job(Strictly):
    move: tuple[Number, Number, Number] | None = None
    wait: Positive | None = None
    pick: str | None = None
    place: str | None = None
    part: str = "part"
    submit: str | None = None

    @model_validator(mode="after")
    def _one_kind(self) -> _Job:
        given = self.model_fields_set - {"part"}
        if given not in ({"move"}, {"wait"}, {"pick", "place"}, {"submit"}):
            raise ValueError("a job is one of move, wait, pick with place, or submit")
        return self

    def job(self) -> Job:
        if self.move is not None:
            return Job("move", target=self.move)
        if self.wait is not None:
            return Job("wait", seconds=self.wait)
        if self.submit is not None:
            return Job("submit", order=self.submit)
        return Job("pick_place", pick=self.pick or "", place=self.place or "", part=self.part)


class _Gantry(Strictly):
    controller: str = "parked"
    at: tuple[Number, Number, Number] | None = None
    jobs: list[_Job] = []
    repeat: Annotated[bool, Strict()] = False


class _Trial(Strictly):
    name: str | None = None
    floorplan: str
    folder: str = "."
    duration: Positive = 275.0
    seed: Annotated[int, Strict(), Field(ge=0, le=LARGEST_SEED)] = 0
    rules: RuleKeys = RuleKeys.model_validate(PAPER.name)
    people: list[PersonKeys] = []
    gantry: _Gantry = _Gantry()
    agvs: dict[str, AgvKeys] = {}
    ariac: str | None = None
    until_submitted: Annotated[bool, Strict()] | None = None
    expect: dict[str, Any] = {}


def build(form: type[_Made], document: Document, folder: Path, own_code: bool) -> _Made:
    """The trial in `document`, which stands in `folder`. Errors as of `Trial.load`."""
    if reading.is_ariac(document):
        return replace(reading.build(form, document, folder), own_code=own_code)
    schema = document.checked(_Trial, TrialError)
    home, folder = folder, folder / schema.folder
    plan = _floorplan(schema.floorplan, folder, document)
    rules, rule_problems = build_rules(schema.rules, document, folder, "rules", own_code=own_code)
    trial = form(
        floorplan=plan,
        name=Path(document.file).name.split(".")[0] if schema.name is None else schema.name,
        duration=schema.duration,
        seed=schema.seed,
        rules=rules,
        people=people_of(schema.people, folder),
        gantry=GantryEntry(
            schema.gantry.controller,
            schema.gantry.at,
            tuple(job.job() for job in schema.gantry.jobs),
            schema.gantry.repeat,
        ),
        agvs={name: agv_moves(keys) for name, keys in schema.agvs.items()},
        yielding=yielding(schema.agvs),
        expect=schema.expect,
        folder=folder,
        floorplan_source=schema.floorplan,
        until_submitted=bool(schema.until_submitted),
        own_code=own_code,
    )
    if schema.ariac is not None:
        trial = _with_orders(trial, schema, schema.ariac, document)
    problems = [*rule_problems, *_problems(trial, schema, document)]
    if fault := out_of_reach(trial, home):
        problems.append(document.problem(fault, "folder"))
    if problems:
        raise TrialError(document.file, problems)
    return trial


def _with_orders(trial: _Made, schema: _Trial, name: str, document: Document) -> _Made:
    """The trial with the orders, parts and challenges of an ARIAC trial file."""
    path = trial.folder / name
    if not floorplan.is_there(path):
        raise TrialError(document.file, [document.problem(f"no such file: {name!r}", "ariac")])
    orders = floorplan.read_yaml(path, TrialError)
    workload, notices = reading.read_workload(orders, trial.floorplan)
    given = schema.model_fields_set
    until_submitted = schema.until_submitted
    return replace(
        trial,
        workload=replace(workload, source=name),
        notices=notices,
        people=trial.people if "people" in given else reading.people_of(workload),
        duration=trial.duration if "duration" in given else reading.duration_of(workload),
        until_submitted="duration" not in given if until_submitted is None else until_submitted,
    )


def _floorplan(name: str, folder: Path, document: Document) -> Floorplan:
    if name in floorplan.builtin():
        return floorplan.load(name)
    path = folder / name
    if not floorplan.is_there(path):
        message = (
            f"no such file, nor a built-in floorplan: {name!r};"
            f" {suggestion(name, floorplan.builtin())}"
        )
        raise TrialError(document.file, [document.problem(message, "floorplan")])
    return floorplan.load(path)


def _problems(trial: Scenario, schema: _Trial, document: Document) -> Iterator[Problem]:
    """What keys and types can't tell: whether the things a trial names are there."""
    for message, place in faults(trial):
        yield document.problem(message, *_in_file(place, schema))
    if trial.floorplan.gantry is not None:
        try:
            controller_source(trial.gantry.controller, trial.folder, own_code=trial.own_code)
        except ControllerError as why:
            yield document.problem(str(why), "gantry", "controller")


def _in_file(place: Place, schema: _Trial) -> Place:
    """Where something stands in the file: the moves of an AGV may have a key of their own."""
    match place:
        case ("agvs", name, int(k), key) if not isinstance(schema.agvs[str(name)], list):
            return ("agvs", name, "moves", k, key)
    return place
