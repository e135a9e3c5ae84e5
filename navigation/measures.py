"""Measures of motions: length, turning, time stationary, and minimum distances between bodies.

They are computed from the polynomials of the motions, for all bodies together, without sampling.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator, Sequence
from functools import cached_property
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from floorplan.files.dataclass import dataclass

from .kernels.discs import DiscWindow, first_conflict
from .monitor import minimum_separation
from .motion import Motion, join, standing
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
from .walking import swath

FAR = 1e6
"""Metres. Place of an absent body, which is near no other body."""

_LARGEST = 2**16
"""Number of cubics between two bodies that are processed together. Each has some hundred values."""


@dataclass(frozen=True)
class Company:
    """Distances of a body from others, while any of them was present.

    `mean` is the mean over time of the distance to the nearest of them. `minimum` and `maximum` are
    over all of them (metres). `within` has the duration for which the nearest was closer than each
    limit (seconds). Without a common `time` (seconds) all values are 0.
    """

    time: float
    mean: float
    minimum: float
    maximum: float
    within: tuple[float, ...]


class Courses:
    """Motions of several bodies, each over its own time span.

    `spans` has (begin, end) in seconds for each motion. Array results have one value per motion. A
    jump to another place adds neither length nor turning.
    """

    def __init__(self, motions: Sequence[Motion], spans: Sequence[tuple[float, float]]) -> None:
        for begin, end in spans:
            if not (math.isfinite(begin) and math.isfinite(end) and begin <= end):
                raise ValueError(f"can't look from {begin} s to {end} s")
        self._motions = motions
        self._spans = np.array(spans, dtype=np.float64).reshape(-1, 2)

    @cached_property
    def time(self) -> Array:
        """Duration of each span in seconds."""
        return np.asarray(self._spans[:, 1] - self._spans[:, 0])

    @cached_property
    def length(self) -> Array:
        """Path length in metres: ∫ |v| dt."""
        return self._integrated(self._velocity)

    @cached_property
    def acceleration(self) -> Array:
        """∫ |a| dt in m/s, without the sudden turns of a walker at a corner."""
        return self._integrated(derivative(self._velocity))

    @cached_property
    def jerk(self) -> Array:
        """∫ |j| dt in m/s², without steps of the acceleration."""
        third = derivative(derivative(self._velocity))[..., 0]
        return self._summed(np.hypot(third[:, 0], third[:, 1]) * self._stretches.durations)

    @cached_property
    def top_speed(self) -> Array:
        """Maximum speed in m/s."""
        fastest = -least(-self._speed_squared, self._stretches.body, len(self._motions))
        return np.sqrt(np.where(np.isfinite(fastest), np.maximum(fastest, 0.0), 0.0))

    @cached_property
    def turning(self) -> Array:
        """Angle of turns in both directions in radians: ∫ |ω| dt and sudden turns."""
        rotation = self._stretches.pieces[:, 2]
        return self._summed(_variation(rotation, self._stretches.durations)) + self._sudden_turns()

    def time_not_moving(self, speed: float, turning: float) -> Array:
        """Return the duration (s) with less than `speed` (m/s) and less than `turning` (rad/s)."""
        durations = self._stretches.durations
        spin = bernstein(square(derivative(self._stretches.pieces[:, 2])), durations)
        excess = np.stack([speed**2 - self._speed_squared, turning**2 - spin], axis=1)
        return self._summed(durations - time_negative(excess, durations))

    def company(
        self,
        bodies: Sequence[tuple[int, Sequence[int]]],
        within: Sequence[float] = (),
        radii: Sequence[float] | None = None,
    ) -> list[Company]:
        """Return the distances of each body from the nearest of given others, by index.

        Distances are between centres, minus the `radii` (metres) of both bodies if present. For
        each distance of `within` (metres), the result has the duration with a smaller distance.
        """
        sizes = np.zeros(len(self._motions)) if radii is None else np.asarray(radii, np.float64)
        total = _Tally(len(bodies), len(within))
        for meetings in self._meetings(bodies, sizes):
            meetings.add_to(total, within)
        return total.companies()

    def _meetings(
        self, bodies: Sequence[tuple[int, Sequence[int]]], sizes: Array
    ) -> Iterator[_Meetings]:
        """Yield the relative motions of bodies in batches of limited size."""
        for size, batch in itertools.groupby(enumerate(bodies), lambda one: len(one[1][1])):
            longest = max(_LARGEST // max(size, 1), 1)
            pending: list[_Meetings] = []
            for group, (body, others) in batch:
                beside = self._beside(group, body, others, sizes)
                for first in range(0, len(beside.groups), longest):
                    part = beside.part(first, first + longest)
                    if sum(len(one.groups) for one in pending) + len(part.groups) > longest:
                        yield _Meetings.of(pending)
                        pending = []
                    pending.append(part)
            if pending:
                yield _Meetings.of(pending)

    def _beside(self, group: int, body: int, others: Sequence[int], sizes: Array) -> _Meetings:
        members = [body, *others]
        # Divide time only where one of these motions changes, not all of them.
        motions = [self._motions[member] for member in members]
        durations, there, pieces = _common_stretches(motions, self._spans[members])
        present = (there[:1] & there[1:]).T
        rows = np.flatnonzero(present.any(1))
        apart = (pieces[1:, rows, :2] - pieces[:1, rows, :2]).swapaxes(0, 1)
        away = np.zeros(apart.shape[1:])
        away[:, 0, 0] = FAR
        return _Meetings(
            np.full(len(rows), group),
            durations[rows],
            present[rows],
            np.where(present[rows][..., None, None], apart, away),
            np.broadcast_to(sizes[body] + sizes[list(others)], (len(rows), len(others))),
        )

    @cached_property
    def _stretches(self) -> _Stretches:
        """Stretches of all motions, one motion after another."""
        cuts = [
            _cuts([one], span[None]) for one, span in zip(self._motions, self._spans, strict=True)
        ]
        begins = list(zip(self._motions, (times[:-1] for times in cuts), strict=True))
        return _Stretches(
            np.repeat(np.arange(len(cuts)), [len(times) for _, times in begins]),
            np.concatenate([np.empty(0), *map(np.diff, cuts)]),
            np.concatenate([np.empty(0, bool), *(np.isin(t, list(m.jumps)) for m, t in begins)]),
            np.concatenate([np.empty((0, 3, 4)), *(m.cubics(t) for m, t in begins)]),
        )

    @cached_property
    def _velocity(self) -> Array:
        """Velocity along x and y in each stretch: (S, 2, 3)."""
        return derivative(self._stretches.pieces[:, :2])

    @cached_property
    def _speed_squared(self) -> Array:
        x, y = self._velocity.swapaxes(0, 1)
        return bernstein(square(x) + square(y), self._stretches.durations)

    def _integrated(self, vectors: Array) -> Array:
        """Return ∫ |vectors| dt of each motion, for polynomials (S, 2, n)."""
        x, y = vectors[:, :1], vectors[:, 1:]
        nothing = np.zeros((len(vectors), 1))
        return self._summed(integral_of_least_length(x, y, nothing, self._stretches.durations))

    def _summed(self, figures: Array) -> Array:
        """Return the sum of the values (S,) of each motion's stretches."""
        return _totals(self._stretches.body, figures, len(self._motions))

    def _sudden_turns(self) -> Array:
        """Return the sum of the angles of sudden turns (radians)."""
        body, durations, jumped, pieces = self._stretches
        rotation, u = pieces[:, 2], durations
        ends = rotation[:, 0] + u * (rotation[:, 1] + u * (rotation[:, 2] + u * rotation[:, 3]))
        turns = rotation[1:, 0] - ends[:-1]
        # The shorter direction, because headings that differ by a whole turn are the same.
        turns = np.abs(turns - math.tau * np.round(turns / math.tau))
        counts = (body[1:] == body[:-1]) & ~jumped[1:]
        return _totals(body[1:], turns * counts, len(self._motions))


