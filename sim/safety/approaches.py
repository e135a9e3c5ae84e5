"""Approaches: motions of a machine towards a person during a violation.

The machine causes a violation if it moves at its begin. An approach begins later.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterator, Sequence
from functools import partial
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from navigation import Motion, Shapes, minimum_margin

from .margins import Encountered, Span, moving_spans

LEAST = 1e-3
"""Distance by which a machine must come nearer by its own motion to approach, m."""

ROUNDING = 1e-6
"""Time after the begin of a violation after which a motion is an approach, s."""

PARTS = 32
"""Number of parts of an approach that are checked."""

MOMENT = 1e-6
"""Time step of the derivative of the distance between surfaces, s."""

SLOWEST = 1e-5
"""Speed below which a surface does not approach, because of rounding, m/s."""

HALVINGS = 30
"""Number of times that the ends of an approach between surfaces are bisected."""

BATCH = 64
"""Number of pieces of motions that are sampled in one array."""

Floats = NDArray[np.float64]


class Approach(NamedTuple):
    """An approach: the least margin meanwhile (metres), when that was, and from when to when.

    Times are in seconds.
    """

    margin: float
    time: float
    person: str
    machine: str
    begin: float
    end: float


def approaches(beside: Encountered, violations: Sequence[Span]) -> Iterator[Approach]:
    """Yield the approaches of a machine to a person during these violations."""
    motions, shapes = (beside.walk, beside.measured), beside.shapes
    for begin, end in violations:
        if not moving_spans(beside.measured, begin, end, turning=shapes is not None):
            continue
        towards = _towards if shapes is None else partial(_surface_towards, shapes)
        for since, until in towards(*motions, begin, end):
            # The motion at the begin of the violation is its cause.
            if since > begin + ROUNDING:
                last = float(np.nextafter(until, since))
                time, margin = minimum_margin(*motions, beside.law, since, last, shapes=shapes)
                yield Approach(margin, time, beside.person, beside.machine, since, until)


def _towards(walk: Motion, machine: Motion, begin: float, end: float) -> Iterator[Span]:
    """Yield the intervals in which the machine's own motion brings it nearer to the person."""
    spans: list[Span] = []
    for since, until in itertools.pairwise(_cuts(walk, machine, begin, end)):
        person, moving = (motion.cubics(np.array([since]))[0, :2] for motion in (walk, machine))
        velocity = moving[:, 1:] * np.array([1.0, 2.0, 3.0])
        if not velocity.any():
            continue
        apart = person - moving
        # The speed of the approach times the distance is a polynomial of degree 5.
        closing = np.sum([np.convolve(v, r) for v, r in zip(velocity, apart, strict=True)], axis=0)
        spans += [(since + a, since + b) for a, b in _positive(closing, until - since)]
    for since, until in _joined(spans):
        if _gained(walk, machine, since, until) > LEAST:
            yield since, until


def _surface_towards(
    shapes: Shapes, walk: Motion, machine: Motion, begin: float, end: float
) -> Iterator[Span]:
    """Yield the intervals in which the machine's own motion brings its surface nearer.

    The rate is no polynomial. It is sampled so densely that no point of the machine covers `LEAST`
    between two instants, so that every approach that counts has one. Its ends are then bisected.
    """

    def approach(t: Floats) -> Floats:
        return _surface_rate(shapes, walk, machine, t)

    cuts = np.array(_cuts(walk, machine, begin, end))
    pace = _fastest(machine, shapes.reach, cuts[:-1], cuts[1:])
    pieces = np.column_stack([cuts[:-1], cuts[1:], np.ceil(np.diff(cuts) * pace / LEAST)])
    pieces = pieces[pace > 0.0]
    spans = [
        span
        for k in range(0, len(pieces), BATCH)
        for span in _sampled_spans(approach, *pieces[k : k + BATCH].T)
    ]
    for since, until in _joined(spans):
        t = since + (until - since) * (np.arange(PARTS) + 0.5) / PARTS
        if float(approach(t).mean() * (until - since)) > LEAST:
            yield since, until


