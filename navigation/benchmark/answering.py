"""Planners in one world, and their answers with CPU times."""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from floorplan import Point, UserError
from floorplan.files.dataclass import dataclass

from ..catalog import PlannerChoice, PlanningError, Watch, planner_info
from ..planner import PathPlanner
from ..world import CollisionWorld
from .peers import PEERS, Search

Floats = NDArray[np.float64]

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


@dataclass(frozen=True, kw_only=True)
class Answer:
    """Path of a planner and its costs, in seconds of CPU time."""

    points: Floats | None = None
    """(N, 2) metres, or None without a path."""
    reason: str = ""
    """Reason of `PlanningError`, or "failed" with the error of the planner."""
    planning: float = 0.0
    simplification: float = 0.0
    progress: tuple[Progress, ...] = ()


Ask = Callable[[Point, Point, int], Answer]
"""Function that returns the answer of a planner to a start and goal (metres) and a seed."""


def table_name(planner: str | PlannerChoice) -> str:
    """Return the name of `planner` in tables. `UserError` if it is unknown or not installed."""
    if isinstance(planner, str) and planner in PEERS:
        if not PEERS[planner].installed:
            raise UserError(f"{planner} is not installed: pip install {planner.lower()}")
        return planner
    choice = PlannerChoice.of(planner)
    choice.check()
    return str(choice)


def planner_in(
    planner: str | PlannerChoice,
    world: CollisionWorld,
    radius: float,
    iterations: int | None,
    seconds: float | None,
) -> Callable[[], Ask]:
    """Return the function that prepares `planner` for the world as it is now."""
    if isinstance(planner, str) and planner in PEERS:
        prepare = PEERS[planner].prepare
        return lambda: partial(_ask_peer, prepare(world, radius))
    choice = PlannerChoice.of(planner)
    if iterations is None and seconds is not None:
        iterations = _WITHOUT_END
    takes = choice.is_own or "iterations" in planner_info(choice.name).parameters
    if iterations is not None and takes and "iterations" not in dict(choice.parameters):
        choice = choice.with_parameters({"iterations": iterations})
    own = PathPlanner(world, radius, planner=choice)
    own.prepare()
    # Checks of earlier planners on this floor are not counted, so they must not be reused either.
    own.roadmap().verdicts.clear()
    return lambda: partial(_ask_own, own, math.inf if seconds is None else seconds)


def _ask_own(planner: PathPlanner, limit: float, start: Point, goal: Point, seed: int) -> Answer:
    """Return the answer of Floorwalker's `planner` within `limit` seconds: see `Ask`."""
    watch = _ProgressWatch(limit)
    try:
        path = planner.plan(start, goal, seed=seed, watch=watch)
    except PlanningError as why:
        return Answer(reason=why.reason, planning=watch.elapsed())
    taken = watch.elapsed()
    watch.add(path.length)
    planning = min(watch.solved_after, taken)
    return Answer(
        points=path.points,
        planning=planning,
        simplification=taken - planning,
        progress=tuple(watch.progress),
    )


class _ProgressWatch(Watch):
    """Recorder of the best paths of a search, which it ends after `limit` seconds of CPU time."""

    def __init__(self, limit: float) -> None:
        self._limit = limit
        self._begin = time.process_time()
        self._iterations = 0
        self.progress: list[Progress] = []
        self.solved_after = math.inf
        """Seconds, until the search ended with a path."""

    def elapsed(self) -> float:
        """Return the seconds of CPU time since the search began."""
        return time.process_time() - self._begin

    def iteration(self, planner: Any) -> bool:
        """Record the planner's best cost, if it has one: see `Watch`."""
        self._iterations += 1
        # OMPL's progress properties have the same value, but its binding cannot return them.
        if hasattr(planner, "bestCost"):
            cost = float(planner.bestCost().value())
            if cost > 0:
                self.add(cost)
        return self.elapsed() > self._limit

    def solved(self) -> None:
        """Record the time: see `Watch`."""
        self.solved_after = self.elapsed()

    def add(self, length: float) -> None:
        """Record a path of `length` metres, if it is the shortest so far."""
        if not self.progress or length < self.progress[-1].length:
            self.progress.append(Progress(self._iterations, self.elapsed(), length))


def _ask_peer(search: Search, start: Point, goal: Point, seed: int) -> Answer:
    """Return the answer of a peer's `search`, which uses no seed: see `Ask`."""
    begin = time.process_time()
    try:
        points = search(start, goal)
    except Exception as why:  # any failure of a peer is its answer
        reason = f"failed: {type(why).__name__}"
        return Answer(reason=reason, planning=time.process_time() - begin)
    taken = time.process_time() - begin
    if points is None:
        return Answer(reason="unreachable", planning=taken)
    path = np.array([start, *points, goal], dtype=float)
    path = path[np.append(True, np.any(np.diff(path, axis=0) != 0, axis=1))]
    return Answer(points=path, planning=taken, progress=(Progress(0, taken, length_of(path)),))


def length_of(points: Floats) -> float:
    """Return the length of the polyline `points`, shape (N, 2), in metres."""
    return float(np.hypot(*np.diff(points, axis=0).T).sum())
