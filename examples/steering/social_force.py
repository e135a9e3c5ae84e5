"""Social force model (D. Helbing and P. Molnár, Phys. Rev. E 51, 4282, 1995).

A force pulls each person to the desired velocity. Other people repel by a potential with elliptical
lines around their next step, and walls by a potential of the distance. All distances are between
centres, because people are points in this model.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from random import Random

import numpy as np

TINY = 1e-9
"""Length below which a vector has no direction, m or m/s."""

REACH = 12.0
"""Number of ranges σ or R beyond which a potential is ignored. It has then decayed to 6e-6."""

NEAREST = 1e-3
"""Minimum of distances and semi-axes, m, because the direction of a force is undefined at 0."""


@dataclass(frozen=True, kw_only=True)
class SocialForceParameters:
    """Parameters of the model, by default those of the paper."""

    relaxation: float = 0.5
    """Relaxation time τ, s."""
    people_strength: float = 2.1
    """Strength V⁰ of the potential around people, m²/s²."""
    people_range: float = 0.3
    """Range σ of that potential, m."""
    walls_strength: float = 10.0
    """Strength U⁰ of the potential around walls, m²/s²."""
    walls_range: float = 0.2
    """Range R of that potential, m."""
    step_time: float = 2.0
    """Duration Δt of the next step of other people, s."""
    sight: float = math.radians(200.0)
    """Angle of sight 2φ, radians."""
    unseen: float = 0.5
    """Weight c of people outside of the angle of sight."""
    faster: float = 1.3
    """Maximum speed as a multiple of the desired speed. A person's maximum speed also holds."""
    fluctuation: float = 0.3
    """Standard deviation of both components of the fluctuation, m/s². The paper gives no value."""


class SocialForce:
    """Social force model as a sampled steering.

    Parameters
    ----------
    parameters : SocialForceParameters, optional
        By default those of the paper.
    """

    def __init__(self, parameters: SocialForceParameters | None = None) -> None:
        self._parameters = SocialForceParameters() if parameters is None else parameters
        self._random: Random | None = None

    def velocities(self, scene) -> np.ndarray:
        """Return the velocities of all people until the next step, shape (N, 2), m/s.

        The step is that of the semi-implicit Euler method.
        """
        parameters = self._parameters
        force = (scene.desired - scene.velocity) / parameters.relaxation
        self._add_people(force, scene)
        self._add_walls(force, scene)
        self._add_fluctuations(force, scene)
        velocity = scene.velocity + scene.step * force
        fastest = np.minimum(parameters.faster * lengths(scene.desired), scene.max_speed)
        speed = lengths(velocity)
        too_fast = speed > fastest
        share = np.where(too_fast, fastest / np.where(too_fast, speed, 1.0), 1.0)
        return np.asarray(velocity * share[:, None])

    def _add_people(self, force: np.ndarray, scene) -> None:
        """Add the repulsion between people, eqs. 3, 4 and 8 of the paper."""
        parameters = self._parameters
        desired = unit(scene.desired)
        step = parameters.step_time * lengths(scene.velocity)[:, None] * _heading(scene)
        apart = scene.at[:, None, :] - scene.at
        beyond = apart - step
        distance = np.maximum(lengths(apart), NEAREST)
        other_distance = np.maximum(lengths(beyond), NEAREST)
        both, axis = distance + other_distance, lengths(step)
        semi_minor = np.sqrt(np.maximum(both * both - axis * axis, 0.0)) / 2
        np.maximum(semi_minor, NEAREST, out=semi_minor)
        acts = (semi_minor < REACH * parameters.people_range) & scene.steered[:, None]
        np.fill_diagonal(acts, val=False)
        who, _ = np.nonzero(acts)
        slope = apart[acts] / distance[acts][:, None] + beyond[acts] / other_distance[acts][:, None]
        slope *= (both[acts] / (4 * semi_minor[acts]))[:, None]
        push = parameters.people_strength / parameters.people_range
        pushes = slope * (push * _decay(semi_minor[acts], parameters.people_range))[:, None]
        toward = -(desired[who] * pushes).sum(axis=1)
        seen = toward >= lengths(pushes) * math.cos(parameters.sight / 2)
        pushes *= np.where(seen, 1.0, parameters.unseen)[:, None]
        np.add.at(force, who, pushes)

    def _add_walls(self, force: np.ndarray, scene) -> None:
        """Add the repulsion of walls, eq. 5 of the paper."""
        parameters = self._parameters
        away = scene.at[scene.wall_of] - scene.wall_at
        distance = np.maximum(lengths(away), NEAREST)
        push = (
            parameters.walls_strength
            / parameters.walls_range
            * _decay(distance, parameters.walls_range)
        )
        np.add.at(force, scene.wall_of, away * (push / distance)[:, None])

    def _add_fluctuations(self, force: np.ndarray, scene) -> None:
        """Add the fluctuations. Without them two people who meet head-on never pass."""
        width = self._parameters.fluctuation
        if self._random is None:
            self._random = Random(scene.seed)
        if width > 0.0:
            for k in np.flatnonzero(scene.steered):
                force[k] += self._random.gauss(0.0, width), self._random.gauss(0.0, width)


def _heading(scene) -> np.ndarray:
    """Return the desired directions, and the directions of motion of those who have no goal."""
    return np.where(scene.steered[:, None], unit(scene.desired), unit(scene.velocity))


def _decay(distance: np.ndarray, within: float) -> np.ndarray:
    """Return exp(-distance / within), by the same function of C for all lengths of arrays."""
    return np.array([math.exp(-d / within) for d in distance.tolist()])


def unit(vectors: np.ndarray) -> np.ndarray:
    """Return the directions of vectors, shape (N, 2). The direction of a tiny vector is zero."""
    length = lengths(vectors)
    known = length > TINY
    return np.where(known[:, None], vectors / np.where(known, length, 1.0)[:, None], 0.0)


def lengths(vectors: np.ndarray) -> np.ndarray:
    """Return the lengths of vectors, shape (..., 2)."""
    x, y = vectors[..., 0], vectors[..., 1]
    # Unlike `hypot`, the result has the same bits on all machines.
    return np.asarray(np.sqrt(x * x + y * y))
