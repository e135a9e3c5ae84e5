"""OMPL's sampling-based planners over a collision world.

Their budget is a number of iterations instead of a time, so the same query and seed give the same
path on every machine.
"""

from __future__ import annotations

import heapq
import inspect
import itertools
import math
import traceback
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from numbers import Integral
from pathlib import Path
from typing import Any

import ompl.base as ob
import ompl.geometric as og
import ompl.util as ou

from floorplan import Point, UserError
from floorplan.files.dataclass import dataclass

from .catalog import (
    ITERATIONS,
    PlannerChoice,
    PlannerError,
    Settings,
    Watch,
    planner_info,
    set_parameter,
    settings_of,
)

Free = Callable[[Point, Point], bool]
"""Function that returns whether the segment between two places is free."""


class TooManyChecksError(Exception):
    """Ends a search that exceeds its budget."""


@dataclass(frozen=True)
class OmplQuery:
    """Query for a path from `start` to `goal` between `low` and `high` corners (metres)."""

    start: Point
    goal: Point
    low: Point
    high: Point
    free: Free


@contextmanager
def no_log() -> Iterator[None]:
    """Suppress OMPL's log."""
    level = ou.getLogLevel()
    ou.setLogLevel(ou.LOG_NONE)
    try:
        yield
    finally:
        ou.setLogLevel(level)


class OmplFloor:
    """OMPL's space of places between `low` and `high` (metres), in which `free` tests segments.

    After `limit` checks, `TooManyChecksError` ends a search. Call `release` at the end.
    """

    def __init__(self, low: Point, high: Point, free: Free, limit: float = math.inf) -> None:
        bounds = ob.RealVectorBounds(2)
        for axis in (0, 1):
            bounds.setLow(axis, low[axis])
            bounds.setHigh(axis, high[axis])
        self._space: Any = ob.RealVectorStateSpace(2)
        self._space.setBounds(bounds)
        self.information: Any = ob.SpaceInformation(self._space)
        # OMPL's pointers do not keep these objects alive.
        self._motions: Any = Motions(self.information, free, limit)
        self._places: Any = Places(self.information, free, limit)
        self.information.setMotionValidator(self._motions)
        self.information.setStateValidityChecker(self._places)
        self.information.setup()
        self.here: Any = self.information.allocState()
        self.there: Any = self.information.allocState()
        """Two states for places, of which OMPL makes copies."""

    def moves(self, a: Point, b: Point) -> bool:
        """Return whether the segment from a to b is free by OMPL's motion validator."""
        here, there = self.here, self.there
        here[0], here[1] = a
        there[0], there[1] = b
        return bool(self.information.checkMotion(here, there))

    def release(self) -> None:
        """Release OMPL's objects in a safe order."""
        self.here = None
        self.there = None
        self._motions = None
        self._places = None
        self.information = None
        self._space = None


class OmplSetup:
    """OMPL's objects for one query.

    After `limit` checks, `TooManyChecksError` ends the search. Call `release` at the end.
    """

    def __init__(self, query: OmplQuery, limit: float = math.inf) -> None:
        self._floor = OmplFloor(query.low, query.high, query.free, limit)
        self.information: Any = self._floor.information
        self._setup: Any = og.SimpleSetup(self.information)
        start, goal = (state_at(self.information, end) for end in (query.start, query.goal))
        self._setup.setStartAndGoalStates(start, goal)
        self.planner: Any = None
        self.solved = False
        """Whether the planner has reported a solution."""

    def use(self, planner: Any) -> None:
        """Use OMPL's `planner` for the search."""
        self.planner = planner
        self._setup.setPlanner(planner)
        self._setup.setup()

    def solve(self, until: Any) -> Any:
        """Return the exact path of the planner before the condition `until`, or None."""
        self.solved = self._setup.solve(until).getStatus() == ob.PlannerStatus.EXACT_SOLUTION
        return self._setup.getSolutionPath() if self._setup.haveExactSolutionPath() else None

    def release(self) -> None:
        """Release OMPL's objects in a safe order."""
        self.planner = None
        self._setup = None
        self.information = None
        self._floor.release()


def path_along(information: Any, points: list[Point]) -> Any:
    """Return OMPL's path along `points`."""
    path = og.PathGeometric(information)
    state = information.allocState()
    for place in points:
        state[0], state[1] = place
        path.append(state)  # makes a copy
    return path


