"""Planners that the benchmark compares: Floorwalker's own and those of other packages.

They know no radius, but for OMPL's own roadmap planner. Those among polygons get the floor shrunk
by it, those on a grid only cells whose steps all keep it. Ends that lie in the last few millimetres
beside a wall, which such floors lack, are linked to the nearest place that they have.
"""

from __future__ import annotations

import math
import time
import weakref
from abc import ABC, abstractmethod
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


class _ProgressWatch(Watch):
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
        watch = _ProgressWatch(self._budget.seconds)
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


CELL = 0.05
"""Metres. Side of the cells of grid planners."""

COARSENED = 0.002
"""Metres. How far extremitypathfinder's corners may be off: it takes minutes to look at finer."""


class Peer(ABC):
    """Planner of another package, in `world`, for a disc of `radius` metres."""

    def __init__(self, world: CollisionWorld, radius: float) -> None:
        self._world, self._radius = world, radius

    @abstractmethod
    def look(self) -> None:
        """Take in where things stand now."""

    @abstractmethod
    def between(self, start: Point, goal: Point) -> Sequence[Point] | None:
        """Return the path from `start` to `goal`, or None where there is none."""

    def answer(self, start: Point, goal: Point, seed: int) -> Answer:
        """Return the path from `start` to `goal` (metres); `seed` makes no difference."""
        begin = time.process_time()
        try:
            points = self.between(start, goal)
        except Exception as why:  # a peer's own failure, whatever it is, is its answer
            return Answer(None, f"failed: {type(why).__name__}", time.process_time() - begin)
        taken = time.process_time() - begin
        if points is None:
            return Answer(None, "unreachable", taken)
        path = np.array([start, *points, goal], dtype=float)
        moves = np.append(True, np.any(np.diff(path, axis=0) != 0, axis=1))
        length = float(np.hypot(*np.diff(path, axis=0).T).sum())
        return Answer(path[moves], "", taken, progress=(Progress(0, taken, length),))


class _AmongPolygons(Peer):
    """Planner that searches a polygon with holes: the piece of the free space with both ends."""

    def look(self) -> None:
        """Make a search for each piece of the free space."""
        pieces = self._world.free_space(self._radius).pieces
        self._pieces = [self._coarsened(piece) for piece in pieces]
        shapely.prepare(self._pieces)
        self._searches = [self._search(piece) for piece in self._pieces]

    def between(self, start: Point, goal: Point) -> Sequence[Point] | None:
        """Return the path from `start` to `goal`, or None where they are in different pieces."""
        one, a = self._inside(start)
        other, b = self._inside(goal)
        return self._searches[one](a, b) if one == other else None

    def _inside(self, place: Point) -> tuple[int, Point]:
        """Return the index of the piece at `place`, and the place in it that is nearest."""
        inside = np.flatnonzero(shapely.intersects_xy(self._pieces, *place))
        if len(inside):
            return int(inside[0]), place
        at = shapely.Point(place)
        nearest = int(np.argmin(shapely.distance(self._pieces, at)))
        link = shapely.shortest_line(self._pieces[nearest], at)
        x, y = shapely.get_coordinates(link)[0].tolist()
        return nearest, (x, y)

    def _coarsened(self, piece: shapely.Polygon) -> shapely.Polygon:
        return piece

    @abstractmethod
    def _search(self, piece: shapely.Polygon) -> Callable[[Point, Point], Sequence[Point] | None]:
        """Return a function that searches `piece`."""


class JuPedSim(_AmongPolygons):
    """JuPedSim's routing engine: A* over a triangulation, and the funnel through it."""

    def _search(self, piece: shapely.Polygon) -> Callable[[Point, Point], Sequence[Point] | None]:
        engine = import_module("jupedsim").RoutingEngine(piece)
        return lambda start, goal: list(engine.compute_waypoints(start, goal))


class Extremity(_AmongPolygons):
    """extremitypathfinder: A* over the visibility graph of the corners."""

    def _coarsened(self, piece: shapely.Polygon) -> shapely.Polygon:
        return shapely.orient_polygons(piece.simplify(COARSENED))

    def _search(self, piece: shapely.Polygon) -> Callable[[Point, Point], Sequence[Point] | None]:
        environment = import_module("extremitypathfinder").PolygonEnvironment()
        rings = [shapely.get_coordinates(ring)[:-1] for ring in (piece.exterior, *piece.interiors)]
        environment.store(rings[0], rings[1:], validate=False)

        def search(start: Point, goal: Point) -> Sequence[Point] | None:
            points, _ = environment.find_shortest_path(start, goal, verify=False)
            return list(points) or None

        return search


