"""Commands and tasks: values that others send to people and machines, and goals with a result."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Callable, Sequence
from typing import Any

from shapely.geometry import LineString

from floorplan import UserError
from navigation import PlanningError

from ..core.body import Body
from ..core.recorder import Event
from .values import Feedback, Pose, Target

SUCCEEDED, CANCELLED = "succeeded", "cancelled"

REPLACED = "failed: another goal or command replaced it"

OVER = "failed: the run is over"

BEGUN_AGAIN = "failed: the run has begun again"

SIMPLER = 0.05
"""Metres by which the waypoints of a person or machine may differ from a dense path."""


CarryOut = Callable[[str, Any, str], Any]
"""Carries out a value for a command or task by name, from a client. It may raise `Rejected`."""


class CellCommand:
    """Command to a person or machine, by name, such as "machines/bot/twist"."""

    def __init__(self, name: str, carry_out: CarryOut) -> None:
        self.name = name
        self._carry_out = carry_out

    def take(self, value: Any, source: str = "") -> None:
        """Carry out a value and record it in the commands of the trial.

        Parameters
        ----------
        value : object
            The value. See the table of commands in the documentation.
        source : str, optional
            Name of the client.

        Raises
        ------
        Rejected
            If the value must not enter, or is impossible now.
        """
        self._carry_out(self.name, value, source)


class CellTask:
    """Task that a person or machine can carry out, by name, such as "machines/bot/go_to"."""

    def __init__(self, name: str, carry_out: CarryOut) -> None:
        self.name = name
        self._carry_out = carry_out

    def start(self, goal: Any, source: str = "") -> Running:
        """Start the task, which ends the one under way of the same person or machine.

        Parameters
        ----------
        goal : object
            The goal. See the table of tasks in the documentation.
        source : str, optional
            Name of the client.

        Returns
        -------
        Running
            The task under way.

        Raises
        ------
        Rejected
            If the goal must not enter, or cannot be reached.
        """
        running: Running = self._carry_out(self.name, goal, source)
        return running


class Running(ABC):
    """Task under way: a person or machine on the way to targets, one after the other.

    Attributes
    ----------
    goal : object
        Goal of the task.
    """

    def __init__(self, goal: Any, body: Body, targets: Sequence[Target]) -> None:
        self.goal = goal
        self.refresh: Callable[[], None] = lambda: None
        """Brings all tasks up to date."""
        self._body = body
        self._left = [*targets]
        self._began = body.clock.now
        self._outcome = ""
        """Outcome of the way to the first target, or nothing while it is under way."""
        self._result: str | None = None
        self._on_end: list[Callable[[str], None]] = []

    @property
    def result(self) -> str | None:
        """Result "succeeded", "cancelled" or "failed: why". None while the task is under way."""
        self.refresh()
        return self._result

    @property
    def ended(self) -> bool:
        """Whether the task has a result."""
        return self._result is not None

    def feedback(self) -> Feedback:
        """Return the progress."""
        state, clock = self._body.state, self._body.clock
        points = [state.at, *((x, y) for x, y, *_ in self._left)]
        remaining = sum(map(math.dist, points, points[1:]))
        return Feedback(Pose.of(state), remaining, clock.now - self._began, len(self._left))

    def cancel(self) -> None:
        """Stop the person or machine, unless the task has ended."""
        if self.result is None:
            self._stop()
            self.end(CANCELLED)

    def on_end(self, callback: Callable[[str], None]) -> None:
        """Call a function with the result at the end, or at once if the task has ended."""
        if self._result is None:
            self._on_end.append(callback)
        else:
            callback(self._result)

    def end(self, result: str) -> None:
        """End the task with a result, unless it has one."""
        if self._result is None:
            self._result = result
            for callback in self._on_end:
                callback(result)

    def update(self) -> None:
        """Set out for the next target, or end the task."""
        if self._result is not None or not self._outcome:
            return
        if self._outcome == SUCCEEDED and len(self._left) > 1:
            del self._left[0]
            try:
                self.begin()
            except (ValueError, PlanningError) as why:
                self.end(f"failed: {why}")
        else:
            self._left = []
            self.end(self._outcome)

    @abstractmethod
    def begin(self) -> None:
        """Set out for the first target. `ValueError` or `PlanningError` if that is impossible."""

    @abstractmethod
    def _stop(self) -> None:
        """Stop at once."""

    def see(self, event: Event) -> None:  # noqa: B027 (few tasks need events)
        """Handle an event of the run, by default not at all."""


def simplified(targets: Sequence[Target]) -> list[Target]:
    """Return the waypoints of a dense path that are needed, without headings but for the last."""
    if len(targets) < 2:
        return [*targets]
    line = LineString([target[:2] for target in targets]).simplify(SIMPLER)
    points: list[Target] = [(float(x), float(y)) for x, y in line.coords]
    return [*points[1:-1], targets[-1]]


def tasks_to(
    body: str, read: Callable[[Any], Target], make: Callable[[Any, Sequence[Target]], Running]
) -> dict[str, Callable[[Any], Running]]:
    """Return the tasks of a person or machine that goes to targets, by name.

    `read` returns the target of a goal, and `make` the task of a goal and its targets.
    """

    def path(goal: Any) -> list[Target]:
        if not isinstance(goal, Sequence) or isinstance(goal, str) or not goal:
            raise UserError("expected at least one pose")
        return [*map(read, goal)]

    return {
        f"{body}/go_to": lambda goal: make(goal, [read(goal)]),
        f"{body}/go_through": lambda goal: make(goal, path(goal)),
        f"{body}/follow": lambda goal: make(goal, simplified(path(goal))),
    }