def _sampled_spans(
    approach: Callable[[Floats], Floats], begin: Floats, end: Floats, samples: Floats
) -> Iterator[Span]:
    """Yield the spans of pieces in which the surface comes nearer, found by samples of each."""
    count = samples.astype(int)
    last = count.cumsum() - 1
    first = last + 1 - count
    piece = np.repeat(np.arange(len(count)), count)
    inner = np.arange(len(piece)) - first[piece] + 1
    t = begin[piece] + (end - begin)[piece] * inner / (count + 1)[piece]
    nearer = approach(t) > SLOWEST
    change = np.flatnonzero((nearer[1:] != nearer[:-1]) & (piece[1:] == piece[:-1]))
    before, low, high = nearer[change], t[change], t[change + 1]
    for _ in range(HALVINGS if len(change) else 0):
        middle = (low + high) / 2
        same = (approach(middle) > SLOWEST) == before
        low, high = np.where(same, middle, low), np.where(same, high, middle)
    turns = (low + high) / 2
    begins = np.sort(np.concatenate([begin[nearer[first]], turns[~before]]))
    ends = np.sort(np.concatenate([end[nearer[last]], turns[before]]))
    yield from zip(begins.tolist(), ends.tolist(), strict=True)


def _surface_rate(shapes: Shapes, walk: Motion, machine: Motion, t: Floats) -> Floats:
    """Return the speed (m/s) at which the machine's motion brings its surface nearer at `t` (s)."""
    places, poses = walk.position(t), machine.cubics(t)[..., :2]
    now = shapes.distances(places, poses[..., 0])
    return (now - shapes.distances(places, poses[..., 0] + MOMENT * poses[..., 1])) / MOMENT


def _fastest(machine: Motion, reach: float, begin: Floats, end: Floats) -> Floats:
    """Return bounds on the speed (m/s) of all points within `reach` of the axis on each piece."""
    _, v, a, j = np.moveaxis(np.abs(machine.cubics(begin)), 2, 0)
    u = (end - begin)[:, np.newaxis]
    velocity = v + 2 * a * u + 3 * j * u * u
    bound: Floats = np.linalg.norm(velocity[:, :2], axis=1) + reach * velocity[:, 2]
    return bound


def _cuts(walk: Motion, machine: Motion, begin: float, end: float) -> list[float]:
    """Return the times between which both motions are one cubic each."""
    inner = {
        piece.begin
        for motion in (walk, machine)
        for piece in motion.pieces_from(begin, end)
        if begin < piece.begin < end
    }
    return sorted({begin, end, *inner})


def _positive(polynomial: Floats, duration: float) -> Iterator[Span]:
    """Yield where a polynomial, lowest power first, is positive between 0 and `duration`."""
    roots = np.roots(np.trim_zeros(polynomial, "b")[::-1])
    real = roots[np.abs(roots.imag) < 1e-9].real
    cuts = sorted({0.0, duration, *real[(real > 0.0) & (real < duration)].tolist()})
    for a, b in itertools.pairwise(cuts):
        if np.polyval(polynomial[::-1], (a + b) / 2) > 0.0:
            yield a, b


def _joined(spans: Sequence[Span]) -> list[Span]:
    """Return the sorted spans, joined where they meet."""
    joined: list[Span] = []
    for since, until in spans:
        if joined and since - joined[-1][1] <= ROUNDING:
            joined[-1] = (joined[-1][0], until)
        else:
            joined.append((since, until))
    return joined


def _gained(walk: Motion, machine: Motion, begin: float, end: float) -> float:
    """Return the distance (m) by which the machine's motion brings it nearer to the person."""
    t = begin + (end - begin) * (np.arange(PARTS) + 0.5) / PARTS
    apart = walk.position(t) - machine.position(t)
    along = (machine.velocity(t) * apart).sum(axis=1)
    distance = np.maximum(np.linalg.norm(apart, axis=1), LEAST)
    return float((along / distance).mean() * (end - begin))
