"""Entrances: where people come in, one after the other as they came."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable

from floorplan import Point

from ..core.clock import Clock, Turn

LOOKS_AGAIN = 0.5
"""Seconds until somebody who finds no room to come in looks again."""


class Entrances:
    """People who want to come in: a queue for each place, first in, first out.

    Only the first of a queue looks for room, however many wait behind them.
    """

    def __init__(self, clock: Clock) -> None:
        self._clock = clock
        self._queues: dict[Point, deque[tuple[float, Callable[[], bool]]]] = {}

    def join(self, place: Point, come_in: Callable[[], bool]) -> None:
        """Queue at `place`; `come_in` is called when it is their turn, and returns whether it went.

        It is called at once, and every `LOOKS_AGAIN` seconds after that while they are the first.
        """
        queue = self._queues.setdefault(place, deque())
        queue.append((self._clock.now, come_in))
        if len(queue) == 1:
            self._look(place)

    def _look(self, place: Point) -> None:
        queue, now = self._queues[place], self._clock.now
        _, come_in = queue[0]
        if not come_in():
            queue[0] = (now + LOOKS_AGAIN, come_in)
        else:
            queue.popleft()
        if queue:
            self._clock.call_at(self._next(queue, now), lambda: self._look(place), Turn.NOTICE)

    def _next(self, queue: deque[tuple[float, Callable[[], bool]]], now: float) -> float:
        """Return when the first looks, who has looked in vain before at their own pace."""
        t, come_in = queue[0]
        while t < now:
            t += LOOKS_AGAIN
        queue[0] = (t, come_in)
        return t
