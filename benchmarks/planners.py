"""Floorwalker's default planner beside what else people plan with, on the same questions.

    python benchmarks/planners.py [--queries 200] [--radius 0.3] [FLOORPLAN ...]

Peers are asked where they are installed: JuPedSim's RoutingEngine and extremitypathfinder on the
floor shrunk by the radius, and an A* search over a grid of 5 cm. Times are of the CPU, after a
planner has looked at the fixed floor; "scene" is what it needs whenever AGVs have moved.
"""

from __future__ import annotations

import argparse
import heapq
import itertools
import math
import time
from collections.abc import Callable, Iterator

import numpy as np
import shapely

import floorplan
from navigation import CollisionWorld, PathPlanner, PlanningError
from navigation.benchmark import Scene, scenes

CELL = 0.05
"""Metres."""

Way = list[tuple[float, float]]
Ask = Callable[[tuple[float, float], tuple[float, float]], Way | None]


class Ours:
    """A planner of Floorwalker's, by name."""

    def __init__(self, world: CollisionWorld, radius: float, planner: str = "Roadmap") -> None:
        self._planner = PathPlanner(world, radius)
        self._planner.prepare()
        self._name = planner

    def scene(self) -> Ask:
        """Nothing to do: the world is read when a path is asked for."""

        def ask(start: tuple[float, float], goal: tuple[float, float]) -> Way | None:
            try:
                return self._planner.plan(start, goal, planner=self._name).points.tolist()
            except PlanningError:
                return None

        return ask


class JuPedSim:
    """RoutingEngine on the piece of the shrunk floor that the start is in."""

    def __init__(self, world: CollisionWorld, radius: float) -> None:
        import jupedsim

        self._engine = jupedsim.RoutingEngine
        self._world, self._radius = world, radius

    def scene(self) -> Ask:
        pieces = [(p, self._engine(p)) for p in self._world.free_space(self._radius).pieces]

        def ask(start: tuple[float, float], goal: tuple[float, float]) -> Way | None:
            for piece, engine in pieces:
                if shapely.contains_xy(piece, *start):
                    return list(engine.compute_waypoints(start, goal))
            return None

        return ask


class Extremity:
    """extremitypathfinder on the same pieces, arcs drawn with corners 2 mm off at most.

    It takes minutes to look at finer ones.
    """

    def __init__(self, world: CollisionWorld, radius: float) -> None:
        import extremitypathfinder

        self._kind = extremitypathfinder.PolygonEnvironment
        self._world, self._radius = world, radius

    def scene(self) -> Ask:
        pieces = []
        for piece in self._world.free_space(self._radius).pieces:
            rings = shapely.orient_polygons(piece.simplify(0.002))
            environment = self._kind()
            environment.store(
                np.array(rings.exterior.coords)[:-1],
                [np.array(hole.coords)[:-1] for hole in rings.interiors],
                validate=False,
            )
            environment.prepare()
            pieces.append((piece, environment))

        def ask(start: tuple[float, float], goal: tuple[float, float]) -> Way | None:
            for piece, environment in pieces:
                if shapely.contains_xy(piece, *start):
                    way, _ = environment.find_shortest_path(start, goal, verify=False)
                    return list(way) or None
            return None

        return ask


