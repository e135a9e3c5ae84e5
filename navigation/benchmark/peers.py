"""Planners of other packages that the benchmark compares.

Only OMPL's own roadmap planner has a radius. Planners among polygons get the floor shrunk by the
radius, planners on a grid the cells whose steps keep it. Such floors lack the last millimetres
beside walls. Starts and goals there are linked to the nearest position that the floor contains.
"""

from __future__ import annotations

import math
import weakref
from collections.abc import Callable, Iterator, Sequence
from functools import partial
from importlib import import_module
from importlib.util import find_spec
from typing import Any

import numpy as np
import ompl.base as ob
import ompl.geometric as og
import ompl.util as ou
import shapely
from numpy.typing import NDArray

from floorplan import Point
from floorplan.files.dataclass import dataclass

from ..planner import COARSE
from ..roadmap import HAIR
from ..roadmap_planner import SLACK
from ..sampling import OmplFloor, no_log, points_of, state_at
from ..world import CollisionWorld

Search = Callable[[Point, Point], Sequence[Point] | None]
"""Function from start and goal to the waypoints between, or None without a path."""


@dataclass(frozen=True)
class Peer:
    """Planner of another package."""

    module: str
    prepare: Callable[[CollisionWorld, float], Search]
    """Function from a world as it is now and the radius of a disc to the search there."""

    @property
    def installed(self) -> bool:
        """True if its package is installed."""
        return find_spec(self.module) is not None


def _among_polygons(
    search_of: Callable[[shapely.Polygon], Search],
    simplify: Callable[[shapely.Polygon], shapely.Polygon] | None,
    world: CollisionWorld,
    radius: float,
) -> Search:
    """Return a search of the piece of the free space that contains both start and goal."""
    pieces = world.free_space(radius).pieces
    if simplify is not None:
        pieces = [simplify(piece) for piece in pieces]
    shapely.prepare(pieces)
    searches = [search_of(piece) for piece in pieces]

    def inside(place: Point) -> tuple[int, Point]:
        """Return the index of the piece at `place`, and the nearest position in it."""
        containing = np.flatnonzero(shapely.intersects_xy(pieces, *place))
        if len(containing):
            return int(containing[0]), place
        at = shapely.Point(place)
        nearest = int(np.argmin(shapely.distance(pieces, at)))
        x, y = shapely.shortest_line(pieces[nearest], at).coords[0]
        return nearest, (x, y)

    def between(start: Point, goal: Point) -> Sequence[Point] | None:
        (one, a), (other, b) = inside(start), inside(goal)
        return searches[one](a, b) if one == other else None

    return between


def _jupedsim(piece: shapely.Polygon) -> Search:
    """Search by A* over a triangulation, and the funnel through it."""
    engine = import_module("jupedsim").RoutingEngine(piece)
    return lambda start, goal: list(engine.compute_waypoints(start, goal))


COARSENED = 0.002
"""Metres. Error of extremitypathfinder's corners, because finer ones take minutes to prepare."""


def _coarsened(piece: shapely.Polygon) -> shapely.Polygon:
    return shapely.orient_polygons(piece.simplify(COARSENED))


def _extremity(piece: shapely.Polygon) -> Search:
    """Search by A* over the visibility graph of the corners."""
    environment = import_module("extremitypathfinder").PolygonEnvironment()
    rings = [shapely.get_coordinates(ring)[:-1] for ring in (piece.exterior, *piece.interiors)]
    environment.store(rings[0], rings[1:], validate=False)
    return lambda start, goal: (
        list(environment.find_shortest_path(start, goal, verify=False)[0]) or None
    )


CELL = 0.05
"""Metres. Side of the cells of grid planners."""

Cell = tuple[int, int]
"""Row and column."""

CellSearch = Callable[[Cell, Cell], Any]
"""Function from start and goal to the cells between, or None without a path."""


def _on_grid(
    search_of: Callable[[NDArray[np.bool_]], CellSearch], world: CollisionWorld, radius: float
) -> Search:
    """Return a search over the cells from whose centres every step to a neighbour is free."""
    low_x, low_y, high_x, high_y = world.plan.boundary.bounds
    xs = np.arange(low_x, high_x, CELL) + CELL / 2
    ys = np.arange(low_y, high_y, CELL) + CELL / 2
    # At this distance, the middle of a diagonal step is still a radius away.
    keep = math.hypot(radius, CELL * math.sqrt(0.5))
    free = np.zeros((len(ys), len(xs)), bool)
    for piece in world.free_space(keep).pieces:
        shapely.prepare(piece)
        free |= shapely.contains_xy(piece, *np.meshgrid(xs, ys))
    search = search_of(free)

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


