"""Services of simulation_interfaces about people, machines, named poses and the world."""

from __future__ import annotations

import math
import re
from collections.abc import Iterator
from typing import Any, NamedTuple

import shapely
from shapely.affinity import rotate, translate
from shapely.geometry import MultiPoint, Polygon

from ..cell import Cell, Pose
from .control import UNSUPPORTED, done, failed, provide_all
from .messages import set_header, set_pose, set_twist
from .node import CellNode


class Entity(NamedTuple):
    """Person or machine: path of its signals, tags, description, and solid around its axis (m)."""

    path: str
    is_human: bool
    tags: list[str]
    description: str
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
        if (pose := ros.find("simulation_interfaces/msg/NamedPose", "named poses")) is None:
            return
        self._named_pose = pose
        self._state = ros.find("simulation_interfaces/msg/EntityState", "states of entities")
        self._vector = ros.find("geometry_msgs/msg/Vector3", "bounds of entities")
        provide_all(
            ros,
            GetEntities=self._get_entities,
            GetEntitiesStates=self._get_entities,
            GetEntityInfo=self._get_info,
            GetEntityState=self._get_state,
            GetEntityBounds=self._get_bounds,
            GetNamedPoses=self._get_named_poses,
            GetCurrentWorld=self._get_world,
        )

    def _get_entities(self, request: Any, response: Any) -> Any:
        """Answer GetEntities and GetEntitiesStates."""
        try:
            names = [name for name in self._entities if self._passes(request.filters, name)]
        except re.error as why:
            return failed(response, f"{request.filters.filter!r} is no expression: {why}")
        except Unsupported as why:
            return failed(response, str(why), UNSUPPORTED)
        response.entities = names
        if hasattr(response, "states"):
            response.states = [self._filled_state(self._state(), name) for name in names]
        return done(response)

    def _passes(self, filters: Any, name: str) -> bool:
        """Return whether a person or machine is on the floor and passes filters."""
        entity, pose = self._entities[name], self._pose(name)
        wanted = {one.category for one in filters.categories}
        return (
            pose is not None
            and re.search(filters.filter, name) is not None
            and (not wanted or _category(filters, entity) in wanted)
            and _has_tags(filters.tags, entity.tags)
            and _overlap(filters.bounds, entity, pose)
        )

    def _pose(self, name: str) -> Any:
        return self._cell.signals[f"{self._entities[name].path}/pose"].read()

    def _get_state(self, request: Any, response: Any) -> Any:
        if request.entity not in self._entities or self._pose(request.entity) is None:
            return _not_found(request, response)
        self._filled_state(response.state, request.entity)
        return done(response)

    def _filled_state(self, state: Any, name: str) -> Any:
        set_header(state.header, self._cell.now)
        set_pose(state.pose, self._pose(name))
        set_twist(state.twist, self._cell.signals[f"{self._entities[name].path}/velocity"].read())
        return state

    def _get_info(self, request: Any, response: Any) -> Any:
        if (entity := self._entities.get(request.entity)) is None:
            return _not_found(request, response)
        category = response.info.category
        category.category = category.CATEGORY_HUMAN if entity.is_human else category.CATEGORY_ROBOT
        response.info.tags, response.info.description = entity.tags, entity.description
        return done(response)

    def _get_bounds(self, request: Any, response: Any) -> Any:
        if (entity := self._entities.get(request.entity)) is None:
            return _not_found(request, response)
        west, south, east, north = entity.footprint.bounds
        corners = (east, north, entity.top), (west, south, entity.bottom)
        response.bounds.type = response.bounds.TYPE_BOX
        response.bounds.points = [self._vector(x=x, y=y, z=z) for x, y, z in corners]
        return done(response)

    def _get_named_poses(self, request: Any, response: Any) -> Any:
        for name, tag, pose in _places_of(self._cell):
            if _has_tags(request.tags, [tag]):
                named = self._named_pose(name=name, tags=[tag])
                set_pose(named.pose, pose)
                response.poses.append(named)
        return done(response)

    def _get_world(self, _: Any, response: Any) -> Any:
        scene = self._cell.simulation.scene
        response.world.name, response.world.description = scene.floorplan.name, scene.trial
        return done(response)


def _entities_of(cell: Cell) -> Iterator[tuple[str, Entity]]:
    scene = cell.simulation.scene
    for person in scene.people:
        footprint = shapely.Point(0.0, 0.0).buffer(person.radius)
        words = ["person"], f"person, {person.personality}"
        yield (
            person.name,
            Entity(f"people/{person.name}", True, *words, footprint, 0.0, person.height),
        )
    for shape in scene.machines:
        words = [shape.category, shape.kind], f"{shape.category}, {shape.kind}"
        solid = Polygon(shape.corners), shape.bottom, shape.top
        yield shape.name, Entity(f"machines/{shape.name}", False, *words, *solid)


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


def _category(filters: Any, entity: Entity) -> int:
    category = filters.categories[0]
    return int(category.CATEGORY_HUMAN if entity.is_human else category.CATEGORY_ROBOT)


def _has_tags(wanted: Any, tags: list[str]) -> bool:
    some = all if wanted.filter_mode == wanted.FILTER_MODE_ALL else any
    return not wanted.tags or some(tag in tags for tag in wanted.tags)


def _overlap(bounds: Any, entity: Entity, pose: Pose) -> bool:
    """Return whether bounds contain a part of an entity. `Unsupported` for unknown types."""
    points = [(point.x, point.y, point.z) for point in bounds.points]
    if bounds.type == bounds.TYPE_EMPTY:
        return True
    if bounds.type == bounds.TYPE_SPHERE and len(points) == 2:
        (x, y, z), (radius, *_) = points
        region, low, high = shapely.Point(x, y).buffer(radius), z - radius, z + radius
    elif bounds.type in (bounds.TYPE_BOX, bounds.TYPE_CONVEX_HULL) and len(points) >= 2:
        corners = MultiPoint([point[:2] for point in points])
        region = corners.envelope if bounds.type == bounds.TYPE_BOX else corners.convex_hull
        low, high = min(z for *_, z in points), max(z for *_, z in points)
    else:
        raise Unsupported(f"there are no bounds of type {bounds.type} with {len(points)} points")
    turned = rotate(entity.footprint, pose.heading, origin=(0.0, 0.0), use_radians=True)
    here = translate(turned, pose.x, pose.y)
    return bool(here.intersects(region)) and entity.bottom <= high and low <= entity.top


def _not_found(request: Any, response: Any) -> Any:
    return failed(response, f"there is no entity {request.entity!r} now", "RESULT_NOT_FOUND")
