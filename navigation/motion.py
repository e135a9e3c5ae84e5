"""Motions: the position of a body as piecewise polynomials in time.

A motion is known in closed form until it is replaced. So questions about it ("when do these two get
too close?") are solved instead of sampled.
"""

from __future__ import annotations

import math
from array import array
from bisect import bisect_left, bisect_right
from collections.abc import Callable, Iterable, Iterator, MutableSequence, Sequence
from functools import cached_property
from typing import NamedTuple, overload

import numpy as np
from numpy.typing import ArrayLike, NDArray

from floorplan.files.dataclass import dataclass

from .kernels.numbers import POSE_WIDTH, numbers
from .kernels.pieces import Pack, between, breaks, evaluate, rest, state
from .polynomials import monotone_cubics

Cubic = tuple[float, float, float, float]
"""Coefficients c of c[0] + c[1] u + c[2] u² + c[3] u³ with u the time since a piece began."""

Array = NDArray[np.float64]

Table = MutableSequence[float]
"""Begin, end and the coefficients of x, y and rotation of each piece, one piece after another.

It is a row of `navigation.kernels.numbers`: an `array("d")` or a list.
"""

JUMP_TOLERANCE = 1e-6
"""Metres. A larger distance between consecutive pieces is a jump."""


class Piece(NamedTuple):
    """Part of a motion in which x, y and rotation are cubic functions of time.

    Attributes
    ----------
    begin, end : float
        Begin and end in seconds.
    x, y, rotation : tuple of float
        Coefficients c of c[0] + c[1] u + c[2] u² + c[3] u³ with u the time since `begin`, in metres
        and radians.
    """

    begin: float
    end: float
    x: Cubic
    y: Cubic
    rotation: Cubic

    @property
    def moves(self) -> bool:
        """True if the position changes. Turning on the spot does not count."""
        return any((*self.x[1:], *self.y[1:]))

    @property
    def stands(self) -> bool:
        """True if neither position nor rotation changes."""
        return not (self.moves or any(self.rotation[1:]))

    def cut(self, begin: float, end: float) -> Piece:
        """Return the part between two times within the piece."""
        if begin == self.begin:
            return self._replace(end=end)
        u = begin - self.begin
        return Piece(begin, end, shift(self.x, u), shift(self.y, u), shift(self.rotation, u))


class State(NamedTuple):
    """State of a body at one time: x, y and rotation in metres and radians."""

    position: tuple[float, float, float]
    velocity: tuple[float, float, float]
    acceleration: tuple[float, float, float]

    @property
    def at(self) -> tuple[float, float]:
        """Position on the floor (x, y)."""
        return self.position[:2]

    @property
    def speed(self) -> float:
        """Speed on the floor in m/s."""
        return math.hypot(self.velocity[0], self.velocity[1])


