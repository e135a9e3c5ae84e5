"""What a trial file says that is likely a slip: names that nobody has, idle sinks, odd figures."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import replace
from typing import Any

import bdi
from floorplan import Document, Fault, Problem, suggestion

from ..core.scenario import PersonEntry, Scenario, spot
from ..machines.gantry.robot import GANTRY
from ..machines.kinds import KINDS, is_own
from ..machines.law_audit import far_laws

FASTEST = 4.0
"""m/s. Whoever is faster runs."""

VISITOR = "visitor"
"""The built-in personality that goes to its sink."""


def likely_slips(trial: Scenario, document: Document) -> tuple[Problem, ...]:
    """Return a notice on each likely slip: a name that is nobody's, an idle sink, an odd figure.

    Names in rule sets and floors of files of their own may be those of other trials: they are left
    out.
    """
    faults = [*_laws(trial, document.data.get("rules")), *_places(trial, document.data)]
    entries = document.data.get("people") or ()
    faults += [*_sinks(trial, entries), *_speeds(entries), *_far_laws(trial)]
    return tuple(document.problem(message, *place) for message, place in faults)


def _laws(trial: Scenario, rules: Any) -> Iterator[Fault]:
    """Yield the laws for machines, or kinds of them, that are not there."""
    if not isinstance(rules, dict) or any(is_own(entry) for entry in trial.machines.values()):
        return  # code of one's own says itself of what kind its machine is
    lanes = [lane.name for lane in trial.floorplan.lanes]
    machines = [*([GANTRY] if trial.floorplan.gantry else []), *lanes, *trial.machines]
    known = dict.fromkeys((*machines, *KINDS))
    for name in rules.get("laws", ()):
        if name not in known:
            hint = suggestion(name, known)
            yield f"no machine and no kind is called {name!r}; {hint}", ("rules", "laws", name)


def _speeds(entries: Iterable[dict[str, Any]]) -> Iterator[Fault]:
    """Yield the walking speeds at which nobody walks."""
    for k, keys in enumerate(entries):
        speed = keys.get("max_speed")
        if isinstance(speed, int | float) and speed > FASTEST:
            message = f"{speed:g} m/s are {3.6 * speed:g} km/h, and nobody walks so fast"
            yield message, ("people", k, "max_speed")


def _far_laws(trial: Scenario) -> Iterator[Fault]:
    """Yield the laws that nobody can keep on a floor so small."""
    for key, metres in far_laws(trial).items():
        message = f"{key} asks for {metres:,.0f} m, far more than the floor is long"
        yield f"{message}; its terms are in seconds and metres", ("rules", *key.split("."))


def _sinks(trial: Scenario, entries: Iterable[dict[str, Any]]) -> Iterator[Fault]:
    """Yield the sinks of those who walk the stations, where there is none."""
    stations = {station.position for station in trial.floorplan.patrolled}
    for k, keys in enumerate(entries):
        personality = keys.get("personality", PersonEntry.personality)
        if "sink" not in keys or personality == VISITOR or personality not in bdi.programs():
            continue
        if spot(trial.floorplan, keys["sink"]) not in stations:
            message = f"no station is there, and {personality} people go to no other place"
            yield f"{message}; those of the personality {VISITOR} do", ("people", k, "sink")


def _places(trial: Scenario, data: dict[str, Any]) -> Iterator[Fault]:
    """Yield the zones and gates that concern, by a name or pattern, nobody who is there."""
    floor = data["floorplan"]
    if not isinstance(floor, dict):
        return
    bodies = [person.name for person in trial.people]
    bodies += [lane.name for lane in trial.floorplan.lanes] + [*trial.machines]
    for key, places in (("zones", trial.floorplan.zones), ("gates", trial.floorplan.gates)):
        for place in places:
            if place.name not in floor.get(key, ()):
                continue
            for k, pattern in enumerate(place.concerns):
                alone = replace(place, concerns=(pattern,))
                if bodies and not any(map(alone.is_about, bodies)):
                    message = f"nobody is called {pattern!r}; {suggestion(pattern, bodies)}"
                    yield message, ("floorplan", key, place.name, "concerns", k)
