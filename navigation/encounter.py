"""Two motions beside each other: bounds on their distance and speeds over an interval."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import NamedTuple

from .motion import Cubic, Motion, Piece, shift, still


class Bounds(NamedTuple):
    """What holds throughout an interval: metres and m/s. At an instant, low equals high."""

    distance_low: float
    distance_high: float
    human_low: float
    human_high: float
    robot_low: float
    robot_high: float


class Encounter:
    """A stretch of time in which the motions of a person and a machine are one cubic each."""

    __slots__ = ("_human", "_robot", "_x", "_y", "begin", "end")

    def __init__(self, begin: float, end: float, human: Piece, robot: Piece) -> None:
        self.begin = begin
        self.end = end
        human_x, human_y = _from(human, begin)
        robot_x, robot_y = _from(robot, begin)
        self._human = (human_x, human_y)
        self._robot = (robot_x, robot_y)
        self._x = _difference(robot_x, human_x)
        self._y = _difference(robot_y, human_y)

    def distance(self, t: float) -> float:
        """The distance between the centres at `t` (metres)."""
        u = t - self.begin
        a, b = self._x, self._y
        return math.hypot(
            a[0] + u * (a[1] + u * (a[2] + u * a[3])),
            b[0] + u * (b[1] + u * (b[2] + u * b[3])),
        )

    def closing(self, begin: float, end: float) -> tuple[float, float]:
        """Bounds on the rate of half the squared distance from `begin` to `end` (m²/s).

        Negative while the two come closer, positive while they part.
        """
        half = (end - begin) / 2
        middle = begin - self.begin + half
        x, y = shift(self._x, middle), shift(self._y, middle)
        rate = x[0] * x[1] + y[0] * y[1]
        # Its derivative is |v|² + r·a; bound every factor by its Taylor series about the middle.
        jerk = 6 * math.hypot(x[3], y[3])
        acceleration = 2 * math.hypot(x[2], y[2]) + jerk * half
        speed = math.hypot(x[1], y[1]) + acceleration * half
        distance = math.hypot(x[0], y[0]) + speed * half
        slack = (speed * speed + distance * acceleration) * half
        return rate - slack, rate + slack

    def bounds(self, begin: float, end: float) -> Bounds:
        """What holds throughout the interval from `begin` to `end` within this stretch."""
        half = (end - begin) / 2
        middle = begin - self.begin + half
        human_low, human_high = _speed(self._human, middle, half)
        robot_low, robot_high = _speed(self._robot, middle, half)
        near, far, _ = self._distance(middle, half)
        return Bounds(near, far, human_low, human_high, robot_low, robot_high)

    def nearest(self, begin: float, end: float) -> tuple[float, float]:
        """A lower bound on the distance over an interval, and an instant that comes close to it."""
        half = (end - begin) / 2
        middle = begin - self.begin + half
        near, _, offset = self._distance(middle, half)
        return near, self.begin + middle + offset

    def _distance(self, middle: float, half: float) -> tuple[float, float, float]:
        """Bounds on the distance within `half` of `middle`, and where its linear part is least.

        About the middle the relative position is r + v u + (a/2) u² + (j/6) u³. The distance to
        the segment r + v u is known exactly; the rest can't be longer than (a/2) h² + (j/6) h³.
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
        if square > 0.0:
            offset = min(max(-(x * vx + y * vy) / square, -half), half)
        near = math.hypot(x + vx * offset, y + vy * offset)
        far = max(
            math.hypot(x - vx * half, y - vy * half), math.hypot(x + vx * half, y + vy * half)
        )
        return max(near - bend, 0.0), far + bend, offset


def encounters(human: Motion, robot: Motion, begin: float, end: float) -> Iterator[Encounter]:
    """The stretches from `begin` to `end` (seconds), in order of time; one if they are equal."""
    human_pieces, robot_pieces = _ahead(human, begin, end), _ahead(robot, begin, end)
    human_piece, robot_piece = next(human_pieces), next(robot_pieces)
    t = begin
    while True:
        until = min(human_piece.end, robot_piece.end, end)
        yield Encounter(t, until, human_piece, robot_piece)
        t = until
        if t >= end:
            return
        if human_piece.end <= t:
            human_piece = next(human_pieces)
        if robot_piece.end <= t:
            robot_piece = next(robot_pieces)


def _ahead(motion: Motion, begin: float, end: float) -> Iterator[Piece]:
    """The pieces of a motion that are not over at `begin`, then one of standing until `end`."""
    if begin < motion.start:
        yield still(motion.state(begin).position, begin, motion.start)
    for piece in motion.pieces_from(begin):
        if piece.end > begin:
            yield piece
    yield still(motion.state(motion.end).position, motion.end, max(end, motion.end))


def _from(piece: Piece, t: float) -> tuple[Cubic, Cubic]:
    u = t - piece.begin
    if u == 0.0:
        return piece.x, piece.y
    return shift(piece.x, u), shift(piece.y, u)


def _difference(a: Cubic, b: Cubic) -> Cubic:
    return (a[0] - b[0], a[1] - b[1], a[2] - b[2], a[3] - b[3])


def _speed(axes: tuple[Cubic, Cubic], middle: float, half: float) -> tuple[float, float]:
    """Bounds on a speed within `half` of `middle`."""
    x, y = axes
    if x[2] == y[2] == x[3] == y[3] == 0.0:
        speed = math.hypot(x[1], y[1])
        return speed, speed
    speed = math.hypot(
        x[1] + middle * (2 * x[2] + middle * 3 * x[3]),
        y[1] + middle * (2 * y[2] + middle * 3 * y[3]),
    )
    slack = half * 2 * math.hypot(x[2] + 3 * x[3] * middle, y[2] + 3 * y[3] * middle)
    slack += half * half * 3 * math.hypot(x[3], y[3])
    return max(speed - slack, 0.0), speed + slack