@dataclass(frozen=True)
class Motion:
    """Motion of a body as a function of continuous time.

    It is piecewise cubic, and stationary before `start` and after `end`. `walk`, `gantry_move`,
    `agv_run`, `standing`, `join` and `from_samples` create motions.

    Parameters
    ----------
    pieces : sequence of Piece
        Consecutive pieces without gaps in time.
    jumps : frozenset of float, optional
        Times in seconds at which the position is discontinuous.

    Raises
    ------
    ValueError
        If there is no piece, a gap in time, or an unexpected jump.
    """

    pieces: Sequence[Piece]
    jumps: frozenset[float] = frozenset()

    def __post_init__(self) -> None:
        # Set directly, because a cached property takes a lock, and crowds create many motions.
        fields = vars(self)
        table = fields["table"] = _table(self.pieces)
        if not table:
            raise ValueError("a motion needs at least one piece")
        fields["start"], fields["end"] = table[0], table[1 - POSE_WIDTH]
        for k in breaks(table, JUMP_TOLERANCE):
            piece, before = self.pieces[k], self.pieces[max(k - 1, 0)]
            if piece.end < piece.begin:
                raise ValueError(
                    f"a motion ends at t = {piece.end} s, before it begins at {piece.begin} s"
                )
            if before.end != piece.begin:
                raise ValueError(f"a motion has a gap from t = {before.end} s to {piece.begin} s")
            if piece.begin not in self.jumps:
                parted = gap(before, piece)
                raise ValueError(f"a motion jumps by {parted:.6g} m at t = {piece.begin} s")

    @classmethod
    def from_samples(cls, t: ArrayLike, xy: ArrayLike, rotation: ArrayLike | None = None) -> Motion:
        """Return a motion through samples of a tracked person or of a robot.

        Parameters
        ----------
        t : array_like
            Increasing times in seconds, shape (N,).
        xy : array_like
            Positions in metres, shape (N, 2).
        rotation : array_like, optional
            Rotations in radians, shape (N,). Steps of more than π count as turns the other way. By
            default 0.

        Returns
        -------
        Motion
            Monotone cubics between samples: position and velocity are continuous, and each
            coordinate stays between its two samples.

        Raises
        ------
        ValueError
            If shapes differ, a value is not finite, or times do not increase.
        """
        times, places = np.asarray(t, dtype=float), np.asarray(xy, dtype=float)
        turned = np.zeros(times.shape) if rotation is None else np.asarray(rotation, dtype=float)
        for name, values, shape in (
            ("t", times, (times.size,)),
            ("xy", places, (*times.shape, 2)),
            ("rotation", turned, times.shape),
        ):
            if values.shape == (0,) == shape:
                raise ValueError("a motion needs a sample, found none")
            if values.shape != shape:
                raise ValueError(f"{name} must have the shape {shape}, found {values.shape}")
            if not np.isfinite(values).all():
                k = int(np.argwhere(~np.isfinite(values))[0, 0])
                raise ValueError(f"{name}[{k}] is not finite: {values[k]}")
        if (late := np.flatnonzero(np.diff(times) <= 0)).size:
            k = int(late[0])
            raise ValueError(f"t must rise: t[{k + 1}] = {times[k + 1]} s after {times[k]} s")
        if len(times) == 1:
            return standing(tuple(places[0]), heading=float(turned[0]), start=float(times[0]))
        cubics = monotone_cubics(times, np.column_stack([places, np.unwrap(turned)]))
        x, y, rotations = (list(map(tuple, axis)) for axis in cubics.swapaxes(0, 1).tolist())
        ends = times.tolist()
        return cls(tuple(map(Piece, ends, ends[1:], x, y, rotations)))

    def __reduce__(self) -> tuple[Callable[..., Motion], tuple[array[float], frozenset[float]]]:
        # Kernels may be compiled on one side only.
        return _of_doubles, (array("d", self.table), self.jumps)

    def __repr__(self) -> str:
        count = len(self.pieces)
        pieces = f"{count} piece{'' if count == 1 else 's'}"
        return f"<Motion from t = {self.start:g} s to {self.end:g} s: {pieces}>"

    @cached_property
    def start(self) -> float:
        """Start time in seconds."""
        return self.pieces[0].begin

    @cached_property
    def end(self) -> float:
        """Time in seconds after which the body is stationary."""
        return self.pieces[-1].end

    @property
    def last_begin(self) -> float:
        """Start time of the last piece in seconds."""
        return self.table[-POSE_WIDTH]

    def position(self, t: ArrayLike) -> Array:
        """Return the position at some times.

        Parameters
        ----------
        t : array_like
            Times in seconds, a scalar or shape (N,).

        Returns
        -------
        numpy.ndarray
            x and y in metres, shape (2,) or (N, 2).
        """
        return _value(*self._cubics_at(t))[..., :2]

    def velocity(self, t: ArrayLike) -> Array:
        """Return the velocity at some times.

        Parameters
        ----------
        t : array_like
            Times in seconds, a scalar or shape (N,).

        Returns
        -------
        numpy.ndarray
            Velocity in m/s, shape (2,) or (N, 2). At a change it is the velocity after it.
        """
        return np.where(self._moves(t)[..., None], _slope(*self._cubics_at(t)), 0.0)[..., :2]

    def rotation(self, t: ArrayLike) -> Array:
        """Return the rotation at some times.

        Parameters
        ----------
        t : array_like
            Times in seconds, a scalar or shape (N,).

        Returns
        -------
        numpy.ndarray
            Rotation in radians, shape () or (N,): 0 along x, counterclockwise.
        """
        return _value(*self._cubics_at(t))[..., 2]

    def cubics(self, t: ArrayLike) -> Array:
        """Return x, y and rotation as cubics of the time since each of `t` (s): shape (..., 3, 4).

        They are valid until the next change.
        """
        u, c = self._cubics_at(t)
        cubics = np.stack(
            (_value(u, c), _slope(u, c), c[..., 2] + u * 3 * c[..., 3], c[..., 3]), -1
        )
        cubics[~self._moves(t), :, 1:] = 0.0
        return cubics

    def state(self, t: float) -> State:
        """Return position, velocity and acceleration at `t` (seconds)."""
        cache = self.__dict__
        last: tuple[float, State] | None = cache.get("known")
        if last is not None and last[0] == t:
            return last[1]
        t = float(t)
        evaluated = State(*state(self.table, t))
        # A motion never changes, so the cache stays valid.
        cache["known"] = (t, evaluated)
        return evaluated

    def state_before(self, t: float) -> State:
        """Return the state just before `t`, before a change or a jump at that time."""
        t = float(t)
        # The last piece that began before t.
        row = max(0, bisect_left(self._begins, t) - 1)
        return State(*evaluate(self.table, row, t, self.start < t <= self.end))

    def cut(self, begin: float, end: float) -> Motion:
        """Return the motion from `begin` to `end` (seconds), including stationary parts."""
        table = between(self.table, float(begin), float(end))
        jumps = frozenset(t for t in self.jumps if begin < t < end) if self.jumps else self.jumps
        return motion_of(table, jumps)

    def translated(self, dx: float, dy: float) -> Motion:
        """Return the motion shifted by `dx` and `dy` metres."""
        if dx == dy == 0.0:
            return self
        pieces = [
            piece._replace(x=(piece.x[0] + dx, *piece.x[1:]), y=(piece.y[0] + dy, *piece.y[1:]))
            for piece in self.pieces
        ]
        return Motion(tuple(pieces), self.jumps)

    def pieces_from(self, t: float, until: float = math.inf) -> Sequence[Piece]:
        """Return the pieces that end after `t` and begin before `until` (seconds)."""
        first = max(0, bisect_right(self._begins, t) - 1)
        return self.pieces[first : bisect_left(self._begins, until)]

    @cached_property
    def _begins(self) -> Sequence[float]:
        return self.table[::POSE_WIDTH]

    @cached_property
    def table(self) -> Table:
        """Begin, end and coefficients of x, y and rotation of each piece: see `Table`."""
        return _table(self.pieces)

    @cached_property
    def _tables(self) -> tuple[Array, Array, Array]:
        """Begins (P,), durations (P,) and coefficients (P, 3, 4)."""
        rows = np.array(self.table).reshape(-1, POSE_WIDTH)
        return rows[:, 0], rows[:, 1] - rows[:, 0], rows[:, 2:].reshape(-1, 3, 4)

    def _cubics_at(self, t: ArrayLike) -> tuple[Array, Array]:
        """Return the cubics at each `t`, and the time since their begins: (..., 1)."""
        times = np.asarray(t, dtype=np.float64)
        begins, durations, table = self._tables
        # Among pieces that begin at the same time, the last applies.
        index = np.maximum(np.searchsorted(begins, times, side="right") - 1, 0)
        return np.clip(times - begins[index], 0.0, durations[index])[..., None], table[index]

    def _moves(self, t: ArrayLike) -> NDArray[np.bool_]:
        times = np.asarray(t, dtype=np.float64)
        return (times >= self.start) & (times < self.end)


