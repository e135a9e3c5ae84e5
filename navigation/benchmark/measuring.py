"""Planner benchmark: all planners answer the same questions, and the answers are evaluated."""

from __future__ import annotations

import math
import re
import time
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from floorplan import Floorplan, Point, UserError
from floorplan.files.dataclass import dataclass

from ..catalog import PlannerChoice
from ..world import CollisionWorld
from .answering import Answer, Ask, Progress, length_of, planner_in, table_name
from .questions import Question, drawn_questions, read_questions

Floats = NDArray[np.float64]

TOUCHES = 2e-3
"""Metres. Maximum violation of the radius, because floors of some peers are as inexact."""

_AT = 1e-6
"""Metres. Tolerance of the first and last point of a path."""

SEEDED = 50
"""Default number of seeded questions."""


@dataclass(frozen=True, kw_only=True)
class Asked(Question):
    """Question to a planner."""

    floorplan: str
    planner: str
    query: int
    run: int
    seed: int
    longest: float = math.inf
    """A path that exceeds this multiple of the shortest path is wrong."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Attempt:
    """Answer of a planner to a question, with its measures."""

    asked: Asked
    solved: bool
    reason: str
    """Reason without a path: see `PlanningError`, or "failed" for a peer."""
    wrong: str
    """Empty, or "touches", "too long", "elsewhere" (does not connect start and goal), or "none"
    (denies an existing path)."""
    cpu_seconds: float
    planning_seconds: float
    simplification_seconds: float
    scene_seconds: float = 0.0
    """CPU time of updating the planner after AGVs have moved."""
    memory: float = math.nan
    """Growth of the process at its peak in MB, NaN if unknown."""
    length: float = math.nan
    """Metres, as the following measures except `bends` and `turning`. NaN without a path."""
    clearance: float = math.nan
    """Minimum along the path, of its centre line."""
    bends: int = 0
    turning: float = math.nan
    """Sum of all turns, in radians."""
    ompl_clearance: float = math.nan
    """OMPL's definition: mean over the waypoints, minus the radius."""
    ompl_smoothness: float = math.nan
    """OMPL's definition, in 1/m²: see `ompl_smoothness`."""
    points: Floats | None
    progress: tuple[Progress, ...]
    """Shorter and shorter paths of the search. The last one is the answer."""

    @property
    def ratio(self) -> float:
        """Length over that of the shortest path."""
        return _over(self.length, self.asked.shortest)

    @property
    def listed_ratio(self) -> float:
        """Length over the length that a scenario lists."""
        return _over(self.length, self.asked.listed)

    @property
    def first_seconds(self) -> float:
        """CPU time (s) until the first path, or the correct proof of none, otherwise inf.

        With a limit of the length, only paths within the limit count.
        """
        if not self.solved:
            return self.cpu_seconds if self.right else math.inf
        limit = self.asked.longest * self.asked.shortest
        allowed = [one.cpu_seconds for one in self.progress if not one.length > limit]
        planned = [] if math.isfinite(limit) else [self.planning_seconds]
        return min([*planned, *allowed[:1]], default=self.cpu_seconds)

    @property
    def right(self) -> bool:
        """True for a correct path, and for a correct proof that there is none."""
        if self.asked.shortest == math.inf:
            return self.reason == "unreachable"
        return self.solved and not self.wrong


def _over(length: float, best: float) -> float:
    """Return the ratio of lengths, 1 if the start is the goal."""
    if best == 0:
        return math.nan if math.isnan(length) else 1.0
    return length / best


def benchmark(
    plans: Sequence[Floorplan],
    planners: Sequence[str | PlannerChoice],
    *,
    queries: int | None = None,
    runs: int = 1,
    seed: int = 0,
    radius: float | None = None,
    questions: Path | None = None,
    iterations: int | None = None,
    seconds: float | None = None,
    longest: float | None = None,
    progress: Callable[[str, str], None] | None = None,
) -> list[Attempt]:
    """Ask all planners the same questions, and evaluate their answers.

    All results except times and memory are the same for the same seed, unless `seconds` are given.

    Parameters
    ----------
    plans : sequence of Floorplan
        Floors with different names.
    planners : sequence of str or PlannerChoice
        Choices of Floorwalker's planners (`"BITstar: {samples_per_batch: 50}"`), or names of
        `PEERS`.
    queries : int, optional
        Number of questions on each floor. By default 50, or all of the file.
    runs : int, optional
        Number of times that each question is asked, with different seeds.
    seed : int, optional
        Seed of questions and planners.
    radius : float, optional
        Radius of the disc in metres. By default the radius of the floor's people.
    questions : pathlib.Path, optional
        File of questions, a CSV table or a MovingAI scenario.
    iterations : int, optional
        Budget of OMPL's planners. By default each has its own.
    seconds : float, optional
        Budget of CPU time for each answer of OMPL's planners.
    longest : float, optional
        Paths that exceed this multiple of the shortest path are wrong.
    progress : callable, optional
        Called after each answer with the names of floor and planner.

    Returns
    -------
    list of Attempt
        Answers by floor, planner, question and run.

    Raises
    ------
    floorplan.UserError
        If a parameter is invalid, a planner unknown, or a peer not installed.
    QuestionsError
        With all faults of the file of questions.
    """
    for name, count in (("queries", queries), ("runs", runs), ("iterations", iterations)):
        if count is not None and count < 1:
            raise UserError(f"{name} must be 1 or more, found {count}")
    for name, figure in (("radius", radius), ("seconds", seconds), ("longest", longest)):
        least = 1 if name == "longest" else 0
        if figure is not None and not least < figure < math.inf:
            raise UserError(f"{name} must be above {least} and finite, found {figure:g}")
    names = [plan.name for plan in plans]
    if twice := [name for name in names if names.count(name) > 1]:
        raise UserError(f"two floors are called {twice[0]!r}: their answers would be mixed up")
    entries = {table_name(planner): planner for planner in planners}
    results = []
    for plan in plans:
        keep = plan.human.radius if radius is None else radius
        if questions is None:
            posed = [*drawn_questions(plan, queries=queries or SEEDED, seed=seed, radius=keep)]
        else:
            posed = read_questions(questions, plan, radius=keep, queries=queries, seed=seed)
        for name, planner in entries.items():
            world = CollisionWorld(plan)
            prepare = planner_in(planner, world, keep, iterations, seconds)
            repeated = (
                Asked(
                    **vars(question),
                    floorplan=plan.name,
                    planner=name,
                    query=number,
                    run=run,
                    seed=seed + number + run * len(posed),
                    longest=longest or math.inf,
                )
                for number, question in enumerate(posed)
                for run in range(runs)
            )
            for attempt in attempts(prepare, world, keep, repeated):
                results.append(attempt)
                if progress is not None:
                    progress(plan.name, name)
    return results


