"""Kinds of machines: registry, machines of a floor and a trial, and the audit of their laws."""

from __future__ import annotations

import inspect
import math
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, is_dataclass, replace
from typing import Any, TypeVar

from pydantic import ValidationError
from shapely.geometry import Polygon

from floorplan import Floorplan, Gantry, UserError
from floorplan.files.problems import Fault, Place, field_name, form_keys, misfits, shown
from navigation import ApproachLaw, IntegralLaw, SeparationLaw
from navigation.separation import required_at_speeds

from ..core.body import Category, Machine, MachineShape
from ..core.custom_code import CodeFolder, CustomCode, Kind, importing
from ..core.scenario import AgvMove, GantryEntry, Scenario
from ..core.stage import MachineEntry, MachineModel, Stage
from ..safety.laws import OwnLaw
from .agv.model import AgvModel
from .amr.controllers import VEHICLE_CONTROLLERS
from .amr.model import AmrModel, overlaps
from .gantry.controllers import controller_source
from .gantry.model import GantryModel
from .gantry.robot import GANTRY

KINDS: dict[str, type[MachineModel]] = {"gantry": GantryModel, "agv": AgvModel, "amr": AmrModel}
"""The kinds of machines by name. A package adds its own by `KINDS["tugger"] = TuggerModel`."""


_Scenario = TypeVar("_Scenario", bound=Scenario)


class MachineError(UserError):
    """A machine of a trial that can't be found, or whose keys are wrong."""


def _is_model(found: object) -> bool:
    if not inspect.isclass(found) or not issubclass(found, MachineModel):
        return False
    return is_dataclass(found) and not inspect.isabstract(found)


MODEL = Kind(
    noun="kind of machine",
    words="machine: a machine is a dataclass derived from sim.MachineModel",
    accepts=_is_model,
    error=MachineError,
    builtin=KINDS,
)
"""The kind of class that a trial names as the kind of a machine."""


@importing()
def models_of(scenario: Scenario, *, own: bool = True) -> dict[str, MachineModel]:
    """Return the machines of a trial by name: the floor's gantry and AGVs, then its `machines`.

    Those of the user's `own` kinds are left out if code of theirs is not to be run.
    `MachineError` if there is something wrong with one of the latter. Whether built-in kinds fit
    the floor is checked with the trial (`machine_faults`).
    """
    models = on_floor(scenario)
    for name, entry in scenario.machines.items():
        if is_own(entry) and not own:
            continue
        kind = _kind(name, entry, scenario)
        try:
            models[name] = kind.read(name, entry.keys)
            faults: list[Fault] = []
            if is_own(entry):
                plan = scenario.floorplan
                faults += models[name].faults(plan, _vehicles(scenario))
                faults += models[name].place_faults(name, plan)
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
    if type(model) not in (GantryModel, AgvModel, AmrModel):
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

    `MachineError` if there is no such kind.
    """
    if is_own(entry):
        own_kind(entry, scenario.code_folder)
        return None
    kind = entry.kind if isinstance(entry.kind, type) else KINDS[entry.kind]
    return [name for name, _ in form_keys(kind.key_schema or kind)]


def with_controller(
    scenario: _Scenario, controller: str | Callable[[Any], Any], machine: str = ""
) -> _Scenario:
    """Return the scenario with this controller of one machine, or of each gantry and vehicle.

    Built-in controllers and generators have no `rate`. `MachineError` if there is no such machine,
    and `ControllerError` if there is no such controller.
    """
    machines = {}
    for name, entry in scenario.machines.items():
        names = keys_of(entry, scenario) or (["controller"] if name == machine else [])
        if machine in ("", name) and "controller" in names:
            keys = {**entry.keys, "controller": controller}
            if controller in VEHICLE_CONTROLLERS or inspect.isgeneratorfunction(controller):
                keys.pop("rate", None)
            machines[name] = replace(entry, keys=keys)
    changed = replace(scenario, machines=scenario.machines | machines)
    if machine in ("", GANTRY) and (scenario.floorplan.gantry is not None or not machines):
        controller_source(controller, scenario.code_folder)
        return replace(changed, gantry=replace(scenario.gantry, controller=controller))
    if not machines:
        raise MachineError(f"no machine with a controller is called {machine!r}")
    return changed


def may_be(category: Category, entry: MachineEntry) -> bool:
    """Return True if a machine may be of a category; no code of the user's own is run for that."""
    kind = entry.kind if isinstance(entry.kind, type) else KINDS.get(entry.kind)
    return kind is None or kind.category == category


def kind_name(entry: MachineEntry) -> str:
    """Return the name of a machine's kind: of one's own, that of its class in small letters."""
    kind = entry.kind if isinstance(entry.kind, str) else entry.kind.__name__
    return kind.rpartition(":")[2].lower()


def kind_of(name: str, scenario: Scenario) -> str:
    """Return the name of the kind of a machine of a trial, as of `kind_name`."""
    entry = scenario.machines.get(name, MachineEntry("gantry" if name == GANTRY else "agv"))
    known = [kind for kind, model in KINDS.items() if entry.kind in (kind, model)]
    return known[0] if known else kind_name(entry)


