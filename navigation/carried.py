"""Motions of points that a body carries along: beside its axis, they turn with it."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from .kernels.numbers import POSE_WIDTH, numbers_of
from .motion import Motion, motion_of

CLOSE = 1e-4
"""Metres. The cubics of a point stay this close to the arc on which it turns."""

Floats = NDArray[np.float64]


def carried(motion: Motion, ahead: float, aside: float) -> Motion:
    """Return the motion of a point `ahead` of a body's axis and `aside` to its left, in metres.

    Where the body turns, the point is on an arc. Its cubics are Hermite's, and stay within `CLOSE`
    metres of it.
    """
    offset = complex(ahead, aside)
    if not offset:
        return motion
    rows = np.array(motion.table).reshape(-1, POSE_WIDTH)
    duration = rows[:, 1] - rows[:, 0]
    count = _counts(rows[:, 10:], abs(offset), duration)
    if count.max() > 1:
        rows, duration = _divided(rows, duration, count)
    found = rows.copy()
    turn = rows[:, 10:].T
    p, v = _at(turn, offset, np.zeros(len(rows)))
    q, w = _at(turn, offset, duration)
    # Place and velocity at both ends are those of the arc.
    h = np.where(duration > 0.0, duration, np.inf)
    turns = turn[1:].any(axis=0)
    bend = np.where(turns, (3 * (q - p) / h - 2 * v - w) / h, 0.0)
    twist = np.where(turns, (v + w - 2 * (q - p) / h) / h**2, 0.0)
    added = np.column_stack([p, v, bend, twist])
    found[:, 2:6] += added.real
    found[:, 6:10] += added.imag
    return motion_of(numbers_of(found), motion.jumps)


def _divided(rows: Floats, duration: Floats, count: NDArray[np.intp]) -> tuple[Floats, Floats]:
    """Return the pieces of a table, each divided into so many alike, and their durations."""
    of = np.repeat(np.arange(len(rows)), count)
    place = np.arange(len(of)) - np.repeat(np.cumsum(count) - count, count)
    low = duration[of] * (place / count[of])
    parts = rows[of]
    parts[:, 0] += low
    last = place + 1 == count[of]
    parts[:-1, 1] = np.where(last[:-1], parts[:-1, 1], parts[1:, 0])
    u = low[:, None]
    for first in (2, 6, 10):
        c0, c1, c2, c3 = (parts[:, first + k, None].copy() for k in range(4))
        parts[:, first : first + 4] = np.hstack(
            [c0 + u * (c1 + u * (c2 + u * c3)), c1 + u * (2 * c2 + u * 3 * c3), c2 + u * 3 * c3, c3]
        )
    return parts, parts[:, 1] - parts[:, 0]


def _at(turn: Floats, offset: complex, u: Floats) -> tuple[NDArray[np.complex128], ...]:
    """Return places and velocities of the point relative to the axis, as complex numbers."""
    angle = turn[0] + u * (turn[1] + u * (turn[2] + u * turn[3]))
    rate = turn[1] + u * (2 * turn[2] + u * 3 * turn[3])
    # Functions of `math` give the same on every machine.
    place = offset * np.array([complex(math.cos(a), math.sin(a)) for a in angle.tolist()])
    return place, 1j * rate * place


def _counts(rotation: Floats, reach: float, duration: Floats) -> NDArray[np.intp]:
    """Return into how many cubics each arc of a radius of `reach` metres is divided.

    Hermite's cubic over h seconds is off by h⁴ M / 384 at most, with M the greatest fourth
    derivative (A. Quarteroni, R. Sacco and F. Saleri, "Numerical Mathematics", 2nd edition 2007,
    8.4). That of exp(i θ) is at most ω⁴ + 6 ω² α + 3 α² + 4 ω j with the derivatives of θ.
    """
    _, v, a, j = np.abs(rotation).T
    rate, bend, jerk = v + duration * (2 * a + duration * 3 * j), 2 * a + 6 * j * duration, 6 * j
    most = reach * (rate**4 + 6 * rate**2 * bend + 3 * bend**2 + 4 * rate * jerk)
    parts = np.ceil(duration * np.sqrt(np.sqrt(most / (384 * CLOSE))))
    return np.asarray(np.maximum(parts, 1), dtype=np.intp)
