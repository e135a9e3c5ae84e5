"""Values of signals, and goals and feedback of tasks."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from floorplan.files.dataclass import dataclass
from navigation.motion import State


@dataclass(frozen=True)
class Pose:
    """Pose on the floor.

    Parameters
    ----------
    x, y : float
        Position in metres.
    heading : float
        Heading in radians.
    """

    x: float
    y: float
    heading: float = 0.0

    @classmethod
    def of(cls, state: State) -> Pose:
        """Return the pose of a state."""
        return cls(*state.position)


@dataclass(frozen=True)
class Velocity:
    """Velocity over the floor.

    Parameters
    ----------
    x, y : float
        Velocity in m/s, in the frame of the floor.
    turn : float
        Angular velocity in rad/s, counterclockwise.
    """

    x: float
    y: float
    turn: float = 0.0

    def seen_at(self, heading: float) -> Velocity:
        """Return the velocity in the frame of a body: forwards, to the left, and the same turn.

        Parameters
        ----------
        heading : float
            Heading of the body in radians.
        """
        c, s = math.cos(heading), math.sin(heading)
        return Velocity(c * self.x + s * self.y, c * self.y - s * self.x, self.turn)


@dataclass(frozen=True, eq=False)
class Scan:
    """Laser scan of a machine.

    Parameters
    ----------
    distances : ndarray
        Distances in metres, of shape (rays,), counterclockwise. It is `reach` where nothing is
        nearer.
    reach : float
        Range in metres.
    first : float
        Angle of the first ray to the heading in radians.
    """

    distances: NDArray[np.float64]
    reach: float
    first: float = -math.pi

    @property
    def step(self) -> float:
        """Angle between two rays in radians."""
        return math.tau / len(self.distances)


@dataclass(frozen=True)
class MonitorState:
    """Separation of a person and a machine.

    Parameters
    ----------
    distance, required : float
        Distance, and the distance that the law requires, in metres.
    """

    distance: float
    required: float


@dataclass(frozen=True)
class Feedback:
    """Progress of a task.

    Parameters
    ----------
    pose : Pose
        Current pose.
    remaining : float
        Straight distance to the goal, through the waypoints that are left, in metres.
    elapsed : float
        Duration since the start of the task in seconds.
    waypoints : int
        Number of waypoints that are left, including the goal.
    """

    pose: Pose
    remaining: float
    elapsed: float
    waypoints: int


Target = tuple[float, ...]
"""x and y (m), and a heading (rad) if one is required."""


def target_of(goal: Pose | Sequence[float]) -> Target:
    """Return the target of a goal: a pose, or a sequence of two or three numbers."""
    if isinstance(goal, Pose):
        goal = (goal.x, goal.y, goal.heading)
    if isinstance(goal, str) or not isinstance(goal, Sequence | np.ndarray):
        raise ValueError("expected a Pose, or x, y and possibly a heading")
    numbers = tuple(map(float, goal))
    if len(numbers) not in (2, 3):
        raise ValueError(f"expected x, y and possibly a heading, not {len(numbers)} numbers")
    return numbers
