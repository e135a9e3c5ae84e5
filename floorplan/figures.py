"""Which figures a floor, a trial or a rule set can have: neither tiny nor huge."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

from .document import Fault
from .model import Floorplan

LARGEST = 1e9
"""No figure of a floor, a trial or a rule set is larger, in its unit: beyond, steps of a millimetre
or a millisecond are soon lost to rounding, and in the end distances can't be recorded."""

SMALLEST = 1e-6
"""No figure that has to be more than 0 is smaller, in its unit: at less, nothing ever arrives."""

WIDEST = 1e6
"""Metres (or radians). No floor is longer, and no lane or axis goes further from its 0: on longer
ways Ruckig finds no motion."""

_LANE_SIZES = ("length", "width", "height", "max_speed", "max_acceleration")
_AXIS_SIZES = ("max_speed", "max_acceleration", "max_jerk")
_GANTRY_SIZES = ("arm_reach", "arm_bottom", "rail_height", "tray_height")


def size_fault(value: float) -> str:
    """Why `value` can be no length, speed or duration in its unit; an empty text if it can."""
    if SMALLEST <= value <= LARGEST:
        return ""
    if 0 < value < SMALLEST:
        return f"must be at least {SMALLEST:g}, not {value!r}"
    return f"must be more than 0 and at most {LARGEST:g}, not {value!r}"


def figure_faults(plan: Floorplan) -> Iterator[Fault]:
    """Every figure of `plan` that is too small or too large to work with."""
    west, south, east, north = plan.boundary.bounds
    if max(east - west, north - south) > WIDEST:
        yield f"is more than {WIDEST:,.0f} m long", ("boundary",)
    yield from _sizes(plan.human, tuple(vars(plan.human)), "human")
    for lane in plan.lanes:
        place = ("agvs", "lanes", lane.name)
        if not all(abs(value) <= LARGEST for value in (*lane.origin, lane.heading)):
            yield f"origin and heading must be within ±{LARGEST:g}", place
        yield from _range(lane.limits, *place, "limits")
        yield from _sizes(lane, _LANE_SIZES, *place)
    if plan.gantry is not None:
        for name, axis in zip(("x", "y", "rotation"), plan.gantry.axes, strict=True):
            yield from _range((axis.low, axis.high), "gantry", name, "range")
            yield from _sizes(axis, _AXIS_SIZES, "gantry", name)
        yield from _sizes(plan.gantry, _GANTRY_SIZES, "gantry")


def _range(ends: tuple[float, float], *place: str) -> Iterator[Fault]:
    if not -WIDEST <= ends[0] < ends[1] <= WIDEST:
        yield f"must be [low, high], both within ±{WIDEST:g}, not {list(ends)}", place


def _sizes(thing: object, names: Iterable[str], *place: str) -> Iterator[Fault]:
    for name in names:
        if fault := size_fault(getattr(thing, name)):
            yield fault, (*place, name)


__all__ = ["LARGEST", "SMALLEST", "WIDEST", "figure_faults", "size_fault"]