def machine_faults(scenario: Scenario) -> Iterator[Fault]:
    """Yield the faults of a trial's `machines`; code of the user's own is not run."""
    plan = scenario.floorplan
    taken = {GANTRY, *(lane.name for lane in plan.lanes)}
    vehicles = _vehicles(scenario)
    stand: dict[str, Polygon] = {}
    for name, entry in scenario.machines.items():
        if name in taken:
            yield f"another machine is called {name!r} already", (name,)
        try:
            if is_own(entry):
                own_kind(entry, scenario.code_folder)
                continue
            kind = _kind(name, entry, scenario)
            model = kind.read(name, entry.keys)
        except MachineError as why:
            yield str(why), (name, "kind")
        except ValidationError as why:
            for message, place in misfits(why, kind.key_schema or kind, entry.keys):
                yield message, (name, *place)
        else:
            yield from (
                (message, (name, *place)) for message, place in model.faults(plan, vehicles)
            )
            found = (*model.place_faults(name, plan), *model.code_faults(scenario.code_folder))
            yield from ((message, (name, *place)) for message, place in found)
            if (area := model.stands_at_start(name, plan)) is not None:
                stand[name] = area
    lanes = {lane.name: lane.footprint(lane.locations[lane.start]) for lane in plan.lanes}
    for one, other in overlaps({**lanes, **stand}.items()):
        if isinstance(stand.get(other), Polygon):
            yield f"starts where {one} stands", (other,)


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


def own_kind(entry: MachineEntry, folder: CodeFolder) -> CustomCode:
    """Return the source of a machine's own kind, which is not imported; `MachineError` if none."""
    return folder.find(str(entry.kind), MODEL)


def _vehicles(scenario: Scenario) -> set[str]:
    return {*scenario.machines, *(lane.name for lane in scenario.floorplan.lanes)}


def _kind(name: str, entry: MachineEntry, scenario: Scenario) -> type[MachineModel]:
    if not isinstance(entry.kind, str):
        return entry.kind
    if entry.kind in KINDS:
        return KINDS[entry.kind]
    try:
        source = own_kind(entry, scenario.code_folder)
        found: type[MachineModel] = source.load()
    except MachineError as why:
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


FAR = 2.0
"""Sizes of a floor. A law that asks for more was probably meant in other units."""

_ROUNDING = 1e-9
"""Seconds or metres. A law that is short by less is not short."""


@dataclass(frozen=True, kw_only=True)
class ShortLaw:
    """A law that states a shorter stop than its machine may take, in seconds and metres.

    `law` is its key in the rule set; `stopping` is None where the law computes it from `t2`. Of
    ISO 13855, `t2` is its time.
    """

    machine: str
    law: str
    t2: float
    needed_t2: float
    stopping: float | None
    needed_stopping: float


@dataclass(frozen=True, kw_only=True)
class ShortDistance:
    """A law that requires less than a machine and a walking person cover while the machine stops.

    Distances are in metres, at the top speeds of both.
    """

    machine: str
    law: str
    distance: float
    needed_distance: float


def short_laws(trial: Scenario, *, own_laws: bool = False) -> tuple[ShortLaw | ShortDistance, ...]:
    """Return the machines of `trial` for which the law states too short a stop.

    Laws that state no stop are not judged of machines with protective fields, which stop these.
    Custom laws are judged only with `own_laws`, because their code is run.
    """
    plan, rules = trial.floorplan, trial.rules
    found: list[ShortLaw | ShortDistance] = []
    for name, model in models_of(trial, own=False).items():
        shape = model.shape(name, plan)
        key, law = rules.law_and_key_of(shape)
        if (stop := model.longest_stop(plan)) is None:
            continue
        time, distance = stop
        if isinstance(law, SeparationLaw | IntegralLaw | ApproachLaw):
            t2 = law.time if isinstance(law, ApproachLaw) else law.t2
            stopping = None if isinstance(law, ApproachLaw) else law.stopping
            if time > t2 + _ROUNDING or (stopping is not None and distance > stopping + _ROUNDING):
                found.append(
                    ShortLaw(
                        machine=name,
                        law=key,
                        t2=t2,
                        needed_t2=time,
                        stopping=stopping,
                        needed_stopping=distance,
                    )
                )
        elif name not in trial.fields and (own_laws or not isinstance(law, OwnLaw)):
            walking = plan.human.max_speed
            stated = required_at_speeds(law, walking, shape.top_speed)
            needed = walking * time + distance
            if needed > stated + _ROUNDING:
                found.append(
                    ShortDistance(machine=name, law=key, distance=stated, needed_distance=needed)
                )
    return tuple(found)


def far_laws(trial: Scenario) -> dict[str, float]:
    """Return the laws that ask for more room than there is, by their keys, and how much (metres).

    That is more than `FAR` times the diagonal of the floor, of somebody at the usual top speed
    near a machine that stands. Laws of one's own are not asked.
    """
    plan, rules = trial.floorplan, trial.rules
    west, south, east, north = plan.boundary.bounds
    room = FAR * math.hypot(east - west, north - south)
    laws = dict(
        rules.law_and_key_of(model.shape(name, plan))
        for name, model in models_of(trial, own=False).items()
    )
    asked = {
        key: required_at_speeds(law, plan.human.max_speed, 0.0)
        for key, law in laws.items()
        if not isinstance(law, OwnLaw)
    }
    return {key: metres for key, metres in asked.items() if metres > room}


def in_words(found: Iterable[ShortLaw | ShortDistance]) -> str:
    """Return the stops that the laws state and those the machines need, rounded up to 0.01."""
    machines: dict[str, list[str]] = {}
    for short in found:
        if isinstance(short, ShortDistance):
            stated, needed = f"{short.distance:g} m", f"{_rounded_up(short.needed_distance):g} m"
        else:
            stated = _stop(short.t2, short.stopping)
            needed = _stop(_rounded_up(short.needed_t2), _rounded_up(short.needed_stopping))
        machines.setdefault(f"{stated} (up to {needed} needed)", []).append(short.machine)
    return "; ".join(f"{', '.join(names)} {figures}" for figures, names in machines.items())


def _stop(time: float, distance: float | None) -> str:
    return f"{time:g} s" if distance is None else f"{time:g} s and {distance:g} m"


def _rounded_up(figure: float) -> float:
    return math.ceil(100 * figure - 1e-6) / 100