def _value(u: Array, c: Array) -> Array:
    return np.asarray(c[..., 0] + u * (c[..., 1] + u * (c[..., 2] + u * c[..., 3])))


def _slope(u: Array, c: Array) -> Array:
    return np.asarray(c[..., 1] + u * (2 * c[..., 2] + u * 3 * c[..., 3]))


def _table(pieces: Sequence[Piece]) -> Table:
    """Return the table of pieces."""
    flat: Callable[[], Table] | None = getattr(pieces, "flat", None)
    if flat is not None:
        return flat()
    return numbers([c for p in pieces for c in (p.begin, p.end, *p.x, *p.y, *p.rotation)])


def pieces_of(table: Table) -> Iterator[Piece]:
    """Yield the pieces of a motion's table."""
    rows = zip(*[iter(table)] * POSE_WIDTH, strict=True)
    for begin, end, x0, x1, x2, x3, y0, y1, y2, y3, r0, r1, r2, r3 in rows:
        yield Piece(begin, end, (x0, x1, x2, x3), (y0, y1, y2, y3), (r0, r1, r2, r3))


class TablePieces(Sequence[Piece]):
    """Pieces that are created from a motion's table on access."""

    def __init__(self, table: Table) -> None:
        self._numbers = table

    def __len__(self) -> int:
        return len(self._numbers) // POSE_WIDTH

    def __iter__(self) -> Iterator[Piece]:
        return pieces_of(self.flat())

    @overload
    def __getitem__(self, index: int) -> Piece: ...

    @overload
    def __getitem__(self, index: slice) -> Sequence[Piece]: ...

    def __getitem__(self, index: int | slice) -> Piece | Sequence[Piece]:
        if isinstance(index, slice):
            first, last, step = index.indices(len(self))
            if step != 1:
                return tuple(self[k] for k in range(first, last, step))
            return tuple(pieces_of(self._numbers[first * POSE_WIDTH : last * POSE_WIDTH]))
        k = range(0, len(self._numbers), POSE_WIDTH)[index]
        return next(pieces_of(self._numbers[k : k + POSE_WIDTH]))

    def flat(self) -> Table:
        """Return the table."""
        return self._numbers

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, (TablePieces, tuple)):
            return NotImplemented
        return tuple(self) == tuple(other)

    def __hash__(self) -> int:
        return hash(tuple(self))


