"""Planners of people's paths by the names that a trial gives."""

from __future__ import annotations

import ast
import inspect
from dataclasses import replace
from pathlib import Path
from typing import TypeVar

import ompl.base as ob

from floorplan import UserError, suggestion
from navigation import PlannerChoice, PlannerError

from ..core.own_code import import_own
from ..core.own_parameters import parameters
from ..core.own_source import REFUSED, Kind, OwnCodeError, Source, find_source, is_derived
from ..core.scenario import PersonEntry, Scenario

_Made = TypeVar("_Made", bound=Scenario)


PLANNER = Kind(
    words="planner: a planner is a subclass of ompl.base.Planner",
    written=is_derived,
    made=lambda found: inspect.isclass(found) and issubclass(found, ob.Planner),
)
"""The kind of class that a trial names as its planner."""


def planner_of(entry: PersonEntry, scenario: Scenario) -> PlannerChoice:
    """Return the planner that finds a person's paths: their own, else the trial's."""
    return scenario.planner if entry.planner is None else entry.planner


def with_planner(scenario: _Made, planner: PlannerChoice | str) -> _Made:
    """Return the same scenario in which everybody has this planner."""
    choice = PlannerChoice.of(planner)
    planner_source(choice, scenario.folder, own_code=scenario.own_code)
    people = tuple(replace(person, planner=None) for person in scenario.people)
    return replace(scenario, planner=choice, people=people)


def find_planner(choice: PlannerChoice, folder: Path, *, own_code: bool = True) -> PlannerChoice:
    """Return `choice`, ready to be asked: one of the user's own, in `folder`, is imported.

    Without `own_code` that is refused. `PlannerError` says what is missing.
    """
    source = planner_source(choice, folder, own_code=own_code)
    try:
        found = choice if source is None else replace(choice, kind=import_own(source))
        found.check()
    except OwnCodeError as why:
        raise PlannerError(f"the planner {why}") from why
    except UserError as why:
        raise PlannerError(str(why)) from why
    return found


def planner_source(choice: PlannerChoice, folder: Path, *, own_code: bool = True) -> Source | None:
    """Return the source of a planner of the user's own, which is not imported; None for others.

    `PlannerError` is as of `find_planner`, as far as the source shows what is missing.
    """
    try:
        choice.check()
    except UserError as why:
        raise PlannerError(str(why)) from why
    if not choice.is_own or choice.kind is not None:
        return None
    if not own_code:
        raise PlannerError(f"the planner {choice.name!r}: {REFUSED}")
    try:
        source = find_source(choice.name, folder, PLANNER)
    except OwnCodeError as why:
        raise PlannerError(f"the planner {why}") from why
    assert isinstance(source.definition, ast.ClassDef)
    taken = parameters(source.definition)
    if taken is not None and not taken.any_name:
        # The first is OMPL's space information.
        known = taken.names[1:]
        for name in choice.own_parameters:
            if name not in known:
                hint = f"; {suggestion(name, known)}" if known else ""
                raise PlannerError(f"the planner {choice.name} has no parameter {name!r}{hint}")
    return source
