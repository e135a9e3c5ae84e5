"""Names in a trial: bodies, places, parts, orders, and kinds of events."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator
from pathlib import Path
from typing import Any

import bdi
from floorplan import UserError
from floorplan.files.problems import Fault, suggestion

from ..core.body import PERSON
from ..core.events import EVENT_KINDS, Form
from ..core.scenario import Scenario
from ..machines.gantry.controllers import CONTROLLERS
from ..machines.gantry.tasks import fixed_places
from ..machines.kinds import KINDS, is_own, kind_name, kind_of, on_floor
from ..safety.laws import own_laws

MOST_NAMED = 12
"""Maximum number of names in a line of text."""


def in_words(trial: Scenario) -> str:
    """Return the first people of a trial with their personalities, and the number of others."""
    bodies = [f"{one.name} ({Path(one.personality_name).stem})" for one in trial.people]
    return _first(bodies) or "nobody"


def machines_in_words(trial: Scenario) -> str:
    """Return the first machines of a trial with their kinds, and the number of others."""
    names = machines(trial)
    kinds = [kind_of(name, trial) for name in names]
    named = [
        name if name == kind else f"{name} ({kind})"
        for name, kind in zip(names, kinds, strict=True)
    ]
    return f"machine{'s' if len(names) > 1 else ''} {_first(named)}" if names else ""


def _first(names: list[str]) -> str:
    more = len(names) - MOST_NAMED
    return ", ".join([*names[:MOST_NAMED], f"{more} more"] if more > 0 else names)


def people(trial: Scenario) -> list[str]:
    """Return the names of the people."""
    return [person.name for person in trial.people]


def machines(trial: Scenario) -> list[str]:
    """Return the names of the machines."""
    return [*on_floor(trial), *trial.machines]


def agvs(trial: Scenario) -> list[str]:
    """Return the names of the AGVs and of the machines of the trial."""
    return [*(lane.name for lane in trial.floorplan.lanes), *trial.machines]


def stations(trial: Scenario) -> list[str]:
    """Return the names of the stations."""
    return [station.name for station in trial.floorplan.stations]


def zones(trial: Scenario) -> list[str]:
    """Return the names of the zones of the floor."""
    return [zone.name for zone in trial.floorplan.zones]


def places(trial: Scenario) -> list[str]:
    """Return the names of places from which the gantry picks and onto which it places parts."""
    return [*fixed_places(trial.floorplan), *agvs(trial)]


def parts(trial: Scenario) -> list[str]:
    """Return the names of all parts that may be carried."""
    ariac = trial.workload.parts if trial.workload else ()
    return [*ariac, *(job.part for job in trial.gantry.jobs if job.part)]


def orders(trial: Scenario) -> list[str]:
    """Return the names of the orders that are submitted."""
    ariac = trial.workload.ids if trial.workload else ()
    return [*ariac, *(job.order for job in trial.gantry.jobs if job.order)]


def _locations(trial: Scenario) -> list[str]:
    lanes = trial.floorplan.lanes
    return [name for lane in lanes for name in (*lane.locations, *lane.serves)]


def _personalities(trial: Scenario) -> list[str]:
    changes = [change.personality_name for person in trial.people for change in person.changes]
    return [*sorted(bdi.programs()), *(Path(name).stem for name in changes)]


_NAMES: dict[Form, Callable[[Scenario], list[str]]] = {
    "person": people,
    "machine": machines,
    "agv": agvs,
    "station": stations,
    "door": lambda trial: [door.name for door in trial.floorplan.doors],
    "obstacle": lambda trial: [
        *(timed.obstacle.name for timed in trial.obstacles),
        *(command.block.name for command in trial.commands if command.block is not None),
    ],
    "location": _locations,
    "place": lambda trial: [*places(trial), *_locations(trial)],
    "part": parts,
    "order": orders,
    "personality": _personalities,
    "kind of job": lambda _: [
        "move",
        "wait",
        "pick_place",
        "submit",
        "tray",
        "dispose",
        "assemble",
    ],
    "type of order": lambda _: ["kitting", "assembly", "combined"],
    "cause": lambda trial: [*KINDS, PERSON, *map(kind_name, trial.machines.values())],
    "reason": lambda _: ["gantry", "agv"],
}


def known_names(trial: Scenario, form: Form) -> list[str] | None:
    """Return all names of this form in `trial`, or None if any text is valid."""
    names = _NAMES.get(form)
    return None if names is None else list(dict.fromkeys(names(trial)))


def checked_name(name: Any, form: str, known: Collection[str]) -> str:
    """Return `name`. `UserError` lists the known names if it is none of them."""
    if name not in known:
        hint = suggestion(str(name), known) if known else "there is none in this trial"
        raise UserError(f"no {form} is called {name!r}; {hint}")
    return str(name)


def name_faults(name: str, form: str, known: Collection[str], *place: str | int) -> Iterator[Fault]:
    """Yield a fault if a name at a place of a trial is unknown."""
    try:
        checked_name(name, form, known)
    except UserError as why:
        yield str(why), place


def event_kinds(trial: Scenario, kind: str) -> Collection[str]:
    """Return the names of all kinds of events.

    They include `kind` if custom code, which is not imported yet, may define it.
    """
    if trial.own_code and any(own_names(trial)):
        return [*EVENT_KINDS, kind]
    return EVENT_KINDS


def own_names(trial: Scenario) -> Iterator[str]:
    """Yield the names of all custom code in the trial's folder."""
    controller = trial.gantry.controller
    if controller not in (*CONTROLLERS, *CONTROLLERS.values()):
        yield trial.gantry.controller_name
    planners = (trial.planner, *(person.planner for person in trial.people))
    yield from dict.fromkeys(one.name for one in planners if one is not None and one.is_own)
    if trial.steering is not None:
        yield trial.steering
    modules = (trial.actions, *(person.actions for person in trial.people))
    yield from dict.fromkeys(name for name in modules if name is not None)
    yield from (str(entry.kind) for entry in trial.machines.values() if is_own(entry))
    controllers = (entry.keys.get("controller") for entry in trial.machines.values())
    yield from (name for name in controllers if isinstance(name, str) and ":" in name)
    for law in dict.fromkeys(own_laws(trial.rules)):
        if law.folder == trial.folder.resolve():
            yield law.name
