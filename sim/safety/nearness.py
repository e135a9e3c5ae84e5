"""Nearness of two bodies: when a condition on them begins to hold, and when they have parted."""

from __future__ import annotations

from collections.abc import Callable

from navigation import Condition, first_time

from ..core.body import Body
from ..core.clock import Alarm, Turn
from ..core.stage import Stage


class NearWatch:
    """Calls `notify` as two bodies come so near that `near` holds (True), and as `parted` does."""

    def __init__(
        self,
        stage: Stage,
        bodies: tuple[Body, Body],
        near: Condition,
        parted: Condition,
        notify: Callable[[bool], None],
    ) -> None:
        self.is_near = False
        self._stage = stage
        self._bodies = bodies
        self._near = near
        self._parted = parted
        self._notify = notify
        self._alarm = Alarm(stage.clock, self._ring, Turn.NOTICE)
        for body in bodies:
            body.on_change.append(self._reconsider)
        self._reconsider()

    def _reconsider(self) -> None:
        one, other = (body.motion for body in self._bodies)
        now = self._stage.clock.now
        end = max(now, min(max(one.end, other.end), self._stage.end))
        awaited = self._parted if self.is_near else self._near
        self._alarm.set(first_time(awaited, one, other, now, end))

    def _ring(self) -> None:
        self.is_near = not self.is_near
        self._reconsider()
        self._notify(self.is_near)
