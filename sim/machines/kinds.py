"""The kinds of machines, and the machines of a floor and of a trial, of whatever kind."""

from __future__ import annotations

import ast
import inspect
from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import fields, is_dataclass
from pathlib import Path

from pydantic import ValidationError

from floorplan import (
    Fault,
    Floorplan,
    Gantry,
    Place,
    UserError,
    field_name,
    misfits,
    shown,
    suggestion,
)

from ..core.machine import Category, Machine, MachineShape
from ..core.machine_model import MachineEntry, MachineModel
from ..core.own_code import import_own
from ..core.own_source import REFUSED, Kind, OwnCodeError, Source, find_source, is_derived
from ..core.scenario import AgvMove, GantryEntry, Scenario
from ..core.stage import Stage
from .agv.model import AgvModel
from .gantry.model import GantryModel
from .gantry.robot import GANTRY

KINDS: dict[str, type[MachineModel]] = {"gantry": GantryModel, "agv": AgvModel}
"""The kinds of machines by name. A package adds its own by `KINDS["tugger"] = TuggerModel`."""


class MachineError(UserError):
    """A machine of a trial that can't be found, or whose keys are wrong."""


def _is_model(found: object) -> bool:
    if not inspect.isclass(found) or not issubclass(found, MachineModel):
        return False
    return is_dataclass(found) and not inspect.isabstract(found)


MODEL = Kind(
    words="machine: a machine is a dataclass derived from sim.MachineModel",
    written=is_derived,
    made=_is_model,
)
"""The kind of class that a trial names as the kind of a machine."""


def models_of(scenario: Scenario, *, own: bool = True) -> dict[str, MachineModel]:
    """Return the machines of a trial by name: the floor's gantry and AGVs, then its `machines`.

    Those of the user's `own` kinds are left out if code of theirs is not to be run.
    `MachineError` if there is something wrong with one of the latter.
    """
    models = on_floor(scenario)
    for name, entry in scenario.machines.items():
        if is_own(entry) and not own:
            continue
        kind = _kind(name, entry, scenario)
        try:
            models[name] = kind.read(name, entry.keys)
            faults = [*models[name].faults(scenario.floorplan, _vehicles(scenario))]
        except ValidationError as why:
            faults = misfits(why, kind.key_schema or kind, entry.keys)
        if faults:
            listed = "; ".join(f"{field_name(place)}: {message}" for message, place in faults)
            raise MachineError(f"the machine {name!r}: {listed}")
    return models


def made_by(model: MachineModel, name: str, stage: Stage) -> Machine:
    """Return the machine `name` of a model; `MachineError` if that makes something else."""
    made = model.make(name, stage)
    if not isinstance(made, Machine):
        raise MachineError(f"the machine {name!r}: make returned {shown(made)}, not a sim.Machine")

    def refuse_jump() -> None:
        raise MachineError(
            f"the machine {name!r} jumps at t = {stage.clock.now:g} s: a motion that it follows"
            " must begin then, where the machine is"
        )

    def refuse_haste() -> None:
        t = made.shape.too_fast(made.body.motion, stage.clock.now)
        if t is not None:
            raise MachineError(
                f"the machine {name!r} is faster at t = {t:g} s than the top speed of its shape,"
                f" {made.shape.top_speed:g} m/s, on which laws and stops rely"
            )

    made.body.on_jump.append(refuse_jump)
    if type(model) not in (GantryModel, AgvModel):
        made.body.on_change.append(refuse_haste)
    return made


def on_floor(scenario: Scenario) -> dict[str, MachineModel]:
    """Return the machines of a trial's floor, with their moves and jobs in the trial, by name."""
    return _on(scenario.floorplan, scenario.gantry, scenario.agvs, scenario.yielding)


def machines_on(plan: Floorplan) -> tuple[MachineShape, ...]:
    """Return the machines that a floor itself has, as others see them."""
    models = _on(plan, GantryEntry(), {}, frozenset())
    return tuple(model.shape(name, plan) for name, model in models.items())


def rails_under(machine: str, plan: Floorplan) -> Gantry | None:
    """Return the rails of the floor, if `machine` is the name of the gantry that runs on them."""
    return plan.gantry if machine == GANTRY else None


def is_own(entry: MachineEntry) -> bool:
    """Return True if the kind of a machine is code that stands beside the trial."""
    return isinstance(entry.kind, str) and entry.kind not in KINDS


