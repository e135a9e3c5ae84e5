"""What a floorplan's keys and types can't tell: whether its geometry makes sense."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import shapely
from shapely.geometry import Point, Polygon
from shapely.validation import explain_validity

from .document import Document
from .model import Floorplan, Gantry, Lane
from .problems import Problem


def geometry_problems(plan: Floorplan, document: Document) -> Iterator[Problem]:
    """Everything about `plan` that can't be, each with its place in `document`."""
    fault = polygon_fault(plan.boundary)
    if fault:
        yield document.problem(fault, "boundary")
    whole = not fault
    footprints = [obstacle.footprint for obstacle in plan.obstacles]
    sound = shapely.is_valid(footprints) & (shapely.area(footprints) > 0)
    for index in np.flatnonzero(~sound):
        obstacle = plan.obstacles[index]
        whole = False
        yield document.problem(polygon_fault(obstacle.footprint), "obstacles", obstacle.name)
    for name in plan.patrol:
        if name not in {station.name for station in plan.stations}:
            yield document.problem(f"no station is called {name!r}", "patrol")
    for lane in plan.lanes:
        yield from _lane_problems(lane, document)
    if plan.gantry is not None:
        yield from _gantry_problems(plan.gantry, document)
    if whole:
        for station in plan.stations:
            if fault := standing_fault(plan, station.position):
                yield document.problem(fault, "stations", station.name)
        if plan.safe_zone is not None and (fault := standing_fault(plan, plan.safe_zone.position)):
            yield document.problem(fault, "safe_zone", "at")


def polygon_fault(polygon: Polygon) -> str:
    """Why `polygon` encloses no area, or an empty text if it does."""
    if not polygon.is_valid:
        reason = explain_validity(polygon).replace("Self-intersection", "edges cross at ")
        return f"is not a simple polygon: {reason}"
    if polygon.area <= 0:
        return "encloses no area"
    return ""


def standing_fault(plan: Floorplan, at: tuple[float, float], radius: float | None = None) -> str:
    """Why nobody of `radius` metres (the plan's people if None) can stand at `at`, or nothing."""
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
    return f"{place} is {gap:.3f} m from {name}; a person of radius {radius:g} m does not fit"


def _lane_problems(lane: Lane, document: Document) -> Iterator[Problem]:
    low, high = lane.limits
    for name, q in lane.locations.items():
        if not low <= q <= high:
            yield document.problem(
                f"{q:g} is outside the lane's limits {low:g} … {high:g}", "agvs", "locations", name
            )
    known = ", ".join(lane.locations) or "none"
    if lane.start not in lane.locations:
        yield document.problem(
            f"{lane.name} starts at {lane.start!r}, which is no location (there are: {known})",
            *("agvs", "lanes", lane.name),
        )
    for alias, location in lane.serves.items():
        if location not in lane.locations:
            yield document.problem(
                f"{location!r} is no location (there are: {known})",
                *("agvs", "lanes", lane.name, "serves", alias),
            )


def _gantry_problems(gantry: Gantry, document: Document) -> Iterator[Problem]:
    for fault in gantry.faults(gantry.start):
        yield document.problem(fault, "gantry", "start")
