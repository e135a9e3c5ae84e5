"""The planner benchmark: asks every planner the same queries and evaluates the answers."""

from __future__ import annotations

import math
import re
import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from floorplan import Floorplan, Point, UserError

from ..catalog import PlannerChoice
from ..world import CollisionWorld
from .peers import Answer, Contender, OwnPlanner, PeerPlanner, Progress, peer_named
from .questions import QuerySet, scenes, scenes_of

Floats = NDArray[np.float64]

TOUCHES = 2e-3
"""Metres. A path that is this much closer to something than the radius is a wrong answer; some
peers know the floor no better."""

_AT = 1e-6
"""Metres. A path begins and ends no farther than this from where it was asked to."""

SEEDED = 50
"""Number of seeded questions where none is given."""


@dataclass(frozen=True, kw_only=True)
class Asked:
    """A question as it was put to a planner."""

    floorplan: str
    planner: str
    query: int
    run: int
    seed: int
    start: Point
    goal: Point
    agvs: tuple[tuple[str, float], ...] = ()
    """Where they stood: lane positions, in metres."""
    shortest: float
    """Metres of the shortest path; infinite where there is none, NaN where nobody knows."""
    listed: float = math.nan
    """Metres that a scenario lists, over cells; NaN where there is none."""
    longest: float = math.inf
    """A path of more than so many times the shortest is a wrong answer."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Attempt:
    """One answer of one planner to one question."""

    asked: Asked
    solved: bool
    reason: str
    """Of no path: see `PlanningError`; "failed" where a peer broke down."""
    wrong: str
    """Empty, or "touches", "too long", "elsewhere" (not from the start to the goal), or "none"
    (says that there is no path, though there is)."""
    cpu_seconds: float
    planning_seconds: float
    simplification_seconds: float
    scene_seconds: float = 0.0
    """Of the CPU, that the planner looked at where the AGVs stand before it was asked here."""
    memory: float = math.nan
    """MB that the process grew by at its peak; NaN where the system does not tell."""
    checks: int = 0
    """Collision queries; 0 for a peer, which has its own."""
    length: float = math.nan
    """Metres, as is all that follows but `bends` and `turning`; NaN where there is no path."""
    clearance: float = math.nan
    """The least anywhere along the path, of its centre line."""
    bends: int = 0
    turning: float = math.nan
    """Radians that the path turns by in all."""
    ompl_clearance: float = math.nan
    """OMPL's definition: the mean over the waypoints, less the radius."""
    ompl_smoothness: float = math.nan
    """OMPL's definition, in 1/m²: see `ompl_smoothness`."""
    points: Floats | None
    progress: tuple[Progress, ...]
    """Ever shorter paths while it searched; the last is the answer."""

    @property
    def ratio(self) -> float:
        """Length over that of the shortest path."""
        return _over(self.length, self.asked.shortest)

    @property
    def listed_ratio(self) -> float:
        """Length over that of the shortest path over cells, which a scenario lists."""
        return _over(self.length, self.asked.listed)

    @property
    def first_seconds(self) -> float:
        """Seconds of CPU until there was a first path, simplified or not; infinite without one.

        Until there was the proof, where there is rightly none. A path that is longer than allowed
        is none yet; where there is such a limit, a path counts from when its length is known.
        """
        if not self.solved:
            return self.cpu_seconds if self.right else math.inf
        limit = self.asked.longest * self.asked.shortest
        allowed = [one.cpu_seconds for one in self.progress if not one.length > limit]
        planned = [] if math.isfinite(limit) else [self.planning_seconds]
        return min([*planned, *allowed[:1]], default=self.cpu_seconds)

    @property
    def right(self) -> bool:
        """True if it is a path that nothing is wrong with, or rightly none."""
        if self.asked.shortest == math.inf:
            return self.reason == "unreachable"
        return self.solved and not self.wrong


