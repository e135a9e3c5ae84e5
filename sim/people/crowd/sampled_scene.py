"""Input of a sampled steering at one step: people as arrays, and the walls near them."""

from __future__ import annotations

from typing import Protocol

import numpy as np
import shapely
from numpy.typing import NDArray

from floorplan.files.dataclass import dataclass

Floats = NDArray[np.float64]
Indices = NDArray[np.intp]
Flags = NDArray[np.bool_]

TINY = 1e-9
"""Length below which a vector has no direction, m or m/s."""


@dataclass(frozen=True, kw_only=True)
class SampledScene:
    """All N bodies at one time, and the points of walls near those who are under way.

    Attributes
    ----------
    step : float
        Time until the next step, s.
    seed : int
        Seed of the trial.
    at, velocity : ndarray, shape (N, 2)
        Positions, m, and velocities of the last step, m/s.
    desired : ndarray, shape (N, 2)
        Velocities to the next waypoint on an empty floor, m/s. Zero without a goal.
    radius, max_speed : ndarray, shape (N,)
        Radius of the body, m, and maximum speed, m/s.
    steered : ndarray of bool, shape (N,)
        Whether the model chooses the velocity. The others stand, or move by other rules.
    wall_of : ndarray of int, shape (M,)
        Index of the body, in ascending order, for each nearest point of a wall.
    wall_at : ndarray, shape (M, 2)
        These points, m.
    """

    step: float
    seed: int
    at: Floats
    velocity: Floats
    desired: Floats
    radius: Floats
    max_speed: Floats
    steered: Flags
    wall_of: Indices
    wall_at: Floats


class SampledSteering(Protocol):
    """Interface of a custom steering that chooses all velocities of a step together."""

    def velocities(self, scene: SampledScene) -> Floats:
        """Return the velocity of each body until the next step, shape (N, 2), m/s.

        Only those of steered bodies are used.
        """
        ...


class WallSides:
    """Sides of the walls around free floor.

    Parameters
    ----------
    room : shapely.Geometry
        The free floor, m.
    """

    def __init__(self, room: shapely.Geometry) -> None:
        oriented = shapely.get_parts(shapely.orient_polygons(room))
        lines = [ring for part in oriented for ring in (part.exterior, *part.interiors)]
        rings = [shapely.get_coordinates(ring) for ring in lines]
        self._begin = np.concatenate([ring[:-1] for ring in rings])
        self._along = np.concatenate([np.diff(ring, axis=0) for ring in rings])
        self._square = (self._along**2).sum(axis=1)
        first = np.cumsum([0, *(len(ring) - 1 for ring in rings)])
        self._before = np.arange(first[-1]) - 1
        self._before[first[:-1]] = first[1:] - 1
        ahead, behind = self._along, self._along[self._before]
        # The room is on the left, so something solid sticks out where a ring turns right.
        self._sticks_out = behind[:, 0] * ahead[:, 1] - behind[:, 1] * ahead[:, 0] < 0.0

    def near(self, at: Floats, within: float) -> tuple[Indices, Floats]:
        """Return the points of walls at which the distance from a position is a local minimum.

        A straight wall has one such point, and so has a corner that sticks out.

        Parameters
        ----------
        at : ndarray, shape (N, 2)
            Positions, m.
        within : float
            Maximum distance, m.

        Returns
        -------
        ndarray of int, shape (M,)
            Index of the position, in ascending order.
        ndarray, shape (M, 2)
            Point of a wall, m.
        """
        from_begin = at[:, None, :] - self._begin
        x, y = from_begin[..., 0], from_begin[..., 1]
        along_x, along_y = self._along[:, 0], self._along[:, 1]
        share = (x * along_x + y * along_y) / self._square
        faces = along_x * y - along_y * x >= 0.0
        on_side = faces & (share > 0.0) & (share < 1.0)
        on_corner = self._sticks_out & (share <= 0.0) & (share[:, self._before] >= 1.0)
        share = np.where(on_corner, 0.0, share)
        points = self._begin + share[..., None] * self._along
        away = at[:, None, :] - points
        is_near = away[..., 0] ** 2 + away[..., 1] ** 2 <= within**2
        who, which = np.nonzero((on_side | on_corner) & is_near)
        return who, points[who, which]
