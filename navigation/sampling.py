"""OMPL's sampling-based planners over a collision world, by name.

Their budget is a number of iterations, never a time, so the same question and seed give the same
path on every machine.
"""

from __future__ import annotations

import heapq
import itertools
import math
import re
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from typing import Any

import ompl.base as ob
import ompl.geometric as og
import ompl.util as ou

from floorplan import Point

from .path import PlannerInfo

Free = Callable[[Point, Point], bool]
"""Function that returns whether the segment between two places is free."""

MOST_CHECKS = 200
"""Collision checks per iteration, on average, after which a planner that won't stop is stopped."""


_KNOWN = {
    "AORRTC": ("RRTConnect again and again, each time for a shorter path", True, 2_000),
    "BFMT": ("fast marching trees from both ends over one batch of samples", True, 100_000),
    "BITstar": ("batches of samples, searched in order of promise", True, 4_000),
    "BKPIECE1": ("trees from both ends into the least covered cells", False, 20_000),
    "FMT": ("a fast marching tree over one batch of samples", True, 100_000),
    "InformedRRTstar": ("RRT* that samples only where a shorter path may be", True, 2_000),
    "KPIECE1": ("a tree into the least covered cells", False, 20_000),
    "LBKPIECE1": ("BKPIECE that checks links only when needed", False, 100_000),
    "PRM": ("a roadmap of samples, linked to their neighbours", False, 1_000),
    "PRMstar": ("a roadmap of samples with links enough to be optimal", True, 1_000),
    "RRT": ("a tree of random steps from the start", False, 20_000),
    "RRTConnect": ("trees from both ends that reach for each other", False, 20_000),
    "RRTstar": ("RRT that rewires its tree for shorter paths", True, 2_000),
    "SORRTstar": ("Informed RRT* that takes its samples in order", True, 2_000),
}
"""Summary, whether it is optimal, and iterations, of the planners of OMPL 2."""

_LOST_IF_STRAIGHT = ("AORRTC", "SORRTstar")
"""Planners of OMPL 2.0.1 that fail where the start sees the goal: the first answers with a path of
no length, the second never."""

_OWN = ("iterations", "simplify")
"""The parameters that all of them have on top of OMPL's."""

_NOT_A_NUMBER = ("ProjectionEvaluator", "DefaultConnectionStrategy")


class _TooManyChecksError(Exception):
    """Ends a search from inside when it exceeds its budget."""


def sampling_planners() -> tuple[PlannerInfo, ...]:
    """Return the geometric planners of the OMPL that is installed, by name."""
    found = []
    for name in sorted(dir(og)):
        kind = getattr(og, name)
        if isinstance(kind, type) and issubclass(kind, ob.Planner):
            known = _KNOWN.get(name, (f"OMPL's {name}", False, 2_000))
            found.append(PlannerInfo(name, *known, (*_OWN, *_setters(kind))))
    return tuple(found)


@dataclass(frozen=True)
class Question:
    """A path to be found from `start` to `goal` between `low` and `high` corners (metres)."""

    start: Point
    goal: Point
    low: Point
    high: Point
    free: Free


def sample_path(
    question: Question, info: PlannerInfo, parameters: Mapping[str, object], seed: int
) -> list[Point] | None:
    """Return a path by the planner `info`, or None if its budget ran out.

    `ValueError` names a parameter that it does not have or a value that does not fit.
    """
    unknown = [name for name in parameters if name not in info.parameters]
    if unknown:
        raise ValueError(
            f"{info.name} has no parameter {unknown[0]!r} (there are: {', '.join(info.parameters)})"
        )
    if not 0 <= seed < 2**32 - 1:
        raise ValueError(f"a seed must be a whole number from 0 to 4294967294, found {seed}")
    if info.name in _LOST_IF_STRAIGHT and question.free(question.start, question.goal):
        return [question.start, question.goal]
    settings = dict(parameters)
    iterations = _fit("iterations", settings.pop("iterations", info.iterations), 1)
    simplify = _fit("simplify", settings.pop("simplify", True), True)
    level = ou.getLogLevel()
    ou.setLogLevel(ou.LOG_NONE)
    # OMPL takes this as the first seed of all that follows only if it is not 0.
    ou.RNG.setSeed(seed + 1)
    search = _OmplSearch(question, iterations)
    try:
        return search.run(info.name, settings, simplify)
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

    def __init__(self, question: Question, iterations: int) -> None:
        self._question = question
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

    def run(self, name: str, settings: Mapping[str, object], simplify: bool) -> list[Point] | None:
        self._planner = getattr(og, name)(self._information)
        for parameter, value in settings.items():
            _set(self._planner, parameter, value)
        self._setup.setPlanner(self._planner)
        self._setup.setup()
        if name in ("PRM", "PRMstar"):
            points = self._through_roadmap()
            return points and self._simplified(points, simplify)
        self._setup.solve(self._budget())
        if not self._setup.haveExactSolutionPath():
            return None
        return self._finished(self._setup.getSolutionPath(), simplify)

    def _budget(self) -> Any:
        count = itertools.count(1)
        return ob.PlannerTerminationCondition(lambda: next(count) > self._iterations)

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


def _setters(kind: type) -> tuple[str, ...]:
    """Return the names of the parameters of an OMPL planner class, from its setters."""
    own = [m[3:] for m in dir(kind) if m.startswith("set") and not hasattr(ob.Planner, m)]
    return tuple(_snake(name) for name in own if name not in _NOT_A_NUMBER)


def _snake(name: str) -> str:
    return re.sub(r"(?<=[a-z])(?=[A-Z])", "_", name).lower()


def _set(planner: Any, parameter: str, value: object) -> None:
    (camel,) = (m[3:] for m in dir(planner) if m[:3] == "set" and _snake(m[3:]) == parameter)
    now = getattr(planner, f"get{camel}")()
    getattr(planner, f"set{camel}")(_fit(parameter, value, now))


def _fit(parameter: str, value: object, like: Any) -> Any:
    """Return `value` as the kind of number that `like` is; `ValueError` if it isn't one."""
    if isinstance(like, bool):
        if isinstance(value, bool):
            return value
        raise ValueError(f"parameter {parameter!r} must be true or false, found {value!r}")
    number = math.nan
    if isinstance(value, int | float) and not isinstance(value, bool):
        with suppress(OverflowError):
            number = float(value)
    if isinstance(like, int):
        if number > 0 and number.is_integer():
            return int(number)
        raise ValueError(f"parameter {parameter!r} must be a whole number above 0, found {value!r}")
    if 0 <= number < math.inf:
        return number
    raise ValueError(f"parameter {parameter!r} must be a number, 0 or more, found {value!r}")
