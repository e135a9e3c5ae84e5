"""Collision queries against a floorplan and the bodies on it, as they are now."""

from __future__ import annotations

import math
from collections.abc import Collection, Iterable, Mapping, MutableSequence
from typing import Any, NoReturn

import numpy as np
import shapely
from numpy.typing import ArrayLike
from shapely.geometry import Polygon

from floorplan import Floorplan, Gate, Point, UserError, check
from floorplan.files.problems import suggestion
from floorplan.files.values import Named

from . import ground
from .bodies import TOLERANCE, CollisionBody, Disc, Sweep, touch
from .freespace import FreeSpace, Gates, Narrows
from .kernels.edges import Grid, come_into
from .kernels.numbers import numbers
from .roadmap import HAIR, Roadmap

_WIDER = 1.001
"""Factor of a radius, so that it includes polygons around arcs."""

_ROUNDING = 10 * TOLERANCE
"""Metres. Tolerance for a disc beside an obstacle."""


class CollisionWorld:
    """Collision geometry of a floorplan with its AGVs and other bodies at their present positions.

    Queries are about discs on the floor. FCL answers them, and sweeps a disc along a segment as one
    exact shape. AGVs are at the start of their lanes until they are moved. The centre of a disc
    crosses one-way gates in their direction only.

    Parameters
    ----------
    plan : Floorplan
        Floorplan.
    bottom, top : float, optional
        Range of heights in metres, by default that of a person. Everything below or above is
        ignored.
    gates : iterable of Gate, optional
        One-way gates. By default the gates of the floor that concern all.

    Raises
    ------
    floorplan.FloorplanError
        If the floorplan is not correct.
    floorplan.UserError
        If `top` is not above `bottom`.

    Examples
    --------
    >>> import floorplan
    >>> from navigation import CollisionWorld
    >>> world = CollisionWorld(floorplan.load("ariac2023"))
    >>> world.move_agv("agv1", "as1")
    >>> world.free((-5.0, 3.75), radius=0.3)
    True
    """

    def __init__(
        self,
        plan: Floorplan,
        *,
        bottom: float = 0.0,
        top: float | None = None,
        gates: Iterable[Gate] | None = None,
    ) -> None:
        check(plan)
        self.plan = plan
        minded = [gate for gate in plan.one_ways if gate.is_about("")] if gates is None else gates
        self.gates = Gates(minded)
        """One-way gates that apply."""
        self.bottom = bottom
        self.top = plan.human.height if top is None else top
        if not self.bottom < self.top:
            raise UserError(f"heights must rise, found {self.bottom:g} … {self.top:g}")
        blocked = tuple(plan.blocked(self.bottom, self.top))
        self.floor, self.edges = ground.floor(plan.boundary, blocked)
        """Floor without obstacles, one polygon or several, and its edges."""
        self._bounds: tuple[float, float, float, float] = plan.boundary.bounds
        self._solid = ground.solid(self.floor, self._bounds)
        self._sweep = Sweep()
        self._bodies: dict[str, CollisionBody] = {}
        self._there: tuple[Named[CollisionBody], MutableSequence[float]] | None = None
        self._agvs: dict[str, float] = {}
        self.changes = 0
        """Number of changes of bodies."""
        self._fixed_space: dict[float, FreeSpace] = {}
        self._roadmaps: dict[tuple[float, float], Roadmap] = {}
        self._free_space: dict[float, tuple[tuple[CollisionBody, ...], FreeSpace]] = {}
        for lane in plan.lanes:
            self.move_agv(lane.name, lane.start)

    def __reduce__(self) -> NoReturn:
        raise TypeError(f"a {type(self).__name__} holds FCL's geometry, which can't be copied")

    def __repr__(self) -> str:
        return f"<CollisionWorld of {self.plan.name!r} with {len(self._bodies)} bodies>"

    # Bodies

    def move_agv(self, name: str, to: float | str) -> None:
        """Move an AGV.

        Parameters
        ----------
        name : str
            Name of the AGV.
        to : float or str
            Lane position in metres, or location.

        Raises
        ------
        KeyError
            If there is no such AGV.
        floorplan.UserError
            If the position is not on its lane.
        """
        if self._agvs.get(name) == to:
            return
        lane = self.plan.lane(name)
        q = lane.lane_position(to)
        if self._agvs.get(name) == q:
            return
        self._agvs[name] = q
        self._put(name, lane.footprint(q), 0.0, lane.height)

    def agv_position(self, name: str) -> float:
        """Return the lane position of the AGV called `name` in metres."""
        self.plan.lane(name)
        return self._agvs[name]

    def place(
        self, name: str, shape: Polygon | Disc, bottom: float = 0.0, top: float | None = None
    ) -> None:
        """Add a body, or move the body of this name.

        Parameters
        ----------
        name : str
            Name of the body.
        shape : shapely.Polygon or Disc
            Footprint in metres.
        bottom, top : float, optional
            Heights in metres, by default the whole range of the world.

        Raises
        ------
        floorplan.UserError
            If the floorplan has something of this name, or if the shape is invalid.
        """
        obstacles, lanes = self.plan.obstacles, self.plan.lanes
        fixed = {"boundary", *(o.name for o in obstacles), *(lane.name for lane in lanes)}
        if name in fixed:
            raise UserError(f"{name!r} belongs to the floorplan; choose another name for a body")
        self._put(name, shape, bottom, self.top if top is None else top)

    def remove(self, name: str) -> None:
        """Remove the body called `name`. `KeyError` if there is none."""
        if name in self._agvs or name not in self._bodies:
            placed = ", ".join(n for n in self._bodies if n not in self._agvs) or "none"
            raise KeyError(f"no placed body is called {name!r} (there are: {placed})")
        del self._bodies[name]
        self._there = None
        self.changes += 1

    def as_if(
        self, there: Mapping[str, Polygon | Disc] | None = None, *, away: Collection[str] = ()
    ) -> CollisionWorld:
        """Return a copy of this world with other bodies. This world does not change.

        Parameters
        ----------
        there : mapping of str to shapely.Polygon or Disc, optional
            Additional footprints by name, over the whole range of heights.
        away : collection of str, optional
            Names of bodies that the copy lacks.

        Returns
        -------
        CollisionWorld
            Copy that shares everything that depends on the floor alone.

        Raises
        ------
        KeyError
            If a name in `away` is unknown.
        floorplan.UserError
            See `place`.
        """
        names = {*self._bodies, *(lane.name for lane in self.plan.lanes)}
        for name in away:
            if name not in names:
                raise KeyError(f"no body is called {name!r}; {suggestion(name, sorted(names))}")
        other = object.__new__(type(self))
        vars(other).update(vars(self))
        other._bodies = {name: b for name, b in self._bodies.items() if name not in away}
        other._agvs = {name: q for name, q in self._agvs.items() if name not in away}
        other._free_space = dict(self._free_space)
        other._there = None
        for name, shape in (there or {}).items():
            other.place(name, shape)
        return other

    @property
    def bodies(self) -> Named[CollisionBody]:
        """Bodies on the floor within the range of heights."""
        return self._standing[0]

    @property
    def bounds(self) -> MutableSequence[float]:
        """Bounds of the bodies: minimum x and y, maximum x and y of each in metres."""
        return self._standing[1]

    @property
    def _standing(self) -> tuple[Named[CollisionBody], MutableSequence[float]]:
        """Bodies and their bounds, cached until one moves."""
        if self._there is None:
            bodies = Named(self._bodies.values())
            self._there = bodies, numbers(bound for body in bodies for bound in body.bounds)
        return self._there

    def near(self, a: Point, b: Point, radius: float) -> list[CollisionBody]:
        """Return the bodies whose bounds a disc of `radius` metres meets between a and b."""
        bodies, bounds = self._standing
        return [bodies[k] for _, k in come_into(bounds, [a, b], radius)]

    def _put(self, name: str, shape: Polygon | Disc, bottom: float, top: float) -> None:
        body = (
            ground.body(name, shape)
            if isinstance(shape, Polygon)
            else CollisionBody.of(name, shape)
        )
        if bottom < self.top and self.bottom < top:
            self._bodies[name] = body
        else:
            self._bodies.pop(name, None)
        self._there = None
        self.changes += 1

    # Free space

    @property
    def walkable(self) -> shapely.Geometry:
        """Floor without everything on it (shapely, metres). It is not shrunk by a radius."""
        return self.floor.difference(shapely.union_all([body.footprint for body in self.bodies]))

    def free_space(self, radius: float) -> FreeSpace:
        """Return the free space of the centre of a disc of `radius` metres."""
        there = self.bodies
        cached = self._free_space.get(radius)
        if cached is not None and cached[0] == there:
            return cached[1]
        fresh = ground.free_space(self.floor, radius, there)
        self._free_space[radius] = (there, fresh)
        return fresh

    def fixed_space(self, radius: float) -> FreeSpace:
        """Return the free space without bodies. It is computed once per radius."""
        space = self._fixed_space.get(radius)
        if space is None:
            space = self._fixed_space[radius] = ground.fixed_space(self.floor, radius)
        return space

    def narrows(self, radius: float, abreast: int = 2) -> Narrows:
        """Return the narrow places of the floor, and 0.35 m around them.

        Discs of `radius` metres do not pass there `abreast`. Bodies do not count.
        """
        return ground.narrow_places(self.floor, radius, abreast)

    @property
    def walls(self) -> Grid:
        """Edges of the floor. Bodies do not count."""
        return ground.walls(self.floor)

    def roadmap(self, radius: float, step: float) -> Roadmap:
        """Return the visibility graph of the floor for discs of `radius` metres.

        Its paths turn by at most `step` radians per waypoint. It is computed once per radius and
        step.
        """
        roadmap = self._roadmaps.get((radius, step))
        if roadmap is None:
            roadmap = ground.roadmap(self.floor, radius, step, self.gates.all)
            self._roadmaps[radius, step] = roadmap
        return roadmap

    # Queries

    def free(self, point: Point, radius: float) -> bool:
        """Return whether a disc of `radius` metres around `point` touches nothing."""
        return self.segment_free(point, point, radius)

    def segment_free(
        self, a: Point, b: Point, radius: float, among: Iterable[CollisionBody] | None = None
    ) -> bool:
        """Return whether a disc can move along a segment.

        Parameters
        ----------
        a, b : Point
            Ends of the segment (x, y) in metres.
        radius : float
            Radius in metres.
        among : iterable of CollisionBody, optional
            Bodies to check, by default all.

        Returns
        -------
        bool
            True if the disc touches nothing, and crosses no gate against its direction.
        """
        if self.gates.lines and not self.gates.allow(a, b):
            return False
        if not self._within(a, b, radius):
            return False
        sweep = self._sweep.between(a, b, radius)
        if touch(sweep, self._solid):
            return False
        if among is None:
            near = self.near(a, b, radius)
        else:
            near = [body for body in among if body.near(a, b, radius)]
        return not (near and any(touch(sweep, body.solid) for body in near))

    def clear_of(self, shape: Any, bounds: tuple[float, float, float, float]) -> bool:
        """Return whether an FCL object within `bounds` (metres) touches nothing on the floor."""
        low, high = (bounds[0], bounds[1]), (bounds[2], bounds[3])
        if not self._within(low, high, 0.0) or touch(shape, self._solid):
            return False
        return not any(touch(shape, body.solid) for body in self.near(low, high, 0.0))

    def hits(self, a: Point, b: Point, radius: float) -> list[CollisionBody]:
        """Return the bodies that a disc of `radius` metres touches between a and b."""
        near = self.near(a, b, radius)
        if not near:
            return []
        sweep = self._sweep.between(a, b, radius)
        return [body for body in near if touch(sweep, body.solid)]

    def distance(self, point: Point) -> float:
        """Return the distance from `point` to the nearest obstacle, body or boundary in metres.

        It is 0 inside an obstacle and outside the boundary.
        """
        if not self._within(point, point, 0.0):
            return 0.0
        solids = [self._solid, *(body.solid for body in self._bodies.values())]
        return min(self._sweep.distance(point, solid) for solid in solids)

    def clearance(self, points: ArrayLike, among: Iterable[CollisionBody] | None = None) -> float:
        """Return the minimum distance along a polyline.

        Parameters
        ----------
        points : array_like
            Waypoints, shape (N, 2), in metres.
        among : iterable of CollisionBody, optional
            Bodies to check, by default all.

        Returns
        -------
        float
            Distance to obstacles, bodies and boundary in metres, 0 if the polyline leaves the
            floor.
        """
        along = np.asarray(points, dtype=float)
        still = bool((along == along[0]).all())
        line = shapely.Point(along[0]) if still else shapely.linestrings(along)
        if not self.floor.covers(line):
            return 0.0
        least = float(shapely.distance(self.edges, line))
        bodies = self._bodies.values() if among is None else among
        return min([least, *(body.clear_of(line) for body in bodies)])

    def nearest(self, point: Point) -> tuple[str, float]:
        """Return the name of the nearest obstacle or body, and its distance in metres.

        The edge of the floor is called "boundary". Outside it, the answer is ("boundary", 0.0).
        """
        return self.neighbours(point)[0]

    def neighbours(self, point: Point) -> list[tuple[str, float]]:
        """Return names and distances (metres) of all obstacles and bodies, nearest first."""
        at = shapely.Point(point)
        inside = self.plan.boundary.contains(at)
        edge = float(shapely.distance(self.plan.boundary.exterior, at)) if inside else 0.0
        things = self.things()
        with np.errstate(over="ignore"):
            gaps = shapely.distance([shape for _, shape in things], at)
        neighbours = [("boundary", edge)]
        neighbours += [(name, float(gap)) for (name, _), gap in zip(things, gaps, strict=True)]
        return sorted(neighbours, key=lambda named: named[1])

    def things(self) -> list[tuple[str, Polygon]]:
        """Return names and footprints of all obstacles and bodies."""
        fixed = [
            (o.name, o.footprint) for o in self.plan.obstacles if o.overlaps(self.bottom, self.top)
        ]
        return fixed + [(body.name, body.footprint) for body in self._bodies.values()]

    def reaches(self, start: Point, goal: Point, radius: float) -> bool:
        """Return whether a disc of `radius` metres can move from `start` to `goal` at present."""
        return self.gates.reach(self.free_space(radius), start, goal)

    def nearest_free(self, point: Point, radius: float) -> Point | None:
        """Return the nearest position with room for a disc of `radius` metres, or None."""
        # Only bodies near the point, near its result without them, near the sides of that, or
        # between can change the result. Add such bodies until none is missing.
        among: set[str] = set()
        while True:
            bodies = tuple(body for body in self.bodies if body.name in among)
            space = ground.free_space(self.floor, radius, bodies)
            place = space.nearest(point)
            if place is None:
                return None
            (low_x, low_y), (high_x, high_y) = space.bounds_at(place)
            away = math.dist(point, place)
            low = min(low_x, point[0] - away), min(low_y, point[1] - away)
            high = max(high_x, point[0] + away), max(high_y, point[1] + away)
            near = {body.name for body in self.near(low, high, _WIDER * radius + HAIR)}
            if near <= among:
                return place
            among |= near

    def exits(self, point: Point, radius: float) -> list[Point]:
        """Return positions to leave a point where bodies leave a disc no room.

        There is one for each reachable piece of the free space, nearest first. On the straight
        segment to it, the disc touches only the bodies that it touches at `point`, and comes no
        closer to them. Without fixed obstacles in the way only.

        Parameters
        ----------
        point : Point
            Position (x, y) in metres.
        radius : float
            Radius in metres.

        Returns
        -------
        list of Point
            Positions (x, y) in metres.
        """
        keep = radius - _ROUNDING
        touched = self.hits(point, point, radius + HAIR)
        others = self.as_if(away=[body.name for body in touched])
        if not others.free(point, keep):
            return []

        def clear(place: Point) -> bool:
            line, at = shapely.linestrings([point, place]), shapely.Point(point)
            return others.segment_free(point, place, keep) and all(
                body.clear_of(line) >= body.clear_of(at) - _ROUNDING for body in touched
            )

        # Beyond this distance, none of them can touch the disc.
        reach = HAIR + sum(math.dist(b.bounds[:2], b.bounds[2:]) + 2 * radius for b in touched)
        exits = self.free_space(radius + HAIR).outward(point, reach)
        nearest = [next(filter(clear, places), None) for places in exits]
        return sorted(
            (place for place in nearest if place is not None),
            key=lambda place: math.dist(point, place),
        )

    def _within(self, a: Point, b: Point, margin: float) -> bool:
        """Return whether a and b are finite and inside the bounds of the floor by `margin`."""
        (ax, ay), (bx, by), (low_x, low_y, high_x, high_y) = a, b, self._bounds
        return (
            low_x + margin <= ax <= high_x - margin
            and low_x + margin <= bx <= high_x - margin
            and low_y + margin <= ay <= high_y - margin
            and low_y + margin <= by <= high_y - margin
        )