class _Stretches(NamedTuple):
    """Stretches of several motions, in each of which the motion is one cubic."""

    body: Index
    """Index of the motion: (S,)."""
    durations: Array
    """Seconds: (S,)."""
    jumped: NDArray[np.bool_]
    """Whether the motion jumps at the begin: (S,)."""
    pieces: Array
    """x, y and rotation since the begin: (S, 3, 4)."""


@dataclass(frozen=True)
class _Meetings:
    """Relative motions of bodies and others, with a row for every stretch with any other body."""

    groups: Index
    """Index of the body of each row: (M,)."""
    durations: Array
    """Seconds: (M,)."""
    present: NDArray[np.bool_]
    """Mask of the others that are present: (M, others)."""
    apart: Array
    """Vectors from the body to each of the others, as cubics: (M, others, 2, 4)."""
    less: Array
    """Sum of both radii in metres: (M, others)."""

    @classmethod
    def of(cls, parts: Sequence[_Meetings]) -> _Meetings:
        return cls(*map(np.concatenate, zip(*(part._columns for part in parts), strict=True)))

    def part(self, begin: int, end: int) -> _Meetings:
        groups, durations, present, apart, less = self._columns
        rows = slice(begin, end)
        return _Meetings(groups[rows], durations[rows], present[rows], apart[rows], less[rows])

    def add_to(self, total: _Tally, within: Sequence[float]) -> None:
        x, y = self.apart[..., 0, :], self.apart[..., 1, :]
        count = len(total.time)
        total.time += _totals(self.groups, self.durations, count)
        lengths = integral_of_least_length(x, y, self.less, self.durations)
        total.sums += _totals(self.groups, lengths, count)
        squared = bernstein(square(x) + square(y), self.durations[:, None])
        near, far = self._extremes(squared, count)
        np.minimum(total.near, near, out=total.near)
        np.maximum(total.far, far, out=total.far)
        for k, distance in enumerate(within):
            limits = np.maximum(distance + self.less, 0.0)
            inside = time_negative(squared - (limits**2)[..., None], self.durations)
            total.inside[k] += _totals(self.groups, inside, count)

    @property
    def _columns(self) -> tuple[Index, Array, NDArray[np.bool_], Array, Array]:
        return self.groups, self.durations, self.present, self.apart, self.less

    def _extremes(self, squared: Array, count: int) -> tuple[Array, Array]:
        """Return the minimum and maximum distance of each body: (count,) of metres."""
        size = self.present.shape[1]
        row, other = np.nonzero(self.present)
        group = self.groups[row] * size + other
        squared = squared[row, other]
        less = np.zeros(count * size)
        less[group] = self.less[row, other]
        near = np.sqrt(np.maximum(least(squared, group, len(less)), 0.0)) - less
        farthest = -least(-squared, group, len(less))
        far = np.sqrt(np.maximum(farthest, 0.0)) - less
        far[~np.isfinite(farthest)] = -np.inf
        shape = (count, size)
        return near.reshape(shape).min(1), far.reshape(shape).max(1)


