"""The bridge's time as the page of its run may change it."""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from typing import Protocol

from floorplan import UserError

from ..core.tempo import Tempo, checked_speed
from ..simulation import Simulation

PERIOD = 0.1
"""Seconds of the wall clock between two looks at what the page wants."""

PAUSED = "it is paused on its page"


class Viewer(Protocol):
    """A page that shows a run under way; what is wanted there is carried out in `attend`."""

    def follow(self, simulation: Simulation, tempo: Tempo | None = None) -> None:
        """Show a run that has started, and let the page change its tempo."""

    def attend(self, simulation: Simulation) -> None:
        """Carry out what the page wants, and send it what has changed."""

    def leave(self) -> None:
        """Carry out no more: the run is over."""


class BridgeTempo:
    """The speed and the pauses of a session: `changed()` is called after each change."""

    def __init__(self, speed: float) -> None:
        self.speed = speed
        self.paused = False
        self.changed: Callable[[], None] = lambda: None

    def change(self, *, speed: float | None = None, paused: bool | None = None) -> None:
        """Go on with another speed, pause, or go on; a run without a speed gets none."""
        if speed is not None and not self.speed:
            raise UserError("time goes on as soon as all clients can follow: it has no speed")
        if speed is not None:
            self.speed = checked_speed(speed)
        if paused is not None:
            self.paused = paused
        self.changed()


async def attend(viewer: Viewer, simulation: Simulation) -> None:
    """Do what a page wants, and show it what happens, until this is cancelled."""
    try:
        while True:
            viewer.attend(simulation)
            await asyncio.sleep(PERIOD)
    finally:
        viewer.leave()
