"""Protective fields of a machine: areas about it in which a person slows or stops it.

A safety scanner has sets of fields, and the speed of the machine chooses among them.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator, Sequence
from dataclasses import fields, replace
from functools import cached_property
from operator import itemgetter
from typing import Annotated, Any, Literal, NamedTuple

from pydantic import AfterValidator
from shapely.geometry import Polygon

from floorplan import UserError
from floorplan.checks import polygon_fault
from floorplan.files.dataclass import dataclass
from floorplan.files.fields import Constrained, Flag, Pair
from floorplan.files.forms import KEYS

from .kernels.fields import FieldSearch, FieldSwitches
from .kernels.numbers import numbers
from .motion import Motion

Corners = tuple[tuple[float, float], ...]

FieldKind = Literal["protective", "warning"]

KINDS: tuple[FieldKind, ...] = ("protective", "warning")

SPEED_TOLERANCE = 1e-4
"""Tolerance of limits of sets in m/s and rad/s, because a body on an arc is a spline."""

UNBOUNDED = (-math.inf, math.inf)

_Range = tuple[float, float]


def _read_corners(corners: Corners) -> Corners:
    few = f"must have 3 corners or more, not {len(corners)}" if len(corners) < 3 else ""
    if fault := few or polygon_fault(Polygon(corners)):
        raise UserError(fault)
    return corners


def _read_range(pair: _Range) -> _Range:
    if pair[0] > pair[1]:
        raise UserError(f"must be [low, high] with low <= high, found {list(pair)}")
    return pair


_CornersKey = Annotated[tuple[Pair, ...], AfterValidator(_read_corners)]
_RangeKey = Annotated[Pair, AfterValidator(_read_range)]


@dataclass(frozen=True, kw_only=True, repr=False)
class FieldSet:
    """Fields of a machine, and the velocities at which they apply.

    Parameters
    ----------
    name : str
        Name in reports.
    protective : sequence of tuple of float
        Corners of the protective field in the frame of the machine, metres: x forwards, y to the
        left. The polygon may be concave.
    warning : sequence of tuple of float, optional
        Corners of the warning field. It is optional.
    linear : tuple of float, optional
        Minimum and maximum of the speed along the heading, m/s. Backwards is negative.
    theta : tuple of float, optional
        Minimum and maximum of the turn rate, rad/s, counterclockwise.
    direction : tuple of float, optional
        First and last direction of travel from the heading, radians counterclockwise. With it,
        `linear` is of the speed over the floor, which is never negative. At rest every direction
        fits.
    load : bool, optional
        Whether the machine must be loaded, or must not be. By default both fit.

    Raises
    ------
    UserError
        If a polygon is none, or a range is empty or not a number.

    Notes
    -----
    The keys are those of Nav2's velocity polygons (`linear_min`, `theta_max`,
    `direction_start_angle`, …). Limits are inclusive, within 0.0001 m/s and rad/s.
    """

    __pydantic_config__ = KEYS

    name: Annotated[str, Constrained(min_length=1)]
    protective: _CornersKey
    warning: _CornersKey = ()
    linear: _RangeKey = UNBOUNDED
    theta: _RangeKey = UNBOUNDED
    direction: _RangeKey | None = None
    load: Flag | None = None

    def __repr__(self) -> str:
        corners = f"{len(self.protective)} and {len(self.warning)} corners"
        return f"<FieldSet {self.name!r} at {self.linear} m/s, {self.theta} rad/s: {corners}>"

    def __post_init__(self) -> None:
        put = object.__setattr__
        if not isinstance(self.name, str) or not self.name:
            raise UserError(f"name of a field set must be a text, not {self.name!r}")
        put(self, "protective", _polygon(self.protective, f"{self.name}: protective"))
        if len(self.warning):
            put(self, "warning", _polygon(self.warning, f"{self.name}: warning"))
        else:
            put(self, "warning", ())
        put(self, "linear", _range(self.linear, f"{self.name}: linear"))
        put(self, "theta", _range(self.theta, f"{self.name}: theta"))
        if self.direction is not None:
            put(self, "direction", _directions(self.direction, f"{self.name}: direction"))
        if self.load not in (True, False, None):
            raise UserError(f"{self.name}: load must be true or false, not {self.load!r}")

    def __getstate__(self) -> dict[str, Any]:
        return _state(self)

    def fits_load(self, loaded: bool) -> bool:
        """Return whether the set applies to a machine that is `loaded` or not."""
        return self.load in (None, loaded)

    def corners(self, field: FieldKind) -> Corners:
        """Return the corners of a field."""
        return self.protective if field == "protective" else self.warning

    @cached_property
    def _speeds(self) -> list[float]:
        """Values of the set for the kernel, with the tolerance."""
        low, high = self.linear
        turn_low, turn_high = self.theta
        eps = SPEED_TOLERANCE
        ranges = [low - eps, high + eps, turn_low - eps, turn_high + eps]
        if self.direction is None:
            return [*ranges, 0.0, 1.0, 0.0, 1.0, 0.0, eps]
        a, b = self.direction
        wide = 2.0 if b - a > math.pi else 1.0
        return [*ranges, wide, math.cos(a), math.sin(a), math.cos(b), math.sin(b), eps]

    @cached_property
    def searches(self) -> dict[FieldKind, FieldSearch]:
        """Searches for contacts with each field of the set."""
        searches: dict[FieldKind, FieldSearch] = {}
        for field in KINDS:
            corners = self.corners(field)
            edges = zip(corners, (*corners[1:], *corners[:1]), strict=True)
            if corners:
                searches[field] = FieldSearch(numbers([c for a, b in edges for c in (*a, *b)]))
        return searches


class FieldSpan(NamedTuple):
    """Time span (seconds) in which a set applies, or none."""

    begin: float
    end: float
    set: FieldSet | None


class FieldGap(NamedTuple):
    """Velocities without a set: ranges as in `FieldSet`."""

    linear: tuple[float, float]
    theta: tuple[float, float]
    direction: tuple[float, float] | None
    loaded: bool


@dataclass(frozen=True, kw_only=True)
class ProtectiveFields:
    """Field sets of a machine. The first that fits its velocity and load applies.

    Parameters
    ----------
    sets : sequence of FieldSet
        Sets in the order of their priority. Either all of them have a `direction` or none.
    response_time : float, optional
        Time from a contact to the begin of braking, s: of the sensor, the control and the brakes.
        Instants of contacts do not contain it.

    Raises
    ------
    UserError
        If there is no set, two have the same name, or the time is negative or not finite.
    """

    sets: tuple[FieldSet, ...]
    response_time: float = 0.0

    def __post_init__(self) -> None:
        object.__setattr__(self, "sets", tuple(self.sets))
        if not self.sets:
            raise UserError("sets must have a field set")
        names = [each.name for each in self.sets]
        for name in names:
            if names.count(name) > 1:
                raise UserError(f"sets must have different names, not {name!r} twice")
        if len({each.direction is None for each in self.sets}) > 1:
            raise UserError("either all sets must have a direction or none")
        if not 0 <= self.response_time < math.inf:
            raise UserError(f"response_time must be 0 or more, not {self.response_time}")

    def __getstate__(self) -> dict[str, Any]:
        return _state(self)

    @cached_property
    def reach(self) -> float:
        """Radius of the circle around the machine's axis that contains all fields, in metres."""
        return max(math.hypot(*c) for each in self.sets for c in (*each.protective, *each.warning))

    def applying(
        self, machine: Motion, begin: float, end: float, loaded: bool = False
    ) -> tuple[FieldSpan, ...]:
        """Return which set applies at which time.

        Parameters
        ----------
        machine : Motion
            Motion of the machine.
        begin, end : float
            Time span, s. Both are finite.
        loaded : bool, optional
            Whether the machine is loaded.

        Returns
        -------
        tuple of FieldSpan
            Consecutive spans, with switches solved to 1 ns.
        """
        spans = []
        rows = self._switches(machine, loaded)
        for (since, k), (until, _) in itertools.pairwise([*rows, (math.inf, -1)]):
            if (since < end and until > begin) or since <= begin == end < until:
                chosen = None if k < 0 else self._for(loaded)[k]
                spans.append(FieldSpan(max(since, begin), min(until, end), chosen))
        return tuple(spans)

    def gaps(
        self,
        linear: tuple[float, float],
        theta: tuple[float, float] = (0.0, 0.0),
        directions: Sequence[float] | None = None,
    ) -> tuple[FieldGap, ...]:
        """Return the velocities of a machine without a set.

        Parameters
        ----------
        linear, theta : tuple of float
            Ranges of the machine's velocity, in m/s and rad/s. If the sets have a `direction`, the
            speed is that over the floor.
        directions : sequence of float, optional
            Directions of travel that the machine has, rad. The default is all.
        """
        loads = (False, True)
        return tuple(gap for on in loads for gap in self._gaps(linear, theta, directions, on))

    def _gaps(
        self, linear: _Range, theta: _Range, directions: Sequence[float] | None, loaded: bool
    ) -> Iterator[FieldGap]:
        sets = self._for(loaded)
        around: list[_Range | None] = [None]
        if sets and sets[0].direction is not None and linear != (0.0, 0.0):
            turns = [a % math.tau for each in sets for a in each.direction or ()]
            # Narrow gaps between the directions of two sets are rounding.
            parts = _parts((0.0, math.tau), turns)
            around = [part for part in parts if part[1] - part[0] > SPEED_TOLERANCE]
            if directions is not None:
                around = [(angle, angle) for angle in directions]
        for part in _untaken(linear, theta, around, sets):
            yield FieldGap(*part, loaded)

    def remaining(
        self,
        name: str,
        linear: tuple[float, float] = UNBOUNDED,
        theta: tuple[float, float] = UNBOUNDED,
        loads: Sequence[bool] = (False, True),
    ) -> tuple[FieldSet, ...]:
        """Return the parts of a set that apply, because no previous set fits.

        Parameters
        ----------
        name : str
            Name of the set.
        linear, theta : tuple of float, optional
            Ranges of the machine's velocity: see `gaps`.
        loads : sequence of bool, optional
            Whether the machine may be loaded, and whether it may not be.

        Returns
        -------
        tuple of FieldSet
            Set with smaller ranges. The tuple is empty if the set never applies.
        """
        k = next(k for k, each in enumerate(self.sets) if each.name == name)
        each = self.sets[k]
        parts: dict[FieldSet, None] = {}
        linear, theta = _shared(each.linear, linear), _shared(each.theta, theta)
        if linear[0] > linear[1] or theta[0] > theta[1]:
            return ()
        for loaded in filter(each.fits_load, loads):
            sets = [one for one in self.sets[:k] if one.fits_load(loaded)]
            sets = [one for one in sets if _meets(one.linear, linear) and _meets(one.theta, theta)]
            around: Sequence[_Range | None] = [None]
            if each.direction is not None:
                first = each.direction[0]
                turns = [a for one in sets for a in one.direction or ()]
                around = _parts(each.direction, [first + (a - first) % math.tau for a in turns])
            for part in _untaken(linear, theta, around, sets):
                parts[replace(each, **part._asdict())] = None
        return tuple(parts)

    def _for(self, loaded: bool) -> tuple[FieldSet, ...]:
        return self._with_load[loaded][0]

    @cached_property
    def _with_load(self) -> tuple[tuple[tuple[FieldSet, ...], FieldSwitches], ...]:
        """Sets of a machine without load and with load, and the choice among them."""
        choices = []
        for loaded in (False, True):
            sets = tuple(each for each in self.sets if each.fits_load(loaded))
            rows = numbers([value for each in sets for value in each._speeds])
            choices.append((sets, FieldSwitches(rows)))
        return tuple(choices)

    def _switches(self, machine: Motion, loaded: bool) -> list[tuple[float, int]]:
        """Return the times at which sets begin to apply, with their indices. The first is -inf."""
        # The motion is the cache, because many people are tested beside one machine.
        cache = vars(machine)
        switches: dict[bool, list[tuple[float, int]]]
        owner, switches = cache.get("field_switches", (None, {}))
        if owner is not self:
            switches = {}
            cache["field_switches"] = (self, switches)
        if loaded not in switches:
            # One second before and after, the machine is at rest.
            begin, end = machine.start - 1.0, machine.end + 1.0
            changes = self._with_load[loaded][1].switches(machine, begin, end)
            switches[loaded] = [(-math.inf, changes[0][1]), *changes[1:]]
        return switches[loaded]


