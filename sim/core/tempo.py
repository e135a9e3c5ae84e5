"""Simulated time by real time, in a run that somebody watches."""

from __future__ import annotations

import math
from typing import Protocol

from floorplan import UserError


class Tempo(Protocol):
    """Simulated time by real time: `speed` times as fast, or not at all while `paused`."""

    @property
    def speed(self) -> float:
        """Seconds of the run in a second of real time; 0 for as fast as it can be."""

    @property
    def paused(self) -> bool:
        """True while simulated time stands still because somebody wants it to."""

    def change(self, *, speed: float | None = None, paused: bool | None = None) -> None:
        """Go on with another speed, pause, or go on after a pause; None leaves it as it is.

        `ValueError` where that can't be.
        """


def checked_speed(speed: float) -> float:
    """Return a speed that can be; `ValueError` for another."""
    if not 0 < speed < math.inf:
        raise UserError(f"speed must be more than 0, not {speed:g}")
    return speed
