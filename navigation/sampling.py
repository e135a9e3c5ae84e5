"""OMPL's sampling-based planners over a collision world, by name.

Their budget is a number of iterations, never a time, so the same question and seed give the same
path on every machine.
"""

from __future__ import annotations

import heapq
import itertools
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import ompl.base as ob
import ompl.geometric as og
import ompl.util as ou

from floorplan import Point

from .catalog import ITERATIONS, Setting, fit, planner_info, set_parameter
from .choice import PlannerChoice
from .path import Watch

Free = Callable[[Point, Point], bool]
"""Function that returns whether the segment between two places is free."""

MOST_CHECKS = 200
"""Collision checks per iteration, on average, after which a planner that won't stop is stopped."""


_LOST_IF_STRAIGHT = ("AORRTC", "SORRTstar")
"""Planners of OMPL 2.0.1 that fail where the start sees the goal: the first answers with a path of
no length, the second never."""


class _TooManyChecksError(Exception):
    """Ends a search from inside when it exceeds its budget."""


@dataclass(frozen=True)
class Question:
    """A path to be found from `start` to `goal` between `low` and `high` corners (metres)."""

    start: Point
    goal: Point
    low: Point
    high: Point
    free: Free


def sample_path(
    question: Question, choice: PlannerChoice, seed: int, watch: Watch | None = None
) -> list[Point] | None:
    """Return a path by the planner of `choice`, or None if its budget ran out.

    `ValueError` names a parameter that it does not have or a value that does not fit.
    """
    choice.check()
    if not 0 <= seed < 2**32 - 1:
        raise ValueError(f"a seed must be a whole number from 0 to 4294967294, found {seed}")
    if choice.name in _LOST_IF_STRAIGHT and question.free(question.start, question.goal):
        return [question.start, question.goal]
    usual = planner_info(choice.name).iterations if choice.kind is None else ITERATIONS
    settings = dict(choice.parameters)
    iterations = fit("iterations", settings.pop("iterations", usual), 1)
    simplify = fit("simplify", settings.pop("simplify", True), True)
    level = ou.getLogLevel()
    ou.setLogLevel(ou.LOG_NONE)
    # OMPL takes this as the first seed of all that follows only if it is not 0.
    ou.RNG.setSeed(seed + 1)
    search = _OmplSearch(question, iterations, watch or Watch())
    try:
        return search.run(choice, settings, simplify)
    except _TooManyChecksError:
        return None
    finally:
        search.release()
        ou.setLogLevel(level)


class _Motions(ob.MotionValidator):  # type: ignore[misc]
    """Answers OMPL which segments are free, each as one sweep."""

    def __init__(self, information: Any, free: Free, most: int) -> None:
        super().__init__(information)
        self._free = free
        self._left = most

    def checkMotion(self, a: Any, b: Any, *_: Any) -> bool:
        self._left -= 1
        if self._left < 0:
            raise _TooManyChecksError
        return self._free((a[0], a[1]), (b[0], b[1]))


class _Places(ob.StateValidityChecker):  # type: ignore[misc]
    """Answers OMPL which places are free."""

    def __init__(self, information: Any, free: Free, most: int) -> None:
        super().__init__(information)
        self._free = free
        self._left = most

    def isValid(self, at: Any) -> bool:
        self._left -= 1
        if self._left < 0:
            raise _TooManyChecksError
        place = (at[0], at[1])
        return self._free(place, place)


