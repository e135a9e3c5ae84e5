"""Nearness of two people: when they come nearer to each other than a distance, and part again."""

from __future__ import annotations

from collections.abc import Callable

from navigation import Apart, FixedDistance, TooClose, first_time

from ..core.body import Body
from ..core.clock import Alarm, Turn
from ..core.stage import Stage


class NearWatch:
    """Calls `notify` as two bodies come within `near` metres (True), and as they have parted.

    That is once they are `parting` metres further apart. Distances are between centres.
    """

    def __init__(
        self,
        stage: Stage,
        bodies: tuple[Body, Body],
        near: float,
        parting: float,
        notify: Callable[[bool], None],
    ) -> None:
        self.is_near = False
        self._stage = stage
        self._bodies = bodies
        self._apart = Apart(near + parting)
        self._close = TooClose(FixedDistance(near))
        self._notify = notify
        self._alarm = Alarm(stage.clock, self._ring, Turn.NOTICE)
        for body in bodies:
            body.on_change.append(self._reconsider)
        self._reconsider()

    def _reconsider(self) -> None:
        mine, theirs = (body.motion for body in self._bodies)
        now = self._stage.clock.now
        end = max(now, min(max(mine.end, theirs.end), self._stage.end))
        awaited = self._apart if self.is_near else self._close
        self._alarm.set(first_time(awaited, mine, theirs, now, end))

    def _ring(self) -> None:
        self.is_near = not self.is_near
        self._reconsider()
        self._notify(self.is_near)
