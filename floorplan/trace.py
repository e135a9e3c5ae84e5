"""From a grid of cells to the polygons they make up."""

from __future__ import annotations

import numpy as np
import shapely
from numpy.typing import NDArray

_INSET = 0.125
"""Cells. How far a ring keeps from a corner at which two of its cells touch diagonally."""

Ints = NDArray[np.int64]


def trace(cells: NDArray[np.bool_], tolerance: float) -> shapely.Geometry:
    """The area of the cells that are set: (rows, columns), cell [r, c] covers x c…c+1, y r…r+1.

    Cells that touch only at a corner stay apart. Rings are simplified, but no point of them moves
    by more than `tolerance` cells.
    """
    rings = _rings(np.pad(cells, 1))
    area = shapely.build_area(shapely.geometrycollections(rings)) if rings else shapely.Polygon()
    return shapely.simplify(area, tolerance, preserve_topology=True)


def _rings(cells: NDArray[np.bool_]) -> list[shapely.Geometry]:
    """The closed outlines, through the corners where they turn.

    Along every row of corners an outline comes and goes in turn, so sorted corners pair up into
    its horizontal sides; along every column into its vertical ones. The sides then chain up.
    """
    row, column, second, point = _corners(cells)
    count = len(row)
    if not count:
        return []
    across = _pairs(count, np.lexsort((np.arange(count), column, row)))
    # At a diagonal corner the first of two copies ends the side on the left, the second begins
    # the one on the right.
    # The copy that goes round the cell above comes first along the column.
    lower = cells[row, column] == second
    along = _pairs(count, np.lexsort((lower, row, column)))
    rings = []
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
        rings.append(shapely.linearrings(point[[*chain, first]]))
    return rings


def _corners(
    cells: NDArray[np.bool_],
) -> tuple[Ints, Ints, NDArray[np.bool_], NDArray[np.float64]]:
    """Where outlines turn: the row and column, whether it is the second copy, and the place.

    Corners where two cells touch diagonally come twice.
    """
    above_left, above_right = cells[:-1, :-1], cells[:-1, 1:]
    below_left, below_right = cells[1:, :-1], cells[1:, 1:]
    diagonal = (above_left == below_right) & (above_right == below_left)
    diagonal &= above_left != above_right
    odd = above_left ^ above_right ^ below_left ^ below_right
    row, column = np.nonzero(odd | diagonal)
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
    """The partner of each, where they pair up in this order."""
    partner = np.empty(count, np.int64)
    partner[order[0::2]], partner[order[1::2]] = order[1::2], order[0::2]
    return partner