def motion_of(table: Table, jumps: frozenset[float] = frozenset()) -> Motion:
    """Return the motion of a valid table without checks."""
    motion = object.__new__(Motion)
    fields = vars(motion)  # what a frozen dataclass sets, and what `Motion` keeps
    fields["pieces"], fields["jumps"], fields["table"] = TablePieces(table), jumps, table
    fields["start"], fields["end"] = table[0], table[1 - POSE_WIDTH]
    return motion


def _of_doubles(values: array[float], jumps: frozenset[float]) -> Motion:
    return motion_of(numbers(values), jumps)


def standing(at: tuple[float, float], *, heading: float = 0.0, start: float = 0.0) -> Motion:
    """Return the motion of a stationary body.

    Parameters
    ----------
    at : tuple of float
        Position (x, y) in metres.
    heading : float, optional
        Rotation in radians.
    start : float, optional
        Start time in seconds.

    Returns
    -------
    Motion
        Motion without end.
    """
    start = float(start)
    return Motion(TablePieces(rest(start, start, float(at[0]), float(at[1]), float(heading))))


def still(at: tuple[float, float, float], begin: float, end: float) -> Piece:
    """Return a stationary piece at `at` (x, y, rotation) from `begin` to `end` (seconds)."""
    x, y, rotation = (float(c) for c in at)
    along_x, along_y, turning = ((c, 0.0, 0.0, 0.0) for c in (x, y, rotation))
    return Piece(float(begin), float(end), along_x, along_y, turning)


def join(motions: Iterable[Motion], *, end: float | None = None) -> Motion:
    """Return motions one after another as one motion.

    Parameters
    ----------
    motions : iterable of Motion
        Motions in the order of their starts. Each is valid until the next starts.
    end : float, optional
        End of the last motion in seconds.

    Returns
    -------
    Motion
        Motion that is stationary in between. It jumps if a motion starts elsewhere.
    """
    table = numbers([])
    jumps: set[float] = set()
    for motion in motions:
        if table:
            _stand_until(table, motion.start)
            if math.dist(_pose_at_end(table)[:2], motion.table[2:10:4]) > JUMP_TOLERANCE:
                jumps.add(motion.start)
        table += motion.table
        jumps |= motion.jumps
    if end is not None:
        _stand_until(table, float(end))
    return Motion(TablePieces(table), frozenset(jumps))


def _stand_until(table: Table, t: float) -> None:
    """End a table at `t`: remove later pieces, or add a rest."""
    while len(table) > POSE_WIDTH and table[-POSE_WIDTH] >= t:
        del table[-POSE_WIDTH:]
    end = table[1 - POSE_WIDTH]
    if end > t:
        table[1 - POSE_WIDTH] = t
    elif end < t:
        at = _pose_at_end(table)
        # The new rest replaces a piece without length.
        if end == table[-POSE_WIDTH]:
            del table[-POSE_WIDTH:]
        table += rest(end, t, *at)


def _pose_at_end(table: Table) -> tuple[float, float, float]:
    """Return x, y and rotation at the end of the last piece of a table."""
    (piece,) = pieces_of(table[-POSE_WIDTH:])
    u = piece.end - piece.begin
    return value(piece.x, u), value(piece.y, u), value(piece.rotation, u)


def gap(before: Piece, after: Piece) -> float:
    """Return the distance between the end of one piece and the beginning of the next (metres)."""
    u = before.end - before.begin
    return math.hypot(value(before.x, u) - after.x[0], value(before.y, u) - after.y[0])


def value(c: Cubic, u: float) -> float:
    """Return the cubic `c` at `u` seconds after its begin."""
    return c[0] + u * (c[1] + u * (c[2] + u * c[3]))


def shift(c: Cubic, u: float) -> Cubic:
    """Return the same cubic relative to `u` seconds later."""
    return (
        value(c, u),
        c[1] + u * (2 * c[2] + u * 3 * c[3]),
        c[2] + u * 3 * c[3],
        c[3],
    )


class Track:
    """Recorder of successive motions of a body."""

    def __init__(self) -> None:
        self._pack = Pack()
        self._jumps: set[float] = set()
        self._end: float | None = None

    def __repr__(self) -> str:
        return f"<Track of {self._pack.count} pieces>"

    def __bool__(self) -> bool:
        return self._end is not None

    def add(self, motion: Motion, begin: float, end: float) -> None:
        """Append `motion` from `begin` to `end` (s). `ValueError` if there is a gap in time.

        A start at another position is a jump.
        """
        if self._end is not None and self._end != begin:
            raise ValueError(f"a track has a gap from t = {self._end} s to {begin} s")
        self._end = end
        if self._pack.add(motion.table, begin, end, JUMP_TOLERANCE):
            self._jumps.add(begin)
        if motion.jumps:
            self._jumps.update(t for t in motion.jumps if begin < t < end)

    def motion(self) -> Motion:
        """Return everything so far as one motion."""
        return Motion(TablePieces(self._pack.pieces()), frozenset(self._jumps))
