"""Events as the lines of a log."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from ..core.recorder import Event
from ..machines.gantry.robot import GANTRY

Level = Literal["info", "warning", "error"]

LEVELS: dict[str, Level] = {
    "violation": "error",
    "gantry_disabled": "warning",
    "protective_stop": "warning",
    "robot_malfunction": "warning",
    "notice": "warning",
    "path_blocked": "warning",
    "teleport": "warning",
    "warning": "warning",
}
"""The level of events by their kind; all others are "info"."""


@dataclass(frozen=True)
class Line:
    """One line of a log: its instant (seconds), level, subject and text."""

    t: float
    level: Level
    name: str
    text: str


def line(event: Event) -> Line:
    """Return the line for an event: its kind, and its fields as name=value."""
    kind = event["kind"]
    named = (event.get(role) for role in ("person", "agv", "machine"))
    who = next(filter(None, named), "trial" if "trial" in kind else GANTRY)
    fields = [
        f"{name}={_shown(value)}"
        for name, value in event.items()
        if name not in ("t", "kind", "person", "agv", "machine")
    ]
    return Line(event["t"], LEVELS.get(kind, "info"), who, " ".join([kind, *fields]))


def _shown(value: object) -> str:
    if isinstance(value, float):
        return f"{value:.3f}".rstrip("0").rstrip(".")
    if isinstance(value, list | tuple):
        return "(" + ", ".join(_shown(inner) for inner in value) + ")"
    return "none" if value is None else str(value)
