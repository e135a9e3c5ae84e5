"""Personalities: where their programs are, and what every person believes at first."""

from __future__ import annotations

import json
import re
from pathlib import Path

import bdi
from floorplan import Floorplan

from .rules import RuleSet, suggestion
from .trial import PersonEntry


def find_program(personality: str, folder: Path) -> str | Path:
    """The built-in personality of that name, or the path of an .asl file seen from `folder`.

    `FileNotFoundError` says what there is.
    """
    if personality in bdi.programs():
        return personality
    path = folder / personality
    if path.is_file():
        return path
    raise FileNotFoundError(
        f"no personality and no .asl file is called {personality!r};"
        f" {suggestion(personality, bdi.programs())}"
    )


def first_beliefs(entry: PersonEntry, plan: Floorplan, rules: RuleSet) -> list[str]:
    """What a person knows before the trial starts, as AgentSpeak literals."""
    stations = [plan.station(name) for name in plan.patrol]
    beliefs = [f"station({_atom(s.name)},{s.position[0]},{s.position[1]})" for s in stations]
    if plan.safe_zone is not None:
        x, y = plan.safe_zone.position
        beliefs.append(f"safe_zone({x},{y})")
    beliefs.append(f"pause_after_violation({rules.pause_after_violation * 1000:g})")
    beliefs.append(f"pause_after_agv({rules.pause_after_agv * 1000:g})")
    return [*beliefs, *entry.beliefs]


def _atom(name: str) -> str:
    """A name as an AgentSpeak term: as it is where that is an atom, else as a string."""
    return name if re.fullmatch(r"[a-z][A-Za-z0-9_]*", name) else json.dumps(name)
