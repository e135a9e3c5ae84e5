"""The roadmap as a planner of OMPL's: the shortest path along the corners of what stands there."""

from __future__ import annotations

import itertools
import weakref
from collections.abc import Callable, Collection
from typing import Any

import ompl.base as ob

from floorplan import Point

from .bodies import TOLERANCE, Body
from .catalog import ROADMAP
from .freespace import STEP
from .kernels.edges import Room, touches
from .ompl_setup import OmplFloor, path_along
from .roadmap import HAIR, Roadmap
from .search import shortest_path
from .world import CollisionWorld

SLACK = HAIR / 2
"""Metres. Clearance asked of a path beyond the radius, so that rounding can't take it away."""

_SURE = 2 * TOLERANCE
"""Metres. What has so much room beyond what is asked has room by FCL, too."""

_MOST_JUDGED = 4096
"""Number of links of which FCL's answer among the bodies near them is kept."""


class Links:
    """What is in the way of links, for discs of `radius` metres.

    A search asks what the floor and the bodies leave `clear`, worked out in the plane; OMPL asks
    whether links are `free`, which FCL decides.
    """

    def __init__(self, world: CollisionWorld, radius: float) -> None:
        self.world = world
        self.radius = radius
        self.among: list[Body] | None = None
        """The bodies that count for OMPL; None for all."""
        self.judged: dict[tuple[Point, Point], tuple[list[Body], bool, int]] = {}
        """What FCL said of links between bends, among which bodies, and in how many checks."""
        self._keep = radius + SLACK
        self._walls = world.walls(self._keep)
        self._floor = self.room([])
        self._place = self.room([], _SURE)

    def holds(self, place: Point) -> bool:
        """Return whether there is room at a place, and so much that FCL can't but agree."""
        if not self._place.holds(*place):
            return False
        near = self.world.near(place, place, self._keep + _SURE)
        return not any(self.blocks(body, place, place, _SURE) for body in near)

    def clear(self, a: Point, b: Point) -> bool:
        """Return whether the floor leaves room on the link from a, where there is room, to b."""
        self.world.checks += 1
        return self._floor.clear(*a, *b, True)

    def near(self, a: Point, b: Point) -> list[Body]:
        """Return the bodies that may be in the way on the link from a to b."""
        near = self.world.near(a, b, self._keep)
        self.world.checks += len(near)
        return near

    def blocks(self, body: Body, a: Point, b: Point, beyond: float = 0.0) -> bool:
        """Return whether a body is in the way on the link from a, where it is not, to b."""
        edges, rounding = body.outline
        return touches(edges, *a, *b, self._keep + rounding + beyond)

    def room(self, bodies: Collection[Body], beyond: float = 0.0) -> Room:
        """Return the room that the floor and `bodies` leave, `beyond` what is kept (metres)."""
        outlines = [body.outline for body in bodies]
        return Room(self._walls.grid, self._keep + beyond, outlines, self.world.gates.lines)

    def free(self, a: Point, b: Point) -> bool:
        """Return whether the link from a to b is free."""
        return self.world.segment_free(a, b, self._keep, self.among)

    def hit(self, a: Point, b: Point) -> bool:
        """Return whether a body is touched on the link from a to b, by FCL."""
        return bool(self.world.hits(a, b, self._keep))