class _Tally:
    """Sums and extremes of the distances of `count` bodies."""

    def __init__(self, count: int, limits: int) -> None:
        self.time, self.sums = np.zeros((2, count))
        self.near, self.far = np.full(count, np.inf), np.full(count, -np.inf)
        self.inside = np.zeros((limits, count))

    def companies(self) -> list[Company]:
        return [
            Company(
                float(time),
                float(self.sums[k] / time) if time else 0.0,
                float(self.near[k]) if time else 0.0,
                float(self.far[k]) if time else 0.0,
                tuple(map(float, self.inside[:, k])),
            )
            for k, time in enumerate(self.time)
        ]


class _CommonStretches(NamedTuple):
    """Stretches of several motions: durations (S,), presence (motions, S), and cubics.

    The cubics have the shape (motions, S, 3, 4).
    """

    durations: Array
    there: NDArray[np.bool_]
    cubics: Array


def _common_stretches(motions: Sequence[Motion], spans: Array) -> _CommonStretches:
    """Return stretches in each of which every motion is one cubic."""
    cuts = _cuts(motions, spans)
    begins = cuts[:-1]
    there = (spans[:, :1] <= begins) & (begins < spans[:, 1:])
    cubics = np.array([motion.cubics(begins) for motion in motions])
    return _CommonStretches(np.diff(cuts), there, cubics)


def _cuts(motions: Sequence[Motion], spans: Array) -> Array:
    if not len(spans):
        return np.zeros(1)
    times = [spans.ravel()]
    for motion in motions:
        pieces = motion.pieces
        times.append(np.array([pieces[0].begin, *(piece.end for piece in pieces)]))
    cuts = np.unique(np.concatenate(times))
    return np.asarray(cuts[(spans.min() <= cuts) & (cuts <= spans.max())])


def _totals(groups: Index, figures: Array, count: int) -> Array:
    """Return the sum of the values of each group: (count,)."""
    return np.bincount(groups, figures, count).astype(np.float64)


def _variation(cubics: Array, durations: Array) -> Array:
    """∫ |derivative| dt of cubics (..., 4) on 0 … duration (...)."""
    # Between the zeros of its derivative a cubic is monotonic, so its variation is the sum of its
    # changes between them. The zeros are q / a and c / q, without cancellation.
    a, b, c = 3 * cubics[..., 3], 2 * cubics[..., 2], cubics[..., 1]
    # Without a real zero the root is 0. The additional cut then changes nothing.
    root = np.sqrt(np.maximum(b * b - 4 * a * c, 0.0))
    q = -(b + np.copysign(root, b)) / 2
    with np.errstate(divide="ignore", over="ignore", invalid="ignore"):
        turns = np.sort(np.nan_to_num([q / a, c / q], posinf=0.0, neginf=0.0), axis=0)
    between = [np.zeros_like(durations + a), *np.clip(turns, 0.0, durations), durations + 0.0 * a]
    values = [c * u + cubics[..., 2] * u**2 + cubics[..., 3] * u**3 for u in between]
    return np.asarray(sum(np.abs(w - v) for v, w in itertools.pairwise(values)))


STEP = 0.1
"""Seconds between the times at which all pairs are compared first."""

