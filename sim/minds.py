"""What every person believes before a trial starts."""

from __future__ import annotations

import re

import bdi
from floorplan import Floorplan

from .rules import RuleSet
from .trial import PersonEntry


def first_beliefs(entry: PersonEntry, plan: Floorplan, rules: RuleSet) -> list[bdi.Literal | str]:
    """What a person knows before the trial starts."""
    stations = [plan.station(name) for name in plan.patrol]
    beliefs: list[bdi.Literal | str] = [
        bdi.Literal("station", (_name(station.name), *station.position)) for station in stations
    ]
    if plan.safe_zone is not None:
        beliefs.append(bdi.Literal("safe_zone", plan.safe_zone.position))
    for pause, seconds in (
        ("pause_after_violation", rules.pause_after_violation),
        ("pause_after_agv", rules.pause_after_agv),
    ):
        beliefs.append(bdi.Literal(pause, (seconds * 1000,)))
    return [*beliefs, *entry.beliefs]


def _name(name: str) -> bdi.Term:
    """A name as an AgentSpeak term: an atom where it can be one, else a string."""
    return bdi.Literal(name) if re.fullmatch(r"[a-z][A-Za-z0-9_]*", name) else name
