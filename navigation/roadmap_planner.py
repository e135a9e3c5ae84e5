"""Planner of OMPL that searches the roadmap for the shortest path along corners."""

from __future__ import annotations

import itertools
import weakref
from collections.abc import Callable, Collection
from typing import Any

import ompl.base as ob

from floorplan import Point

from .bodies import TOLERANCE, CollisionBody
from .catalog import ROADMAP
from .freespace import STEP
from .kernels.edges import Room, come_into, touches
from .roadmap import HAIR, Roadmap
from .sampling import OmplFloor, path_along
from .world import CollisionWorld

SLACK = HAIR / 2
"""Metres. Required clearance of a path beyond the radius, against rounding."""

_SURE = 2 * TOLERANCE
"""Metres. With this additional clearance, a segment is free in FCL too."""


class Links:
    """Collision tests of links for discs of `radius` metres.

    A search tests links in the plane. OMPL asks whether links are `free`, which FCL decides.
    """

    def __init__(self, world: CollisionWorld, radius: float) -> None:
        self.world = world
        self.radius = radius
        self.among: list[CollisionBody] | None = None
        """Bodies that count for OMPL, or None for all."""
        self._judged: dict[tuple[Point, Point], bool] = {}
        self._judged_at = world.changes
        self._keep = radius + SLACK
        self._walls = world.walls
        self._floor = self.room([])
        self._place = self.room([], _SURE)

    @property
    def judged(self) -> dict[tuple[Point, Point], bool]:
        """FCL's results for links since a body moved."""
        if self._judged_at != self.world.changes:
            self._judged, self._judged_at = {}, self.world.changes
        return self._judged

    def holds(self, place: Point) -> bool:
        """Return whether a position is certainly free, without a query to FCL."""
        if not self._place.holds(*place):
            return False
        near = self.world.near(place, place, self._keep + _SURE)
        return not (near and any(self.blocks(body, place, place, _SURE) for body in near))

    def clear(self, a: Point, b: Point) -> bool:
        """Return whether the link from a, which is free, to b is clear of the floor's edges."""
        return self._floor.clear(*a, *b, True)

    def met(self, points: list[Point]) -> list[CollisionBody]:
        """Return the bodies in the way on the polyline `points`, in order."""
        met: list[CollisionBody] = []
        near = come_into(self.world.bounds, points, self._keep)
        if near:
            bodies = self.world.bodies
            for leg, k in near:
                if bodies[k] not in met and self.blocks(bodies[k], points[leg], points[leg + 1]):
                    met.append(bodies[k])
        return met

    def blocks(self, body: CollisionBody, a: Point, b: Point, beyond: float = 0.0) -> bool:
        """Return whether a body is in the way on the link from a, where it is not, to b."""
        edges, rounding = body.outline
        return touches(edges, *a, *b, self._keep + rounding + beyond)

    def room(self, bodies: Collection[CollisionBody], beyond: float = 0.0) -> Room:
        """Return the room among the floor and `bodies`, `beyond` the clearance (metres)."""
        outlines = [body.outline for body in bodies]
        return Room(self._walls, self._keep + beyond, outlines, self.world.gates.lines)

    def free(self, a: Point, b: Point) -> bool:
        """Return whether the link from a to b is free."""
        return self.world.segment_free(a, b, self._keep, self.among)

    def hit(self, a: Point, b: Point) -> bool:
        """Return whether a body touches the disc on the link from a to b, by FCL."""
        return bool(self.world.hits(a, b, self._keep))


