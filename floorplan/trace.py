"""Polygons around the cells of a grid."""

from __future__ import annotations

from typing import TypeAlias

import numpy as np
import shapely
from numpy.typing import NDArray

from .problems import UserError

MOST_CORNERS = 1_000_000
"""Most corners of all outlines together: the walls of a large hall have some 10,000."""

MOST_OUTLINES = 100_000
"""Most outlines: nothing could be planned among more obstacles."""

_INSET = 0.125
"""Cells. How far a ring keeps from a corner at which two of its cells touch diagonally."""

Ints = NDArray[np.int64]

Ring: TypeAlias = shapely.Geometry
"""A closed line."""


class IntricateError(UserError):
    """Cells with more outlines than can be handled."""


def trace(cells: NDArray[np.bool_], tolerance: float) -> shapely.Geometry:
    """The area of the cells that are set: (rows, columns), cell [r, c] covers x c…c+1, y r…r+1.

    Cells that touch only at a corner stay apart. Rings are simplified, but no point of them moves
    by more than `tolerance` cells. `IntricateError` if there are more than `MOST_OUTLINES`
    of them, or if they have more than `MOST_CORNERS` corners.
    """
    shells, holes = _rings(np.pad(cells, 1))
    if (count := len(shells) + len(holes)) > MOST_OUTLINES:
        raise IntricateError(f"{count:,} outlines, of at most {MOST_OUTLINES:,}")
    # Rings lie on the borders of cells and keep apart at diagonal corners, so what they make up is
    # valid by construction and is not checked.
    area = shapely.MultiPolygon(_polygons(shells, holes))
    return shapely.simplify(area, tolerance, preserve_topology=True)


def _polygons(shells: list[Ring], holes: list[Ring]) -> list[shapely.Geometry]:
    """Return each shell with the holes in it: a hole is in the smallest of the shells around it."""
    if not holes:
        return [shapely.polygons(shell) for shell in shells]
    filled = shapely.polygons(shells)
    tree = shapely.STRtree(shapely.get_point(holes, 0))
    around, inside = tree.query(filled, predicate="contains")
    # The smallest shell around a hole comes first, and `unique` keeps the first of each hole.
    inner_first = np.argsort(shapely.area(filled)[around], kind="stable")
    _, first = np.unique(inside[inner_first], return_index=True)
    owner = around[inner_first][first].tolist()
    held: list[list[Ring]] = [[] for _ in shells]
    for hole, shell in zip(holes, owner, strict=True):
        held[shell].append(hole)
    return [shapely.Polygon(shell, within) for shell, within in zip(shells, held, strict=True)]


def _rings(cells: NDArray[np.bool_]) -> tuple[list[Ring], list[Ring]]:
    """Return the closed outlines through their corners: those around cells, and those of holes.

    Along every row of corners an outline comes and goes in turn, so sorted corners pair up into
    its horizontal sides; along every column into its vertical ones. The sides then chain up.
    """
    row, column, second, point = _corners(cells)
    count = len(row)
    if not count:
        return [], []
    # Sorted by row, then column: every other corner begins a side, and the next one ends it.
    across = _pairs(count, np.lexsort((np.arange(count), column, row)))
    # At a diagonal corner the first of two copies ends the side on the left, the second begins
    # the one on the right.
    # The copy that goes round the cell above comes first along the column.
    lower = cells[row, column] == second
    along = _pairs(count, np.lexsort((lower, row, column)))
    shells: list[Ring] = []
    holes: list[Ring] = []
    # Below and right of its first corner, in the order of rows, is the inside of an outline.
    is_shell = cells[row + 1, column + 1].tolist()
    done = np.zeros(count, bool)
    across_list, along_list = across.tolist(), along.tolist()
    for first in range(count):
        if done[first]:
            continue
        chain = []
        here = first
        while True:
            there = across_list[here]
            chain += [here, there]
            here = along_list[there]
            if here == first:
                break
        done[chain] = True
        ring = shapely.linearrings(point[[*chain, first]])
        (shells if is_shell[first] else holes).append(ring)
    return shells, holes


def _corners(
    cells: NDArray[np.bool_],
) -> tuple[Ints, Ints, NDArray[np.bool_], NDArray[np.float64]]:
    """Return the corners of outlines: row and column, whether it is the second copy, and place.

    Corners where two cells touch diagonally come twice.
    """
    above_left, above_right = cells[:-1, :-1], cells[:-1, 1:]
    below_left, below_right = cells[1:, :-1], cells[1:, 1:]
    diagonal = (above_left == below_right) & (above_right == below_left)
    diagonal &= above_left != above_right
    # An outline turns where one or three of the four cells around a corner are set.
    odd = above_left ^ above_right ^ below_left ^ below_right
    odd |= diagonal
    if (count := np.count_nonzero(odd)) > MOST_CORNERS:
        raise IntricateError(f"outlines of {count:,} corners, of at most {MOST_CORNERS:,}")
    row, column = np.nonzero(odd)
    twice = diagonal[row, column]
    row, column = np.repeat(row, 1 + twice), np.repeat(column, 1 + twice)
    twice = np.repeat(twice, 1 + twice)
    second = np.zeros(len(row), bool)
    second[1:] = twice[1:] & (row[1:] == row[:-1]) & (column[1:] == column[:-1])
    # The copies part, each towards the set cell that it goes round.
    sideways = np.where(second, _INSET, -_INSET) * twice
    upright = np.where(above_left[row, column] == second, _INSET, -_INSET) * twice
    # Corner [r, c] lies between the cells r and r + 1 of the padded grid: at y = r unpadded.
    point = np.column_stack([column + sideways, row + upright]).astype(float)
    return row, column, second, point


def _pairs(count: int, order: NDArray[np.intp]) -> Ints:
    """Return the partner of each, where they pair up in this order."""
    partner = np.empty(count, np.int64)
    partner[order[0::2]], partner[order[1::2]] = order[1::2], order[0::2]
    return partner
