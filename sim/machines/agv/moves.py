"""Moves of AGVs that come again and again."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace

from ...core.numbers import times_until
from ...core.scenario import AgvMove

MOST_MOVES = 100_000
"""Moves of all AGVs in a trial; more of them are a slip."""


def number_of(moves: Iterable[AgvMove], end: float) -> int:
    """Return how many there are of these moves until `end` (seconds)."""
    return sum(times_until(end, move.time, move.every) for move in moves)


def repeated(moves: tuple[AgvMove, ...], end: float) -> tuple[AgvMove, ...]:
    """Return all of these moves until `end` (seconds), in order of time if any comes again."""
    if all(move.every is None for move in moves):
        return moves
    found = [
        replace(move, time=move.time + k * (move.every or 0.0), every=None)
        for move in moves
        for k in range(times_until(end, move.time, move.every))
    ]
    return tuple(sorted(found, key=lambda move: move.time))
