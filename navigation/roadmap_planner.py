"""The roadmap as a planner of OMPL's: the shortest path along the corners of what stands there."""

from __future__ import annotations

import itertools
import weakref
from collections.abc import Callable
from functools import partial
from typing import Any

import ompl.base as ob

from floorplan import Point

from .bodies import Body
from .catalog import ROADMAP
from .freespace import STEP
from .lookup import LookUp
from .ompl_setup import OmplFloor, path_along, points_of, state_at
from .roadmap import HAIR, Ends, Roadmap
from .search import shortest_path
from .world import CollisionWorld

SLACK = HAIR / 2
"""Metres. Clearance asked of a path beyond the radius, so that rounding can't take it away."""

_MANY = 3
"""Once a path meets this many bodies, it pays to find out first whether there is one at all."""


class Links:
    """FCL's answers about links, for discs of `radius` metres.

    Of the bodies only those in `met` count, or all while that is None.
    """

    def __init__(self, world: CollisionWorld, radius: float) -> None:
        self.world = world
        self.radius = radius
        self.met: list[Body] | None = None

    def free(self, a: Point, b: Point) -> bool:
        """Return whether the link from a to b is free."""
        return self.world.segment_free(a, b, self.radius + SLACK, self.met)

    def bodies(self, a: Point, b: Point) -> list[Body]:
        """Return the bodies in the way on the link from a to b."""
        return self.world.hits(a, b, self.radius + SLACK)


class RoadmapSearch:
    """One search of the roadmap from `start` to `goal`, in bends of `step` radians at most.

    shapely proposes links; `ask` decides about each that the search takes. `links` are told which
    bodies count for it.
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

    def _free_on(self, roadmap: Roadmap, here: int, there: int, a: Point, b: Point) -> bool:
        """Return whether the link from place `here` at a to place `there` at b is free.

        Links between the floor's own bends are asked once: they change no more than the floor.
        """
        if min(here, there) < 0 or max(here, there) >= len(roadmap.bends):
            return self._ask(a, b)
        link = roadmap.number(here, there)
        met, self._links.met = self._links.met, []
        free = roadmap.asked.get(link)
        if free is None:
            free = roadmap.asked[link] = self._ask(a, b)
        else:
            self._links.world.checks += 1  # as if asked: figures don't depend on earlier questions
        self._links.met = met
        return free and not (met and any(body in met for body in self._links.bodies(a, b)))

    def path(self) -> list[Point] | None:
        """Return the points of the shortest path, or None if there is none."""
        links, start, goal = self._links, self._start, self._goal
        links.met = None
        if self._ask(start, goal):
            return [start, goal]
        world, room = links.world, links.radius + HAIR
        if not world.gates.reach(world.fixed_space(room), start, goal):
            return None
        for step in (self._step, STEP):
            points = self._around_bodies(world.roadmap(links.radius, step))
            if points is not None or self._hopeless():
                return points
        return None

    def _around_bodies(self, roadmap: Roadmap) -> list[Point] | None:
        """Return the shortest path on `roadmap` round the bodies that it meets.

        Bodies are taken in only when a path runs into them. That is enough: a shortest path round
        some of the bodies that is clear of all others is the shortest path round all.
        """
        met: list[Body] = []
        self._links.met = met
        free = partial(self._free_on, roadmap)
        points = None
        known: LookUp | None = None
        if roadmap.between is not None:
            known = LookUp(roadmap, self._start, self._goal, free)
        if self._links.bodies(self._start, self._goal) and self._ask(self._start, self._goal):
            points = [self._start, self._goal]  # but for bodies
        elif known is not None:
            points = known.path()
        ends: Ends | None = None
        while True:
            if points is None:
                if ends is None:
                    ends = known.ends() if known else roadmap.ends(self._start, self._goal)
                points, known_links = shortest_path(roadmap, ends, met, free, self._hopeless)
                self._links.world.checks += known_links  # as above
            if points is None:
                return None
            fresh = [
                body
                for a, b in itertools.pairwise(points)
                for body in self._links.bodies(a, b)
                if body not in met
            ]
            if not fresh:
                return points
            points = None
            met += dict.fromkeys(fresh)
            if len(met) >= _MANY and self._hopeless():
                return None

    def _hopeless(self) -> bool:
        """Return True if it is proved that there is no path."""
        room = self._links.radius + HAIR
        return not self._links.world.reaches(self._start, self._goal, room)


class RoadmapPlanner(ob.Planner):  # type: ignore[misc]
    """Planner of OMPL's that answers one question with the shortest path on the roadmap.

    Each link that the search takes is asked of OMPL's motion validator, which asks FCL. The
    question is handed over here: OMPL 2.0.1 frees start states that Python has read from a problem
    definition twice.
    """

    def __init__(
        self, information: Any, links: Links, start: Point, goal: Point, step: float
    ) -> None:
        super().__init__(information, ROADMAP)
        self._information = information
        self._question = (links, start, goal, step)

    def solve(self, _: Any) -> Any:
        """Add the shortest path to the problem, if there is one."""
        information = self._information

        def ask(a: Point, b: Point) -> bool:
            return bool(information.checkMotion(state_at(information, a), state_at(information, b)))

        points = RoadmapSearch(*self._question, ask).path()
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
        self._links = Links(world, radius)
        low_x, low_y, high_x, high_y = world.plan.boundary.bounds
        self._floor = OmplFloor((low_x, low_y), (high_x, high_y), self._links.free)
        # At exit OMPL must let go before Python does; nobody may ask any more then.
        self.release = weakref.finalize(self, self._floor.release)

    def path(self, start: Point, goal: Point, step: float) -> list[Point] | None:
        """Return the shortest path in bends of `step` radians at most; None where there is none."""
        information = self._floor.information
        problem = ob.ProblemDefinition(information)
        problem.setStartAndGoalStates(state_at(information, start), state_at(information, goal))
        planner = RoadmapPlanner(information, self._links, start, goal, step)
        planner.setProblemDefinition(problem)
        planner.solve(ob.plannerNonTerminatingCondition())
        if not problem.hasExactSolution():
            return None
        return points_of(problem.getSolutionPath(), start, goal)
