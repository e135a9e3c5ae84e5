"""Conflicts of discs on the floor: the first instant at which two of them come too close.

Both follow motions that end in a standing which counts for ever. The tables are plain numbers in
flat rows, one for each piece, so that a loop over them needs no object of this library.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from .motion import Motion, value

RESOLUTION = 1e-4
"""Seconds. A stretch that is undecided when it is shorter than this counts as a conflict."""

Row = tuple[float, float, float, float, float, float, float, float, float, float]
"""Begin and end of a piece (seconds), and the coefficients of x and y since it began."""


class Swath(NamedTuple):
    """The floor that a disc's centre takes from an instant on: rows in time, and their bounds.

    The last row is the final standing, which has no end; `rests` is when that begins (seconds),
    `low_x` to `high_y` bound the whole (metres).
    """

    rows: tuple[Row, ...]
    rests: float
    low_x: float
    low_y: float
    high_x: float
    high_y: float

    @property
    def place(self) -> tuple[float, float]:
        """Where it comes to stand."""
        return (self.rows[-1][2], self.rows[-1][6])


def swath(motion: Motion, begin: float) -> Swath:
    """Return the swath of `motion` from `begin` (seconds) on."""
    rows: list[Row] = []
    xs: list[float] = []
    ys: list[float] = []
    for piece in motion.pieces_from(begin):
        if piece.end <= begin or piece.end <= piece.begin:
            continue
        rows.append((piece.begin, piece.end, *piece.x, *piece.y))
        duration = piece.end - piece.begin
        for axis, cubic in ((xs, piece.x), (ys, piece.y)):
            ends = cubic[0], value(cubic, duration)
            axis += ends
            if cubic[3] or (cubic[2] and cubic[1] * (cubic[1] + 2 * cubic[2] * duration) < 0):
                # It may turn back within the piece: no farther out than its control points.
                third = duration * cubic[1] / 3
                axis.append(cubic[0] + third)
                axis.append(cubic[0] + 2 * third + duration * duration * cubic[2] / 3)
    x, y = motion.state(max(begin, motion.end)).at
    since = max(begin, motion.end)
    rows.append((since, math.inf, x, 0.0, 0.0, 0.0, y, 0.0, 0.0, 0.0))
    xs.append(x)
    ys.append(y)
    return Swath(tuple(rows), since, min(xs), min(ys), max(xs), max(ys))


def first_conflict(one: Swath, other: Swath, least: float, begin: float) -> float | None:
    """Return the first instant from `begin` on at which two centres are closer than `least`.

    Seconds and metres; None if there is none. The swaths of `one` and of the `other` reach back to
    `begin`. Never misses
    one; finds one too many only where the two stay within rounding of `least`.
    """
    if (
        one.low_x - other.high_x >= least
        or other.low_x - one.high_x >= least
        or one.low_y - other.high_y >= least
        or other.low_y - one.high_y >= least
    ):
        return None
    a_rows, b_rows = one.rows, other.rows
    i = j = 0
    while a_rows[i][1] <= begin:
        i += 1
    while b_rows[j][1] <= begin:
        j += 1
    t = begin
    limit = least * least
    while True:
        a_begin, a_end, ax0, ax1, ax2, ax3, ay0, ay1, ay2, ay3 = a_rows[i]
        b_begin, b_end, bx0, bx1, bx2, bx3, by0, by1, by2, by3 = b_rows[j]
        u, w = t - a_begin, t - b_begin
        if u > 0.0:
            ax0 += u * (ax1 + u * (ax2 + u * ax3))
            ax1 += u * (2 * ax2 + u * 3 * ax3)
            ax2 += u * 3 * ax3
            ay0 += u * (ay1 + u * (ay2 + u * ay3))
            ay1 += u * (2 * ay2 + u * 3 * ay3)
            ay2 += u * 3 * ay3
        if w > 0.0:
            bx0 += w * (bx1 + w * (bx2 + w * bx3))
            bx1 += w * (2 * bx2 + w * 3 * bx3)
            bx2 += w * 3 * bx3
            by0 += w * (by1 + w * (by2 + w * by3))
            by1 += w * (2 * by2 + w * 3 * by3)
            by2 += w * 3 * by3
        until = a_end if a_end < b_end else b_end
        x, y = ax0 - bx0, ay0 - by0
        if until == math.inf:
            return t if x * x + y * y < limit else None
        duration = until - t
        x1, x2, x3 = ax1 - bx1, ax2 - bx2, ax3 - bx3
        y1, y2, y3 = ay1 - by1, ay2 - by2, ay3 - by3
        if x3 == 0.0 and y3 == 0.0:
            # A quadratic stays between its control points.
            xm, ym = x + duration * x1 / 2, y + duration * y1 / 2
            xe = x + duration * (x1 + duration * x2)
            ye = y + duration * (y1 + duration * y2)
            if (
                (x >= least and xm >= least and xe >= least)
                or (x <= -least and xm <= -least and xe <= -least)
                or (y >= least and ym >= least and ye >= least)
                or (y <= -least and ym <= -least and ye <= -least)
            ):
                t = until
                if a_end <= t:
                    i += 1
                if b_end <= t:
                    j += 1
                continue
        found = _within(x, x1, x2, x3, y, y1, y2, y3, duration, least)
        if found is not None:
            return t + found
        t = until
        if a_end <= t:
            i += 1
        if b_end <= t:
            j += 1


def _within(
    x0: float,
    x1: float,
    x2: float,
    x3: float,
    y0: float,
    y1: float,
    y2: float,
    y3: float,
    duration: float,
    least: float,
) -> float | None:
    """Return the first u from 0 to `duration` at which a relative position is within `least`.

    About the middle of a stretch the position is r + v u + (a/2) u² + (j/6) u³. The distance along
    the straight line r + v u is convex, and the rest can't be longer than (a/2) h² + (j/6) h³
    (as in `Encounter`); a stretch that this leaves undecided is halved.
    """
    begin, end = 0.0, duration
    later: list[tuple[float, float]] = []
    curved = bool(x2 or y2 or x3 or y3)
    while True:
        half = (end - begin) / 2
        m = begin + half
        x = x0 + m * (x1 + m * (x2 + m * x3))
        y = y0 + m * (y1 + m * (y2 + m * y3))
        vx = x1 + m * (2 * x2 + m * 3 * x3)
        vy = y1 + m * (2 * y2 + m * 3 * y3)
        square = vx * vx + vy * vy
        offset = 0.0
        if square > 0.0:
            offset = -(x * vx + y * vy) / square
            offset = -half if offset < -half else half if offset > half else offset
        nx, ny = x + vx * offset, y + vy * offset
        near = math.sqrt(nx * nx + ny * ny)
        bend = 0.0
        if curved:
            ax, ay = x2 + 3 * x3 * m, y2 + 3 * y3 * m
            bend = (
                half * half * (math.sqrt(ax * ax + ay * ay) + half * math.sqrt(x3 * x3 + y3 * y3))
            )
        if near - bend >= least:
            if not later:
                return None
            begin, end = later.pop()
            continue
        if end - begin <= RESOLUTION:
            return begin
        if bend == 0.0:
            return _entered(x0, x1, y0, y1, begin, end, least) if not curved else begin
        later.append((m, end))
        end = m


def _entered(
    x: float, vx: float, y: float, vy: float, begin: float, end: float, least: float
) -> float:
    """Return the first u from `begin` to `end` at which x + vx u, y + vy u is within `least`."""
    x, y = x + vx * begin, y + vy * begin
    c = x * x + y * y - least * least
    if c <= 0.0:
        return begin
    a, b = vx * vx + vy * vy, x * vx + y * vy
    root = math.sqrt(max(b * b - a * c, 0.0))
    return min(begin + max(c / (root - b), 0.0), end)