def points_of(path: Any, start: Point, goal: Point) -> list[Point]:
    """Return the places of an OMPL path, from `start` to `goal`, without repetitions."""
    points = [(float(at[0]), float(at[1])) for at in path.getStates()]
    points[0], points[-1] = start, goal
    return [points[0], *(b for a, b in itertools.pairwise(points) if a != b)]


def state_at(information: Any, place: Point) -> Any:
    """Return OMPL's state at `place`."""
    # Unlike states of the space, those of the information are freed with their Python object.
    state = information.allocState()
    state[0], state[1] = place
    return state


def _place_of(state: Any) -> Point:
    return (state[0], state[1])


class Motions(ob.MotionValidator):  # type: ignore[misc]
    """Validator of OMPL that tests each segment as one sweep.

    `free` is called at most `limit` times, with the `values` of both states.
    """

    def __init__(
        self,
        information: Any,
        free: Callable[[Any, Any], bool],
        limit: float,
        values: Callable[[Any], Any] = _place_of,
    ) -> None:
        super().__init__(information)
        self._free = free
        self._checks_left = limit
        self._values = values

    def checkMotion(self, a: Any, b: Any, *_: Any) -> bool:
        """Return whether the segment between two states is free."""
        self._checks_left -= 1
        if self._checks_left < 0:
            raise TooManyChecksError
        return self._free(self._values(a), self._values(b))


class Places(ob.StateValidityChecker):  # type: ignore[misc]
    """Checker of OMPL that tests a place as a segment without length: see `Motions`."""

    def __init__(
        self,
        information: Any,
        free: Callable[[Any, Any], bool],
        limit: float,
        values: Callable[[Any], Any] = _place_of,
    ) -> None:
        super().__init__(information)
        self._free = free
        self._checks_left = limit
        self._values = values

    def isValid(self, at: Any) -> bool:
        """Return whether a state is free."""
        self._checks_left -= 1
        if self._checks_left < 0:
            raise TooManyChecksError
        values = self._values(at)
        return self._free(values, values)


MOST_CHECKS = 200
"""Mean number of collision checks per iteration after which a search is ended."""


_SAME = 1e-6
"""Metres. Tolerance for the ends of a path."""

_NEIGHBOURS = 30
"""Number of nearest samples of a PRM to which start and goal are linked."""

_LOST_IF_STRAIGHT = ("AORRTC", "SORRTstar")
"""Planners of OMPL 2.0.1 that fail if the straight path is free. The first returns a path without
length, the second does not end."""


def sample_path(
    query: OmplQuery, choice: PlannerChoice, seed: int, watch: Watch | None = None
) -> list[Point] | None:
    """Return a path by the planner of `choice`, or None if its budget ends first.

    `ValueError` names an unknown parameter or an invalid value.
    """
    choice.check()
    if not (isinstance(seed, Integral) and 0 <= seed < 2**32 - 1):
        raise UserError(f"a seed must be a whole number from 0 to 4294967294, found {seed}")
    if choice.name in _LOST_IF_STRAIGHT and query.free(query.start, query.goal):
        return [query.start, query.goal]
    usual = planner_info(choice.name).iterations if choice.kind is None else ITERATIONS
    settings = settings_of(dict(choice.parameters), usual)
    # OMPL accepts only a first seed that is not 0.
    with no_log():
        ou.RNG.setSeed(int(seed) + 1)
        search = _Search(query, settings, watch or Watch())
        try:
            return search.run(choice)
        except (TooManyChecksError, PlannerError) as why:
            if isinstance(why, PlannerError):
                raise
            return None
        except Exception as why:
            if choice.kind is None:
                raise
            raise PlannerError(
                f"the planner {choice.name} failed {_how(choice.kind, why)}"
            ) from why
        finally:
            search.release()


