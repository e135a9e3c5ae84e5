"""Checks of a floorplan: its geometry, its names and the range of its numbers."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterator
from itertools import combinations

import numpy as np
import shapely
from shapely.geometry import LineString, Point, Polygon
from shapely.validation import explain_validity

from .files.fields import LARGEST, SMALLEST
from .files.problems import Fault, FloorplanError, Place, Problem, metres, refuse
from .files.values import SOUND, range_faults, require, require_fields
from .model import Floor, Gate, Lane, Obstacle, Zone

WIDEST = 1e6
"""Metres or radians. Maximum length of a floor, and largest coordinate of a lane or axis, because
Ruckig fails on longer paths."""

_TOUCHES = 1e-6
"""m². Largest area that an AGV and an obstacle share if they only touch."""

_STARTS, _MOST_STARTS = "_starts", 1000
"""Attribute of a floorplan with the cached faults of start positions, and their maximum number."""

ENDS = 0.05
"""Metres. Maximum distance between the end of a gate and a wall, too narrow for a person."""


def check(plan: Floor, *, file: str = "") -> None:
    """Check the geometry, the names and the values of a floorplan.

    Parameters
    ----------
    plan : Floorplan
        Floorplan to check. A floorplan that is correct is checked only once.
    file : str, optional
        Name of the floorplan in errors.

    Raises
    ------
    FloorplanError
        With all problems of the floorplan, each with its field.
    TypeError
        If `plan` is no `Floorplan`, or if a field has another type.
    """
    require(plan, Floor, "floorplan.load", "a Floorplan")
    if SOUND in vars(plan):
        return
    require_fields(plan)
    refuse(file or f"floorplan {plan.name!r}", faults(plan), FloorplanError)
    keep_sound(plan)


WIDE = 1e4
"""Metres. A longer floor was probably drawn in another unit."""


def size_notices(plan: Floor, unit: str, key: str = "units") -> tuple[Problem, ...]:
    """Return a notice if the floor is implausibly small or large for lengths in `unit`."""
    west, south, east, north = plan.boundary.bounds
    short, long = sorted((east - west, north - south))
    person = 2 * plan.human.radius
    if person <= short and long <= WIDE:
        return ()
    odd = f"narrower than a person ({person:g} m)" if short < person else "wider than 10 km"
    size = f"the floor is {metres(east - west)} m × {metres(north - south)} m, {odd}"
    remedy = f"its unit is {unit}; if that is wrong, `{key}` corrects it"
    return (Problem(f"{size}: {remedy}", "boundary"),)


def keep_sound(plan: Floor) -> None:
    """Mark `plan` as correct, so that `check` need not repeat its work."""
    vars(plan)[SOUND] = True


def faults(plan: Floor) -> Iterator[Fault]:
    """Yield all faults of `plan`."""
    fault = polygon_fault(plan.boundary)
    if fault:
        yield fault, ("boundary",)
    whole = not fault
    footprints = [obstacle.footprint for obstacle in plan.obstacles]
    sound = shapely.is_valid(footprints) & (shapely.area(footprints) > 0)
    for index in np.flatnonzero(~sound):
        obstacle = plan.obstacles[index]
        whole = False
        yield polygon_fault(obstacle.footprint), ("obstacles", obstacle.name)
    for obstacle in plan.obstacles:
        if fault := height_fault(obstacle):
            yield fault, ("obstacles", obstacle.name, "z")
    yield from _door_faults(plan)
    yield from _zone_faults(plan)
    yield from _gate_faults(plan)
    yield from _name_faults(plan)
    yield from _figure_faults(plan)
    for name in plan.patrol or ():
        if name not in {station.name for station in plan.stations}:
            yield f"no station is called {name!r}", ("patrol",)
    for lane in plan.lanes:
        yield from _lane_faults(lane)
    if plan.gantry is not None:
        yield from ((fault, ("gantry", "start")) for fault in plan.gantry.faults(plan.gantry.start))
    if whole:
        for station in plan.stations:
            if fault := standing_fault(plan, station.position):
                yield fault, ("stations", station.name)
        if plan.safe_zone is not None and (fault := starting_fault(plan, plan.safe_zone.position)):
            yield fault, ("safe_zone", "at")
        for lane in plan.lanes:
            yield from _sweep_faults(lane, plan)
        yield from _loose_gate_faults(plan)


def polygon_fault(polygon: Polygon) -> str:
    """Return the reason why `polygon` encloses no area, or an empty text if it does."""
    if not polygon.is_valid:
        reason = explain_validity(polygon).replace("Self-intersection", "edges cross at ")
        return f"is not a simple polygon: {reason}"
    if polygon.area <= 0:
        return "encloses no area"
    return ""


def starting_fault(plan: Floor, at: tuple[float, float], radius: float | None = None) -> str:
    """Return the reason why a person can't start at `at` on `plan`, or an empty text.

    See `standing_fault`. In addition, no AGV may be there at the start.
    """
    if SOUND not in vars(plan):
        return _starting_fault(plan, at, radius)
    # Floorplans are immutable, and all trials on a floor use the same few positions.
    reasons: dict[tuple[float | None, ...], str] = vars(plan).setdefault(_STARTS, {})
    key = (*at, radius)
    if key not in reasons:
        if len(reasons) >= _MOST_STARTS:
            reasons.clear()
        reasons[key] = _starting_fault(plan, at, radius)
    return reasons[key]


def _starting_fault(plan: Floor, at: tuple[float, float], radius: float | None) -> str:
    if fault := standing_fault(plan, at, radius):
        return fault
    for lane in plan.lanes:
        start = lane.locations.get(lane.start)
        if start is not None and lane.footprint(start).covers(Point(at)):
            return f"({at[0]:g}, {at[1]:g}) is inside {lane.name}, which stands there at the start"
    return ""


def standing_fault(plan: Floor, at: tuple[float, float], radius: float | None = None) -> str:
    """Return the reason why a person can't stand at `at` (x, y in metres), or an empty text.

    The person has `radius` metres, that of the plan's people if None.
    """
    radius = plan.human.radius if radius is None else radius
    point, place = Point(at), f"({at[0]:g}, {at[1]:g})"
    if not plan.boundary.contains(point):
        return f"{place} is outside the boundary"
    there = [o for o in plan.obstacles if o.overlaps(0.0, plan.human.height)]
    far = shapely.distance([o.footprint for o in there], point).tolist()
    gaps = [(gap, f"obstacle {o.name!r}") for gap, o in zip(far, there, strict=True)]
    gaps.append((plan.boundary.exterior.distance(point), "the boundary"))
    gap, name = min(gaps)
    if gap >= radius:
        return ""
    if gap == 0:
        return f"{place} is inside {name}"
    far = metres(gap, radius)
    return f"{place} is {far} m from {name}; a person of radius {radius:g} m does not fit"


def height_fault(obstacle: Obstacle) -> str:
    """Return the reason why the heights of an obstacle are invalid, or an empty text."""
    if obstacle.bottom < obstacle.top:
        return ""
    return f"must rise from bottom to top: {obstacle.bottom:g} … {obstacle.top:g}"


def _name_faults(plan: Floor) -> Iterator[Fault]:
    names: dict[Place, list[str]] = {
        ("obstacles",): [obstacle.name for obstacle in plan.obstacles],
        ("stations",): [station.name for station in plan.stations],
        ("agvs", "lanes"): [lane.name for lane in plan.lanes],
        ("doors",): [door.name for door in plan.doors],
        ("zones",): [zone.name for zone in plan.zones],
        ("gates",): [gate.name for gate in plan.gates],
    }
    for place, all_names in names.items():
        for name, count in Counter(all_names).items():
            if count > 1:
                yield f"{count} of them have this name", (*place, name)
    # Path planning identifies these by name.
    taken = {*names["obstacles",], *names["agvs", "lanes"]}
    for place in (("doors",), ("zones",), ("gates",)):
        for name in taken.intersection(names[place]):
            yield f"something else is called {name!r} already", (*place, name)
        taken.update(names[place])


def _lane_faults(lane: Lane) -> Iterator[Fault]:
    low, high = lane.limits
    for name, q in lane.locations.items():
        if not low <= q <= high:
            message = f"{q:g} is outside the lane's limits {low:g} … {high:g}"
            yield message, ("agvs", "locations", name)
    names = ", ".join(lane.locations) or "none"
    if lane.start not in lane.locations:
        message = f"{lane.name} starts at {lane.start!r}, which is no location (there are: {names})"
        yield message, ("agvs", "lanes", lane.name)
    for alias, location in lane.serves.items():
        if location not in lane.locations:
            message = f"{location!r} is no location (there are: {names})"
            yield message, ("agvs", "lanes", lane.name, "serves", alias)


def _door_faults(plan: Floor) -> Iterator[Fault]:
    whole = []
    for door in plan.doors:
        place = ("doors", door.name)
        if not SMALLEST <= math.dist(*door.ends) <= WIDEST:
            yield "its two ends are one place", (*place, "between")
            continue
        whole.append(door)
        yield from _sizes(door, *place)
        for k, end in enumerate(door.ends):
            if not plan.boundary.covers(Point(end)):
                yield f"({end[0]:g}, {end[1]:g}) is outside the boundary", (*place, "between", k)
    for one, other in combinations(whole, 2):
        if one.footprint.intersection(other.footprint).area > _TOUCHES:
            yield f"overlaps the door {one.name!r}", ("doors", other.name)


def _zone_faults(plan: Floor) -> Iterator[Fault]:
    for zone in plan.zones:
        place = ("zones", zone.name)
        if fault := polygon_fault(zone.area):
            yield fault, place
            continue
        if fault := zone.rule_fault:
            yield fault, place
        if zone.one_way is not None:
            yield from _one_way_faults(zone, (*place, "one_way"))
        yield from _sizes(zone, *place)
        if not zone.forbidden or "*" not in zone.concerns:
            continue
        for station in plan.stations:
            if zone.area.covers(Point(station.position)):
                yield f"the station {station.name!r} is in it, and nobody may go there", place


def _one_way_faults(zone: Zone, place: Place) -> Iterator[Fault]:
    if not SMALLEST <= math.hypot(*(zone.one_way or ())) <= WIDEST:
        yield "is no direction; give x and y, as in [1, 0]", place
        return
    ends = ["exit" if gate.name.endswith("(exit)") else "entry" for gate in zone.gates]
    if sorted(ends) != ["entry", "exit"]:
        message = "its outline must have one straight side across that direction at either end"
        yield f"{message}, it has {ends.count('entry')} and {ends.count('exit')}", place


def _gate_faults(plan: Floor) -> Iterator[Fault]:
    whole = []
    for gate in plan.gates:
        place = ("gates", gate.name)
        if not SMALLEST <= math.dist(*gate.ends) <= WIDEST:
            yield "its two ends are one place", (*place, "between")
            continue
        whole.append(gate)
        beside = LineString(gate.ends).distance(Point(gate.towards))
        (x, y), (ax, ay), (tx, ty) = gate.normal, gate.ends[0], gate.towards
        if not beside <= WIDEST or (tx - ax) * x + (ty - ay) * y < SMALLEST:
            message = f"({tx:g}, {ty:g}) is on its line; give a place on the side to cross to"
            yield message, (*place, "towards")
    for one, other in combinations(whole, 2):
        if LineString(one.ends).intersects(LineString(other.ends)):
            yield f"meets the gate {one.name!r}", ("gates", other.name, "between")


def _loose_gate_faults(plan: Floor) -> Iterator[Fault]:
    """Yield the ends of gates that people could walk around."""
    if not plan.one_ways:
        return
    walls = plan.free(0.0, plan.human.height).boundary
    places: list[tuple[Gate, Place]] = [(gate, ("gates", gate.name)) for gate in plan.gates]
    places += [(gate, ("zones", zone.name)) for zone in plan.zones for gate in zone.gates]
    for gate, place in places:
        for k, end in enumerate(gate.ends):
            at = Point(end)
            gap = walls.distance(at)
            inside = not plan.boundary.covers(at) or any(
                o.footprint.covers(at) for o in plan.obstacles if o.overlaps(0.0, plan.human.height)
            )
            if gap > ENDS and not inside:
                message = f"({end[0]:g}, {end[1]:g}) is {metres(gap)} m from the nearest wall;"
                message += " a gate goes from wall to wall, else people walk round its end"
                if place[0] == "zones":
                    yield message.replace("a gate", "a one-way zone"), (*place, "one_way")
                else:
                    yield message, (*place, "between", k)


def _sweep_faults(lane: Lane, plan: Floor) -> Iterator[Fault]:
    """Yield the obstacles that the AGV of `lane` would drive through."""
    there = [o for o in plan.obstacles if o.overlaps(0.0, lane.height)]
    swept = shapely.MultiPolygon([lane.footprint(q) for q in lane.limits]).convex_hull
    shared = shapely.intersection([o.footprint for o in there], swept)
    for index in np.flatnonzero(shapely.area(shared) > _TOUCHES):
        place = shared[index].representative_point()
        message = (
            f"{lane.name} drives through obstacle {there[index].name!r}"
            f" at ({place.x:.2f}, {place.y:.2f}); move the lane, or narrow its limits"
        )
        yield message, ("agvs", "lanes", lane.name)


def _figure_faults(plan: Floor) -> Iterator[Fault]:
    """Yield the numbers of `plan` that are out of range."""
    west, south, east, north = plan.boundary.bounds
    if max(east - west, north - south) > WIDEST:
        yield f"is more than {WIDEST:,.0f} m long", ("boundary",)
    yield from _sizes(plan.human, "human")
    for lane in plan.lanes:
        place = ("agvs", "lanes", lane.name)
        if not all(abs(value) <= LARGEST for value in (*lane.origin, lane.heading)):
            yield f"origin and heading must be within ±{LARGEST:g}", place
        yield from _range(lane.limits, *place, "limits")
        yield from _sizes(lane, *place)
    if plan.gantry is not None:
        for name, axis in zip(("x", "y", "rotation"), plan.gantry.axes, strict=True):
            yield from _range((axis.low, axis.high), "gantry", name, "range")
            yield from _sizes(axis, "gantry", name)
        yield from _sizes(plan.gantry, "gantry")


def _range(ends: tuple[float, float], *place: str) -> Iterator[Fault]:
    if not -WIDEST <= ends[0] < ends[1] <= WIDEST:
        yield f"must be [low, high], both within ±{WIDEST:g}, not {list(ends)}", place


def _sizes(thing: object, *place: str) -> Iterator[Fault]:
    """Yield the fields of an object that are out of range, below `place`."""
    for message, inner in range_faults(thing):
        yield message, (*place, *inner)
