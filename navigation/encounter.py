"""Bounds on the distance and the speeds of two motions over an interval."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from typing import NamedTuple

from .motion import Cubic, Motion, Piece, shift, still
from .odometer import Enclosure, Odometer, speed_along

_NEAR = 1e-9
"""Metres. Nearer than this, the direction from one to the other is mostly rounding."""


class Bounds(NamedTuple):
    """Bounds throughout an interval: metres and m/s. At an instant, low equals high."""

    distance_low: float
    distance_high: float
    human_low: float
    human_high: float
    robot_low: float
    robot_high: float


class Encounter:
    """A stretch of time in which the motions of a person and a machine are one cubic each.

    `human` and `robot` are the odometers of the whole motions.
    """

    __slots__ = (
        "_human",
        "_human_piece",
        "_human_steady",
        "_robot",
        "_robot_piece",
        "_robot_steady",
        "_x",
        "_y",
        "begin",
        "end",
        "human",
        "robot",
    )

    rounding = 0.0
    """Metres by which distances may be off, so that ties need not be what they seem."""

    def __init__(
        self,
        begin: float,
        end: float,
        pieces: tuple[Piece, Piece],
        odometers: tuple[Odometer, Odometer],
    ) -> None:
        self.begin = begin
        self.end = end
        self.human, self.robot = odometers
        self._human_piece, self._robot_piece = human, robot = pieces
        human_x, human_y = _from(human, begin)
        robot_x, robot_y = _from(robot, begin)
        self._human = (human_x, human_y)
        self._robot = (robot_x, robot_y)
        self._human_steady = _steady_speed(human_x, human_y)
        self._robot_steady = _steady_speed(robot_x, robot_y)
        self._x = _difference(robot_x, human_x)
        self._y = _difference(robot_y, human_y)

    def distance(self, t: float) -> float:
        """Return the distance between the two at `t` (metres)."""
        u = t - self.begin
        a, b = self._x, self._y
        return math.hypot(
            a[0] + u * (a[1] + u * (a[2] + u * a[3])),
            b[0] + u * (b[1] + u * (b[2] + u * b[3])),
        )

    def closing(self, begin: float, end: float) -> tuple[float, float]:
        """Return bounds on the rate of half the squared distance from `begin` to `end` (m²/s).

        Negative while the two come closer, positive while they part.
        """
        half = (end - begin) / 2
        middle = begin - self.begin + half
        (x, vx, ax, jx), (y, vy, ay, jy) = shift(self._x, middle), shift(self._y, middle)
        # r·v as a polynomial about the middle: its terms one by one, by their greatest size.
        rate = x * vx + y * vy
        slack = half * (
            abs(vx * vx + vy * vy + 2 * (x * ax + y * ay))
            + half
            * (
                3 * abs(vx * ax + vy * ay + x * jx + y * jy)
                + half
                * (
                    abs(2 * (ax * ax + ay * ay) + 4 * (vx * jx + vy * jy))
                    + half * (5 * abs(ax * jx + ay * jy) + half * 3 * (jx * jx + jy * jy))
                )
            )
        )
        return rate - slack, rate + slack

    def bounds(self, begin: float, end: float) -> Bounds:
        """Return the bounds from `begin` to `end`, an interval within this stretch."""
        half = (end - begin) / 2
        middle = begin - self.begin + half
        human_low, human_high = self._human_steady or _speed(self._human, middle, half)
        robot_low, robot_high = self._robot_steady or _speed(self._robot, middle, half)
        near, far, _ = self._distance(middle, half, 0.0, 0.0)
        return Bounds(near, far, human_low, human_high, robot_low, robot_high)

    def apart(
        self, begin: float, end: float, slope: float = 0.0, curve: float = 0.0
    ) -> tuple[float, float, float]:
        """Bounds on distance − `slope` u − `curve` u² / 2 over an interval, u from its middle.

        Slope (m/s) and curve (m/s²) are those of a required distance that changes while the two
        move. The third number is an instant at which the figure is near the low.
        """
        half = (end - begin) / 2
        middle = begin - self.begin + half
        near, far, offset = self._distance(middle, half, slope, curve)
        return near, far, min(max(self.begin + middle + offset, begin), end)

    def human_speed(self, begin: float, end: float) -> Enclosure:
        """Return the human's speed over an interval within this stretch, m/s."""
        return speed_along(self._human_piece, begin, end)

    def robot_speed(self, begin: float, end: float) -> Enclosure:
        """Return the robot's speed over an interval within this stretch, m/s."""
        return speed_along(self._robot_piece, begin, end)

    def _distance(
        self, middle: float, half: float, slope: float, curve: float
    ) -> tuple[float, float, float]:
        """See `apart`, for all |u| <= `half`; the third number is a u.

        About the middle the relative position is r + v u + (a/2) u² + (j/6) u³. What |r + v u| −
        slope u may be is known exactly, for it is convex; the rest of the position can't be longer
        than (a/2) h² + (j/6) h³.
        """
        a, b = self._x, self._y
        x = a[0] + middle * (a[1] + middle * (a[2] + middle * a[3]))
        y = b[0] + middle * (b[1] + middle * (b[2] + middle * b[3]))
        if half == 0.0:
            distance = math.hypot(x, y)
            return distance, distance, 0.0
        vx = a[1] + middle * (2 * a[2] + middle * 3 * a[3])
        vy = b[1] + middle * (2 * b[2] + middle * 3 * b[3])
        bend = half * half * math.hypot(a[2] + 3 * a[3] * middle, b[2] + 3 * b[3] * middle)
        if a[3] or b[3]:
            bend += half * half * half * math.hypot(a[3], b[3])
        square = vx * vx + vy * vy
        offset = 0.0
        if square > slope * slope:
            offset = -(x * vx + y * vy) / square
            if slope:
                across = abs(x * vy - y * vx)
                offset += across / square * (slope / math.sqrt(square - slope * slope))
            offset = min(max(offset, -half), half)
        elif slope:
            offset = math.copysign(half, slope)
        near = math.hypot(x + vx * offset, y + vy * offset)
        before = math.hypot(x - vx * half, y - vy * half)
        after = math.hypot(x + vx * half, y + vy * half)
        if slope or curve:
            rise = slope * half
            bend = self._bend(middle, half, curve, bend)
            return near - slope * offset - bend, max(before + rise, after - rise) + bend, offset
        return max(near - bend, 0.0), max(before, after) + bend, offset

    def _bend(self, middle: float, half: float, curve: float, bend: float) -> float:
        """Bound the deviation of distance − curve u² / 2 from that along a line: of third order.

        With n the direction of r, that is (n·a − curve) u² / 2 + (n·j/6) u³, and in addition what
        is due to n turning, and to the part of the bend across n. `bend` is the length of it all.
        """
        (x, vx, ax, jx), (y, vy, ay, jy) = shift(self._x, middle), shift(self._y, middle)
        whole = bend + abs(curve) / 2 * half * half
        away = math.hypot(x, y)
        nearest = away - math.hypot(vx, vy) * half
        if nearest < _NEAR:
            return whole
        along = abs((x * ax + y * ay) / away - curve / 2) + abs(x * jx + y * jy) / away * half
        turn = abs(x * vy - y * vx) * half / (nearest * nearest)
        return min(along * half * half + bend * (turn + bend / (2 * nearest)), whole)