class _OmplSearch:
    """One question to OMPL, with objects of its own: nothing is left over for the next."""

    def __init__(self, question: Question, iterations: int, watch: Watch) -> None:
        self._question = question
        self._watch = watch
        self._iterations = iterations
        bounds = ob.RealVectorBounds(2)
        for axis in (0, 1):
            bounds.setLow(axis, question.low[axis])
            bounds.setHigh(axis, question.high[axis])
        self._space: Any = ob.RealVectorStateSpace(2)
        self._space.setBounds(bounds)
        self._setup: Any = og.SimpleSetup(self._space)
        self._information: Any = self._setup.getSpaceInformation()
        most = MOST_CHECKS * iterations
        self._motions: Any = _Motions(self._information, question.free, most)
        self._places: Any = _Places(self._information, question.free, most)
        self._information.setMotionValidator(self._motions)
        self._setup.setStateValidityChecker(self._places)
        self._setup.setStartAndGoalStates(self._state(question.start), self._state(question.goal))
        self._planner: Any = None

    def release(self) -> None:
        """Release OMPL's objects in an order that it survives."""
        self._planner = None
        self._setup = None
        self._motions = None
        self._places = None
        self._information = None
        self._space = None

    def run(
        self, choice: PlannerChoice, settings: Mapping[str, Setting], simplify: bool
    ) -> list[Point] | None:
        if choice.kind is not None:
            self._planner = choice.kind(self._information, **settings)
        else:
            self._planner = getattr(og, choice.name)(self._information)
            for parameter, value in settings.items():
                set_parameter(self._planner, parameter, value)
        self._setup.setPlanner(self._planner)
        self._setup.setup()
        if choice.name in ("PRM", "PRMstar"):
            points = self._through_roadmap()
            return points and self._simplified(points, simplify)
        self._setup.solve(self._budget())
        if not self._setup.haveExactSolutionPath():
            return None
        return self._finished(self._setup.getSolutionPath(), simplify)

    def _budget(self) -> Any:
        count = itertools.count(1)
        watch, most = self._watch, self._iterations

        def spent() -> bool:
            # Some planners keep their budget: one that held them in turn would never be freed.
            return next(count) > most or watch.iteration(self._planner)

        return ob.PlannerTerminationCondition(spent)

    def _through_roadmap(self) -> list[Point] | None:
        """Return a path over the samples of a PRM.

        Its own search runs in a thread that never gets to ask a Python budget, so only the
        samples and links are OMPL's, and the search is done here.
        """
        self._planner.growRoadmapPtc(self._budget())
        data = ob.PlannerData(self._information)
        self._planner.getPlannerData(data)
        places = [_place(data.getVertex(k).getState()) for k in range(data.numVertices())]
        links: list[list[int]] = [sorted(data.getEdges(k)) for k in range(data.numVertices())]
        return _over_samples(places, links, self._question)

    def _simplified(self, points: Sequence[Point], simplify: bool) -> list[Point]:
        path = og.PathGeometric(self._information)
        for place in points:
            path.append(self._state(place))
        return self._finished(path, simplify)

    def _finished(self, path: Any, simplify: bool) -> list[Point]:
        self._watch.solved()
        if simplify:
            og.PathSimplifier(self._information).simplifyMax(path)
        points = [_place(state) for state in path.getStates()]
        points[0], points[-1] = self._question.start, self._question.goal
        return [points[0], *(b for a, b in itertools.pairwise(points) if a != b)]

    def _state(self, place: Point) -> Any:
        # Unlike those of the space, the information's states are freed when Python lets go.
        state = self._information.allocState()
        state[0], state[1] = place
        return state


def _place(state: Any) -> Point:
    return (float(state[0]), float(state[1]))


def _over_samples(
    places: list[Point], links: list[list[int]], question: Question, neighbours: int = 30
) -> list[Point] | None:
    """Return the shortest path over samples and links, both ends linked to their neighbours."""
    start, goal = len(places), len(places) + 1
    places = [*places, question.start, question.goal]
    near: dict[int, list[int]] = {}
    for end in (start, goal):
        order = sorted(range(start), key=lambda k: math.dist(places[k], places[end]))
        near[end] = [k for k in order[:neighbours] if question.free(places[end], places[k])]
    to_goal = set(near[goal])
    best = {start: 0.0}
    before: dict[int, int] = {}
    queue = [(0.0, 0.0, start)]
    while queue:
        _, so_far, here = heapq.heappop(queue)
        if here == goal:
            chain = [goal]
            while chain[-1] != start:
                chain.append(before[chain[-1]])
            return [places[k] for k in reversed(chain)]
        if so_far > best[here]:
            continue
        nexts = near[start] if here == start else links[here]
        for there in [*nexts, goal] if here in to_goal else nexts:
            then = so_far + math.dist(places[here], places[there])
            if then < best.get(there, math.inf):
                best[there], before[there] = then, here
                left = math.dist(places[there], places[goal])
                heapq.heappush(queue, (then + left, then, there))
    return None
