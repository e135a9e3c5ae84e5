"""Answers of planners, measured and judged by what is known of the floor apart from them."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from floorplan import Point

from ..world import CollisionWorld
from .contenders import Answer, Progress
from .geometry import Floats, ompl_clearance, ompl_smoothness, turning

TOUCHES = 2e-3
"""Metres. A path that is this much closer to something than the radius is a wrong answer; some
peers know the floor no better."""

_AT = 1e-6
"""Metres. A path begins and ends no farther than this from where it was asked to."""


@dataclass(frozen=True)
class Asked:
    """A question as it was put to a planner."""

    floorplan: str
    planner: str
    query: int
    run: int
    seed: int
    start: Point
    goal: Point
    agvs: tuple[tuple[str, float], ...]
    """Where they stood: lane positions, in metres."""
    shortest: float
    """Metres of the shortest path; infinite where there is none, NaN where nobody knows."""
    listed: float
    """Metres that a scenario lists, over cells; NaN where there is none."""
    longest: float = math.inf
    """A path of more than so many times the shortest is a wrong answer."""


@dataclass(frozen=True, eq=False)
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
    scene_seconds: float
    """Of the CPU, that the planner looked at where the AGVs stand before it was asked here."""
    memory: float
    """MB that the process grew by at its peak; NaN where the system does not tell."""
    checks: int
    """Collision queries; 0 for a peer, which has its own."""
    length: float
    """Metres, as is all that follows but `bends` and `turning`; NaN where there is no path."""
    clearance: float
    """The least anywhere along the path, of its centre line."""
    bends: int
    turning: float
    """Radians that the path turns by in all."""
    ompl_clearance: float
    """OMPL's definition: the mean over the waypoints, less the radius."""
    ompl_smoothness: float
    """OMPL's definition, in 1/m²: see `geometry.ompl_smoothness`."""
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


@dataclass(frozen=True)
class Spent:
    """What one answer took, beside its own times."""

    scene_seconds: float
    memory: float
    checks: int


@dataclass(frozen=True)
class Judge:
    """Measures and judges answers in `world`, for a disc of `radius` metres."""

    world: CollisionWorld
    radius: float

    def attempt(self, asked: Asked, answer: Answer, spent: Spent) -> Attempt:
        """Return `answer`, which took what it `spent`, measured and judged."""
        points = _line(answer.points)
        figures = _no_figures() if points is None else self._measured(points)
        return Attempt(
            asked=asked,
            solved=points is not None,
            reason=answer.reason,
            wrong=self._fault(asked, answer, points, figures),
            cpu_seconds=answer.planning + answer.simplification,
            planning_seconds=answer.planning,
            simplification_seconds=answer.simplification,
            scene_seconds=spent.scene_seconds,
            memory=spent.memory,
            checks=spent.checks,
            points=points,
            progress=answer.progress,
            **vars(figures),
        )

    def _measured(self, points: Floats) -> _Figures:
        return _Figures(
            length=float(np.hypot(*np.diff(points, axis=0).T).sum()),
            clearance=self.world.clearance(points),
            bends=len(points) - 2,
            turning=turning(points),
            ompl_clearance=ompl_clearance(points, self.world.distance, self.radius),
            ompl_smoothness=ompl_smoothness(points),
        )

    def _fault(self, asked: Asked, answer: Answer, points: Floats | None, figures: _Figures) -> str:
        if points is None:
            claims = answer.reason == "unreachable" and math.isfinite(asked.shortest)
            return "none" if claims else ""
        if max(math.dist(points[0], asked.start), math.dist(points[-1], asked.goal)) > _AT:
            return "elsewhere"
        if figures.clearance < self.radius - TOUCHES:
            return "touches"
        return "too long" if figures.length > asked.longest * asked.shortest else ""


@dataclass(frozen=True)
class _Figures:
    """Measures of a path, by the names that an attempt has them under."""

    length: float
    clearance: float
    bends: int
    turning: float
    ompl_clearance: float
    ompl_smoothness: float


def _no_figures() -> _Figures:
    return _Figures(math.nan, math.nan, 0, math.nan, math.nan, math.nan)


def _line(points: Floats | None) -> Floats | None:
    """Return `points` as a line of two or more, or None if they are none."""
    if points is None or points.shape[1:] != (2,) or not np.isfinite(points).all():
        return None
    return points if len(points) > 1 else np.repeat(points, 2, axis=0)