WINDOW = 512
"""Number of times per window. Bodies that are far from others throughout a window are skipped, and
memory does not grow with the duration of a run."""

AWAY = 1e8
"""Metres. Offset of absent bodies, from the floor and from each other."""

_HAIR = 1e-9


class Nearest(NamedTuple):
    """Minimum distance of two surfaces (metres), its time (seconds), and the indices of both.

    `overlaps` is the number of pairs that overlapped at any time.
    """

    distance: float
    time: float
    pair: tuple[int, int]
    overlaps: int


def nearest_pair(
    motions: Sequence[Motion],
    radii: Sequence[float],
    top_speeds: Sequence[float],
    begin: float,
    end: float,
    spans: Sequence[Sequence[tuple[float, float]]] | None = None,
) -> Nearest | None:
    """Return the minimum distance between any two of several discs from `begin` to `end` (s).

    `motions` are those of their centres, `radii` in metres, and `top_speeds` (m/s) are bounds
    except at jumps. With `spans`, each disc is present only in given intervals (s). The result is
    None if no two are present together. It is as exact as `minimum_separation`: between two
    sampled times, the distances at both and the speeds bound the distance of a pair. If the bound
    is below the minimum so far, the kernel tests the pair, and the monitor solves for the minimum.
    """
    if spans is not None:
        motions = [
            _present(motion, stays, begin, end, AWAY * (k + 1))
            for k, (motion, stays) in enumerate(zip(motions, spans, strict=True))
        ]
    if len(motions) < 2:
        return None
    count = max(math.ceil((end - begin) / STEP), 1)
    t = np.linspace(begin, end, count + 1)
    times = t.tolist()
    tables = [swath(_reaching_back(motion, begin), begin).table for motion in motions]
    sizes = [*map(float, radii)]
    steps = [float(speed * (t[1] - t[0])) for speed in top_speeds]
    jumps = [_intervals(t, sorted(motion.jumps)) for motion in motions]
    discs = DiscWindow(tables, sizes, steps, jumps)
    # First an upper bound, the minimum over the sampled times.
    nearest = math.inf
    for _ in _windows(discs, times):
        one, other, at, metres = discs.nearest(nearest)
        if metres < nearest:
            nearest, i, j, k = metres, one, other, at
            apart = math.dist(discs.centre(i, k), discs.centre(j, k)) - (radii[i] + radii[j])
    best = (apart, times[k], (i, j))
    overlapping: set[tuple[int, int]] = set()
    nearer = [
        crossing
        for _ in _windows(discs, times)
        for crossing in discs.nearer_between(max(apart, 0.0))
    ]
    for i, j, k in sorted(nearer):
        least, since, until = radii[i] + radii[j], times[k], times[k + 1]
        nearer_than = least + max(best[0], 0.0) - _HAIR
        if first_conflict(tables[i], tables[j], nearer_than, since, until) > until:
            continue
        when, centres = minimum_separation(motions[i], motions[j], since, until)
        if centres - least < -_HAIR:
            overlapping.add((i, j))
        best = min(best, (centres - least, when, (i, j)))
    if spans is not None and best[0] > AWAY / 2:
        return None
    return Nearest(*best, len(overlapping))


def _present(
    motion: Motion, stays: Sequence[tuple[float, float]], begin: float, end: float, away: float
) -> Motion:
    """Return a motion from `begin` to `end` (s), moved by `away` metres except in `stays` (s)."""
    parts: list[Motion] = []
    off, absent = (away, away), begin
    for since, until in ((max(a, begin), min(b, end)) for a, b in stays):
        if since <= begin and until >= end:
            return motion
        if since < until:
            parts += [standing(off, start=absent)] if since > absent else []
            parts.append(motion.cut(since, until))
            absent = until
    if absent < end or not parts:
        parts.append(standing(off, start=absent))
    return join(parts, end=end)


def _reaching_back(motion: Motion, begin: float) -> Motion:
    """Return a motion that stands from `begin` (s) until it starts, for the kernels."""
    if motion.start <= begin:
        return motion
    x, y, heading = motion.state(begin).position
    return join([standing((x, y), heading=heading, start=begin), motion])


def _windows(discs: DiscWindow, times: list[float]) -> Iterator[None]:
    """Advance discs through the windows of `times`. Consecutive windows share a time."""
    for first in range(0, len(times) - 1, WINDOW):
        discs.see(first, times[first : first + WINDOW + 1])
        yield


def _intervals(t: NDArray[np.float64], instants: Sequence[float]) -> list[float]:
    """Return the sorted indices of the intervals of `t` that contain `instants`, as floats."""
    index = np.clip(np.searchsorted(t, instants, side="right") - 1, 0, len(t) - 2)
    return [float(k) for k in index]
