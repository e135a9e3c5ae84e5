"""Kinds of machines: registry, machines of a floor and a trial, and the audit of their laws."""

from __future__ import annotations

import inspect
import math
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import is_dataclass, replace
from typing import Any, TypeVar

from pydantic import ValidationError
from shapely.geometry import Polygon

from floorplan import Floorplan, Gantry, UserError
from floorplan.files.dataclass import dataclass
from floorplan.files.forms import form_keys
from floorplan.files.problems import Fault, Place, field_name, misfits, shown
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
"""Kinds of machines by name. A package adds a kind by `KINDS["tugger"] = TuggerModel`."""


_Scenario = TypeVar("_Scenario", bound=Scenario)


class MachineError(UserError):
    """Error of a machine that does not exist, or has invalid keys."""


def _is_model(code: object) -> bool:
    if not inspect.isclass(code) or not issubclass(code, MachineModel):
        return False
    return is_dataclass(code) and not inspect.isabstract(code)


MODEL = Kind(
    noun="kind of machine",
    words="machine: a machine is a dataclass derived from sim.MachineModel",
    accepts=_is_model,
    error=MachineError,
    builtin=KINDS,
)
"""Classes that a trial can name as the kind of a machine."""


@importing()
def models_of(scenario: Scenario, *, own: bool = True) -> dict[str, MachineModel]:
    """Return the machines of a trial by name: gantry and AGVs of the floor, then its `machines`.

    Custom kinds are included if their code may run (`own`). `MachineError` if one of them is
    invalid. Built-in kinds are checked with the trial (`machine_faults`).
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
    """Return the machine `name` of a model. `MachineError` if that makes another object."""
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
    """Return the machines of the floor of a trial, with their moves and jobs, by name."""
    return _on(scenario.floorplan, scenario.gantry, scenario.agvs, scenario.yielding)


def machines_on(plan: Floorplan) -> tuple[MachineShape, ...]:
    """Return the shapes of the machines of a floor."""
    models = _on(plan, GantryEntry(), {}, frozenset())
    return tuple(model.shape(name, plan) for name, model in models.items())


def rails_under(machine: str, plan: Floorplan) -> Gantry | None:
    """Return the rails of the floor if `machine` is the name of its gantry."""
    return plan.gantry if machine == GANTRY else None


def is_own(entry: MachineEntry) -> bool:
    """Return whether the kind of a machine is custom code."""
    return isinstance(entry.kind, str) and entry.kind not in KINDS


def keys_of(entry: MachineEntry, scenario: Scenario) -> list[str] | None:
    """Return the keys of the kind of a machine, or None for a custom kind.

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
    rateless = controller in VEHICLE_CONTROLLERS or inspect.isgeneratorfunction(controller)
    machines = {}
    for name, entry in scenario.machines.items():
        names = keys_of(entry, scenario) or (["controller"] if name == machine else [])
        if machine in ("", name) and "controller" in names:
            keys = {**entry.keys, "controller": controller}
            if rateless:
                keys.pop("rate", None)
            machines[name] = replace(entry, keys=keys)
    changed = replace(scenario, machines=scenario.machines | machines)
    if machine in ("", GANTRY) and (scenario.floorplan.gantry is not None or not machines):
        controller_source(controller, scenario.code_folder)
        rate = None if rateless else scenario.gantry.rate
        gantry = replace(scenario.gantry, controller=controller, rate=rate)
        return replace(changed, gantry=gantry)
    if not machines:
        raise MachineError(f"no machine with a controller is called {machine!r}")
    return changed


def may_be(category: Category, entry: MachineEntry) -> bool:
    """Return whether a machine may be of a category, without running custom code."""
    kind = entry.kind if isinstance(entry.kind, type) else KINDS.get(entry.kind)
    return kind is None or kind.category == category


def kind_name(entry: MachineEntry) -> str:
    """Return the name of the kind of a machine: its class in lower case for a custom kind."""
    kind = entry.kind if isinstance(entry.kind, str) else entry.kind.__name__
    return kind.rpartition(":")[2].lower()


def kind_of(name: str, scenario: Scenario) -> str:
    """Return the name of the kind of a machine of a trial. See `kind_name`."""
    entry = scenario.machines.get(name, MachineEntry("gantry" if name == GANTRY else "agv"))
    builtin = (kind for kind, model in KINDS.items() if entry.kind in (kind, model))
    return next(builtin, kind_name(entry))