class _Search:
    """Query to an OMPL planner, with a budget of iterations."""

    def __init__(self, query: OmplQuery, settings: Settings, watch: Watch) -> None:
        self._query = query
        self._watch = watch
        self._settings = settings
        self._setup = OmplSetup(query, MOST_CHECKS * settings.iterations)
        self.release = self._setup.release

    def run(self, choice: PlannerChoice) -> list[Point] | None:
        """Return the path of the planner of `choice`, or None."""
        if choice.kind is not None:
            planner = choice.kind(self._setup.information, **self._settings.own)
        else:
            planner = getattr(og, choice.name)(self._setup.information)
            for parameter, value in self._settings.own.items():
                set_parameter(planner, parameter, value)
        self._setup.use(planner)
        if choice.name in ("PRM", "PRMstar"):
            points = self._through_roadmap()
            return points and self._finished(path_along(self._setup.information, points))
        path = self._setup.solve(self._budget())
        if path is None:
            if choice.kind is not None and self._setup.solved:
                raise PlannerError(
                    f"the planner {choice.name} returned EXACT_SOLUTION, but added no path to its"
                    " problem definition that leads to the goal"
                )
            return None
        if choice.kind is not None:
            self._require_answer(choice, path)
        return self._finished(path)

    def _require_answer(self, choice: PlannerChoice, path: Any) -> None:
        """Raise `PlannerError` unless the path of a custom planner answers the query."""
        query, points = self._query, [_place(state) for state in path.getStates()]
        if not points:
            raise PlannerError(f"the planner {choice.name} found a path without any place")
        for end, expected, place in (
            ("starts", query.start, points[0]),
            ("ends", query.goal, points[-1]),
        ):
            if not math.dist(expected, place) <= _SAME:
                raise PlannerError(
                    f"the planner {choice.name} found a path that {end} at {_shown(place)},"
                    f" not at {_shown(expected)}"
                )
        for a, b in itertools.pairwise(points):
            if not query.free(a, b):
                raise PlannerError(
                    f"the planner {choice.name} found a path that is not free from {_shown(a)}"
                    f" to {_shown(b)}; ask checkMotion of its space information about each segment"
                )

    def _budget(self) -> Any:
        count = itertools.count(1)
        setup, watch, limit = self._setup, self._watch, self._settings.iterations

        # AORRTC keeps this function, so it must not refer to the planner, except by `setup`.
        def spent() -> bool:
            return next(count) > limit or watch.iteration(setup.planner)

        return ob.PlannerTerminationCondition(spent)

    def _through_roadmap(self) -> list[Point] | None:
        """Return a path over the samples of a PRM.

        OMPL's search runs in a thread that never calls the Python budget, so OMPL provides samples
        and links only.
        """
        self._setup.planner.growRoadmapPtc(self._budget())
        data = ob.PlannerData(self._setup.information)
        self._setup.planner.getPlannerData(data)
        places = [_place(data.getVertex(k).getState()) for k in range(data.numVertices())]
        links: list[list[int]] = [sorted(data.getEdges(k)) for k in range(data.numVertices())]
        return _over_samples(places, links, self._query)

    def _finished(self, path: Any) -> list[Point]:
        self._watch.solved()
        if self._settings.simplify:
            og.PathSimplifier(self._setup.information).simplifyMax(path)
        return points_of(path, self._query.start, self._query.goal)


def _how(kind: type, why: Exception) -> str:
    """Return the line in which a custom planner failed, and the message of the error.

    If OMPL itself failed, it is the line that defines the class.
    """
    words = f"{type(why).__name__}: {why}".partition("\n")[0].removesuffix(": ")
    last = traceback.extract_tb(why.__traceback__)[-1]
    file, line = Path(last.filename), last.lineno
    if file.parent == Path(__file__).parent:
        with suppress(OSError, TypeError):  # defined interactively, or in C++
            file, line = Path(inspect.getfile(kind)), inspect.getsourcelines(kind)[1]
        needs = "call OMPL's __init__, and return ob.PlannerStatus(…) from solve"
        words = f"as OMPL asked it; it must {needs} ({words})"
    return f"({file.name}, line {line}): {words}"


def _shown(place: Point) -> str:
    return f"({place[0]:.3f}, {place[1]:.3f})"


def _place(state: Any) -> Point:
    return (float(state[0]), float(state[1]))


def _over_samples(
    places: list[Point], links: list[list[int]], query: OmplQuery
) -> list[Point] | None:
    """Return the shortest path over samples and links, with both ends linked to neighbours."""
    start, goal = len(places), len(places) + 1
    places = [*places, query.start, query.goal]
    near: dict[int, list[int]] = {}
    for end in (start, goal):
        order = sorted(range(start), key=lambda k: math.dist(places[k], places[end]))
        near[end] = [k for k in order[:_NEIGHBOURS] if query.free(places[end], places[k])]
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
        # The place was reached on a shorter path since, and `heapq` cannot remove entries.
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
