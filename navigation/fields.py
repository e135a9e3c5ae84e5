"""Protective fields of a machine: areas about it in which a person slows or stops it.

A safety scanner has sets of fields, and the speed of the machine chooses among them.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, fields, replace
from functools import cached_property
from operator import itemgetter
from typing import Annotated, Any, Literal, NamedTuple

from pydantic import AfterValidator, Field
from shapely.geometry import Polygon

from floorplan import UserError
from floorplan.checks import polygon_fault
from floorplan.files.fields import KEYS, Flag, Pair

from .kernels.fields import FieldSearch, FieldSwitches
from .kernels.numbers import numbers
from .motion import Motion

Corners = tuple[tuple[float, float], ...]

FieldKind = Literal["protective", "warning"]

KINDS: tuple[FieldKind, ...] = ("protective", "warning")

SPEED_TOLERANCE = 1e-4
"""m/s and rad/s. Limits of sets are met within this: a body on an arc is a spline."""

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
        Corners of the warning field. Without any, there is none.
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

    name: Annotated[str, Field(min_length=1)]
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
        """The numbers of the set for the kernel, with the tolerance."""
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
        """What finds contacts with each field that the set has."""
        found: dict[FieldKind, FieldSearch] = {}
        for field in KINDS:
            corners = self.corners(field)
            edges = zip(corners, (*corners[1:], *corners[:1]), strict=True)
            if corners:
                found[field] = FieldSearch(numbers([c for a, b in edges for c in (*a, *b)]))
        return found


class FieldSpan(NamedTuple):
    """Time span (seconds) in which a set applies, or none does."""

    begin: float
    end: float
    set: FieldSet | None


class FieldGap(NamedTuple):
    """Velocities to which no set applies: ranges, as those of `FieldSet`."""

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
        """Radius of the circle about the axis of the machine that contains all fields, metres."""
        return max(math.hypot(*c) for each in self.sets for c in (*each.protective, *each.warning))

    def applying(
        self, machine: Motion, begin: float, end: float, loaded: bool = False
    ) -> tuple[FieldSpan, ...]:
        """Return which set applies when.

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
        """Return the velocities of a machine to which no set applies.

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
            # What rounding of directions leaves between two sets is none.
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
        """Return parts of a set to which it applies, because no set before it fits.

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
            The set with smaller ranges. None of them if the set never applies.
        """
        k = next(k for k, each in enumerate(self.sets) if each.name == name)
        each = self.sets[k]
        found: dict[FieldSet, None] = {}
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
            for part, turn, way in _untaken(linear, theta, around, sets):
                found[replace(each, linear=part, theta=turn, direction=way)] = None
        return tuple(found)

    def _for(self, loaded: bool) -> tuple[FieldSet, ...]:
        return self._with_load[loaded][0]

    @cached_property
    def _with_load(self) -> tuple[tuple[tuple[FieldSet, ...], FieldSwitches], ...]:
        """The sets of a machine without load and with, and what chooses among them."""
        found = []
        for loaded in (False, True):
            sets = tuple(each for each in self.sets if each.fits_load(loaded))
            rows = numbers([value for each in sets for value in each._speeds])
            found.append((sets, FieldSwitches(rows)))
        return tuple(found)

    def _switches(self, machine: Motion, loaded: bool) -> list[tuple[float, int]]:
        """Return since when each set applies, by its number, and for the first since ever."""
        # The motion keeps them: many people are judged beside one machine.
        kept = vars(machine)
        known: dict[bool, list[tuple[float, int]]]
        owner, known = kept.get("field_switches", (None, {}))
        if owner is not self:
            known = {}
            kept["field_switches"] = (self, known)
        if loaded not in known:
            # A second before and after, the machine is at rest.
            begin, end = machine.start - 1.0, machine.end + 1.0
            found = self._with_load[loaded][1].switches(machine, begin, end)
            known[loaded] = [(-math.inf, found[0][1]), *found[1:]]
        return known[loaded]


def _state(value: FieldSet | ProtectiveFields) -> dict[str, Any]:
    """Return what a copy of a value needs: kernels, which are not copied, are made anew."""
    return {each.name: getattr(value, each.name) for each in fields(value)}


def _polygon(given: Sequence[Sequence[float]], name: str) -> Corners:
    """Return the corners of a polygon; `UserError` if it is none."""
    try:
        corners = tuple((float(x), float(y)) for x, y in given)
    except (TypeError, ValueError):
        raise UserError(f"{name} must be a list of corners (x, y), not {given!r}") from None
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


def _range(given: Sequence[float], name: str) -> tuple[float, float]:
    try:
        low, high = map(float, given)
    except (TypeError, ValueError):
        raise UserError(f"{name} must be a minimum and a maximum, not {given!r}") from None
    if not low <= high:
        raise UserError(f"{name} must not begin above its end, found {low:g} to {high:g}")
    return low, high


def _directions(given: Sequence[float], name: str) -> tuple[float, float]:
    low, high = _range(given, name)
    if not 0 < high - low <= math.tau + 1e-3:
        raise UserError(f"{name} must be more than nothing and at most a turn, not {given!r}")
    return low, high


def _shared(one: _Range, other: _Range) -> _Range:
    """Return what two ranges share, which ends before it begins if that is nothing."""
    return max(one[0], other[0]), min(one[1], other[1])


def _meets(one: _Range, other: _Range) -> bool:
    low, high = _shared(one, other)
    return low <= high + SPEED_TOLERANCE


def _untaken(
    linear: _Range, theta: _Range, around: Sequence[_Range | None], sets: Sequence[FieldSet]
) -> Iterator[tuple[_Range, _Range, _Range | None]]:
    """Yield the ranges of speed, turn rate and direction to which none of some sets applies."""
    turns = _parts(theta, [limit for each in sets for limit in each.theta])
    parts = _parts(linear, [limit for each in sets for limit in each.linear])
    for way, turn in itertools.product(around, turns):
        taken = [any(_covers(each, part, turn, way) for each in sets) for part in parts]
        for is_taken, group in itertools.groupby(zip(taken, parts, strict=True), itemgetter(0)):
            if not is_taken:
                run = [part for _, part in group]
                yield (run[0][0], run[-1][1]), turn, way


def _parts(whole: _Range, cuts: Sequence[float]) -> list[_Range]:
    """Return the parts into which `cuts` divide a range; a range of no length is one part."""
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
