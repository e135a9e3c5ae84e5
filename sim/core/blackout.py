"""Blackouts: times in which a machine does not see people."""

from __future__ import annotations

from dataclasses import dataclass

from .start import Start


@dataclass(frozen=True)
class Blackout:
    """From `start` on, `machine` does not see people for `seconds`."""

    machine: str
    start: Start
    seconds: float