class Grid:
    """A* over the cells whose centres are free, with steps to all eight neighbours."""

    def __init__(self, world: CollisionWorld, radius: float) -> None:
        self._world, self._radius = world, radius
        low_x, low_y, high_x, high_y = world.plan.boundary.bounds
        self._low = (low_x, low_y)
        self._x = np.arange(low_x, high_x, CELL) + CELL / 2
        self._y = np.arange(low_y, high_y, CELL) + CELL / 2

    def scene(self) -> Ask:
        x, y = np.meshgrid(self._x, self._y)
        free = np.zeros(x.shape, bool)
        for piece in self._world.free_space(self._radius).pieces:
            shapely.prepare(piece)
            free |= shapely.contains_xy(piece, x, y)
        rows, columns = free.shape
        cells = np.pad(free, 1).ravel().tolist()
        wide = columns + 2
        steps = [(1, 1.0), (-1, 1.0), (wide, 1.0), (-wide, 1.0)]
        steps += [(a + b, math.sqrt(2)) for a in (1, -1) for b in (wide, -wide)]

        def cell(at: tuple[float, float]) -> int:
            column = min(max(int((at[0] - self._low[0]) / CELL), 0), columns - 1)
            row = min(max(int((at[1] - self._low[1]) / CELL), 0), rows - 1)
            return (row + 1) * wide + column + 1

        def ask(start: tuple[float, float], goal: tuple[float, float]) -> Way | None:
            way = _a_star(cells, wide, steps, cell(start), cell(goal))
            if way is None:
                return None
            places = [(self._x[k % wide - 1], self._y[k // wide - 1]) for k in way[1:-1]]
            return [start, *places, goal]

        return ask


def _a_star(
    cells: list[bool], wide: int, steps: list[tuple[int, float]], start: int, goal: int
) -> list[int] | None:
    goal_row, goal_column = divmod(goal, wide)
    best = {start: 0.0}
    before: dict[int, int] = {}
    queue = [(0.0, start)]
    done = set()
    while queue:
        _, here = heapq.heappop(queue)
        if here == goal:
            way = [here]
            while way[-1] != start:
                way.append(before[way[-1]])
            return way[::-1]
        if here in done:
            continue
        done.add(here)
        for step, length in steps:
            there = here + step
            if not (cells[there] or there == goal):
                continue
            then = best[here] + length
            if then < best.get(there, math.inf):
                best[there], before[there] = then, here
                row, column = divmod(there, wide)
                up, across = abs(row - goal_row), abs(column - goal_column)
                left = max(up, across) + (math.sqrt(2) - 1) * min(up, across)
                heapq.heappush(queue, (then + left, there))
    return None


def peers(world: CollisionWorld, radius: float) -> Iterator[tuple[str, object]]:
    """Every planner that is installed, with its name, ready for the fixed floor."""
    yield "Floorwalker Roadmap", Ours(world, radius)
    for name in ("RRTConnect", "BITstar"):
        yield f"OMPL {name}, simplified", Ours(world, radius, name)
    for name, kind in (("JuPedSim RoutingEngine", JuPedSim), ("extremitypathfinder", Extremity)):
        try:
            yield name, kind(world, radius)
        except ImportError:
            print(f"({name} is not installed)")
    yield "grid A*, 5 cm", Grid(world, radius)


def measure(name: str, peer: object, asked: list[Scene], world: CollisionWorld) -> str:
    """A line of the table."""
    times, preparing, ratios, gaps = [], [], [], []
    count = 0
    for scene in asked:
        for agv, at in scene.agvs:
            world.move_agv(agv, at)
        begin = time.process_time()
        ask = peer.scene()  # type: ignore[attr-defined]
        preparing.append(time.process_time() - begin)
        for (start, goal), shortest in zip(scene.questions, scene.shortest, strict=True):
            count += 1
            begin = time.process_time()
            try:
                way = ask(start, goal)
            except Exception:  # a peer's own failure, whatever it is, counts as no answer
                way = None
            times.append(time.process_time() - begin)
            if way is not None:
                ratios.append(sum(math.dist(a, b) for a, b in itertools.pairwise(way)) / shortest)
                gaps.append(world.clearance(way))
    ms = 1000 * np.array(times)
    return (
        f"| {name} | {len(ratios) / count:.1%} | {1000 * np.median(preparing):.1f} |"
        f" {np.median(ms):.2f} | {np.percentile(ms, 99):.2f} |"
        f" {np.median(ratios):.4f} | {max(ratios):.4f} | {min(gaps):.4f} |"
    )


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("floorplans", nargs="*", default=list(floorplan.builtin()))
    parser.add_argument("--queries", type=int, default=200)
    parser.add_argument("--radius", type=float, default=None)
    options = parser.parse_args()
    for source in options.floorplans:
        plan = floorplan.load(source)
        radius = options.radius or plan.human.radius
        begin = time.process_time()
        world = CollisionWorld(plan)
        PathPlanner(world, radius).prepare()
        built = time.process_time() - begin
        asked = list(scenes(plan, queries=options.queries, seed=0, radius=radius))
        print(f"\n### {plan.name}, radius {radius:g} m, {options.queries} queries\n")
        print(f"World and roadmap are built in {built:.3f} s.\n")
        print(
            "| planner | solved | scene, ms | median, ms | 99 %, ms | length ÷ shortest, median"
            " | at most | least clearance, m |"
        )
        print("|---|---|---|---|---|---|---|---|")
        for name, peer in peers(world, radius):
            print(measure(name, peer, asked, world), flush=True)


if __name__ == "__main__":
    main()