def _state(value: FieldSet | ProtectiveFields) -> dict[str, Any]:
    """Return the fields of a value for a copy, which creates new kernels."""
    return {each.name: getattr(value, each.name) for each in fields(value)}


def _polygon(points: Sequence[Sequence[float]], name: str) -> Corners:
    """Return the corners of a polygon. `UserError` if it is none."""
    try:
        corners = tuple((float(x), float(y)) for x, y in points)
    except (TypeError, ValueError):
        raise UserError(f"{name} must be a list of corners (x, y), not {points!r}") from None
    if len(corners) > 1 and corners[0] == corners[-1]:
        corners = corners[:-1]
    if len(corners) < 3:
        raise UserError(f"{name} must have 3 corners or more, not {len(corners)}")
    for corner in corners:
        if not all(map(math.isfinite, corner)):
            raise UserError(f"{name} must be finite, not {corner}")
    if not Polygon(corners).is_valid:
        raise UserError(f"{name} must be a polygon whose edges do not cross or touch")
    return corners


def _range(limits: Sequence[float], name: str) -> tuple[float, float]:
    try:
        low, high = map(float, limits)
    except (TypeError, ValueError):
        raise UserError(f"{name} must be a minimum and a maximum, not {limits!r}") from None
    if not low <= high:
        raise UserError(f"{name} must not begin above its end, found {low:g} to {high:g}")
    return low, high


