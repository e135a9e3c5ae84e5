"""Edges of a floor: whether a disc that is swept along a segment touches one."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import cython
else:
    from . import uncompiled as cython

if not cython.compiled:
    from math import ceil, floor, sqrt
else:
    from cython.cimports.libc.math import ceil, floor, sqrt

ROWS = 1 << 20
"""Keys of cells from one column to the next: column · ROWS + row, as seen from the origin."""

_ROWS: float = 1048576.0


def clear(
    cells: dict[int, list[float]],
    width: float,
    ax: float,
    ay: float,
    bx: float,
    by: float,
    radius: float,
    missing: list[int],
) -> bool:
    """Return whether a disc of `radius` metres touches no edge from (ax, ay) to (bx, by).

    `cells` holds by their keys the edges that count in cells of `width` metres, for places that are
    as far apart at most; a single number where it is off the floor. The key of one that is
    not there goes to `missing`, and the answer has to wait for it.
    """
    dx: float = bx - ax
    dy: float = by - ay
    steps: float = ceil(sqrt(dx * dx + dy * dy) / width)
    if steps < 1.0:
        steps = 1.0
    last: float = 0.5
    step: float = 0.0
    while step <= steps:
        share: float = step / steps
        column: float = floor((ax + share * dx) / width)
        key: float = column * _ROWS + floor((ay + share * dy) / width)
        step += 1.0
        if key == last:
            continue
        last = key
        edges: list[float] | None = cells.get(int(key))
        if edges is None:
            missing.append(int(key))
            return False
        if len(edges) == 1 or (len(edges) > 0 and touches(edges, ax, ay, bx, by, radius)):
            return False
    return True


def touches(edges: list[float], ax: float, ay: float, bx: float, by: float, radius: float) -> bool:
    """Return whether an edge is nearer than `radius` (metres) to a segment.

    It goes from (`ax`, `ay`) to (`bx`, `by`); `edges` holds x and y of both ends of each in turn.
    """
    dx: float = bx - ax
    dy: float = by - ay
    length: float = sqrt(dx * dx + dy * dy)
    c: float = 0.0
    s: float = 0.0
    if length > 0.0:
        c = dx / length
        s = dy / length
    least: float = radius * radius
    k: cython.Py_ssize_t
    for k in range(0, len(edges), 4):
        # Along and across the segment, from a:
        px: float = edges[k] - ax
        py: float = edges[k + 1] - ay
        qx: float = edges[k + 2] - ax
        qy: float = edges[k + 3] - ay
        p: float = px * c + py * s
        q: float = qx * c + qy * s
        if (p <= -radius and q <= -radius) or (p >= length + radius and q >= length + radius):
            continue
        h: float = py * c - px * s
        i: float = qy * c - qx * s
        if length > 0.0 and ((h >= radius and i >= radius) or (h <= -radius and i <= -radius)):
            continue
        # The nearest two points are an end of one of them and a point of the other, but where the
        # two cross.
        if h * i < 0.0:
            crossing: float = p + (q - p) * h / (h - i)
            if 0.0 <= crossing <= length:
                return True
        if (
            _square(px, py, dx, dy, length) < least
            or _square(qx, qy, dx, dy, length) < least
            or _square_to(px, py, qx, qy, 0.0, 0.0) < least
            or _square_to(px, py, qx, qy, dx, dy) < least
        ):
            return True
    return False


def _square(px: float, py: float, dx: float, dy: float, length: float) -> float:
    """Return the square of the distance of p from the segment from 0 to d of this `length`."""
    u: float = 0.0
    if length > 0.0:
        u = min(max((px * dx + py * dy) / (length * length), 0.0), 1.0)
    x: float = px - u * dx
    y: float = py - u * dy
    return x * x + y * y


def _square_to(px: float, py: float, qx: float, qy: float, x: float, y: float) -> float:
    """Return the square of the distance of a point from the edge from p to q."""
    dx: float = qx - px
    dy: float = qy - py
    square: float = dx * dx + dy * dy
    u: float = 0.0
    if square > 0.0:
        u = min(max(((x - px) * dx + (y - py) * dy) / square, 0.0), 1.0)
    x -= px + u * dx
    y -= py + u * dy
    return x * x + y * y
