"""Path planning for people."""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Hashable, Mapping
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from floorplan import Point, UserError
from floorplan.files.values import require

from .catalog import ROADMAP, Path, PlannerChoice, PlanningError, Reason, Setting, Watch
from .freespace import STEP, Gates
from .kernels.walks import distinct, is_place
from .obstruction import blocked_place, explain_cut_off
from .roadmap import HAIR, Roadmap
from .roadmap_planner import SLACK, RoadmapQuestions
from .sampling import OmplQuery, sample_path
from .world import CollisionWorld

COARSE = math.radians(15.0)
"""Default turn of a path per waypoint in radians."""

TOO_CLOSE = 1e-3
"""Metres. Tolerance for a start that is too close to something."""

_STEP = HAIR / 100
"""Metres. Shorter segments are left out, because their direction is mostly rounding."""


class PathPlanner:
    """Planner of paths through a `CollisionWorld` for a disc.

    It reads the world when a path is requested.

    Parameters
    ----------
    world : CollisionWorld
        World.
    radius : float, optional
        Radius in metres, by default the radius of the floor's people.
    ignore : collection of str, optional
        Names of bodies that are no obstacles, such as the person who plans.
    step : float, optional
        Maximum turn per waypoint around a corner in radians. Smaller turns follow corners more
        closely and give more waypoints.
    planner : str, mapping, type or PlannerChoice, optional
        Planner by name, with its parameters, or the class of a custom planner.
    seed : int, optional
        Seed of planners that draw samples.
    keep : int, optional
        Maximum number of paths to cache until a body moves.

    Raises
    ------
    floorplan.UserError
        If a value is out of range, or if the planner or a parameter is unknown.

    Examples
    --------
    >>> import floorplan
    >>> from navigation import CollisionWorld, PathPlanner
    >>> world = CollisionWorld(floorplan.load("ariac2023"))
    >>> path = PathPlanner(world, radius=0.3).plan((-15.0, -10.0), (-5.0, 3.75))
    >>> round(path.length, 2)
    17.0
    """

    def __init__(
        self,
        world: CollisionWorld,
        radius: float | None = None,
        ignore: Collection[str] = (),
        *,
        step: float = COARSE,
        planner: PlannerChoice | str | Mapping[str, Any] | type = ROADMAP,
        seed: int = 0,
        keep: int = 0,
    ) -> None:
        require(world, CollisionWorld)
        self.world = world
        self.radius = world.plan.human.radius if radius is None else float(radius)
        if not 0 < self.radius < math.inf:
            raise UserError(f"a radius must be positive and finite, found {self.radius:g}")
        if not STEP <= step <= math.pi / 2:
            raise UserError(f"bends must be from {STEP:.3g} to 1.57 radians, found {step:g}")
        self.ignore = frozenset(ignore)
        self.step = step
        self.choice = PlannerChoice.of(planner)
        """Default planner of queries."""
        self.choice.check()
        self.seed = seed
        self._queries: RoadmapQuestions | None = None
        self._keep = keep
        self._cached: dict[Hashable, Path] = {}
        self._footings: dict[tuple[Point, float], Point] = {}
        """First position from a place that is too close to something, by place and tolerance."""
        self._cached_at = world.changes

    def __repr__(self) -> str:
        return f"<PathPlanner for a radius of {self.radius:g} m in {self.world!r}>"

    def plan(
        self,
        start: ArrayLike,
        goal: ArrayLike,
        *,
        planner: PlannerChoice | str | Mapping[str, Any] | type | None = None,
        parameters: Mapping[str, Setting] | None = None,
        seed: int | None = None,
        watch: Watch | None = None,
    ) -> Path:
        """Return a path from `start` to `goal`.

        Paths of the default planner are the shortest, except for at most 0.6 % of their arcs around
        corners. Other planners are those of OMPL.

        Parameters
        ----------
        start, goal : array_like
            Positions (x, y) in metres.
        planner : str, mapping, type or PlannerChoice, optional
            Planner for this query, by default the planner of the constructor.
        parameters : mapping of str to bool, int, float or str, optional
            Parameters of the planner by name.
        seed : int, optional
            Seed for this query. The same seed gives the same path.
        watch : Watch, optional
            Observer of a search of an OMPL planner.

        Returns
        -------
        Path
            Path along which the disc touches nothing.

        Raises
        ------
        PlanningError
            If there is no path, with the reason.
        floorplan.UserError
            If a position is not finite, or if the planner or a parameter is unknown.
        """
        choice = self._choice(planner, parameters)
        seed = self.seed if seed is None else seed
        a, b = _place(start, "start"), _place(goal, "goal")
        if not self._keep:
            return self._find(a, b, choice, seed, watch)
        if self._cached_at != self.world.changes:
            self._cached_at = self.world.changes
            self._cached.clear()
            self._footings.clear()
        query = (a, b, choice, seed)
        path = self._cached.get(query)
        if path is None:
            path = self._cached[query] = self._find(a, b, choice, seed, watch)
            if len(self._cached) > self._keep:
                del self._cached[next(iter(self._cached))]
        return path

    def _find(
        self, a: Point, b: Point, choice: PlannerChoice, seed: int, watch: Watch | None
    ) -> Path:
        """Return the path from `a` to `b` without a cache."""
        if self.ignore and (away := self.ignore & {body.name for body in self.world.bodies}):
            without = PathPlanner(self.world.as_if(away=away), self.radius, step=self.step)
            return without.plan(a, b, planner=choice, seed=seed, watch=watch)
        if choice.name == ROADMAP:
            path = self._shortest(a, b)
        else:
            path = self._sampled(*self._ends_of(a, b), choice, seed, watch)
        points = np.array(distinct([a, *path, b], _STEP))
        clear = partial(self.world.clearance, points, self.world.bodies)
        return Path(points=points, clear=clear, planner=choice.name)

    def roadmap(self, step: float | None = None) -> Roadmap:
        """Return the visibility graph of the floor, with turns of at most `step` radians."""
        return self.world.roadmap(self.radius, self.step if step is None else step)

    def prepare(self) -> None:
        """Compute in advance what the first query needs."""
        roadmap = self.roadmap()
        _ = roadmap.passages
        for body in self.world.bodies:
            roadmap.around(body)

    def _choice(
        self,
        planner: PlannerChoice | str | Mapping[str, Any] | type | None,
        parameters: Mapping[str, Setting] | None,
    ) -> PlannerChoice:
        """Return the checked planner of one query."""
        if planner is None and not parameters:
            return self.choice
        choice = self.choice if planner is None else PlannerChoice.of(planner)
        if parameters:
            choice = choice.with_parameters(parameters)
        choice.check()
        return choice

    def _sampled(
        self, start: Point, goal: Point, choice: PlannerChoice, seed: int, watch: Watch | None
    ) -> list[Point]:
        keep = self.radius + SLACK
        low_x, low_y, high_x, high_y = self.world.plan.boundary.bounds

        closed = Gates()

        def free(a: Point, b: Point) -> bool:
            return self.world.segment_free(a, b, keep) and not (closed and closed.apart(a, b))

        query = OmplQuery(start, goal, (low_x, low_y), (high_x, high_y), free)
        # Each round closes another gate, so the number of rounds is limited.
        while (points := sample_path(query, choice, seed, watch)) is not None:
            # Most OMPL planners assume that a free motion is free in both directions. Repeat the
            # search with a wall for each gate that the path crosses backwards.
            broken = self.world.gates.broken(points)
            if not broken:
                return points
            closed = Gates((*closed.all, *broken))
        if not self._connected(start, goal):
            raise self._unreachable(start, goal)
        message = f"{choice.name} found no path within its budget; give it more iterations"
        raise PlanningError("not_found", message)

    def _shortest(self, start: Point, goal: Point) -> list[Point]:
        """Return the shortest path between the positions next to start and goal.

        Sweeps from the start and to the goal include the discs there. If both are free in the
        plane, FCL tests only the sweeps.
        """
        if self._queries is None:
            self._queries = RoadmapQuestions(self.world, self.radius)
        links = self._queries.links
        hopeful = links.holds(start) and links.holds(goal)
        points = self._queries.path(start, goal, self.step) if hopeful else None
        if points is not None:
            return points
        leave, arrive = self._ends_of(start, goal)
        if not hopeful or (leave, arrive) != (start, goal):
            points = self._queries.path(leave, arrive, self.step)
        if points is not None:
            return points
        if not self._connected(leave, arrive):
            raise self._unreachable(leave, arrive)
        raise PlanningError("not_found", "no path was found, though there should be one")

    def _ends_of(self, start: Point, goal: Point) -> tuple[Point, Point]:
        """Return the first position after the start, and the last before the goal."""
        leave = self._cached_footing(start, "start", TOO_CLOSE)
        return leave, self._cached_footing(goal, "goal", 0.0)

    def _connected(self, start: Point, goal: Point) -> bool:
        if self.roadmap().apart(start, goal):
            return False
        return self.world.reaches(start, goal, self.radius + HAIR)

    def _unreachable(self, start: Point, goal: Point) -> PlanningError:
        explain = explain_cut_off(self.world, start, goal, self.radius)
        return PlanningError("unreachable", explain)

    def _blocked(self, place: Point, end: str) -> Callable[[], str]:
        """Return a function that explains why `place` is not free at present."""
        return partial(blocked_place, self.world.as_if(), place, end, self.radius)

    def _cached_footing(self, place: Point, end: str, tolerance: float) -> Point:
        """Return `_footing` with a cache, because most goals are stations."""
        if not self._keep:
            return self._footing(place, end, tolerance)
        footing = self._footings.get((place, tolerance))
        if footing is None:
            footing = self._footing(place, end, tolerance)
            if len(self._footings) >= self._keep:
                self._footings.clear()
            self._footings[place, tolerance] = footing
        return footing

    def _footing(self, place: Point, end: str, tolerance: float) -> Point:
        """Return `place`, or the nearest free position if it is slightly too close to something.

        `PlanningError` if it is more than `tolerance` metres too close.
        """
        world = self.world
        if world.free(place, self.radius + SLACK):
            return place
        reason: Reason = "start_blocked" if end == "start" else "goal_blocked"
        gap = world.distance(place)
        if gap < self.radius - max(tolerance, 1e-9):
            raise PlanningError(reason, self._blocked(place, end))
        footing = world.nearest_free(place, self.radius + HAIR)
        # From a place within the tolerance, the nearest free position is not far.
        if footing is None or math.dist(place, footing) > 10 * TOO_CLOSE:
            raise PlanningError(reason, self._blocked(place, end))
        return footing


def _place(at: ArrayLike, end: str) -> Point:
    if is_place(at):
        return at
    position = np.asarray(at, dtype=float)
    if position.shape != (2,) or not np.isfinite(position).all():
        raise UserError(f"the {end} must be a finite x and y, found {at!r}")
    return (float(position[0]), float(position[1]))
