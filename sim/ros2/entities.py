"""Services of simulation_interfaces about people, machines, named poses and the world."""

from __future__ import annotations

import itertools
import math
import re
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any

import shapely
from shapely.affinity import rotate, translate
from shapely.geometry import MultiPoint, Polygon

from ..cell import Cell, Pose, Signal
from ..competition import Values
from ..competition.messages import header, pose_message, twist_message, vector
from ..competition.transport import Answer
from ..exports.scene import ROOT_FRAME
from .control import NOT_FOUND, UNSUPPORTED, done, failed, provide_all
from .node import CellNode

ROBOT, HUMAN = 1, 2
"""Categories of EntityCategory."""

EMPTY, BOX, HULL, SPHERE = range(4)
"""Types of Bounds."""

STATE = ("pose", "velocity")
"""Names of the signals of an entity."""

ALL = 1
"""Mode of TagsFilter that requires all tags."""


@dataclass(frozen=True)
class Entity:
    """Person or machine, with the solid around its axis (m)."""

    name: str
    pose: Signal
    velocity: Signal
    category: int
    tags: list[str]
    footprint: Polygon
    bottom: float
    top: float


class Entities:
    """Provider of the services that read the simulation."""

    def __init__(self, ros: CellNode, cell: Cell) -> None:
        self._cell = cell
        self._entities = {one.name: one for one in _entities_of(cell)}
        provide_all(
            ros,
            GetEntities=self._get_entities,
            GetEntitiesStates=self._get_entities,
            GetEntityInfo=self._about(_info),
            GetEntityState=self._about(lambda entity: {"state": self._state(entity)}),
            GetEntityBounds=self._about(_bounds),
            GetNamedPoses=self._get_named_poses,
            GetCurrentWorld=self._get_world,
        )

    def _get_entities(self, _: Any, request: Values) -> Values:
        """Return the answer of GetEntities, with the states of GetEntitiesStates."""
        filters = request["filters"]
        try:
            entities = [one for one in self._entities.values() if _passes(filters, one)]
        except re.error as why:
            return failed(f"{filters['filter']!r} is no expression: {why}")
        except NotImplementedError as why:
            return failed(str(why), UNSUPPORTED)
        states = [self._state(one) for one in entities]
        return done(entities=[one.name for one in entities], states=states)

    def _about(self, content: Callable[[Entity], Values]) -> Answer:
        """Return a service that answers with the content about an entity that is here."""

        def answer(_: Any, request: Values) -> Values:
            entity = self._entities.get(request["entity"])
            if entity is None or entity.pose.read() is None:
                return failed(f"there is no entity {request['entity']!r} now", NOT_FOUND)
            return done(**content(entity))

        return answer

    def _state(self, entity: Entity) -> Values:
        return {
            "header": header(self._cell.now, ROOT_FRAME),
            "pose": pose_message(entity.pose.read()),
            "twist": twist_message(entity.velocity.read()),
        }

    def _get_named_poses(self, _: Any, request: Values) -> Values:
        poses = [
            {"name": name, "tags": [tag], "pose": pose_message(pose)}
            for name, tag, pose in _places_of(self._cell)
            if _has_tags(request["tags"], [tag])
        ]
        return done(poses=poses)

    def _get_world(self, _: Any, __: Values) -> Values:
        scene = self._cell.simulation.scene
        return done(world={"name": scene.floorplan.name, "description": scene.trial})


def _entities_of(cell: Cell) -> Iterator[Entity]:
    scene, signals = cell.simulation.scene, cell.signals
    for person in scene.people:
        pose, velocity = (signals[f"people/{person.name}/{name}"] for name in STATE)
        circle, tags = shapely.Point(0.0, 0.0).buffer(person.radius), ["person", person.personality]
        yield Entity(person.name, pose, velocity, HUMAN, tags, circle, 0.0, person.height)
    for shape in scene.machines:
        pose, velocity = (signals[f"machines/{shape.name}/{name}"] for name in STATE)
        tags, solid = [shape.category, shape.kind], Polygon(shape.corners)
        yield Entity(shape.name, pose, velocity, ROBOT, tags, solid, shape.bottom, shape.top)


def _info(entity: Entity) -> Values:
    category, description = {"category": entity.category}, ", ".join(entity.tags)
    return {"info": {"category": category, "tags": entity.tags, "description": description}}


def _bounds(entity: Entity) -> Values:
    west, south, east, north = entity.footprint.bounds
    corners = [vector((east, north), entity.top), vector((west, south), entity.bottom)]
    return {"bounds": {"type": BOX, "points": corners}}


def _places_of(cell: Cell) -> Iterator[tuple[str, str, Pose]]:
    """Yield name, tag and pose of stations, the safe zone and locations of lanes."""
    plan = cell.simulation.scene.floorplan
    for station in plan.stations:
        yield station.name, "station", Pose(*station.position)
    if plan.safe_zone is not None:
        yield "safe_zone", "safe_zone", Pose(*plan.safe_zone.position, plan.safe_zone.heading)
    for lane in plan.lanes:
        heading = math.atan2(lane.direction[1], lane.direction[0])
        for location, along in lane.locations.items():
            yield f"{lane.name}/{location}", "location", Pose(*lane.position(along), heading)


def _passes(filters: Values, entity: Entity) -> bool:
    """Return whether a person or machine is on the floor and passes filters."""
    categories, pose = [one["category"] for one in filters["categories"]], entity.pose.read()
    return (
        pose is not None
        and re.search(filters["filter"], entity.name) is not None
        and (not categories or entity.category in categories)
        and _has_tags(filters["tags"], entity.tags)
        and _overlap(filters["bounds"], entity, pose)
    )


def _has_tags(wanted: Values, tags: list[str]) -> bool:
    some = all if wanted["filter_mode"] == ALL else any
    return not wanted["tags"] or some(tag in tags for tag in wanted["tags"])


def _overlap(bounds: Values, entity: Entity, pose: Pose) -> bool:
    """Return whether bounds contain a part of an entity.

    `NotImplementedError` for bounds of unknown types.
    """
    kind, points = bounds["type"], [(one["x"], one["y"], one["z"]) for one in bounds["points"]]
    if kind == EMPTY:
        return True
    if not all(map(math.isfinite, itertools.chain(*points))):
        raise NotImplementedError("numbers of bounds must be finite")
    if kind == SPHERE and len(points) == 2:
        (x, y, z), (radius, *_) = points
        region, low, high = shapely.Point(x, y).buffer(radius), z - radius, z + radius
    elif kind in (BOX, HULL) and len(points) >= 2:
        corners = MultiPoint([point[:2] for point in points])
        region = corners.envelope if kind == BOX else corners.convex_hull
        low, high = min(z for *_, z in points), max(z for *_, z in points)
    else:
        raise NotImplementedError(f"there are no bounds of type {kind} with {len(points)} points")
    turned = rotate(entity.footprint, pose.heading, origin=(0.0, 0.0), use_radians=True)
    here = translate(turned, pose.x, pose.y)
    return bool(here.intersects(region)) and entity.bottom <= high and low <= entity.top
