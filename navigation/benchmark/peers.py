"""Planners that the benchmark compares: Floorwalker's own and those of other packages.

They know no radius, but for OMPL's own roadmap planner. Those among polygons get the floor shrunk
by it, those on a grid only cells whose steps all keep it. Ends that lie in the last few millimetres
beside a wall, which such floors lack, are linked to the nearest place that they have.
"""

from __future__ import annotations

import math
import time
import weakref
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from importlib import import_module
from importlib.util import find_spec
from typing import Any, Protocol

import numpy as np
import ompl.base as ob
import ompl.geometric as og
import ompl.util as ou
import shapely
from numpy.typing import NDArray

from floorplan import Point, UserError

from ..catalog import PlannerChoice, PlanningError, Watch, planner_info
from ..planner import COARSE, PathPlanner
from ..roadmap import HAIR
from ..roadmap_planner import SLACK
from ..sampling import OmplFloor, no_log, points_of, state_at
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


@dataclass(frozen=True, kw_only=True)
class Answer:
    """Path that was found, with what it took; times are of the CPU, in seconds."""

    points: NDArray[np.float64] | None = None
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


class _ProgressWatch(Watch):
    """Watches a search for its best paths, and ends it after so many `seconds` of CPU time."""

    def __init__(self, seconds: float | None) -> None:
        self._seconds = math.inf if seconds is None else seconds
        self._begin = time.process_time()
        self._iterations = 0
        self.progress: list[Progress] = []
        self.solved_after = math.inf
        """Seconds, until the search ended with a path."""

    def elapsed(self) -> float:
        """Return the seconds of CPU time since the search began."""
        return time.process_time() - self._begin

    def iteration(self, planner: Any) -> bool:
        """Note the planner's best cost, where it has one; see `Watch`."""
        self._iterations += 1
        # OMPL's progress properties have the same figure, but its binding can't return them.
        if hasattr(planner, "bestCost"):
            cost = float(planner.bestCost().value())
            if cost > 0:
                self.found(cost)
        return self.elapsed() > self._seconds

    def solved(self) -> None:
        """Note when; see `Watch`."""
        self.solved_after = self.elapsed()

    def found(self, length: float) -> None:
        """Note that a path is `length` metres long, if it is the shortest so far."""
        if not self.progress or length < self.progress[-1].length:
            self.progress.append(Progress(self._iterations, self.elapsed(), length))


class OwnPlanner:
    """A planner of `PathPlanner`, with a budget of iterations and of `seconds` of CPU time."""

    def __init__(
        self,
        world: CollisionWorld,
        radius: float,
        choice: PlannerChoice,
        *,
        iterations: int | None,
        seconds: float | None,
    ) -> None:
        if iterations is None and seconds is not None:
            iterations = _WITHOUT_END
        takes = choice.is_own or "iterations" in planner_info(choice.name).parameters
        if iterations is not None and takes and "iterations" not in dict(choice.parameters):
            choice = choice.with_parameters({"iterations": iterations})
        self._seconds = seconds
        self._planner = PathPlanner(world, radius, planner=choice)
        self._planner.prepare()

    def look(self) -> None:
        """Do nothing: the world is read when a path is asked for."""

    def answer(self, start: Point, goal: Point, seed: int) -> Answer:
        """Return the path from `start` to `goal` (metres) that `seed` leads to."""
        watch = _ProgressWatch(self._seconds)
        try:
            path = self._planner.plan(start, goal, seed=seed, watch=watch)
        except PlanningError as why:
            return Answer(reason=why.reason, planning=watch.elapsed())
        taken = watch.elapsed()
        watch.found(path.length)
        planning = min(watch.solved_after, taken)
        return Answer(
            points=path.points,
            planning=planning,
            simplification=taken - planning,
            progress=tuple(watch.progress),
        )


Search = Callable[[Point, Point], Sequence[Point] | None]
"""Function from start and goal to the waypoints between, or None where there is no path."""