def machine_faults(scenario: Scenario) -> Iterator[Fault]:
    """Yield the faults of the `machines` of a trial, without running custom code."""
    plan = scenario.floorplan
    taken = {GANTRY, *(lane.name for lane in plan.lanes)}
    vehicles = _vehicles(scenario)
    starts: dict[str, Polygon] = {}
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
            faults = (*model.place_faults(name, plan), *model.code_faults(scenario.code_folder))
            yield from ((message, (name, *place)) for message, place in faults)
            if (area := model.stands_at_start(name, plan)) is not None:
                starts[name] = area
    lanes = {lane.name: lane.footprint(lane.locations[lane.start]) for lane in plan.lanes}
    for one, other in overlaps({**lanes, **starts}.items()):
        if other in starts:
            yield f"starts where {one} stands", (other,)


def moves_of(scenario: Scenario) -> Iterator[tuple[Place, Sequence[AgvMove]]]:
    """Yield the place of each AGV in the trial, and its moves as in the file.

    Invalid machines are omitted.
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
    """Return the source of a custom kind without importing it. `MachineError` if there is none."""
    return folder.find(str(entry.kind), MODEL)


def _vehicles(scenario: Scenario) -> set[str]:
    return {*scenario.machines, *(lane.name for lane in scenario.floorplan.lanes)}


def _kind(name: str, entry: MachineEntry, scenario: Scenario) -> type[MachineModel]:
    if not isinstance(entry.kind, str):
        return entry.kind
    if entry.kind in KINDS:
        return KINDS[entry.kind]
    try:
        model: type[MachineModel] = own_kind(entry, scenario.code_folder).load()
    except MachineError as why:
        raise MachineError(f"the machine {name!r}: {why}") from why
    return model


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
"""Diagonals of a floor. A longer distance was probably meant in other units."""

_ROUNDING = 1e-9
"""Seconds or metres. Tolerance of comparisons with a law."""


@dataclass(frozen=True, kw_only=True)
class ShortLaw:
    """A law that states a shorter stop than its machine may need, in seconds and metres.

    `law` is its key in the rule set. `stopping` is None if the law computes the distance from `t2`.
    For ISO 13855, `t2` is its time.
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
    """Return the machines of `trial` whose law states a stop that is too short.

    Laws without a stop are ignored for machines with protective fields. Custom laws count only with
    `own_laws`, because their code runs then.
    """
    plan, rules = trial.floorplan, trial.rules
    short: list[ShortLaw | ShortDistance] = []
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
                short.append(
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
                short.append(
                    ShortDistance(machine=name, law=key, distance=stated, needed_distance=needed)
                )
    return tuple(short)


def far_laws(trial: Scenario) -> dict[str, float]:
    """Return the required distances (m) of laws that exceed `FAR` diagonals of the floor, by key.

    They apply to a person at the default top speed beside a stationary machine. Custom laws are
    omitted.
    """
    plan, rules = trial.floorplan, trial.rules
    west, south, east, north = plan.boundary.bounds
    room = FAR * math.hypot(east - west, north - south)
    laws = dict(
        rules.law_and_key_of(model.shape(name, plan))
        for name, model in models_of(trial, own=False).items()
    )
    distances = {
        key: required_at_speeds(law, plan.human.max_speed, 0.0)
        for key, law in laws.items()
        if not isinstance(law, OwnLaw)
    }
    return {key: metres for key, metres in distances.items() if metres > room}


def in_words(short: Iterable[ShortLaw | ShortDistance]) -> str:
    """Return the stops that the laws state and those that the machines need, rounded up to 0.01."""
    machines: dict[str, list[str]] = {}
    for one in short:
        if isinstance(one, ShortDistance):
            stated, needed = f"{one.distance:g} m", f"{_rounded_up(one.needed_distance):g} m"
        else:
            stated = _stop(one.t2, one.stopping)
            needed = _stop(_rounded_up(one.needed_t2), _rounded_up(one.needed_stopping))
        machines.setdefault(f"{stated} (up to {needed} needed)", []).append(one.machine)
    return "; ".join(f"{', '.join(names)} {figures}" for figures, names in machines.items())


def _stop(time: float, distance: float | None) -> str:
    return f"{time:g} s" if distance is None else f"{time:g} s and {distance:g} m"


def _rounded_up(figure: float) -> float:
    return math.ceil(100 * figure - 1e-6) / 100
