"""The same seeded questions to every planner, and measures of the answers."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np
import shapely
from numpy.typing import NDArray

from floorplan import Floorplan, Point

from ..path import Path, PlanningError
from ..planner import PathPlanner
from ..world import CollisionWorld
from .shortest import ShortestPaths

PER_SCENE = 10
"""Number of questions before the AGVs move on."""

_MARGIN = 1e-3
"""Metres. Starts and goals have this much more room than they need."""

_MOST_DRAWS = 100_000


@dataclass(frozen=True)
class Scene:
    """A floor with its AGVs somewhere (lane positions in metres), and questions to ask there."""

    plan: Floorplan
    agvs: tuple[tuple[str, float], ...]
    questions: tuple[tuple[Point, Point], ...]
    shortest: tuple[float, ...]
    """Metres, for each question; see `shortest.SHORTFALL` for how exact."""


@dataclass(frozen=True)
class Attempt:
    """One answer of one planner to one question."""

    floorplan: str
    planner: str
    query: int
    solved: bool
    reason: str
    cpu_seconds: float
    checks: int
    length: float
    """Metres, as is all that follows but `bends` and `turning`; NaN where there is no path."""
    shortest: float
    clearance: float
    """The least anywhere along the path, of its centre line."""
    bends: int
    turning: float
    """Radians that the path turns by in all."""
    ompl_clearance: float
    """OMPL's definition: the mean over the waypoints, less the radius."""
    ompl_smoothness: float
    """OMPL's definition, in 1/m²: see `ompl_smoothness`."""

    @property
    def ratio(self) -> float:
        """Length over that of the shortest path."""
        return self.length / self.shortest if self.shortest > 0 else 1.0


def scenes(plan: Floorplan, *, queries: int, seed: int, radius: float) -> Iterator[Scene]:
    """Yield seeded questions on `plan` that have an answer, with AGVs anywhere on their lanes.

    `ValueError` if there is no room on the floor for two places.
    """
    rng = np.random.default_rng(seed)
    world = CollisionWorld(plan)
    paths: ShortestPaths | None = None
    for first in range(0, queries, PER_SCENE):
        for lane in plan.lanes:
            world.move_agv(lane.name, float(rng.uniform(*lane.limits)))
        if paths is None or plan.lanes:
            paths = ShortestPaths(world.walkable, radius)
        count = min(PER_SCENE, queries - first)
        questions = tuple(_question(world, paths, rng, radius) for _ in range(count))
        yield Scene(
            plan,
            tuple((lane.name, world.agv_position(lane.name)) for lane in plan.lanes),
            questions,
            tuple(paths.length(*question) for question in questions),
        )


def benchmark(
    plans: Sequence[Floorplan],
    planners: Sequence[str],
    *,
    queries: int = 50,
    seed: int = 0,
    radius: float | None = None,
    progress: Callable[[str, str], None] | None = None,
) -> list[Attempt]:
    """Ask each of `planners` the same `queries` on each of `plans`, for a disc of `radius` metres.

    The floor's own people give the radius where none is given. `progress` is called after each
    answer, with the names of the floor and the planner. All but the CPU times is the same again
    for the same seed.
    """
    attempts = []
    for plan in plans:
        keep = plan.human.radius if radius is None else radius
        asked = list(scenes(plan, queries=queries, seed=seed, radius=keep))
        world = CollisionWorld(plan)
        planner = PathPlanner(world, keep)
        planner.prepare()
        for name in planners:
            query = 0
            for scene in asked:
                for agv, at in scene.agvs:
                    world.move_agv(agv, at)
                for (start, goal), best in zip(scene.questions, scene.shortest, strict=True):
                    attempts.append(_attempt(planner, name, query, start, goal, best, seed))
                    query += 1
                    if progress is not None:
                        progress(plan.name, name)
    return attempts


def _question(
    world: CollisionWorld, paths: ShortestPaths, rng: np.random.Generator, radius: float
) -> tuple[Point, Point]:
    """Return two places with room to stand and a path between them."""
    low_x, low_y, high_x, high_y = world.plan.boundary.bounds
    pieces = [piece for piece in shapely.get_parts(paths.room) if piece.area > 0]
    found: list[tuple[Point, int]] = []
    for _ in range(_MOST_DRAWS):
        at = (float(rng.uniform(low_x, high_x)), float(rng.uniform(low_y, high_y)))
        if not world.free(at, radius + _MARGIN):
            continue
        (within,) = np.nonzero(shapely.intersects_xy(pieces, *at))
        for other, piece in found:
            if piece in within:
                return other, at
        found += [(at, int(piece)) for piece in within]
    name = world.plan.name
    raise ValueError(f"{name} has no two places for a radius of {radius:g} m with a path between")


def _attempt(
    planner: PathPlanner, name: str, query: int, start: Point, goal: Point, best: float, seed: int
) -> Attempt:
    checks = planner.world.checks
    begin = time.process_time()
    path: Path | None = None
    reason = ""
    try:
        path = planner.plan(start, goal, planner=name, seed=seed + query)
    except PlanningError as why:
        reason = why.reason
    cpu = time.process_time() - begin
    checks = planner.world.checks - checks
    return Attempt(
        floorplan=planner.world.plan.name,
        planner=name,
        query=query,
        solved=path is not None,
        reason=reason,
        cpu_seconds=cpu,
        checks=checks,
        length=path.length if path else math.nan,
        shortest=best,
        clearance=path.clearance if path else math.nan,
        bends=len(path.points) - 2 if path else 0,
        turning=_turning(path) if path else math.nan,
        ompl_clearance=(
            ompl_clearance(path.points, planner.world.distance, planner.radius)
            if path
            else math.nan
        ),
        ompl_smoothness=ompl_smoothness(path.points) if path else math.nan,
    )


def _turning(path: Path) -> float:
    """Return the radians that `path` turns by in all."""
    heading = np.unwrap(np.arctan2(*np.diff(path.points, axis=0).T[::-1]))
    return float(np.abs(np.diff(heading)).sum())


def ompl_smoothness(points: NDArray[np.float64]) -> float:
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


def ompl_clearance(
    points: NDArray[np.float64], distance: Callable[[Point], float], radius: float
) -> float:
    """Return `PathGeometric::clearance()` of the polyline `points`, shape (N, 2), in metres.

    That is the mean over the waypoints of the distance to the nearest place that is not valid:
    for a disc of `radius` metres its centre's `distance` to the nearest thing, less the radius.
    """
    return float(np.mean([distance((x, y)) for x, y in points.tolist()])) - radius