@dataclass(frozen=True)
class Peer:
    """Planner of another package that one can ask for by name."""

    name: str
    """That of its package."""
    module: str
    prepare: Callable[[CollisionWorld, float], Search]
    """Takes in where things stand now, for a disc of a radius, and returns the search there."""

    @property
    def installed(self) -> bool:
        """True if its package is there."""
        return find_spec(self.module) is not None


class PeerPlanner:
    """A peer in `world`, for a disc of `radius` metres."""

    def __init__(self, peer: Peer, world: CollisionWorld, radius: float) -> None:
        self._peer, self._world, self._radius = peer, world, radius

    def look(self) -> None:
        """Prepare the peer for where things stand now."""
        self._search = self._peer.prepare(self._world, self._radius)

    def answer(self, start: Point, goal: Point, seed: int) -> Answer:
        """Return the path from `start` to `goal` (metres); `seed` makes no difference."""
        begin = time.process_time()
        try:
            points = self._search(start, goal)
        except Exception as why:  # a peer's own failure, whatever it is, is its answer
            reason = f"failed: {type(why).__name__}"
            return Answer(reason=reason, planning=time.process_time() - begin)
        taken = time.process_time() - begin
        if points is None:
            return Answer(reason="unreachable", planning=taken)
        path = np.array([start, *points, goal], dtype=float)
        path = path[np.append(True, np.any(np.diff(path, axis=0) != 0, axis=1))]
        length = float(np.hypot(*np.diff(path, axis=0).T).sum())
        return Answer(points=path, planning=taken, progress=(Progress(0, taken, length),))


def _among_polygons(
    pieces: Sequence[shapely.Polygon], search: Callable[[shapely.Polygon], Search]
) -> Search:
    """Return a search of the piece with both ends, by what `search` makes of each piece."""
    shapely.prepare(pieces)
    searches = [search(piece) for piece in pieces]

    def inside(place: Point) -> tuple[int, Point]:
        """Return the index of the piece at `place`, and the place in it that is nearest."""
        found = np.flatnonzero(shapely.intersects_xy(pieces, *place))
        if len(found):
            return int(found[0]), place
        at = shapely.Point(place)
        nearest = int(np.argmin(shapely.distance(pieces, at)))
        link = shapely.shortest_line(pieces[nearest], at)
        x, y = shapely.get_coordinates(link)[0].tolist()
        return nearest, (x, y)

    def between(start: Point, goal: Point) -> Sequence[Point] | None:
        one, a = inside(start)
        other, b = inside(goal)
        return searches[one](a, b) if one == other else None

    return between


def _jupedsim(world: CollisionWorld, radius: float) -> Search:
    """JuPedSim's routing engine: A* over a triangulation, and the funnel through it."""

    def search(piece: shapely.Polygon) -> Search:
        engine = import_module("jupedsim").RoutingEngine(piece)
        return lambda start, goal: list(engine.compute_waypoints(start, goal))

    return _among_polygons(world.free_space(radius).pieces, search)


COARSENED = 0.002
"""Metres. How far extremitypathfinder's corners may be off: it takes minutes to look at finer."""


def _extremity(world: CollisionWorld, radius: float) -> Search:
    """extremitypathfinder: A* over the visibility graph of the corners."""

    def search(piece: shapely.Polygon) -> Search:
        environment = import_module("extremitypathfinder").PolygonEnvironment()
        rings = [shapely.get_coordinates(ring)[:-1] for ring in (piece.exterior, *piece.interiors)]
        environment.store(rings[0], rings[1:], validate=False)
        return lambda start, goal: (
            list(environment.find_shortest_path(start, goal, verify=False)[0]) or None
        )

    pieces = world.free_space(radius).pieces
    return _among_polygons(
        [shapely.orient_polygons(piece.simplify(COARSENED)) for piece in pieces], search
    )


CELL = 0.05
"""Metres. Side of the cells of grid planners."""

Cell = tuple[int, int]
"""Row and column."""

CellSearch = Callable[[Cell, Cell], Any]
"""Function from start and goal to the cells between, or None where there is no path."""