def attempts(
    prepare: Callable[[], Ask], world: CollisionWorld, radius: float, questions: Iterator[Asked]
) -> Iterator[Attempt]:
    """Yield the answers to `questions`. `prepare` is called after AGVs have moved."""
    agvs = None
    for asked in questions:
        if asked.agvs != agvs:
            agvs = asked.agvs
            for agv, at in agvs:
                world.move_agv(agv, at)
            begin = time.process_time()
            ask = prepare()
            prepared = time.process_time() - begin
        before = _start_of_peak()
        answer = ask(asked.start, asked.goal, asked.seed)
        memory = max(_megabytes("VmHWM") - before, 0.0)
        spent = {"scene_seconds": prepared, "memory": memory}
        yield evaluate(asked, answer, world, radius, **spent)


def evaluate(
    asked: Asked, answer: Answer, world: CollisionWorld, radius: float, **spent: float
) -> Attempt:
    """Return `answer` with its measures in `world`, and with `spent` as further measures."""
    points = _line(answer.points)
    measures: dict[str, Any] = {**spent}
    wrong = ""
    if points is not None:
        ends = max(math.dist(points[0], asked.start), math.dist(points[-1], asked.goal))
        length, clearance = length_of(points), world.clearance(points)
        too_long = length > asked.longest * asked.shortest
        touches = clearance < radius - TOUCHES
        wrong = "elsewhere" if ends > _AT else "touches" if touches else "too long" * too_long
        measures |= {
            "length": length,
            "clearance": clearance,
            "bends": len(points) - 2,
            "turning": turning(points),
            "ompl_clearance": ompl_clearance(points, world.distance, radius),
            "ompl_smoothness": ompl_smoothness(points),
        }
    elif answer.reason == "unreachable" and math.isfinite(asked.shortest):
        wrong = "none"
    return Attempt(
        asked=asked,
        solved=points is not None,
        reason=answer.reason,
        wrong=wrong,
        cpu_seconds=answer.planning + answer.simplification,
        planning_seconds=answer.planning,
        simplification_seconds=answer.simplification,
        points=points,
        progress=answer.progress,
        **measures,
    )


def _line(points: Floats | None) -> Floats | None:
    """Return `points` as a line of two or more, or None if they are no line."""
    if points is None or points.shape[1:] != (2,) or not np.isfinite(points).all():
        return None
    return points if len(points) > 1 else np.repeat(points, 2, axis=0)


def turning(points: Floats) -> float:
    """Return the sum of all turns of the polyline `points`, shape (N, 2), in radians."""
    heading = np.unwrap(np.arctan2(*np.diff(points, axis=0).T[::-1]))
    return float(np.abs(np.diff(heading)).sum())


def ompl_smoothness(points: Floats) -> float:
    """Return `PathGeometric::smoothness()` of the polyline `points`, shape (N, 2) metres.

    That is the sum over the inner waypoints of (2 α / (a + b))², in 1/m². a and b are the lengths
    of the segments before and after, and α is the angle in radians between their directions. OMPL
    leaves out a waypoint if the path continues or returns on the same line.
    """
    steps = np.diff(points, axis=0)
    lengths = np.hypot(*steps.T)
    before, after = lengths[:-1], lengths[1:]
    with np.errstate(divide="ignore", invalid="ignore"):
        cosine = (steps[:-1] * steps[1:]).sum(axis=1) / (before * after)
        bends = np.abs(cosine) < 1
        terms = (2 * np.arccos(cosine[bends]) / (before + after)[bends]) ** 2
    return float(terms.sum())


def ompl_clearance(points: Floats, distance: Callable[[Point], float], radius: float) -> float:
    """Return `PathGeometric::clearance()` of the polyline `points`, shape (N, 2), in metres.

    That is the mean over the waypoints of the distance to the nearest invalid position: the
    `distance` of the centre to the nearest body, minus the radius.
    """
    return float(np.mean([distance((x, y)) for x, y in points.tolist()])) - radius


def _start_of_peak() -> float:
    """Reset the peak of resident memory to its present value, and return that in MB.

    NaN if the system is not Linux or forbids it. Memory in the allocator does not count again, so
    the first answers of a process grow more than later ones.
    """
    try:
        # Since Linux 4.0: see proc(5).
        Path("/proc/self/clear_refs").write_text("5\n", encoding="ascii")
    except OSError:
        return math.nan
    return _megabytes("VmRSS")


def _megabytes(field: str) -> float:
    try:
        status = Path("/proc/self/status").read_text(encoding="ascii")
    except OSError:
        return math.nan
    line = re.search(rf"^{field}:\s+(\d+) kB", status, re.M)
    return int(line[1]) / 1024 if line else math.nan
