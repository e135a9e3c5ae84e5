"""Paths over a grid are as short as those of a search without estimates."""

import heapq
import itertools
import random

from navigation import block_discs, grid_path, numbers


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