def _on_grid(
    world: CollisionWorld, radius: float, prepare: Callable[[NDArray[np.bool_]], CellSearch]
) -> Search:
    """Return a search over the cells from whose centres every step to a neighbour is free."""
    low_x, low_y, high_x, high_y = world.plan.boundary.bounds
    xs = np.arange(low_x, high_x, CELL) + CELL / 2
    ys = np.arange(low_y, high_y, CELL) + CELL / 2
    # Half of a diagonal step is from a place at this distance no nearer than the radius.
    keep = math.hypot(radius, CELL * math.sqrt(0.5))
    free = np.zeros((len(ys), len(xs)), bool)
    for piece in world.free_space(keep).pieces:
        shapely.prepare(piece)
        free |= shapely.contains_xy(piece, *np.meshgrid(xs, ys))
    search = prepare(free)

    def cell(at: Point) -> Cell | None:
        """Return the free cell nearest to `at`, up to three cells away."""
        row, column = int((at[1] - ys[0]) / CELL + 0.5), int((at[0] - xs[0]) / CELL + 0.5)
        first_row, first_column = max(row - 3, 0), max(column - 3, 0)
        near = np.argwhere(free[first_row : row + 4, first_column : column + 4])
        near += (first_row, first_column)
        away = np.hypot(xs[near[:, 1]] - at[0], ys[near[:, 0]] - at[1])
        return (int(near[away.argmin(), 0]), int(near[away.argmin(), 1])) if len(near) else None

    def between(start: Point, goal: Point) -> Sequence[Point] | None:
        a, b = cell(start), cell(goal)
        cells = None if a is None or b is None else search(a, b)
        if cells is None:
            return None
        return [(float(xs[column]), float(ys[row])) for row, column in cells]

    return between


def _pyastar2d(world: CollisionWorld, radius: float) -> Search:
    """pyastar2d: A* in C++, for which a diagonal step is no longer than a straight one."""

    def prepare(free: NDArray[np.bool_]) -> CellSearch:
        search = import_module("pyastar2d").astar_path
        weights = np.where(free, 1.0, np.inf).astype(np.float32)
        return lambda start, goal: search(weights, start, goal, allow_diagonal=True)

    return _on_grid(world, radius, prepare)


def _scikit_image(world: CollisionWorld, radius: float) -> Search:
    """scikit-image's minimum cost paths: Dijkstra's search, with diagonal steps at their length."""

    def prepare(free: NDArray[np.bool_]) -> CellSearch:
        geometric = import_module("skimage.graph").MCP_Geometric
        weights = np.where(free, 1.0, -1.0)

        def search(start: Cell, goal: Cell) -> Any:
            graph = geometric(weights)
            costs, _ = graph.find_costs([start], [goal])
            return graph.traceback(goal) if np.isfinite(costs[goal]) else None

        return search

    return _on_grid(world, radius, prepare)


