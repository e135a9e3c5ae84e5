"""A way that was found, or the reason why there is none."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

Reason = Literal["start_blocked", "goal_blocked", "unreachable", "not_found"]


@dataclass(frozen=True, eq=False)
class Path:
    """A polyline on the floor that a disc can follow without touching anything."""

    points: NDArray[np.float64]
    """(N, 2) metres, the start first and the goal last, exactly as they were given."""
    clearance: float
    """Metres from the polyline to the nearest thing anywhere along it."""
    planner: str
    """The name of the planner that found it."""
    checks: int
    """How many collision queries it took."""

    def __repr__(self) -> str:
        return (
            f"<Path of {self.length:.3f} m by {self.planner}: {len(self.points)} waypoints,"
            f" {self.clearance:.3f} m clear>"
        )

    @property
    def length(self) -> float:
        """Metres."""
        return float(np.hypot(*np.diff(self.points, axis=0).T).sum())


class PlanningError(Exception):
    """Why there is no path.

    `reason` is "start_blocked" or "goal_blocked" if there is no room to stand there,
    "unreachable" if it is proved that no way leads from one to the other, and "not_found" if a
    planner spent its budget of samples without finding one that may well exist. `message` says
    it in words, and by what; it is worked out when it is first read, from the world as it was.
    """

    def __init__(self, reason: Reason, message: str | Callable[[], str]) -> None:
        super().__init__(reason)
        self.reason: Reason = reason
        self._message = message

    @property
    def message(self) -> str:
        """What is in the way, in a sentence."""
        if not isinstance(self._message, str):
            self._message = self._message()
        return self._message

    def __str__(self) -> str:
        return self.message

    def __reduce__(self) -> tuple[type[PlanningError], tuple[Reason, str]]:
        return (type(self), (self.reason, self.message))


@dataclass(frozen=True)
class PlannerInfo:
    """A planner that one can ask for by name."""

    name: str
    summary: str
    optimal: bool
    """Whether its ways approach the shortest one as its budget grows."""
    refused: str = ""
    """Why it can't be asked for, or empty."""
    iterations: int = 0
    """Its budget where no other is given."""
    parameters: tuple[str, ...] = ()
    """The names of what can be set."""
