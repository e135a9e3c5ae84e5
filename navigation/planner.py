"""Paths from a start to a goal, by the roadmap or by one of OMPL's planners."""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Hashable, Mapping
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from floorplan import Point, UserError, require

from .catalog import ROADMAP, Setting
from .choice import PlannerChoice
from .freespace import STEP
from .gates import Gates
from .kernels.walks import distinct, is_place
from .obstruction import blocked_place, explain_cut_off
from .ompl_setup import Question
from .path import Path, PlanningError, Reason, Watch
from .roadmap import HAIR, Roadmap
from .roadmap_planner import SLACK, RoadmapQuestions
from .sampling import sample_path
from .world import CollisionWorld

COARSE = math.radians(15.0)
"""Radians. Default size of the bends in a path."""

TOO_CLOSE = 1e-3
"""Metres. A start may be this much too close to something."""

_STEP = HAIR / 100
"""Metres. Shorter steps are left out of a path: their direction is mostly rounding."""


class PathPlanner:
    """Finds paths through a `CollisionWorld` for a disc of `radius` metres.

    The world is read as it is when a path is asked for. `ignore` names bodies that are no
    obstacle, above all the person for whom the planner plans. Paths go round corners in bends of
    `step` radians at most: smaller ones hug the corners closer, and are more. `planner` is the one
    to ask: see `PlannerChoice.of`; `seed` is that of its samples. Of the paths found since anything
    on the floor moved, the last `keep` are kept, and are the answer to the same question.
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
        """The planner that is asked where a question names no other."""
        self.choice.check()
        self.seed = seed
        self._questions: RoadmapQuestions | None = None
        self._keep = keep
        self._kept: dict[Hashable, Path] = {}
        self._footings: dict[tuple[Point, float], tuple[Point, int]] = {}
        """Where to go first from a place, and the number of checks that this took."""
        self._kept_at = world.changes

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
        """Return a path from `start` to `goal` (x, y in metres) that keeps the radius clear.

        The default planner's paths are the shortest there are, to within 0.6 % of the arcs around
        corners. Others are OMPL's, by name (see `planners`), with OMPL's `parameters` by name;
        the same `seed` gives the same path. `watch` is told how a search of OMPL's goes on.
        `PlanningError` says why there is none; `ValueError` if a place, the planner or a parameter
        makes no sense.
        """
        choice = self._choice(planner, parameters)
        seed = self.seed if seed is None else seed
        a, b = _place(start, "start"), _place(goal, "goal")
        if not self._keep:
            return self._found(a, b, choice, seed, watch)
        if self._kept_at != self.world.changes:
            self._kept_at = self.world.changes
            self._kept.clear()
            self._footings.clear()
        question = (a, b, choice, seed)
        path = self._kept.get(question)
        if path is None:
            path = self._kept[question] = self._found(a, b, choice, seed, watch)
            if len(self._kept) > self._keep:
                del self._kept[next(iter(self._kept))]
        return path

    def _found(
        self, a: Point, b: Point, choice: PlannerChoice, seed: int, watch: Watch | None
    ) -> Path:
        """Return the path from `a` to `b` that is found now."""
        if self.ignore and (away := self.ignore & {body.name for body in self.world.bodies}):
            without = PathPlanner(self.world.as_if(away=away), self.radius, step=self.step)
            return without.plan(a, b, planner=choice, seed=seed, watch=watch)
        before = self.world.checks
        if choice.name == ROADMAP:
            leave, found, arrive = self._shortest(a, b)
        else:
            leave, arrive = self._ends_of(a, b)
            found = self._sampled(leave, arrive, choice, seed, watch)
        points = np.array(distinct([a, leave, *found, arrive, b], _STEP))
        clear = partial(self.world.clearance, points, self.world.bodies)
        return Path(points, clear, choice.name, self.world.checks - before)

    def roadmap(self, step: float | None = None) -> Roadmap:
        """Return the network of paths between the fixed things, made when first needed."""
        return self.world.roadmap(self.radius, self.step if step is None else step)

    def prepare(self) -> None:
        """Compute now what the first plan would have to wait for."""
        roadmap = self.roadmap()
        for body in self.world.bodies:
            roadmap.around(body)

    def _choice(
        self,
        planner: PlannerChoice | str | Mapping[str, Any] | type | None,
        parameters: Mapping[str, Setting] | None,
    ) -> PlannerChoice:
        """Return the planner of one question, checked."""
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

        question = Question(start, goal, (low_x, low_y), (high_x, high_y), free)
        # Each round closes a gate more, so there are no more rounds than gates.
        while (points := sample_path(question, choice, seed, watch)) is not None:
            # Most of OMPL's planners take a motion that is free to be free in both directions.
            # They are asked again with a wall for each gate that they went through backwards.
            broken = self.world.gates.broken(points)
            if not broken:
                return points
            closed = Gates((*closed.all, *broken))
        if not self._connected(start, goal):
            raise self._unreachable(start, goal)
        message = f"{choice.name} found no path within its budget; give it more iterations"
        raise PlanningError("not_found", message)

    def _shortest(self, start: Point, goal: Point) -> tuple[Point, list[Point], Point]:
        """Return the shortest path, and the places where it leaves the start and gets to the goal.

        Sweeps from the start and to the goal cover the discs there: where these have room in the
        plane, FCL is asked about the sweeps alone.
        """
        if self._questions is None:
            self._questions = RoadmapQuestions(self.world, self.radius)
        links = self._questions.links
        hopeful = links.holds(start) and links.holds(goal)
        points = self._questions.path(start, goal, self.step) if hopeful else None
        if points is not None:
            self.world.checks += 2  # as if asked about the ends, too
            return start, points, goal
        leave, arrive = self._ends_of(start, goal)
        if not hopeful or (leave, arrive) != (start, goal):
            points = self._questions.path(leave, arrive, self.step)
        if points is not None:
            return leave, points, arrive
        if not self._connected(leave, arrive):
            raise self._unreachable(leave, arrive)
        raise PlanningError("not_found", "no path was found, though there should be one")

    def _ends_of(self, start: Point, goal: Point) -> tuple[Point, Point]:
        """Return where to go first from the start, and last before the goal."""
        leave = self._kept_footing(start, "start", TOO_CLOSE)
        return leave, self._kept_footing(goal, "goal", 0.0)

    def _connected(self, start: Point, goal: Point) -> bool:
        return self.world.reaches(start, goal, self.radius + HAIR)

    def _unreachable(self, start: Point, goal: Point) -> PlanningError:
        explain = explain_cut_off(self.world, start, goal, self.radius)
        return PlanningError("unreachable", explain)

    def _blocked(self, place: Point, end: str) -> Callable[[], str]:
        """Return a function that explains why there is no room at `place`, as things are now."""
        return partial(blocked_place, self.world.as_if(), place, end, self.radius)

    def _kept_footing(self, place: Point, end: str, tolerance: float) -> Point:
        """Return as `_footing`, found once where paths are kept: most goals are stations."""
        if not self._keep:
            return self._footing(place, end, tolerance)
        world, known = self.world, self._footings.get((place, tolerance))
        if known is not None:
            world.checks += known[1]  # as if asked: figures don't depend on earlier questions
            return known[0]
        before = world.checks
        found = self._footing(place, end, tolerance)
        if len(self._footings) >= self._keep:
            self._footings.clear()
        self._footings[place, tolerance] = found, world.checks - before
        return found

    def _footing(self, place: Point, end: str, tolerance: float) -> Point:
        """Return `place`, or where to go first from there if it is a hair too close to something.

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
        # From the edge of what is allowed, room is at most a few of these measures away.
        if footing is None or math.dist(place, footing) > 10 * TOO_CLOSE:
            raise PlanningError(reason, self._blocked(place, end))
        return footing


def _place(at: ArrayLike, end: str) -> Point:
    if is_place(at):
        return at
    found = np.asarray(at, dtype=float)
    if found.shape != (2,) or not np.isfinite(found).all():
        raise UserError(f"the {end} must be a finite x and y, found {at!r}")
    return (float(found[0]), float(found[1]))
