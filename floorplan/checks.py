"""What a floorplan's keys and types can't tell: whether its geometry makes sense."""

from __future__ import annotations

from collections.abc import Iterator

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
    for obstacle in plan.obstacles:
        fault = polygon_fault(obstacle.footprint)
        if fault:
            whole = False
            yield document.problem(fault, "obstacles", obstacle.name)
    for name in plan.patrol:
        if name not in {station.name for station in plan.stations}:
            yield document.problem(f"no station is called {name!r}", "patrol")
    for lane in plan.lanes:
        yield from _lane_problems(lane, document)
    if plan.gantry is not None:
        yield from _gantry_problems(plan.gantry, document)
    if whole:
        for station in plan.stations:
            yield from _standing_problems(
                plan, station.position, document, ("stations", station.name)
            )
        if plan.safe_zone is not None:
            at = plan.safe_zone.position
            yield from _standing_problems(plan, at, document, ("safe_zone", "at"))


def polygon_fault(polygon: Polygon) -> str:
    """Why `polygon` encloses no area, or an empty text if it does."""
    if not polygon.is_valid:
        reason = explain_validity(polygon).replace("Self-intersection", "edges cross at ")
        return f"is not a simple polygon: {reason}"
    if polygon.area <= 0:
        return "encloses no area"
    return ""


def _standing_problems(
    plan: Floorplan, at: tuple[float, float], document: Document, place: tuple[str, ...]
) -> Iterator[Problem]:
    """Whether one of the plan's people can stand at `at`."""
    point = Point(at)
    if not plan.boundary.contains(point):
        yield document.problem(f"({at[0]:g}, {at[1]:g}) is outside the boundary", *place)
        return
    radius = plan.human.radius
    for obstacle in plan.obstacles:
        if not obstacle.overlaps(0.0, plan.human.height):
            continue
        gap = obstacle.footprint.distance(point)
        if gap == 0:
            yield document.problem(
                f"({at[0]:g}, {at[1]:g}) is inside obstacle {obstacle.name!r}", *place
            )
        elif gap < radius:
            yield document.problem(
                f"({at[0]:g}, {at[1]:g}) is {gap:.3f} m from obstacle {obstacle.name!r};"
                f" a person of radius {radius:g} m does not fit",
                *place,
            )
    gap = shapely.distance(plan.boundary.exterior, point)
    if gap < radius:
        yield document.problem(
            f"({at[0]:g}, {at[1]:g}) is {gap:.3f} m from the boundary;"
            f" a person of radius {radius:g} m does not fit",
            *place,
        )


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
