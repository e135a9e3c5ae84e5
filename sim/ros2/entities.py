"""Services of simulation_interfaces about people, machines, named poses and the world."""

from __future__ import annotations

import itertools
import math
import re
from collections.abc import Iterator
from typing import Any, NamedTuple

import shapely
from shapely.affinity import rotate, translate
from shapely.geometry import MultiPoint, Polygon

from ..cell import Cell, Pose
from ..competition import Values
from ..competition.messages import header, pose_message, twist_message, vector
from ..exports.scene import ROOT_FRAME
from .control import NOT_FOUND, UNSUPPORTED, done, failed, provide_all
from .node import CellNode

ROBOT, HUMAN = 1, 2
"""Categories of EntityCategory."""

EMPTY, BOX, HULL, SPHERE = range(4)
"""Types of Bounds."""

ALL = 1
"""Mode of TagsFilter that requires all tags."""


class Entity(NamedTuple):
    """Person or machine: path of its signals, category, tags, and solid around its axis (m)."""

    path: str
    category: int
    tags: list[str]
    footprint: Polygon
    bottom: float
    top: float


class Unsupported(Exception):  # noqa: N818 (a result, not a fault)
    """Filter that cannot be applied."""


class Entities:
    """Provider of the services that read the simulation."""

    def __init__(self, ros: CellNode, cell: Cell) -> None:
        self._cell = cell
        self._entities = dict(_entities_of(cell))
        provide_all(
            ros,
            GetEntities=self._get_entities,
            GetEntitiesStates=self._get_states,
            GetEntityInfo=self._get_info,
            GetEntityState=self._get_state,
            GetEntityBounds=self._get_bounds,
            GetNamedPoses=self._get_named_poses,
            GetCurrentWorld=self._get_world,
        )

    def _get_entities(self, _: Any, request: Values) -> Values:
        try:
            names = [name for name in self._entities if self._passes(request["filters"], name)]
        except re.error as why:
            return failed(f"{request['filters']['filter']!r} is no expression: {why}")
        except Unsupported as why:
            return failed(str(why), UNSUPPORTED)
        return done(entities=names)

    def _get_states(self, _: Any, request: Values) -> Values:
        response = self._get_entities(_, request)
        return response | {"states": [self._state(one) for one in response.get("entities", ())]}

    def _get_state(self, _: Any, request: Values) -> Values:
        name = request["entity"]
        is_here = name in self._entities and self._pose(name) is not None
        return done(state=self._state(name)) if is_here else _not_found(name)

    def _get_info(self, _: Any, request: Values) -> Values:
        if (entity := self._entities.get(request["entity"])) is None:
            return _not_found(request["entity"])
        category, description = {"category": entity.category}, ", ".join(entity.tags)
        return done(info={"category": category, "tags": entity.tags, "description": description})

    def _get_bounds(self, _: Any, request: Values) -> Values:
        if (entity := self._entities.get(request["entity"])) is None:
            return _not_found(request["entity"])
        west, south, east, north = entity.footprint.bounds
        corners = [vector((east, north), entity.top), vector((west, south), entity.bottom)]
        return done(bounds={"type": BOX, "points": corners})

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

    def _pose(self, name: str) -> Any:
        return self._cell.signals[f"{self._entities[name].path}/pose"].read()

    def _state(self, name: str) -> Values:
        velocity = self._cell.signals[f"{self._entities[name].path}/velocity"].read()
        return {
            "header": header(self._cell.now, ROOT_FRAME),
            "pose": pose_message(self._pose(name)),
            "twist": twist_message(velocity),
        }

    def _passes(self, filters: Values, name: str) -> bool:
        """Return whether a person or machine is on the floor and passes filters."""
        entity, pose = self._entities[name], self._pose(name)
        categories = [one["category"] for one in filters["categories"]]
        return (
            pose is not None
            and re.search(filters["filter"], name) is not None
            and (not categories or entity.category in categories)
            and _has_tags(filters["tags"], entity.tags)
            and _overlap(filters["bounds"], entity, pose)
        )


def _entities_of(cell: Cell) -> Iterator[tuple[str, Entity]]:
    scene = cell.simulation.scene
    for person in scene.people:
        circle, tags = shapely.Point(0.0, 0.0).buffer(person.radius), ["person", person.personality]
        path = f"people/{person.name}"
        yield person.name, Entity(path, HUMAN, tags, circle, 0.0, person.height)
    for shape in scene.machines:
        tags, solid = [shape.category, shape.kind], (Polygon(shape.corners), shape.bottom)
        yield shape.name, Entity(f"machines/{shape.name}", ROBOT, tags, *solid, shape.top)


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


def _has_tags(wanted: Values, tags: list[str]) -> bool:
    some = all if wanted["filter_mode"] == ALL else any
    return not wanted["tags"] or some(tag in tags for tag in wanted["tags"])


def _overlap(bounds: Values, entity: Entity, pose: Pose) -> bool:
    """Return whether bounds contain a part of an entity. `Unsupported` for unknown types."""
    kind, points = bounds["type"], [(one["x"], one["y"], one["z"]) for one in bounds["points"]]
    if kind == EMPTY:
        return True
    if not all(map(math.isfinite, itertools.chain(*points))):
        raise Unsupported("numbers of bounds must be finite")
    if kind == SPHERE and len(points) == 2:
        (x, y, z), (radius, *_) = points
        region, low, high = shapely.Point(x, y).buffer(radius), z - radius, z + radius
    elif kind in (BOX, HULL) and len(points) >= 2:
        corners = MultiPoint([point[:2] for point in points])
        region = corners.envelope if kind == BOX else corners.convex_hull
        low, high = min(z for *_, z in points), max(z for *_, z in points)
    else:
        raise Unsupported(f"there are no bounds of type {kind} with {len(points)} points")
    turned = rotate(entity.footprint, pose.heading, origin=(0.0, 0.0), use_radians=True)
    here = translate(turned, pose.x, pose.y)
    return bool(here.intersects(region)) and entity.bottom <= high and low <= entity.top


def _not_found(name: str) -> Values:
    return failed(f"there is no entity {name!r} now", NOT_FOUND)