class RoadmapSearch:
    """One search of the roadmap from `start` to `goal`, in bends of `step` radians at most.

    It goes by what is clear in the plane; of the path that it finds, `ask` decides about each link.
    Where one is refused, it searches on without that.
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
        self._ask = ask
        self._refused: set[tuple[Point, Point]] = set()

    def path(self) -> list[Point] | None:
        """Return the points of the shortest path, or None if there is none."""
        links, start, goal = self._links, self._start, self._goal
        straight = links.clear(start, goal)
        if straight:
            near = links.near(start, goal)
            blocked = any(links.blocks(body, start, goal) for body in near)
            if not blocked and self._granted(start, goal):
                return [start, goal]
        world, space = links.world, links.world.fixed_space(links.radius + HAIR)
        # Where there is room at both ends, they can only be apart on a floor in pieces.
        in_pieces = bool(world.gates) or len(space.pieces) != 1
        if in_pieces and not world.gates.reach(space, start, goal):
            return None
        # Wide bends may close a narrow gap. Where they lead nowhere, and nothing proves that
        # nothing does, fine ones decide.
        for step in (self._step, STEP):
            points = self._around_bodies(world.roadmap(links.radius, step), straight)
            if points is not None or self._hopeless():
                return points
        return None

    def _around_bodies(self, roadmap: Roadmap, straight: bool) -> list[Point] | None:
        """Return the shortest path on `roadmap` round the bodies that it meets.

        Bodies are taken in only when a path runs into them. That is enough: a shortest path round
        some of the bodies that is clear of all others is the shortest path round all. `straight` is
        true where nothing but bodies is in the way to the goal.
        """
        links, start, goal = self._links, self._start, self._goal
        met: list[Body] = []
        points: list[Point] | None = [start, goal] if straight else None
        while True:
            # Only asked anew where a body was met, or FCL has refused a link of the answer.
            if points is None or not self._refused.isdisjoint(itertools.pairwise(points)):
                room, refused = links.room(met), self._refused
                points = shortest_path(
                    roadmap, start, goal, straight, met, room, refused, self._hopeless
                )
                links.world.checks += room.asked
            if points is None:
                return None
            pairs = [*itertools.pairwise(points)]
            nears = [links.near(*pair) for pair in pairs]
            touched = {
                body: None
                for pair, near in zip(pairs, nears, strict=True)
                for body in near
                if links.blocks(body, *pair)
            }
            fresh = [body for body in touched if body not in met]
            asked = zip(pairs, nears, strict=True)
            if not fresh and all(self._granted(*pair, near, roadmap) for pair, near in asked):
                return points
            points = None
            met += fresh

    def _granted(
        self, a: Point, b: Point, near: list[Body] | None = None, roadmap: Roadmap | None = None
    ) -> bool:
        """Return whether the link from a to b is free, and keep in mind that it is not.

        Links between bends, of `roadmap` or of bodies, are asked once for as long as the same
        bodies stand `near` them.
        """
        links, known = self._links, None
        fixed = roadmap is not None and a in roadmap.places and b in roadmap.places
        if near is not None and (fixed or (a != self._start and b != self._goal)):
            known = links.judged.get((a, b))
            if known is None or known[0] != near:
                before = links.world.checks
                free = self._asked_of(roadmap, a, b) if roadmap and fixed else self._ask(a, b)
                if len(links.judged) >= _MOST_JUDGED:
                    links.judged.clear()
                links.judged[a, b] = near, free, links.world.checks - before
            else:
                free = known[1]
                links.world.checks += known[2]  # figures don't depend on earlier questions
        else:
            free = self._ask(a, b)
        if not free:
            self._refused.add((a, b))
        return free

    def _asked_of(self, roadmap: Roadmap, a: Point, b: Point) -> bool:
        """Return whether a link between bends of `roadmap` is free.

        Of the floor these are asked once: they change no more than it does.
        """
        links, known = self._links, roadmap.asked.get((a, b))
        if known is None:
            links.among = []
            known = roadmap.asked[a, b] = self._ask(a, b)
            links.among = None
        else:
            links.world.checks += 1  # as if asked
        return known and not links.hit(a, b)

    def _hopeless(self) -> bool:
        """Return True if it is proved that there is no path."""
        room = self._links.radius + HAIR
        return not self._links.world.reaches(self._start, self._goal, room)


class RoadmapPlanner(ob.Planner):  # type: ignore[misc]
    """Planner of OMPL's that answers one question with the shortest path on the roadmap.

    Each link of the path is asked of OMPL's motion validator, which asks FCL. The question is
    handed over here: OMPL 2.0.1 frees start states that Python has read from a problem definition
    twice.
    """

    def __init__(
        self, floor: OmplFloor, links: Links, start: Point, goal: Point, step: float
    ) -> None:
        super().__init__(floor.information, ROADMAP)
        self._floor = floor
        self._question = (links, start, goal, step)
        self.points: list[Point] | None = None
        """The path that was found, as the problem has it."""

    def solve(self, _: Any) -> Any:
        """Add the shortest path to the problem, if there is one."""
        information, here, there = self._floor.information, self._floor.here, self._floor.there

        def ask(a: Point, b: Point) -> bool:
            here[0], here[1] = a
            there[0], there[1] = b
            return bool(information.checkMotion(here, there))

        points = self.points = RoadmapSearch(*self._question, ask).path()
        if points is None:
            return ob.PlannerStatus(ob.PlannerStatus.INFEASIBLE)
        self.getProblemDefinition().addSolutionPath(path_along(information, points))
        return ob.PlannerStatus(ob.PlannerStatus.EXACT_SOLUTION)


class RoadmapQuestions:
    """Questions to the roadmap of `world` for discs of `radius` metres, put by OMPL.

    FCL decides for OMPL what is free. Its space is made once; each question is a problem, and a
    planner, of its own.
    """

    def __init__(self, world: CollisionWorld, radius: float) -> None:
        self.links = Links(world, radius)
        low_x, low_y, high_x, high_y = world.plan.boundary.bounds
        self._floor = OmplFloor((low_x, low_y), (high_x, high_y), self.links.free)
        # At exit OMPL must let go before Python does; nobody may ask any more then.
        self.release = weakref.finalize(self, self._floor.release)

    def path(self, start: Point, goal: Point, step: float) -> list[Point] | None:
        """Return the shortest path in bends of `step` radians at most; None where there is none."""
        floor, problem = self._floor, ob.ProblemDefinition(self._floor.information)
        (floor.here[0], floor.here[1]), (floor.there[0], floor.there[1]) = start, goal
        problem.setStartAndGoalStates(floor.here, floor.there)
        planner = RoadmapPlanner(floor, self.links, start, goal, step)
        planner.setProblemDefinition(problem)
        planner.solve(ob.plannerNonTerminatingCondition())
        return planner.points if problem.hasExactSolution() else None
