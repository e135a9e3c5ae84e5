"""Approaches of a machine during a violation: when it drives at a person already too near.

A violation is caused by the machine if that moves at its first instant. An approach is what a
machine does later: it moves towards the person while the violation lasts.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from navigation import Motion, minimum_margin

from .margins import Encountered, Span, moving_spans

LEAST = 1e-3
"""Metres. A machine that comes no nearer by its own motion does not approach."""

ROUNDING = 1e-6
"""Seconds after the begin of a violation from which on an approach is another one."""

PARTS = 32
"""Parts of an approach by which it is judged whether it counts."""

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
    for begin, end in violations:
        if not moving_spans(beside.measured, begin, end):
            continue
        for since, until in _towards(beside.walk, beside.measured, begin, end):
            # What goes on from the begin of the violation caused it.
            if since > begin + ROUNDING:
                last = float(np.nextafter(until, since))
                time, margin = minimum_margin(beside.walk, beside.measured, beside.law, since, last)
                yield Approach(margin, time, beside.person, beside.machine, since, until)


def _towards(walk: Motion, machine: Motion, begin: float, end: float) -> Iterator[Span]:
    """Yield the intervals in which the machine's own motion brings it nearer to the person."""
    found: list[Span] = []
    for since, until in itertools.pairwise(_cuts(walk, machine, begin, end)):
        person, moving = (motion.cubics(np.array([since]))[0, :2] for motion in (walk, machine))
        velocity = moving[:, 1:] * np.array([1.0, 2.0, 3.0])
        if not velocity.any():
            continue
        apart = person - moving
        # How fast it comes nearer, times the distance: a polynomial of degree 5.
        closing = np.sum([np.convolve(v, r) for v, r in zip(velocity, apart, strict=True)], axis=0)
        found += [(since + a, since + b) for a, b in _positive(closing, until - since)]
    for since, until in _joined(found):
        if _gained(walk, machine, since, until) > LEAST:
            yield since, until


def _cuts(walk: Motion, machine: Motion, begin: float, end: float) -> list[float]:
    """Return the instants between which both motions are one cubic each."""
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
    """Return spans, in order, of which those that meet are one."""
    found: list[Span] = []
    for since, until in spans:
        if found and since - found[-1][1] <= ROUNDING:
            found[-1] = (found[-1][0], until)
        else:
            found.append((since, until))
    return found


def _gained(walk: Motion, machine: Motion, begin: float, end: float) -> float:
    """Return by how much (metres) the machine's own motion brings it nearer to the person."""
    t = begin + (end - begin) * (np.arange(PARTS) + 0.5) / PARTS
    apart = walk.position(t) - machine.position(t)
    along = (machine.velocity(t) * apart).sum(axis=1)
    distance = np.maximum(np.linalg.norm(apart, axis=1), LEAST)
    return float((along / distance).mean() * (end - begin))