MakeEncounter = Callable[[float, float, tuple[Piece, Piece], tuple[Odometer, Odometer]], Encounter]


def encounters(
    human: Motion, robot: Motion, begin: float, end: float, make: MakeEncounter = Encounter
) -> Iterator[Encounter]:
    """The stretches from `begin` to `end` (seconds), in order of time; one if they are equal."""
    human_pieces, robot_pieces = _ahead(human, begin, end), _ahead(robot, begin, end)
    human_piece, robot_piece = next(human_pieces), next(robot_pieces)
    odometers = (Odometer(human), Odometer(robot))
    t = begin
    while True:
        until = min(human_piece.end, robot_piece.end, end)
        yield make(t, until, (human_piece, robot_piece), odometers)
        t = until
        if t >= end:
            return
        if human_piece.end <= t:
            human_piece = next(human_pieces)
        if robot_piece.end <= t:
            robot_piece = next(robot_pieces)


def _ahead(motion: Motion, begin: float, end: float) -> Iterator[Piece]:
    """Yield the pieces of a motion that are not over at `begin`, then standing until `end`.

    Pieces of no length are left out: a body has no velocity for no time.
    """
    if begin < motion.start:
        yield still(motion.state(begin).position, begin, motion.start)
    for piece in motion.pieces_from(begin):
        if piece.end > max(begin, piece.begin):
            _require_figures(piece)
            yield piece
    yield still(motion.state(motion.end).position, motion.end, max(end, motion.end))


def _require_figures(piece: Piece) -> None:
    begin, end, (x0, x1, x2, x3), (y0, y1, y2, y3), turn = piece
    if not math.isfinite(begin + end + x0 + x1 + x2 + x3 + y0 + y1 + y2 + y3 + sum(turn)):
        raise ValueError(f"a motion is not finite from t = {begin} s to {end} s")


def _from(piece: Piece, t: float) -> tuple[Cubic, Cubic]:
    u = t - piece.begin
    if u == 0.0:
        return piece.x, piece.y
    return shift(piece.x, u), shift(piece.y, u)


def _difference(a: Cubic, b: Cubic) -> Cubic:
    return (a[0] - b[0], a[1] - b[1], a[2] - b[2], a[3] - b[3])


def _speed(axes: tuple[Cubic, Cubic], middle: float, half: float) -> tuple[float, float]:
    """Return bounds on a speed within `half` of `middle`."""
    x, y = axes
    speed = math.hypot(
        x[1] + middle * (2 * x[2] + middle * 3 * x[3]),
        y[1] + middle * (2 * y[2] + middle * 3 * y[3]),
    )
    slack = half * 2 * math.hypot(x[2] + 3 * x[3] * middle, y[2] + 3 * y[3] * middle)
    slack += half * half * 3 * math.hypot(x[3], y[3])
    return max(speed - slack, 0.0), speed + slack


def _steady_speed(x: Cubic, y: Cubic) -> tuple[float, float] | None:
    """Return the speed as its own bounds, where it never changes."""
    if x[2] == y[2] == x[3] == y[3] == 0.0:
        speed = math.hypot(x[1], y[1])
        return speed, speed
    return None
