"""Measures of paths: OMPL's own, and turning."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from floorplan import Point

Floats = NDArray[np.float64]


def turning(points: Floats) -> float:
    """Return the radians that the polyline `points`, shape (N, 2), turns by in all."""
    heading = np.unwrap(np.arctan2(*np.diff(points, axis=0).T[::-1]))
    return float(np.abs(np.diff(heading)).sum())


def ompl_smoothness(points: Floats) -> float:
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


def ompl_clearance(points: Floats, distance: Callable[[Point], float], radius: float) -> float:
    """Return `PathGeometric::clearance()` of the polyline `points`, shape (N, 2), in metres.

    That is the mean over the waypoints of the distance to the nearest place that is not valid:
    for a disc of `radius` metres its centre's `distance` to the nearest thing, less the radius.
    """
    return float(np.mean([distance((x, y)) for x, y in points.tolist()])) - radius