class RoadmapOfCorners:
    """OMPL's own roadmap planner, PRM, with the corner points as its samples.

    They are those of the default planner: the bends around all corners of the floor and of what
    stands on it. FCL alone judges the links, of every point with every other, so the search of PRM
    finds the shortest path along them. PRM has no directed links: it knows no one-way gates.
    """

    def __init__(self, world: CollisionWorld, radius: float) -> None:
        self._world, self._radius, self._keep = world, radius, radius + SLACK
        self._number: dict[Point, int] = {}
        low_x, low_y, high_x, high_y = world.plan.boundary.bounds
        self._floor = OmplFloor((low_x, low_y), (high_x, high_y), self._free)
        # OMPL must let go before Python does, at exit as well.
        self.release = weakref.finalize(self, self._floor.release)
        roadmap = world.roadmap(radius, COARSE)
        around = [roadmap.around(body)[:2].T for body in world.bodies]
        places = np.concatenate([roadmap.bends.point, *around]).tolist()
        self._corners = [*dict.fromkeys((x, y) for x, y in places if self._free((x, y), (x, y)))]
        self._number = {place: k for k, place in enumerate(self._corners)}
        self._judged = np.full((len(self._corners),) * 2, -1, np.int8)
        self._grown(self._corners, ob.ProblemDefinition(self._floor.information))

    def __call__(self, start: Point, goal: Point) -> Sequence[Point] | None:
        """Return the path from `start` to `goal`, or None where the corner points lead nowhere."""
        leave, arrive = self._footing(start), self._footing(goal)
        if leave is None or arrive is None:
            return None
        information = self._floor.information
        samples = [*self._corners, leave, arrive]
        while True:
            problem = ob.ProblemDefinition(information)
            problem.setStartAndGoalStates(*(state_at(information, at) for at in (leave, arrive)))
            planner = self._grown(samples, problem)
            if not self._leads_on(planner, leave, arrive):
                return None
            with no_log():
                # PRM searches in a second thread, which must not have to call Python.
                planner.solve(ob.plannerNonTerminatingCondition())
            # It adds start and goal. Where its thread got no time for 0.4 s, it also adds random
            # samples, which depends on the machine.
            if planner.milestoneCount() == len(samples) + 2:
                return points_of(problem.getSolutionPath(), leave, arrive)

    def _free(self, a: Point, b: Point) -> bool:
        """Return whether FCL lets a disc go straight from a to b; once, between corner points."""
        i, j = self._number.get(a), self._number.get(b)
        if i is None or j is None:
            return self._world.segment_free(a, b, self._keep)
        if self._judged[i, j] < 0:
            self._judged[i, j] = self._judged[j, i] = self._world.segment_free(a, b, self._keep)
        return bool(self._judged[i, j])

    def _footing(self, place: Point) -> Point | None:
        """Return `place`, or the nearest one that has room."""
        if self._world.free(place, self._keep):
            return place
        return self._world.nearest_free(place, self._radius + HAIR)

    def _grown(self, samples: list[Point], problem: Any) -> Any:
        """Return OMPL's planner with a roadmap of these samples, each linked to all others."""
        information = self._floor.information
        left = iter(samples)
        information.setValidStateSamplerAllocator(lambda of: _Given(of, left))
        planner = og.PRM(information)
        planner.setProblemDefinition(problem)
        planner.setMaxNearestNeighbors(len(samples) + 2)
        with no_log():
            ou.RNG.setSeed(1)
            planner.setup()
            planner.growRoadmapPtc(
                ob.PlannerTerminationCondition(lambda: planner.milestoneCount() >= len(samples))
            )
        return planner

    def _leads_on(self, planner: Any, start: Point, goal: Point) -> bool:
        """Return whether the links of the roadmap lead from `start` to `goal`."""
        data = ob.PlannerData(self._floor.information)
        planner.getPlannerData(data)  # without samples that have no link
        states = (data.getVertex(k).getState() for k in range(data.numVertices()))
        number = {(state[0], state[1]): k for k, state in enumerate(states)}
        if start not in number or goal not in number:
            return False
        reached, edge = {number[start]}, [number[start]]
        while edge:
            fresh = {*data.getEdges(edge.pop())} - reached
            reached |= fresh
            edge.extend(fresh)
        return number[goal] in reached


class _Given(ob.ValidStateSampler):  # type: ignore[misc]
    """Gives OMPL the samples that are left, one by one, and then none."""

    def __init__(self, information: Any, left: Iterator[Point]) -> None:
        super().__init__(information)
        self._left = left

    def sample(self, state: Any) -> bool:
        """Put the next sample into `state`; return False where none is left."""
        place = next(self._left, None)
        if place is not None:
            state[0], state[1] = place
        return place is not None


PEERS = {
    peer.name: peer
    for peer in (
        Peer("JuPedSim", "jupedsim", _jupedsim),
        Peer("extremitypathfinder", "extremitypathfinder", _extremity),
        Peer("pyastar2d", "pyastar2d", _pyastar2d),
        Peer("scikit-image", "skimage", _scikit_image),
        Peer("PRM-of-corners", "ompl", RoadmapOfCorners),
    )
}
"""All peers, by the names that they are asked for."""


def peer_named(name: str) -> Peer | None:
    """Return the peer called `name`, None if there is none; `ValueError` if it isn't installed."""
    peer = PEERS.get(name)
    if peer is not None and not peer.installed:
        raise UserError(f"{name} is not installed: pip install {name.lower()}")
    return peer
