"""Tasks: goals of people and machines with feedback, cancellation and a result."""

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
from .admission import Admission
from .values import Feedback, Pose, Target

SUCCEEDED, CANCELLED = "succeeded", "cancelled"

REPLACED = "failed: another goal or command replaced it"

OVER = "failed: the run is over"

BEGUN_AGAIN = "failed: the run has begun again"

SIMPLER = 0.05
"""Metres by which the waypoints of a person or machine may differ from a dense path."""


class Journey(ABC):
    """Motion of a person or machine through the targets of one task, which are `left`."""

    body: Body
    left: list[Target]
    ended = ""
    """Outcome of the way to the first target, or nothing while it is under way."""

    @abstractmethod
    def begin(self) -> None:
        """Set out. `ValueError` or `PlanningError` if that is impossible."""

    @abstractmethod
    def stop(self) -> None:
        """Stop at once."""

    def see(self, event: Event) -> None:  # noqa: B027 (few journeys need events)
        """Handle an event of the run, by default not at all."""

    def outcome(self) -> str:
        """Return "succeeded" or "failed: why" once it has ended, and continue until then."""
        if self.ended != SUCCEEDED:
            return self.ended
        self.left.pop(0)
        if not self.left:
            return SUCCEEDED
        try:
            self.begin()
        except (ValueError, PlanningError) as why:
            return f"failed: {why}"
        return ""


class Running:
    """Task under way.

    Attributes
    ----------
    name : str
        Name of the task.
    goal : object
        Its goal.
    """

    def __init__(self, name: str, goal: Any, journey: Journey, refresh: Callable[[], None]) -> None:
        self.name = name
        self.goal = goal
        self._journey = journey
        self._refresh = refresh
        self._began = journey.body.clock.now
        self._result: str | None = None
        self._on_end: list[Callable[[str], None]] = []

    @property
    def result(self) -> str | None:
        """Result "succeeded", "cancelled" or "failed: why". None while the task is under way."""
        self._refresh()
        return self._result

    @property
    def ended(self) -> bool:
        """Whether the task has a result."""
        return self._result is not None

    def feedback(self) -> Feedback:
        """Return the progress."""
        state, left = self._journey.body.state, self._journey.left
        points = [state.at, *((x, y) for x, y, *_ in left)]
        remaining = sum(map(math.dist, points, points[1:]))
        elapsed = self._journey.body.clock.now - self._began
        return Feedback(Pose.of(state), remaining, elapsed, len(left))

    def cancel(self) -> None:
        """Stop the person or machine, unless the task has ended."""
        if self.result is None:
            self._journey.stop()
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

    def see(self, event: Event) -> None:
        """Handle an event of the run."""
        self._journey.see(event)

    def update(self) -> None:
        """Start the next part of the task, or end it."""
        if self._result is None and (outcome := self._journey.outcome()):
            self.end(outcome)


class CellTask:
    """Task that a person or machine can carry out.

    Parameters
    ----------
    name : str
        Name, such as "machines/bot/go_to".
    admission : Admission
        Check of goals.
    make : callable
        Function that returns the journey of a goal. It raises a `ValueError` for invalid goals.
    refresh : callable
        Function that brings all tasks up to date.
    begun : callable
        Function that is called with each task that has started.
    """

    def __init__(
        self,
        name: str,
        admission: Admission,
        make: Callable[[Any], Journey],
        refresh: Callable[[], None],
        begun: Callable[[str, Running], None],
    ) -> None:
        self.name = name
        self._admission = admission
        self.make = make
        self._refresh = refresh
        self._begun = begun

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
        journey = self._admission.carry_out(self.name, goal, source, self._set_out)
        running = Running(self.name, goal, journey, self._refresh)
        self._begun(self.name.rpartition("/")[0], running)
        return running

    def _set_out(self, goal: Any) -> Journey:
        self._refresh()
        journey = self.make(goal)
        journey.begin()
        return journey


def simplified(targets: Sequence[Target]) -> list[Target]:
    """Return the waypoints of a dense path that are needed, without headings but for the last."""
    if len(targets) < 2:
        return [*targets]
    line = LineString([target[:2] for target in targets]).simplify(SIMPLER)
    points: list[Target] = [(float(x), float(y)) for x, y in line.coords]
    return [*points[1:-1], targets[-1]]


def required_targets(goal: Any) -> Sequence[Any]:
    """Return the waypoints of a goal. `ValueError` if there are none."""
    if not isinstance(goal, Sequence) or isinstance(goal, str) or not goal:
        raise UserError("expected at least one pose")
    return goal
