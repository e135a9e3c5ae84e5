"""Names in a trial file that nobody there has: what is said of them makes no difference."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import Any

from floorplan import Document, Fault, Problem, suggestion

from ..core.scenario import Scenario
from ..machines.gantry.robot import GANTRY
from ..machines.kinds import KINDS, is_own


def idle_names(trial: Scenario, document: Document) -> tuple[Problem, ...]:
    """Return a notice on each name in the trial's own file that is nobody's.

    Rule sets and floors of files of their own serve other trials as well, and are not looked at.
    """
    faults = [*_laws(trial, document.data.get("rules")), *_places(trial, document.data)]
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
