"""Paths over a grid are as short as those of a search without estimates."""

import heapq
import itertools
import math
import random

import numpy as np
import shapely
from hypothesis import assume, given, strategies as st

from navigation.freespace import Walls
from navigation.kernels.edges import Legs
from navigation.kernels.grid import block_discs, grid_path
from navigation.kernels.numbers import numbers
from navigation.kernels.ways_round import CHUNK, WaysRound

HALL = shapely.box(-40.0, -40.0, 40.0, 40.0)
CELL, RADIUS = 0.3, 0.2
METRES = st.floats(-25.0, 25.0)


def least_cost(blocked: bytearray, columns: int, start: int, goal: int) -> int | None:
    """The cost of a shortest path, by Dijkstra's algorithm."""
    known = {start: 0}
    queue = [(0, start)]
    while queue:
        cost, cell = heapq.heappop(queue)
        if cell == goal:
            return cost
        for dx, dy in ((1, 0), (-1, 0), (0, 1), (0, -1), (1, 1), (1, -1), (-1, 1), (-1, -1)):
            beside = (cell + dx, cell + dy * columns, cell + dx + dy * columns)
            dearer = cost + (7 if dx and dy else 5)
            if not any(blocked[one] for one in beside) and dearer < known.get(beside[2], 10**9):
                known[beside[2]] = dearer
                heapq.heappush(queue, (dearer, beside[2]))
    return None


def test_paths_are_shortest_and_avoid_what_is_blocked():
    rng = random.Random(5)
    found = 0
    for _ in range(200):
        columns, rows = rng.randint(4, 24), rng.randint(4, 24)
        blocked = bytearray(b"\1" * (columns * rows))
        for row in range(1, rows - 1):
            for column in range(1, columns - 1):
                blocked[row * columns + column] = rng.random() < 0.3
        start, goal = (
            rng.randrange(1, rows - 1) * columns + rng.randrange(1, columns - 1) for _ in range(2)
        )
        blocked[start] = blocked[goal] = 0
        path = grid_path(blocked, columns, start, goal)
        least = least_cost(blocked, columns, start, goal)
        if least is None:
            assert path == []
            continue
        found += 1
        assert path[0] == start and path[-1] == goal
        cost = 0
        for a, b in itertools.pairwise(path):
            dx, dy = b % columns - a % columns, b // columns - a // columns
            assert max(abs(dx), abs(dy)) == 1
            assert not any(blocked[one] for one in (a + dx, a + dy * columns, b))
            cost += 7 if dx and dy else 5
        assert cost == least
    assert found > 50


def test_discs_block_the_cells_whose_middle_they_cover():
    columns, rows, width, low = 12, 9, 0.3, (-1.0, 2.0)
    blocked = bytearray(columns * rows)
    discs = numbers([0.2, 3.1, 0.62, -0.9, 2.1, 0.3])
    block_discs(blocked, columns, *low, width, discs, 0.0)
    for k, taken in enumerate(blocked):
        x = low[0] + (k % columns + 0.5) * width
        y = low[1] + (k // columns + 0.5) * width
        near = [(x - discs[i]) ** 2 + (y - discs[i + 1]) ** 2 < discs[i + 2] ** 2 for i in (0, 3)]
        assert bool(taken) == any(near)


def ways_round() -> tuple[WaysRound, Legs]:
    """Return ways in the hall for somebody of `RADIUS`."""
    room = HALL.buffer(-RADIUS)

    def chunk(i: int, j: int) -> bytes:
        along = (np.arange(CHUNK) + 0.5) * CELL
        x, y = np.meshgrid(i * CHUNK * CELL + along, j * CHUNK * CELL + along)
        return (~shapely.intersects_xy(room, x, y)).tobytes()

    legs = Legs(Walls(HALL, RADIUS).grid, RADIUS, lambda a, b: True)
    return WaysRound(CELL, 6.0, 40_000, chunk), legs


@given(st.lists(st.tuples(METRES, METRES), max_size=20), st.tuples(METRES, METRES))
def test_ways_round_keep_off_all_discs(discs, end):
    ways, legs = ways_round()
    begin, away = (-30.0, -30.0), 0.7
    standing = numbers(number for x, y in discs for number in (x, y, away))
    corners = ways.path(*begin, *end, standing, legs)
    if all(math.dist(end, disc) > 2 * away for disc in discs) and len(discs) < 2:
        assert corners
    assume(corners)
    path = [*zip(corners[::2], corners[1::2], strict=True)]
    assert path[0] == begin and path[-1] == end
    line = shapely.LineString(path)
    assert HALL.buffer(-RADIUS).covers(line)
    assert all(line.distance(shapely.Point(disc)) > away - 1e-9 for disc in discs)


def test_ways_round_are_as_good_on_every_side_of_the_origin():
    ways, legs = ways_round()
    lengths = set()
    for x, y in ((1, 1), (-1, 1), (1, -1), (-1, -1)):
        a, b, disc = (20.25 * x, 20.25 * y), (30.15 * x, 20.25 * y), (25.05 * x, 20.25 * y, 0.7)
        corners = ways.path(*a, *b, numbers(disc), legs)
        path = [*zip(corners[::2], corners[1::2], strict=True)]
        lengths.add(round(sum(itertools.starmap(math.dist, itertools.pairwise(path))), 9))
    assert len(lengths) == 1 and 9.9 < lengths.pop() < 10.5