def keys_of(entry: MachineEntry, scenario: Scenario) -> list[str] | None:
    """Return the keys that a machine of this kind may have; None where only a run can tell.

    The source of a kind of the user's own is read, not run. `MachineError` if there is none.
    """
    if is_own(entry):
        definition = own_kind(entry, scenario.folder, own_code=scenario.own_code).definition
        assert isinstance(definition, ast.ClassDef)
        if [ast.unparse(base).rpartition(".")[2] for base in definition.bases] != ["MachineModel"]:
            return None
        written = [node.target for node in definition.body if isinstance(node, ast.AnnAssign)]
        return [target.id for target in written if isinstance(target, ast.Name)]
    kind = entry.kind if isinstance(entry.kind, type) else KINDS[entry.kind]
    if kind.key_schema is None:
        return [field.name for field in fields(kind)]  # type: ignore[arg-type]
    return [field.alias or name for name, field in kind.key_schema.model_fields.items()]


def may_be(category: Category, entry: MachineEntry) -> bool:
    """Return True if a machine may be of a category; no code of the user's own is run for that."""
    kind = entry.kind if isinstance(entry.kind, type) else KINDS.get(entry.kind)
    return kind is None or kind.category == category


def kind_name(entry: MachineEntry) -> str:
    """Return the name of a machine's kind: of one's own, that of its class in small letters."""
    kind = entry.kind if isinstance(entry.kind, str) else entry.kind.__name__
    return kind.rpartition(":")[2].lower()


def machine_faults(scenario: Scenario) -> Iterator[Fault]:
    """Yield the faults of a trial's `machines`; code of the user's own is not run."""
    plan = scenario.floorplan
    taken = {GANTRY, *(lane.name for lane in plan.lanes)}
    vehicles = _vehicles(scenario)
    for name, entry in scenario.machines.items():
        if name in taken:
            yield f"another machine is called {name!r} already", (name,)
        try:
            if is_own(entry):
                own_kind(entry, scenario.folder, own_code=scenario.own_code)
                continue
            kind = _kind(name, entry, scenario)
            model = kind.read(name, entry.keys)
        except MachineError as why:
            yield str(why), (name, "kind")
        except ValidationError as why:
            for message, place in misfits(why, kind.key_schema or kind, entry.keys):
                yield message, (name, *place)
        else:
            for message, place in model.faults(plan, vehicles):
                yield message, (name, *place)


def moves_of(scenario: Scenario) -> Iterator[tuple[Place, Sequence[AgvMove]]]:
    """Yield the moves of each AGV as they are given, and its place in the trial.

    Machines that can't be are left out.
    """
    for name, moves in scenario.agvs.items():
        yield ("agvs", name), moves
    for name, entry in scenario.machines.items():
        if not is_own(entry):
            with suppress(MachineError, ValidationError):
                model = _kind(name, entry, scenario).read(name, entry.keys)
                if isinstance(model, AgvModel):
                    yield ("machines", name), model.moves


def own_kind(entry: MachineEntry, folder: Path, *, own_code: bool = True) -> Source:
    """Return the source of a machine's own kind, which is not imported; `MachineError` if none."""
    kind = str(entry.kind)
    if ":" not in kind:
        raise MachineError(
            f"no kind of machine is called {kind!r}; {suggestion(kind, KINDS)};"
            " your own is package.module:Class"
        )
    if not own_code:
        raise MachineError(f"{kind!r}: {REFUSED}")
    try:
        return find_source(kind, folder, MODEL)
    except OwnCodeError as why:
        raise MachineError(str(why)) from why


def _vehicles(scenario: Scenario) -> set[str]:
    return {*scenario.machines, *(lane.name for lane in scenario.floorplan.lanes)}


def _kind(name: str, entry: MachineEntry, scenario: Scenario) -> type[MachineModel]:
    if not isinstance(entry.kind, str):
        return entry.kind
    if entry.kind in KINDS:
        return KINDS[entry.kind]
    try:
        source = own_kind(entry, scenario.folder, own_code=scenario.own_code)
        found: type[MachineModel] = import_own(source)
    except (MachineError, OwnCodeError) as why:
        raise MachineError(f"the machine {name!r}: {why}") from why
    return found


def _on(
    plan: Floorplan,
    gantry: GantryEntry,
    moves: Mapping[str, tuple[AgvMove, ...]],
    yielding: frozenset[str],
) -> dict[str, MachineModel]:
    models: dict[str, MachineModel] = {} if plan.gantry is None else {GANTRY: GantryModel(gantry)}
    for lane in plan.lanes:
        models[lane.name] = AgvModel(lane, moves.get(lane.name, ()), lane.name in yielding)
    return models
