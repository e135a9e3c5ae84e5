"""Commands: what somebody outside has done in a run, and when it takes effect."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from floorplan import Obstacle, Point

COMMANDS = ("send", "block", "clear", "hold", "release")
"""The fields of a command of which it has one."""


@dataclass(frozen=True)
class Command:
    """Something that is done from outside at `time` (seconds), after all else of that instant.

    One of: `send` a person `to` a place (x, y in metres, or the name of a station or a door), or as
    near to it as there is room; `block`: put down an obstacle; `clear`: take up the obstacle of
    that name again; `hold` a machine, which brakes and stands, or `release` it.
    """

    time: float
    send: str | None = None
    to: Point | str | None = None
    block: Obstacle | None = None
    clear: str | None = None
    hold: str | None = None
    release: str | None = None


def written_command(event: Mapping[str, Any]) -> dict[str, Any]:
    """Return the keys of a trial file for the command that a `commanded` event records."""
    keys = {"time": event["t"], **{key: event[key] for key in COMMANDS if key in event}}
    if "send" in event:
        keys["to"] = event["to"]
    if "block" in event:
        keys |= {"polygon": event["footprint"], "z": [event["bottom"], event["top"]]}
    return keys