class RoadmapSearch:
    """Search of the roadmap from `start` to `goal`, with bends of at most `step` radians.

    It uses tests in the plane. `ask` then decides about each link of the resulting path. If it
    rejects one, the search continues without that link.
    """

    def __init__(
        self,
        links: Links,
        start: Point,
        goal: Point,
        step: float,
        ask: Callable[[Point, Point], bool],
    ) -> None:
        self._links = links
        self._start, self._goal = start, goal
        self._step = step
        self._room = links.radius + HAIR
        self._ask = ask
        self._refused: set[tuple[Point, Point]] = set()

    def path(self) -> list[Point] | None:
        """Return the points of the shortest path, or None if there is none."""
        links, start, goal = self._links, self._start, self._goal
        points = [start, goal]
        straight = links.clear(start, goal)
        met = links.met(points) if straight else []
        if straight and not met and self._granted(points):
            return points
        if start == goal:
            return None
        # Wide bends may close a narrow gap. If they lead nowhere, and there is no proof that no
        # path exists, fine bends decide.
        for step in (self._step, STEP):
            path = self._around_bodies(links.world.roadmap(links.radius, step), straight, met)
            if path is not None or self._hopeless():
                return path
        return None

    def _around_bodies(
        self, roadmap: Roadmap, straight: bool, met: list[CollisionBody]
    ) -> list[Point] | None:
        """Return the shortest path on `roadmap` around the bodies that it meets, and those `met`.

        A body is added only when a path meets it. That is sufficient, because a shortest path
        around some of the bodies that is clear of all others is the shortest path around all.
        `straight` is true if only bodies can be between start and goal.
        """
        links = self._links
        while True:
            room = links.room(met)
            points = roadmap.path(self._start, self._goal, straight, met, room, self._refused)
            if points is None:
                return None
            fresh = links.met(points)
            if not fresh and self._granted(points, roadmap):
                return points
            met = met + fresh

    def _granted(self, points: list[Point], roadmap: Roadmap | None = None) -> bool:
        """Return whether all links of a path are free. Refuse a link that is not from then on."""
        judged = self._links.judged
        for link in itertools.pairwise(points):
            free = judged[link] if link in judged else self._judge(*link, roadmap)
            if not free:
                self._refused.add(link)
                return False
        return True

    def _judge(self, a: Point, b: Point, roadmap: Roadmap | None) -> bool:
        """Return whether the link from a to b is free.

        Results for links between bends, of `roadmap` or of bodies, are cached until a body moves.
        """
        fixed = roadmap is not None and a in roadmap.places and b in roadmap.places
        free = self._asked_of(roadmap, a, b) if roadmap and fixed else self._ask(a, b)
        if fixed or (a != self._start and b != self._goal):
            self._links.judged[a, b] = free
        return free

    def _asked_of(self, roadmap: Roadmap, a: Point, b: Point) -> bool:
        """Return whether a link between bends of `roadmap` is free.

        Results for the floor alone are cached with the roadmap.
        """
        links, free = self._links, roadmap.verdicts.get((a, b))
        if free is None:
            links.among = []
            free = roadmap.verdicts[a, b] = self._ask(a, b)
            links.among = None
        return free and not links.hit(a, b)

    def _hopeless(self) -> bool:
        """Return whether a proof exists that there is no path."""
        world, ends = self._links.world, (self._start, self._goal)
        # Test the floor without bodies first. The triangles of the roadmap give most proofs, and
        # the free space the rest.
        if world.roadmap(self._links.radius, self._step).apart(*ends):
            return True
        space = world.fixed_space(self._room)
        return not (world.gates.reach(space, *ends) and world.reaches(*ends, self._room))


class RoadmapPlanner(ob.Planner):  # type: ignore[misc]
    """OMPL planner that answers one query with the shortest path on the roadmap.

    OMPL's motion validator tests each link of the path by FCL. The query is passed to the
    constructor, because OMPL 2.0.1 frees start states twice that Python has read from a problem
    definition.
    """

    def __init__(
        self, floor: OmplFloor, links: Links, start: Point, goal: Point, step: float
    ) -> None:
        super().__init__(floor.information, ROADMAP)
        self._floor = floor
        self._question = (links, start, goal, step)
        self.points: list[Point] | None = None
        """Points of the path."""

    def solve(self, _: Any) -> Any:
        """Add the shortest path to the problem."""
        points = self.points = RoadmapSearch(*self._question, self._floor.moves).path()
        if points is None:
            return ob.PlannerStatus(ob.PlannerStatus.INFEASIBLE)
        self.getProblemDefinition().addSolutionPath(path_along(self._floor.information, points))
        return ob.PlannerStatus(ob.PlannerStatus.EXACT_SOLUTION)


class RoadmapQuestions:
    """Queries to the roadmap of `world` for discs of `radius` metres, posed by OMPL.

    OMPL's space is created once. Each query is a new problem and planner. In addition to these, a
    query costs a search, and FCL's tests of the first and the last link of the path. All other
    results are cached: with the floor (`Roadmap`), and until a body moves (`Links.judged`).
    """

    def __init__(self, world: CollisionWorld, radius: float) -> None:
        self.links = Links(world, radius)
        low_x, low_y, high_x, high_y = world.plan.boundary.bounds
        self._floor = OmplFloor((low_x, low_y), (high_x, high_y), self.links.free)
        # OMPL's objects must be released before Python's at exit.
        self.release = weakref.finalize(self, self._floor.release)

    def path(self, start: Point, goal: Point, step: float) -> list[Point] | None:
        """Return the shortest path with bends of at most `step` radians, or None."""
        floor, problem = self._floor, ob.ProblemDefinition(self._floor.information)
        (floor.here[0], floor.here[1]), (floor.there[0], floor.there[1]) = start, goal
        problem.setStartAndGoalStates(floor.here, floor.there)
        planner = RoadmapPlanner(floor, self.links, start, goal, step)
        planner.setProblemDefinition(problem)
        planner.solve(ob.plannerNonTerminatingCondition())
        return planner.points if problem.hasExactSolution() else None
