"""Moves of AGVs that come again and again."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import replace

from ...core.scenario import AgvMove

MOST_MOVES = 100_000
"""Moves of one AGV in a trial; more of them are a slip."""


def number_of(moves: Iterable[AgvMove], end: float) -> int:
    """Return how many there are of these moves until `end` (seconds)."""
    return sum(_times(move, end) for move in moves)


def repeated(moves: tuple[AgvMove, ...], end: float) -> tuple[AgvMove, ...]:
    """Return all of these moves until `end` (seconds), in order of time if any comes again."""
    if all(move.every is None for move in moves):
        return moves
    found = [
        replace(move, time=move.time + k * (move.every or 0.0), every=None)
        for move in moves
        for k in range(_times(move, end))
    ]
    return tuple(sorted(found, key=lambda move: move.time))


def _times(move: AgvMove, end: float) -> int:
    return 1 if move.every is None else max(1, math.ceil((end - move.time) / move.every))
