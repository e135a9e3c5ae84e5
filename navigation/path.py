"""Planned paths, and the reasons why there is none."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from floorplan import UserError

Reason = Literal["start_blocked", "goal_blocked", "unreachable", "not_found"]


@dataclass(frozen=True, eq=False)
class Path:
    """A polyline on the floor that a disc can follow without touching anything."""

    points: NDArray[np.float64]
    """(N, 2) metres, the start first and the goal last, exactly as they were given."""
    clear: float | Callable[[], float] = field(repr=False)
    """Its `clearance`, or a function that works it out."""
    planner: str
    """The name of the planner that found it."""
    checks: int
    """Number of collision queries that it took."""

    def __repr__(self) -> str:
        figures = f"{len(self.points)} waypoints, {self.clearance:.3f} m clear"
        return f"<{type(self).__name__} of {self.length:.3f} m by {self.planner}: {figures}>"

    def __reduce__(self) -> tuple[type[Path], tuple[NDArray[np.float64], float, str, int]]:
        return (type(self), (self.points, self.clearance, self.planner, self.checks))

    def __array__(self, dtype: Any = None, copy: bool | None = None) -> NDArray[Any]:
        """Return its points: a path stands for them wherever an array does, as in `walk`."""
        return np.array(self.points, dtype=dtype, copy=True if copy is None else copy)

    @cached_property
    def clearance(self) -> float:
        """Metres from the polyline to the nearest thing anywhere along it.

        It is computed when first read, from the world as it was.
        """
        return self.clear if isinstance(self.clear, float) else self.clear()

    @property
    def length(self) -> float:
        """Metres."""
        return float(np.hypot(*np.diff(self.points[:, :2], axis=0).T).sum())


class PlanningError(Exception):
    """Reason why there is no path.

    `reason` is "start_blocked" or "goal_blocked" if there is no room to stand there,
    "unreachable" if it is proved that no path leads from one to the other, and "not_found" if a
    planner spent its budget of samples without finding one that may well exist. `message` names
    what is in the way; it is computed when first read, from the world as it was.
    """

    def __init__(self, reason: Reason, message: str | Callable[[], str]) -> None:
        super().__init__(reason)
        self.reason: Reason = reason
        self._message = message

    @property
    def message(self) -> str:
        """The reason in a sentence, with the things that are in the way."""
        if not isinstance(self._message, str):
            self._message = self._message()
        return self._message

    def __str__(self) -> str:
        return self.message

    def __reduce__(self) -> tuple[type[PlanningError], tuple[Reason, str]]:
        return (type(self), (self.reason, self.message))


class PlannerError(UserError):
    """A planner that can't be found, or that failed: its path may be no answer."""


@dataclass(frozen=True)
class PlannerInfo:
    """A planner that one can ask for by name."""

    name: str
    summary: str
    optimal: bool
    """True if its paths approach the shortest one as its budget grows."""
    iterations: int = 0
    """Its budget where no other is given."""
    parameters: tuple[str, ...] = ()
    """The names of what can be set."""


class Watch:
    """Watches a search, of one of OMPL's planners, while it goes on. This one does nothing.

    A budget of time, or a curve of cost over time, is a subclass.
    """

    def iteration(self, planner: Any) -> bool:
        """Return True to end the search here; called before each iteration of `planner`, OMPL's."""
        return False

    def solved(self) -> None:
        """Called when a path was found, before it is simplified."""
