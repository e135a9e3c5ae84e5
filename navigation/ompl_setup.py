"""A question to OMPL: its set-up, with FCL's swept shapes to decide what is free."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any

import ompl.base as ob
import ompl.geometric as og
import ompl.util as ou

from floorplan import Point

Free = Callable[[Point, Point], bool]
"""Function that returns whether the segment between two places is free."""


class TooManyChecksError(Exception):
    """Ends a search from inside when it exceeds its budget."""


@dataclass(frozen=True)
class Question:
    """A path to be found from `start` to `goal` between `low` and `high` corners (metres)."""

    start: Point
    goal: Point
    low: Point
    high: Point
    free: Free


@contextmanager
def no_log() -> Iterator[None]:
    """Keep OMPL's log quiet."""
    level = ou.getLogLevel()
    ou.setLogLevel(ou.LOG_NONE)
    try:
        yield
    finally:
        ou.setLogLevel(level)


class OmplFloor:
    """OMPL's space of places between `low` and `high` (metres), where `free` says what is free.

    After `most` checks a search is ended by `TooManyChecksError`. `release` must be called in the
    end.
    """

    def __init__(self, low: Point, high: Point, free: Free, most: float = math.inf) -> None:
        bounds = ob.RealVectorBounds(2)
        for axis in (0, 1):
            bounds.setLow(axis, low[axis])
            bounds.setHigh(axis, high[axis])
        self._space: Any = ob.RealVectorStateSpace(2)
        self._space.setBounds(bounds)
        self.information: Any = ob.SpaceInformation(self._space)
        # OMPL holds them by pointers that keep nothing alive: Python must.
        self._motions: Any = _Motions(self.information, free, most)
        self._places: Any = _Places(self.information, free, most)
        self.information.setMotionValidator(self._motions)
        self.information.setStateValidityChecker(self._places)
        self.information.setup()
        self.here: Any = self.information.allocState()
        self.there: Any = self.information.allocState()
        """Two states to put places into, of which OMPL keeps copies."""

    def moves(self, a: Point, b: Point) -> bool:
        """Return whether OMPL's motion validator lets one go straight from a to b."""
        here, there = self.here, self.there
        here[0], here[1] = a
        there[0], there[1] = b
        return bool(self.information.checkMotion(here, there))

    def release(self) -> None:
        """Release OMPL's objects in an order that it survives."""
        self.here = None
        self.there = None
        self._motions = None
        self._places = None
        self.information = None
        self._space = None


class OmplSetup:
    """OMPL's objects for one question: nothing is left over for the next.

    After `most` checks the search is ended by `TooManyChecksError`. `release` must be called in
    the end.
    """

    def __init__(self, question: Question, most: float = math.inf) -> None:
        self._question = question
        self._floor = OmplFloor(question.low, question.high, question.free, most)
        self.information: Any = self._floor.information
        self._setup: Any = og.SimpleSetup(self.information)
        self._setup.setStartAndGoalStates(self.state(question.start), self.state(question.goal))
        self.planner: Any = None
        self.solved = False
        """True once the planner has said that it solved the problem."""

    def use(self, planner: Any) -> None:
        """Let `planner`, OMPL's, answer."""
        self.planner = planner
        self._setup.setPlanner(planner)
        self._setup.setup()

    def solve(self, until: Any) -> Any:
        """Return the exact path that the planner finds before `until`, OMPL's, or None."""
        self.solved = self._setup.solve(until).getStatus() == ob.PlannerStatus.EXACT_SOLUTION
        return self._setup.getSolutionPath() if self._setup.haveExactSolutionPath() else None

    def points(self, path: Any) -> list[Point]:
        """Return the places of a path of OMPL's, from the start to the goal, each once in a row."""
        return points_of(path, self._question.start, self._question.goal)

    def path(self, points: list[Point]) -> Any:
        """Return OMPL's path along `points`."""
        return path_along(self.information, points)

    def state(self, place: Point) -> Any:
        """Return OMPL's state at `place`."""
        return state_at(self.information, place)

    def release(self) -> None:
        """Release OMPL's objects in an order that it survives."""
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
        path.append(state)  # a copy of it
    return path


def points_of(path: Any, start: Point, goal: Point) -> list[Point]:
    """Return the places of a path of OMPL's, from `start` to `goal`, each once in a row."""
    points = [(float(at[0]), float(at[1])) for at in path.getStates()]
    points[0], points[-1] = start, goal
    return [points[0], *(b for a, b in itertools.pairwise(points) if a != b)]


def state_at(information: Any, place: Point) -> Any:
    """Return OMPL's state at `place`."""
    # Unlike those of the space, the information's states are freed when Python lets go.
    state = information.allocState()
    state[0], state[1] = place
    return state


class _Motions(ob.MotionValidator):  # type: ignore[misc]
    """Answers OMPL which segments are free, each as one sweep."""

    def __init__(self, information: Any, free: Free, most: float) -> None:
        super().__init__(information)
        self._free = free
        self._left = most

    def checkMotion(self, a: Any, b: Any, *_: Any) -> bool:
        self._left -= 1
        if self._left < 0:
            raise TooManyChecksError
        return self._free((a[0], a[1]), (b[0], b[1]))


class _Places(ob.StateValidityChecker):  # type: ignore[misc]
    """Answers OMPL which places are free."""

    def __init__(self, information: Any, free: Free, most: float) -> None:
        super().__init__(information)
        self._free = free
        self._left = most

    def isValid(self, at: Any) -> bool:
        self._left -= 1
        if self._left < 0:
            raise TooManyChecksError
        place = (at[0], at[1])
        return self._free(place, place)
