"""Optimal reciprocal collision avoidance (ORCA).

J. van den Berg, S. J. Guy, M. Lin and D. Manocha, "Reciprocal n-body collision avoidance", Robotics
Research, Springer Tracts in Advanced Robotics 70, 2011.

Each neighbour and each wall permits a half-plane of velocities. A linear program in two dimensions
finds the permitted velocity nearest to the desired one. If there is none, a linear program in three
dimensions finds the velocity that violates the half-planes of neighbours least.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

Vector = tuple[float, float]

TINY = 1e-9
"""Length below which a vector has no direction, m or m/s."""


@dataclass(frozen=True, kw_only=True)
class OrcaParameters:
    """Parameters of the method. The paper leaves them to the application."""

    horizon: float = 2.0
    """Time τ without collision with other people, s."""
    walls_horizon: float = 0.5
    """Time without collision with walls, s."""
    neighbours: int = 10
    """Maximum number of neighbours, nearest first."""


class HalfPlane(NamedTuple):
    """Permitted velocities v: those with (v - point) · normal ≥ 0. Units are m/s."""

    point: Vector
    normal: Vector

    def violation(self, v: Vector) -> float:
        """Return how far a velocity is outside, m/s. It is negative inside."""
        (x, y), (nx, ny) = self.point, self.normal
        return (x - v[0]) * nx + (y - v[1]) * ny


class Orca:
    """ORCA as a sampled steering.

    Parameters
    ----------
    parameters : OrcaParameters, optional
        Horizons and number of neighbours.
    """

    def __init__(self, parameters: OrcaParameters | None = None) -> None:
        self._parameters = OrcaParameters() if parameters is None else parameters

    def velocities(self, scene) -> np.ndarray:
        """Return the velocities of all people until the next step, shape (N, 2), m/s."""
        found = scene.velocity.copy()
        for k in np.flatnonzero(scene.steered).tolist():
            walls, people = self._of_walls(scene, k), self._of_people(scene, k)
            desired, fastest = _vector(scene.desired[k]), float(scene.max_speed[k])
            found[k] = nearest_permitted(walls, people, desired, fastest)
        return found

    def _of_people(self, scene, k: int) -> list[HalfPlane]:
        """Return the half-planes of the nearest neighbours of a person."""
        parameters, apart = self._parameters, scene.at - scene.at[k]
        square = (apart * apart).sum(axis=1)
        reach = 2 * float(scene.max_speed.max()) * parameters.horizon
        limit = (reach + scene.radius + scene.radius[k]) ** 2
        nearest = np.argsort(square, kind="stable")
        near = [j for j in nearest.tolist() if j != k and square[j] < limit[j]]
        mine = _vector(scene.velocity[k])
        planes = []
        for j in near[: parameters.neighbours]:
            theirs = _vector(scene.velocity[j])
            relative = (mine[0] - theirs[0], mine[1] - theirs[1])
            radius = float(scene.radius[k] + scene.radius[j])
            (ux, uy), normal = least_change(
                _vector(apart[j]), relative, radius, parameters.horizon, scene.step
            )
            # People who do not take half of the change leave all of it to this one.
            share = 0.5 if scene.steered[j] else 1.0
            planes.append(HalfPlane((mine[0] + share * ux, mine[1] + share * uy), normal))
        return planes

    def _of_walls(self, scene, k: int) -> list[HalfPlane]:
        """Return the half-planes that do not reach the nearest walls within their horizon."""
        first, last = np.searchsorted(scene.wall_of, [k, k + 1])
        planes = []
        for x, y in (scene.at[k] - scene.wall_at[first:last]).tolist():
            distance = math.sqrt(x * x + y * y)
            if distance < TINY:
                continue
            normal = (x / distance, y / distance)
            gap = distance - float(scene.radius[k])
            speed = gap / (self._parameters.walls_horizon if gap > 0.0 else scene.step)
            planes.append(HalfPlane((-speed * normal[0], -speed * normal[1]), normal))
        return planes


def least_change(
    apart: Vector, relative: Vector, radius: float, horizon: float, step: float
) -> tuple[Vector, Vector]:
    """Return the smallest change u of a relative velocity to the boundary of a velocity obstacle.

    The obstacle contains the relative velocities with which a point comes within `radius` of
    `apart` during the horizon: a cone, cut off by a disc. Bodies that overlap have to part within
    one step.

    Parameters
    ----------
    apart : (float, float)
        Position of the other body from this one, m.
    relative : (float, float)
        Velocity of this body minus that of the other, m/s.
    radius : float
        Sum of the radii, m.
    horizon, step : float
        Times, s.

    Returns
    -------
    (float, float)
        The change u, m/s.
    (float, float)
        Outward normal of the boundary there.
    """
    (px, py), (vx, vy) = apart, relative
    square = px * px + py * py
    overlaps = square <= radius * radius
    time = step if overlaps else horizon
    wx, wy = vx - px / time, vy - py / time
    along = wx * px + wy * py
    # The disc is nearest to velocities below the points where the cone touches it.
    if overlaps or (along < 0.0 and along * along > radius * radius * (wx * wx + wy * wy)):
        length = math.sqrt(wx * wx + wy * wy)
        normal = (wx / length, wy / length) if length > TINY else (0.0, -1.0)
        change = radius / time - length
        return (change * normal[0], change * normal[1]), normal
    # The leg on the side of the velocity. Two people head-on both take the right one.
    side = 1.0 if px * wy - py * wx > 0.0 else -1.0
    leg = math.sqrt(square - radius * radius)
    dx, dy = (px * leg - side * py * radius) / square, (py * leg + side * px * radius) / square
    normal = (-side * dy, side * dx)
    change = -(vx * normal[0] + vy * normal[1])
    return (change * normal[0], change * normal[1]), normal


def nearest_permitted(
    walls: Sequence[HalfPlane], people: Sequence[HalfPlane], desired: Vector, fastest: float
) -> Vector:
    """Return the permitted velocity nearest to the desired one, or the least bad.

    Parameters
    ----------
    walls : sequence of HalfPlane
        Half-planes that always hold.
    people : sequence of HalfPlane
        Half-planes that all give way by the same speed if they have no velocity in common.
    desired : (float, float)
        Desired velocity, m/s.
    fastest : float
        Maximum speed, m/s.

    Returns
    -------
    (float, float)
        Velocity, m/s.
    """
    planes = [*walls, *people]
    found, failed = _program_2d(planes, desired, fastest)
    if failed == len(planes):
        return found
    if failed < len(walls):  # only a body that touches several walls
        return (0.0, 0.0)
    return _program_3d(walls, people, found, failed - len(walls), fastest)


def _program_2d(
    planes: Sequence[HalfPlane], desired: Vector, fastest: float, *, far: bool = False
) -> tuple[Vector, int]:
    """Return the permitted velocity nearest to `desired`, and the index of the plane that fails.

    The index is the number of planes if none fails. `far` finds the velocity that is farthest in
    the direction of `desired`, a unit vector.
    """
    dx, dy = desired
    speed = math.sqrt(dx * dx + dy * dy)
    scale = fastest if far else min(1.0, fastest / speed) if speed > 0.0 else 1.0
    best = (scale * dx, scale * dy)
    for k, plane in enumerate(planes):
        if plane.violation(best) > 0.0:
            on_line = _program_1d(planes[:k], plane, desired, fastest, far)
            if on_line is None:
                return best, k
            best = on_line
    return best, len(planes)


def _program_1d(
    planes: Sequence[HalfPlane], line: HalfPlane, desired: Vector, fastest: float, far: bool
) -> Vector | None:
    """Return the best permitted velocity on the boundary of a half-plane, or None."""
    (x, y), (nx, ny) = line
    dx, dy = ny, -nx
    middle = -(x * dx + y * dy)
    from_origin = x * nx + y * ny
    rest = fastest * fastest - from_origin * from_origin
    if rest < 0.0:
        return None
    low, high = middle - math.sqrt(rest), middle + math.sqrt(rest)
    for plane in planes:
        turns = dx * plane.normal[0] + dy * plane.normal[1]
        outside = plane.violation((x, y))
        if abs(turns) <= TINY:
            if outside > 0.0:
                return None
        elif turns > 0.0:
            low = max(low, outside / turns)
        else:
            high = min(high, outside / turns)
        if low > high:
            return None
    if far:
        t = high if desired[0] * dx + desired[1] * dy > 0.0 else low
    else:
        t = min(max((desired[0] - x) * dx + (desired[1] - y) * dy, low), high)
    return (x + t * dx, y + t * dy)


def _program_3d(
    walls: Sequence[HalfPlane],
    people: Sequence[HalfPlane],
    best: Vector,
    first: int,
    fastest: float,
) -> Vector:
    """Return the velocity that violates the half-planes of people least, within all walls.

    The third dimension is the violation, which is the same for all half-planes that bound it.
    """
    violation = 0.0
    for k in range(first, len(people)):
        plane = people[k]
        if plane.violation(best) <= violation:
            continue
        alike = [_violated_alike(plane, other) for other in people[:k]]
        planes = [*walls, *(one for one in alike if one is not None)]
        found, failed = _program_2d(planes, plane.normal, fastest, far=True)
        if failed == len(planes):  # otherwise by rounding only
            best = found
        violation = plane.violation(best)
    return best


def _violated_alike(one: HalfPlane, other: HalfPlane) -> HalfPlane | None:
    """Return the velocities that violate `other` at most as much as `one`, or None if all do."""
    (ox, oy), (px, py) = one.normal, other.normal
    nx, ny = px - ox, py - oy
    length = math.sqrt(nx * nx + ny * ny)
    if length <= TINY:
        return None
    nx, ny = nx / length, ny / length
    # The boundary: point · normal of each, subtracted.
    offset = (other.point[0] * px + other.point[1] * py) - (one.point[0] * ox + one.point[1] * oy)
    offset /= length
    return HalfPlane((offset * nx, offset * ny), (nx, ny))


def _vector(values: np.ndarray) -> Vector:
    return float(values[0]), float(values[1])
