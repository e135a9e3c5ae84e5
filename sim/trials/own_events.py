"""Kinds of events that a trial's own controllers and machines define, as their source shows."""

from __future__ import annotations

import ast
from collections.abc import Collection, Iterator

from ..core.events import EVENT_KINDS, EventKind, kind_of
from ..core.own_source import OwnCodeError, Source, definitions_in
from ..core.scenario import Scenario
from ..machines.gantry.controllers import ControllerError, controller_source
from ..machines.kinds import MachineError, is_own, own_kind


def event_kinds(trial: Scenario, wanted: str) -> Collection[str]:
    """Return the names of all kinds of events that `wanted` may be one of.

    The source of own code is looked at only where it is none that is defined already: what it
    defines is a kind once it has been imported, for the run.
    """
    return EVENT_KINDS if wanted in EVENT_KINDS else [*EVENT_KINDS, *own_event_kinds(trial)]


def own_event_kinds(trial: Scenario) -> list[str]:
    """Return the kinds of events that are defined in the files of own controllers and machines."""
    found = []
    for source in _sources(trial):
        try:
            definitions = definitions_in(source.name, source.file).values()
        except OwnCodeError:
            continue
        found += [kind_of(one.name) for one in definitions if _is_event(one)]
    return list(dict.fromkeys(found))


def _sources(trial: Scenario) -> Iterator[Source]:
    """Yield the files; what can't be found is a fault that is reported elsewhere."""
    added = trial.machines.values()
    controllers = [trial.gantry.controller, *(one.keys.get("controller", "") for one in added)]
    for controller in controllers:
        if isinstance(controller, str) and ":" in controller:
            try:
                source = controller_source(controller, trial.folder, own_code=trial.own_code)
            except ControllerError:
                continue
            if source is not None:
                yield source
    for entry in filter(is_own, added):
        try:
            yield own_kind(entry, trial.folder, own_code=trial.own_code)
        except MachineError:
            continue


def _is_event(definition: ast.AST) -> bool:
    """Return True for a class derived from `EventKind`, or `sim.EventKind`, itself."""
    bases = definition.bases if isinstance(definition, ast.ClassDef) else []
    return any(ast.unparse(base).rpartition(".")[2] == EventKind.__name__ for base in bases)
