"""Figures of motions: length, turning, standing, and distances between bodies.

They are computed from the polynomials that motions are made of, for all bodies together; nothing
is sampled.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from .motion import Motion
from .polynomials import (
    Array,
    Index,
    bernstein,
    derivative,
    integral_of_least_length,
    least,
    square,
    time_negative,
)

FAR = 1e6
"""Metres. Place of a body that is not there yet, so that it is near to none."""


@dataclass(frozen=True)
class Company:
    """Distances of a body from others, while any of them was there.

    `mean` is the mean over time of the distance to the nearest of them, `minimum` and `maximum`
    are over all of them (metres). `within` has for each distance asked for the seconds in which
    the nearest was nearer than that. Without a common `time` (seconds) all are 0.
    """

    time: float
    mean: float
    minimum: float
    maximum: float
    within: tuple[float, ...]


class Courses:
    """Motions side by side, each looked at between two instants of its own.

    `spans` has (begin, end) in seconds for each motion. Results that are arrays have one figure
    for each motion. A jump to another place adds neither length nor turning.
    """

    def __init__(self, motions: Sequence[Motion], spans: Sequence[tuple[float, float]]) -> None:
        for begin, end in spans:
            if not (math.isfinite(begin) and math.isfinite(end) and begin <= end):
                raise ValueError(f"can't look from {begin} s to {end} s")
        self._motions = motions
        self._spans = np.array(spans, dtype=np.float64).reshape(-1, 2)
        cuts = self._cuts()
        self._begins, self._durations = cuts[:-1], np.diff(cuts)
        self._there = (self._spans[:, :1] <= self._begins) & (self._begins < self._spans[:, 1:])
        self._pieces = np.array([motion.cubics(self._begins) for motion in motions])

    @cached_property
    def time(self) -> Array:
        """The length of each span, seconds."""
        return np.asarray(self._spans[:, 1] - self._spans[:, 0])

    @cached_property
    def length(self) -> Array:
        """The length of the path gone, metres: ∫ |v| dt."""
        return self._integrated(self._velocity)

    @cached_property
    def acceleration(self) -> Array:
        """∫ |a| dt, m/s; the sudden turns of a walker at a corner are left out."""
        return self._integrated(derivative(self._velocity))

    @cached_property
    def jerk(self) -> Array:
        """∫ |j| dt, m/s²; steps of the acceleration are left out."""
        third = derivative(derivative(self._velocity))[..., 0]
        return self._summed(np.hypot(third[:, :, 0], third[:, :, 1]) * self._durations)

    @cached_property
    def top_speed(self) -> Array:
        """The highest speed, m/s."""
        body, stretch = self._rows
        squares = self._speed_squared[body, stretch]
        fastest = -least(-squares, body, len(self._motions))
        return np.sqrt(np.where(np.isfinite(fastest), np.maximum(fastest, 0.0), 0.0))

    @cached_property
    def turning(self) -> Array:
        """The angle turned by, in either direction, radians: ∫ |ω| dt and turns on the spot."""
        rotation = self._pieces[:, :, 2]
        return self._summed(_variation(rotation, self._durations)) + self._sudden_turns()

    def time_not_moving(self, speed: float, turning: float) -> Array:
        """Return the seconds with less than `speed` (m/s) and less than `turning` (rad/s)."""
        body, stretch = self._rows
        durations = self._durations[stretch]
        spin = bernstein(square(derivative(self._pieces[body, stretch, 2])), durations)
        excess = np.stack(
            [speed**2 - self._speed_squared[body, stretch], turning**2 - spin], axis=1
        )
        moving = time_negative(excess, durations)
        return _totals(body, durations - moving, len(self._motions))

    def company(
        self,
        bodies: Sequence[tuple[int, Sequence[int]]],
        within: Sequence[float] = (),
        radii: Sequence[float] | None = None,
    ) -> list[Company]:
        """Return the distances of each body from the nearest of some others, by their indices.

        Distances are between centres, less the `radii` (metres) of both bodies if they are given.
        For each distance (metres) of `within` there is also the time that another was so near.
        """
        return [] if not bodies else _Meetings(self, bodies, within, radii).company()

    @cached_property
    def _rows(self) -> tuple[Index, Index]:
        """The body and the stretch of each stretch in which a body is looked at."""
        body, stretch = np.nonzero(self._there)
        return body, stretch

    @cached_property
    def _velocity(self) -> Array:
        """(bodies, stretches, 2, 3)"""
        return derivative(self._pieces[:, :, :2])

    @cached_property
    def _speed_squared(self) -> Array:
        return bernstein(
            square(self._velocity[:, :, 0]) + square(self._velocity[:, :, 1]), self._durations
        )

    def _cuts(self) -> Array:
        ends = [self._spans.min(initial=math.inf), self._spans.max(initial=-math.inf)]
        if not len(self._spans):
            return np.zeros(1)
        times = [self._spans.ravel()]
        for motion in self._motions:
            pieces = motion.pieces
            times.append(np.array([pieces[0].begin, *(piece.end for piece in pieces)]))
        # Cut wherever any motion changes: between two cuts all of them are one cubic each.
        cuts = np.unique(np.concatenate(times))
        return np.asarray(cuts[(ends[0] <= cuts) & (cuts <= ends[1])])

    def _integrated(self, vectors: Array) -> Array:
        body, stretch = self._rows
        x, y = vectors[body, stretch, 0][:, None], vectors[body, stretch, 1][:, None]
        nothing = np.zeros((len(body), 1))
        lengths = integral_of_least_length(x, y, nothing, self._durations[stretch])
        return _totals(body, lengths, len(self._motions))

    def _summed(self, figures: Array) -> Array:
        return np.asarray((figures * self._there).sum(1))

    def _sudden_turns(self) -> Array:
        """The angles by which the bodies turn on the spot, together (radians)."""
        rotation, u = self._pieces[:, :, 2], self._durations
        ends = rotation[..., 0] + u * (
            rotation[..., 1] + u * (rotation[..., 2] + u * rotation[..., 3])
        )
        turns = rotation[:, 1:, 0] - ends[:, :-1]
        # The short way round: headings that differ by a whole turn are the same.
        turns = np.abs(turns - math.tau * np.round(turns / math.tau))
        counts = self._there[:, 1:] & self._there[:, :-1]
        for k, motion in enumerate(self._motions):
            counts[k, np.isin(self._begins[1:], list(motion.jumps))] = False
        return np.asarray((turns * counts).sum(1))


class _Meetings:
    """For some bodies, the others beside them: a row for every stretch in which any is there."""

    def __init__(
        self,
        courses: Courses,
        bodies: Sequence[tuple[int, Sequence[int]]],
        within: Sequence[float],
        radii: Sequence[float] | None,
    ) -> None:
        self.count = len(bodies)
        self.within = within
        most = max(len(others) for _, others in bodies)
        # Bodies with fewer others than the most have their first one several times.
        # Arrays need as many for each; one that comes twice changes neither least nor most.
        others = np.array([[*o, *[o[0]] * (most - len(o))] for _, o in bodies])
        own = np.array([body for body, _ in bodies])
        there, pieces = courses._there, courses._pieces
        together = there[own][:, None] & there[others]
        self.group, stretch = np.nonzero(together.any(1))
        self.durations = courses._durations[stretch]
        self.present = together[self.group, :, stretch]
        mine = pieces[own[self.group], stretch, :2][:, None]
        self.apart = pieces[others[self.group], stretch[:, None], :2] - mine
        away = np.zeros_like(self.apart)
        away[..., 0, 0] = FAR
        self.apart = np.where(self.present[..., None, None], self.apart, away)
        sizes = np.zeros(len(there)) if radii is None else np.asarray(radii, dtype=np.float64)
        self.less = (sizes[own][:, None] + sizes[others])[self.group]
        squared = square(self.apart[..., 0, :]) + square(self.apart[..., 1, :])
        self.squared = bernstein(squared, self.durations[:, None])

    def company(self) -> list[Company]:
        time = _totals(self.group, self.durations, self.count)
        x, y = self.apart[..., 0, :], self.apart[..., 1, :]
        lengths = integral_of_least_length(x, y, self.less, self.durations)
        sums = _totals(self.group, lengths, self.count)
        near, far = self._extremes()
        inside = self._time_within()
        return [
            Company(
                float(time[k]),
                float(sums[k] / time[k]) if time[k] else 0.0,
                float(near[k]) if time[k] else 0.0,
                float(far[k]) if time[k] else 0.0,
                tuple(float(seconds[k]) for seconds in inside),
            )
            for k in range(self.count)
        ]

    def _extremes(self) -> tuple[Array, Array]:
        most = self.present.shape[1]
        row, other = np.nonzero(self.present)
        group = self.group[row] * most + other
        squared = self.squared[row, other]
        less = np.zeros(self.count * most)
        less[group] = self.less[row, other]
        near = np.sqrt(np.maximum(least(squared, group, len(less)), 0.0)) - less
        farthest = -least(-squared, group, len(less))
        far = np.sqrt(np.maximum(farthest, 0.0)) - less
        far[~np.isfinite(farthest)] = -np.inf
        shape = (self.count, most)
        return near.reshape(shape).min(1), far.reshape(shape).max(1)

    def _time_within(self) -> list[Array]:
        """For each distance, the seconds of each body."""
        if not len(self.within):
            return []
        limits = np.maximum(np.asarray(self.within)[:, None, None] + self.less, 0.0)
        excess = (self.squared - (limits**2)[..., None]).reshape(-1, *self.squared.shape[1:])
        inside = time_negative(excess, np.tile(self.durations, len(self.within)))
        rows = inside.reshape(len(self.within), -1)
        return [_totals(self.group, row, self.count) for row in rows]


def _totals(groups: Index, figures: Array, count: int) -> Array:
    """The sum of the figures of each group: (count,)."""
    return np.bincount(groups, figures, count).astype(np.float64)


def _variation(cubics: Array, durations: Array) -> Array:
    """∫ |derivative| dt of cubics (..., 4) on 0 … duration (...)."""
    # Between the zeros of its derivative a cubic is monotone, so its variation is the sum of what
    # it changes from one to the next. Zeros by the form that does not cancel (q, then q / a and c /
    # q).
    a, b, c = 3 * cubics[..., 3], 2 * cubics[..., 2], cubics[..., 1]
    # Without a real zero the root is 0 and what comes out is no turn: as a cut it changes nothing.
    root = np.sqrt(np.maximum(b * b - 4 * a * c, 0.0))
    q = -(b + np.copysign(root, b)) / 2
    with np.errstate(divide="ignore", over="ignore", invalid="ignore"):
        turns = np.sort(np.nan_to_num([q / a, c / q], posinf=0.0, neginf=0.0), axis=0)
    between = [np.zeros_like(durations + a), *np.clip(turns, 0.0, durations), durations + 0.0 * a]
    values = [c * u + cubics[..., 2] * u**2 + cubics[..., 3] * u**3 for u in between]
    return np.asarray(sum(np.abs(w - v) for v, w in itertools.pairwise(values)))
