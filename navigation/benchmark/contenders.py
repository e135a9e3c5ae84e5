"""Everything that a benchmark can ask for a path: Floorwalker's planners and those of peers."""

from __future__ import annotations

import math
import time
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from floorplan import Point

from ..catalog import planner_info
from ..choice import PlannerChoice
from ..path import PlanningError, Watch
from ..planner import PathPlanner
from ..world import CollisionWorld

_WITHOUT_END = 10**9
"""Iterations, where the budget is one of time."""


@dataclass(frozen=True)
class Progress:
    """Best path of a search so far."""

    iterations: int
    cpu_seconds: float
    """Since the search began."""
    length: float
    """Metres."""


@dataclass(frozen=True)
class Answer:
    """Path that was found, with what it took; times are of the CPU, in seconds."""

    points: NDArray[np.float64] | None
    """(N, 2) metres; None where no path was found."""
    reason: str = ""
    """As of `PlanningError`; "failed" and the error where the planner itself broke down."""
    planning: float = 0.0
    simplification: float = 0.0
    progress: tuple[Progress, ...] = ()


class Contender(Protocol):
    """Planner in one world, for a disc of one radius."""

    def look(self) -> None:
        """Take in where things stand now: called whenever they have moved."""

    def answer(self, start: Point, goal: Point, seed: int) -> Answer:
        """Return the path from `start` to `goal` (metres) that `seed` leads to."""


@dataclass(frozen=True)
class Budget:
    """Budget of an answer of one of OMPL's planners; without one, each has its own."""

    iterations: int | None = None
    seconds: float | None = None
    """Of the CPU; what comes out then depends on the machine."""


class _Progress(Watch):
    """Watches a search for its best paths, and ends it after so many `seconds` of CPU time."""

    def __init__(self, seconds: float | None) -> None:
        self._seconds = math.inf if seconds is None else seconds
        self._begin = time.process_time()
        self._iterations = 0
        self._least = math.inf
        self.progress: list[Progress] = []
        self.solved_after: float | None = None
        """Seconds, until the search ended with a path."""

    def iteration(self, planner: Any) -> bool:
        """Note the planner's best cost, where it has one; see `Watch`."""
        self._iterations += 1
        # OMPL's progress properties have the same figure, but its binding can't return them.
        if hasattr(planner, "bestCost"):
            cost = float(planner.bestCost().value())
            if 0 < cost < self._least:
                self.found(cost)
        return time.process_time() - self._begin > self._seconds

    def solved(self) -> None:
        """Note when; see `Watch`."""
        self.solved_after = time.process_time() - self._begin

    def found(self, length: float) -> None:
        """Note that the best path is now `length` metres long."""
        self._least = length
        elapsed = time.process_time() - self._begin
        self.progress.append(Progress(self._iterations, elapsed, length))


class Ours:
    """A planner of `PathPlanner`, by its choice, and with no more than a budget."""

    def __init__(
        self, world: CollisionWorld, radius: float, choice: PlannerChoice, budget: Budget
    ) -> None:
        self._budget = budget
        self._planner = PathPlanner(world, radius, planner=_within(choice, budget))
        self._planner.prepare()

    def look(self) -> None:
        """Do nothing: the world is read when a path is asked for."""

    def answer(self, start: Point, goal: Point, seed: int) -> Answer:
        """Return the path from `start` to `goal` (metres) that `seed` leads to."""
        watch = _Progress(self._budget.seconds)
        begin = time.process_time()
        try:
            path = self._planner.plan(start, goal, seed=seed, watch=watch)
        except PlanningError as why:
            return Answer(None, why.reason, time.process_time() - begin)
        taken = time.process_time() - begin
        watch.found(path.length)
        planning = taken if watch.solved_after is None else min(watch.solved_after, taken)
        return Answer(path.points, "", planning, taken - planning, _rising(watch.progress))


def _within(choice: PlannerChoice, budget: Budget) -> PlannerChoice:
    """Return `choice` with the iterations of `budget`, unless it has its own, or can't have any."""
    iterations = budget.iterations
    if iterations is None and budget.seconds is not None:
        iterations = _WITHOUT_END
    takes = choice.is_own or "iterations" in planner_info(choice.name).parameters
    if iterations is None or not takes or "iterations" in dict(choice.parameters):
        return choice
    return choice.with_parameters({"iterations": iterations})


def _rising(progress: Sequence[Progress]) -> tuple[Progress, ...]:
    """Return `progress` without what is not shorter than before."""
    kept: list[Progress] = []
    for one in progress:
        if not kept or one.length < kept[-1].length:
            kept.append(one)
    return tuple(kept)