class _OnGrid(Peer):
    """Planner over the cells from whose centres every step to a neighbour keeps the radius."""

    def __init__(self, world: CollisionWorld, radius: float) -> None:
        super().__init__(world, radius)
        low_x, low_y, high_x, high_y = world.plan.boundary.bounds
        self._x = np.arange(low_x, high_x, CELL) + CELL / 2
        self._y = np.arange(low_y, high_y, CELL) + CELL / 2

    def look(self) -> None:
        """Draw the free space as cells."""
        # Half of a diagonal step is from a place at this distance no nearer than the radius.
        keep = math.hypot(self._radius, CELL * math.sqrt(0.5))
        x, y = np.meshgrid(self._x, self._y)
        free = np.zeros(x.shape, bool)
        for piece in self._world.free_space(keep).pieces:
            shapely.prepare(piece)
            free |= shapely.contains_xy(piece, x, y)
        self._free = free
        self._take(free)

    def between(self, start: Point, goal: Point) -> Sequence[Point] | None:
        """Return the centres of cells from `start` to `goal`, or None where they don't lead on."""
        a, b = self._cell(start), self._cell(goal)
        cells = None if a is None or b is None else self._search(a, b)
        if cells is None:
            return None
        return [(float(self._x[column]), float(self._y[row])) for row, column in cells]

    def _cell(self, at: Point) -> tuple[int, int] | None:
        """Return row and column of the free cell nearest to `at`, up to three cells away."""
        row = int((at[1] - self._y[0]) / CELL + 0.5)
        column = int((at[0] - self._x[0]) / CELL + 0.5)
        first_row, first_column = max(row - 3, 0), max(column - 3, 0)
        near = self._free[first_row : row + 4, first_column : column + 4]
        rows, columns = np.nonzero(near)
        if not len(rows):
            return None
        rows, columns = rows + first_row, columns + first_column
        nearest = int(np.argmin(np.hypot(self._x[columns] - at[0], self._y[rows] - at[1])))
        return int(rows[nearest]), int(columns[nearest])

    @abstractmethod
    def _take(self, free: NDArray[np.bool_]) -> None:
        """Make of the free cells what the search needs."""

    @abstractmethod
    def _search(self, start: tuple[int, int], goal: tuple[int, int]) -> Any:
        """Return rows and columns of the cells from `start` to `goal`, or None."""


class PyAStar2D(_OnGrid):
    """pyastar2d: A* in C++, for which a diagonal step is no longer than a straight one."""

    def _take(self, free: NDArray[np.bool_]) -> None:
        self._weights = np.where(free, 1.0, np.inf).astype(np.float32)

    def _search(self, start: tuple[int, int], goal: tuple[int, int]) -> Any:
        return import_module("pyastar2d").astar_path(
            self._weights, start, goal, allow_diagonal=True
        )


class ScikitImage(_OnGrid):
    """scikit-image's minimum cost paths: Dijkstra's search, with diagonal steps at their length."""

    def _take(self, free: NDArray[np.bool_]) -> None:
        self._costs = np.where(free, 1.0, -1.0)

    def _search(self, start: tuple[int, int], goal: tuple[int, int]) -> Any:
        graph = import_module("skimage.graph").MCP_Geometric(self._costs)
        costs, _ = graph.find_costs([start], [goal])
        return graph.traceback(goal) if np.isfinite(costs[goal]) else None


class RoadmapOfCorners(Peer):
    """OMPL's own roadmap planner, PRM, with the corner points as its samples.

    They are those of the default planner: the bends around all corners of the floor and of what
    stands on it. FCL alone judges the links, of every point with every other, so the search of PRM
    finds the shortest path along them. PRM has no directed links: it knows no one-way gates.
    """

    def __init__(self, world: CollisionWorld, radius: float) -> None:
        super().__init__(world, radius)
        self._keep = radius + SLACK
        self._corners: list[Point] = []
        self._number: dict[Point, int] = {}
        self._judged: NDArray[np.int8] = np.empty((0, 0), np.int8)
        low_x, low_y, high_x, high_y = world.plan.boundary.bounds
        self._floor = OmplFloor((low_x, low_y), (high_x, high_y), self._free)
        # OMPL must let go before Python does, at exit as well.
        self.release = weakref.finalize(self, self._floor.release)

    def look(self) -> None:
        """Let FCL judge the links between all corner points."""
        world = self._world
        roadmap = world.roadmap(self._radius, COARSE)
        around = [roadmap.around(body)[:2].T for body in world.bodies]
        places = np.concatenate([roadmap.bends.point, *around]).tolist()
        self._corners = [*dict.fromkeys((x, y) for x, y in places if self._free((x, y), (x, y)))]
        self._number = {place: k for k, place in enumerate(self._corners)}
        self._judged = np.full((len(self._corners),) * 2, -1, np.int8)
        self._grown(self._corners, ob.ProblemDefinition(self._floor.information))

    def between(self, start: Point, goal: Point) -> Sequence[Point] | None:
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


@dataclass(frozen=True)
class PeerInfo:
    """A peer that one can ask for by name."""

    name: str
    """That of its package."""
    summary: str
    kind: type[Peer]
    module: str

    @property
    def installed(self) -> bool:
        """True if its package is there."""
        return find_spec(self.module) is not None


PEERS = (
    PeerInfo("JuPedSim", "its routing engine, on the floor shrunk", JuPedSim, "jupedsim"),
    PeerInfo(
        "extremitypathfinder",
        f"on the floor shrunk, corners up to {1000 * COARSENED:g} mm off",
        Extremity,
        "extremitypathfinder",
    ),
    PeerInfo("pyastar2d", f"A* on cells of {100 * CELL:g} cm", PyAStar2D, "pyastar2d"),
    PeerInfo("scikit-image", f"Dijkstra on cells of {100 * CELL:g} cm", ScikitImage, "skimage"),
    PeerInfo(
        "PRM-of-corners",
        "OMPL's PRM, the corner points its samples, FCL its judge",
        RoadmapOfCorners,
        "ompl",
    ),
)
"""All peers, by the names that they are asked for."""


def peer_named(name: str) -> PeerInfo | None:
    """Return the peer called `name`, None if there is none; `ValueError` if it isn't installed."""
    for peer in PEERS:
        if peer.name == name:
            if not peer.installed:
                raise UserError(f"{name} is not installed: pip install {name.lower()}")
            return peer
    return None