def _pyastar2d(free: NDArray[np.bool_]) -> CellSearch:
    """Search by A* in C++, for which diagonal steps cost as much as straight ones."""
    search = import_module("pyastar2d").astar_path
    weights = np.where(free, 1.0, np.inf).astype(np.float32)
    return lambda start, goal: search(weights, start, goal, allow_diagonal=True)


def _scikit_image(free: NDArray[np.bool_]) -> CellSearch:
    """Search by Dijkstra's algorithm, with diagonal steps at their length."""
    geometric = import_module("skimage.graph").MCP_Geometric
    weights = np.where(free, 1.0, -1.0)

    def search(start: Cell, goal: Cell) -> Any:
        graph = geometric(weights)
        costs, _ = graph.find_costs([start], [goal])
        return graph.traceback(goal) if np.isfinite(costs[goal]) else None

    return search


class RoadmapOfCorners:
    """OMPL's own roadmap planner, PRM, with the corner points of the default planner as samples.

    Corner points are the turns around all corners of the floor and of the bodies on it. FCL checks
    the segments between all pairs of points, so PRM's search finds the shortest path along them.
    PRM has no directed edges, so it ignores one-way gates.
    """

    def __init__(self, world: CollisionWorld, radius: float) -> None:
        self._world, self._radius, self._keep = world, radius, radius + SLACK
        self._number: dict[Point, int] = {}
        low_x, low_y, high_x, high_y = world.plan.boundary.bounds
        self._floor = OmplFloor((low_x, low_y), (high_x, high_y), self._free)
        # OMPL's objects must be released before Python's, at exit as well.
        self.release = weakref.finalize(self, self._floor.release)
        roadmap = world.roadmap(radius, COARSE)
        around = [roadmap.around(body)[:2].T for body in world.bodies]
        places = np.concatenate([roadmap.bends.point, *around]).tolist()
        self._corners = [*dict.fromkeys((x, y) for x, y in places if self._free((x, y), (x, y)))]
        self._number = {place: k for k, place in enumerate(self._corners)}
        self._judged = np.full((len(self._corners),) * 2, -1, np.int8)
        self._grown(self._corners, ob.ProblemDefinition(self._floor.information))

    def __call__(self, start: Point, goal: Point) -> Sequence[Point] | None:
        """Return the path from `start` to `goal`, or None if the corner points do not link them."""
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
            # PRM adds start and goal. If its thread gets no time for 0.4 s, it also adds random
            # samples. The samples depend on the machine, so repeat the search.
            if planner.milestoneCount() == len(samples) + 2:
                return points_of(problem.getSolutionPath(), leave, arrive)

    def _free(self, a: Point, b: Point) -> bool:
        """Return whether the segment is free by FCL. Results between corner points are cached."""
        i, j = self._number.get(a), self._number.get(b)
        if i is None or j is None:
            return self._world.segment_free(a, b, self._keep)
        if self._judged[i, j] < 0:
            self._judged[i, j] = self._judged[j, i] = self._world.segment_free(a, b, self._keep)
        return bool(self._judged[i, j])

    def _footing(self, place: Point) -> Point | None:
        """Return `place`, or the nearest position with room for the disc."""
        if self._world.free(place, self._keep):
            return place
        return self._world.nearest_free(place, self._radius + HAIR)

    def _grown(self, samples: list[Point], problem: Any) -> Any:
        """Return OMPL's planner with a roadmap of these samples, all linked with each other."""
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
        """Return whether edges of the roadmap lead from `start` to `goal`."""
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
    """Sampler that gives OMPL the remaining samples, one by one."""

    def __init__(self, information: Any, left: Iterator[Point]) -> None:
        super().__init__(information)
        self._left = left

    def sample(self, state: Any) -> bool:
        """Put the next sample into `state`. Return False if none is left."""
        place = next(self._left, None)
        if place is not None:
            state[0], state[1] = place
        return place is not None


PEERS = {
    "JuPedSim": Peer("jupedsim", partial(_among_polygons, _jupedsim, None)),
    "extremitypathfinder": Peer(
        "extremitypathfinder", partial(_among_polygons, _extremity, _coarsened)
    ),
    "pyastar2d": Peer("pyastar2d", partial(_on_grid, _pyastar2d)),
    "scikit-image": Peer("skimage", partial(_on_grid, _scikit_image)),
    "PRM-of-corners": Peer("ompl", RoadmapOfCorners),
}
"""Peers by name, which is also the name of the package to install."""
