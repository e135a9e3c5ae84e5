"""Groups of people who walk together, and where their middles are."""

from __future__ import annotations

import itertools
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

from navigation import Motion, Piece

from ..core.recorder import Event
from .presence import Span

Cubic = tuple[float, float, float, float]


@dataclass(frozen=True)
class Group:
    """Those who walk with a leader: their names, the leader's first, and when (s) they are there.

    `middle` is the mean of their places.
    """

    members: tuple[str, ...]
    span: Span
    middle: Motion


def groups(
    motions: Mapping[str, Motion], events: Iterable[Event], presence: Mapping[str, Span]
) -> dict[str, Group]:
    """Return the groups of a run by their leaders' names, from when all walk together on."""
    members: dict[str, dict[str, float]] = {}
    for event in events:
        if event["kind"] == "walks_with":
            members.setdefault(event["other"], {}).setdefault(event["person"], event["t"])
    found = {}
    for leader, others in members.items():
        names = (leader, *others)
        begin = max(*others.values(), *(presence[name][0] for name in names))
        end = min(presence[name][1] for name in names)
        if begin < end:
            middle = mean_motion([motions[name] for name in names], begin, end)
            found[leader] = Group(names, (begin, end), middle)
    return found


def mean_motion(motions: Sequence[Motion], begin: float, end: float) -> Motion:
    """Return the motion of the middle of several bodies between two instants (seconds)."""
    # Between two instants at which any of them begins a new piece, all are cubics, and so is their
    # mean, coefficient by coefficient, once they are written from the same instant on.
    parts = [motion.cut(begin, end) for motion in motions]
    cuts = sorted({t for part in parts for piece in part.pieces for t in piece[:2]})
    ahead = [list(part.pieces) for part in parts]
    pieces = []
    for since, until in itertools.pairwise(cuts):
        there: list[Piece] = []
        for left in ahead:
            while left[0].end <= since and len(left) > 1:
                left.pop(0)
            there.append(left[0].cut(since, until))
        x, y = _mean([piece.x for piece in there]), _mean([piece.y for piece in there])
        pieces.append(Piece(since, until, x, y, _mean([piece.rotation for piece in there])))
    jumps = frozenset(t for part in parts for t in part.jumps)
    return Motion(tuple(pieces), jumps)


def _mean(cubics: Sequence[Cubic]) -> Cubic:
    a, b, c, d = (sum(terms) / len(cubics) for terms in zip(*cubics, strict=True))
    return a, b, c, d