def _directions(limits: Sequence[float], name: str) -> tuple[float, float]:
    low, high = _range(limits, name)
    if not 0 < high - low <= math.tau + 1e-3:
        raise UserError(f"{name} must be more than nothing and at most a turn, not {limits!r}")
    return low, high


def _shared(one: _Range, other: _Range) -> _Range:
    """Return the intersection of two ranges. It ends before it begins if it is empty."""
    return max(one[0], other[0]), min(one[1], other[1])


def _meets(one: _Range, other: _Range) -> bool:
    low, high = _shared(one, other)
    return low <= high + SPEED_TOLERANCE


class _Velocities(NamedTuple):
    """Ranges of speed, turn rate and direction."""

    linear: _Range
    theta: _Range
    direction: _Range | None


def _untaken(
    linear: _Range, theta: _Range, around: Sequence[_Range | None], sets: Sequence[FieldSet]
) -> Iterator[_Velocities]:
    """Yield the ranges of speed, turn rate and direction without any of some sets."""
    turns = _parts(theta, [limit for each in sets for limit in each.theta])
    parts = _parts(linear, [limit for each in sets for limit in each.linear])
    for way, turn in itertools.product(around, turns):
        taken = [any(_covers(each, part, turn, way) for each in sets) for part in parts]
        for is_taken, group in itertools.groupby(zip(taken, parts, strict=True), itemgetter(0)):
            if not is_taken:
                run = [part for _, part in group]
                yield _Velocities((run[0][0], run[-1][1]), turn, way)


def _parts(whole: _Range, cuts: Sequence[float]) -> list[_Range]:
    """Return the parts into which `cuts` divide a range. An empty range is one part."""
    low, high = whole
    ends = sorted({low, *(cut for cut in cuts if low < cut < high), high})
    return [*itertools.pairwise(ends)] or [whole]


def _covers(each: FieldSet, linear: _Range, theta: _Range, way: _Range | None) -> bool:
    """Return whether a set applies to all velocities of a part."""
    for part, whole in ((linear, each.linear), (theta, each.theta)):
        if part[0] < whole[0] - SPEED_TOLERANCE or part[1] > whole[1] + SPEED_TOLERANCE:
            return False
    if way is None or each.direction is None:
        return True
    first, last = each.direction
    return ((way[0] + way[1]) / 2 - first) % math.tau <= last - first
