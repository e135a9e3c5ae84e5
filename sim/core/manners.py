"""Manners of people towards others, as a trial gives them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

Spread = float | tuple[float, float]
"""A figure, or the least and the most between which each person has one of their own."""

Side = Literal["right", "left"]


@dataclass(frozen=True, kw_only=True)
class MannersEntry:
    """Manners of one person, or of each of several; what is None is as usual.

    `comfort` is in metres, `time_gap`, `foresight`, `reaction_time` and `patience` in seconds. They
    mean what they do in `sim.people.steering.manners.Manners`.
    """

    comfort: Spread | None = None
    time_gap: Spread | None = None
    foresight: Spread | None = None
    reaction_time: Spread | None = None
    patience: Spread | None = None
    passing_side: Side | None = None
    steps_aside: bool | None = None


AS_USUAL = MannersEntry()
"""Manners of which nothing is given."""