def _over(length: float, best: float) -> float:
    """Return the ratio of lengths; 1 for a question that is answered by standing still."""
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
    """Ask each of `planners` the same `queries` on each of `plans`, for a disc of `radius` metres.

    A planner is a choice of one of Floorwalker's (`"BITstar: {samples_per_batch: 50}"`) or the
    name of a peer. The floor's own people give the radius where none is given. There are 50
    seeded questions, or all of those in the file `questions`, unless `queries` says otherwise;
    each is asked `runs` times, with seeds of their own. `iterations` are the budget of OMPL's
    planners in place of their usual ones; `seconds` of CPU time for each of their answers end
    them too, or alone, and all then depends on the machine. A path of more than `longest` times
    the shortest is a wrong answer. `progress` is called after each answer, with the names of the
    floor and the planner. All but times and memory is the same again for the same seed, unless
    `seconds` are given.
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
    entries = {known(planner): planner for planner in planners}
    attempts = []
    for plan in plans:
        keep = plan.human.radius if radius is None else radius
        if questions is None:
            asked = list(scenes(plan, queries=queries or SEEDED, seed=seed, radius=keep))
        else:
            asked = scenes_of(questions, plan, radius=keep, queries=queries, seed=seed)
        for name, planner in entries.items():
            world = CollisionWorld(plan)
            contender = _contender(planner, world, keep, iterations, seconds)
            for attempt in _attempts(
                world, keep, contender, _put(asked, name, runs, seed, longest)
            ):
                attempts.append(attempt)
                if progress is not None:
                    progress(plan.name, name)
    return attempts


def known(planner: str | PlannerChoice) -> str:
    """Return `planner` as tables name it; `ValueError` if there is no such planner or peer."""
    if isinstance(planner, str) and peer_named(planner) is not None:
        return planner
    choice = PlannerChoice.of(planner)
    choice.check()
    return str(choice)


def _contender(
    planner: str | PlannerChoice,
    world: CollisionWorld,
    radius: float,
    iterations: int | None,
    seconds: float | None,
) -> Contender:
    peer = peer_named(planner) if isinstance(planner, str) else None
    if peer is not None:
        return PeerPlanner(peer, world, radius)
    choice = PlannerChoice.of(planner)
    return OwnPlanner(world, radius, choice, iterations=iterations, seconds=seconds)


def _put(
    scenes: Sequence[QuerySet], planner: str, runs: int, seed: int, longest: float | None
) -> Iterator[Asked]:
    """Yield all questions of `scenes` as they are put to `planner`, each of them `runs` times."""
    questions = [(scene, k) for scene in scenes for k in range(len(scene.questions))]
    for number, (scene, k) in enumerate(questions):
        start, goal = scene.questions[k]
        for run in range(runs):
            yield Asked(
                floorplan=scene.plan.name,
                planner=planner,
                query=number,
                run=run,
                seed=seed + number + run * len(questions),
                start=start,
                goal=goal,
                agvs=scene.agvs,
                shortest=scene.shortest[k],
                listed=scene.listed[k],
                longest=longest or math.inf,
            )


def _attempts(
    world: CollisionWorld, radius: float, contender: Contender, questions: Iterator[Asked]
) -> Iterator[Attempt]:
    """Yield the answers of `contender`, measured and judged."""
    agvs = None
    looked = 0.0
    for asked in questions:
        if asked.agvs != agvs:
            agvs = asked.agvs
            for agv, at in agvs:
                world.move_agv(agv, at)
            begin = time.process_time()
            contender.look()
            looked = time.process_time() - begin
        checks, before = world.checks, _start_of_peak()
        answer = contender.answer(asked.start, asked.goal, asked.seed)
        yield evaluate(
            asked,
            answer,
            world,
            radius,
            scene_seconds=looked,
            memory=max(_megabytes("VmHWM") - before, 0.0),
            checks=world.checks - checks,
        )


def evaluate(
    asked: Asked, answer: Answer, world: CollisionWorld, radius: float, **spent: float
) -> Attempt:
    """Return `answer`, measured and judged in `world`; `spent` are further values of it."""
    points = _line(answer.points)
    measures: dict[str, float] = {}
    if points is not None:
        measures = {
            "length": float(np.hypot(*np.diff(points, axis=0).T).sum()),
            "clearance": world.clearance(points),
            "bends": len(points) - 2,
            "turning": turning(points),
            "ompl_clearance": ompl_clearance(points, world.distance, radius),
            "ompl_smoothness": ompl_smoothness(points),
        }
    taken: dict[str, Any] = {**spent, **measures}
    return Attempt(
        asked=asked,
        solved=points is not None,
        reason=answer.reason,
        wrong=_fault(asked, answer, points, measures, radius),
        cpu_seconds=answer.planning + answer.simplification,
        planning_seconds=answer.planning,
        simplification_seconds=answer.simplification,
        points=points,
        progress=answer.progress,
        **taken,
    )


def _fault(
    asked: Asked,
    answer: Answer,
    points: Floats | None,
    measures: dict[str, float],
    radius: float,
) -> str:
    if points is None:
        claims = answer.reason == "unreachable" and math.isfinite(asked.shortest)
        return "none" if claims else ""
    if max(math.dist(points[0], asked.start), math.dist(points[-1], asked.goal)) > _AT:
        return "elsewhere"
    if measures["clearance"] < radius - TOUCHES:
        return "touches"
    return "too long" if measures["length"] > asked.longest * asked.shortest else ""


def _line(points: Floats | None) -> Floats | None:
    """Return `points` as a line of two or more, or None if they are none."""
    if points is None or points.shape[1:] != (2,) or not np.isfinite(points).all():
        return None
    return points if len(points) > 1 else np.repeat(points, 2, axis=0)


def turning(points: Floats) -> float:
    """Return the radians that the polyline `points`, shape (N, 2), turns by in all."""
    heading = np.unwrap(np.arctan2(*np.diff(points, axis=0).T[::-1]))
    return float(np.abs(np.diff(heading)).sum())


def ompl_smoothness(points: Floats) -> float:
    """Return `PathGeometric::smoothness()` of the polyline `points`, shape (N, 2), in metres.

    That is the sum over the inner waypoints of (2 α / (a + b))², with a and b the lengths of the
    segments before and after, and α the angle in radians between their directions: 0 for a
    straight path. OMPL leaves out a waypoint at which the path goes straight on or straight back.
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

    That is the mean over the waypoints of the distance to the nearest place that is not valid:
    for a disc of `radius` metres its centre's `distance` to the nearest thing, less the radius.
    """
    return float(np.mean([distance((x, y)) for x, y in points.tolist()])) - radius


def _start_of_peak() -> float:
    """Set the peak of resident memory to what there is now, and return that in MB.

    NaN where the system is no Linux or does not allow it. What the allocator has kept from before
    is not counted again, so that the first answers of a process grow more than later ones.
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
    found = re.search(rf"^{field}:\s+(\d+) kB", status, re.M)
    return int(found[1]) / 1024 if found else math.nan
