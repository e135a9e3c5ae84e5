"""What is to be done at later times."""

from __future__ import annotations

import heapq
from collections.abc import Callable
from itertools import count


class Alarm:
    """A task to be run at a time, unless it is cancelled before."""

    __slots__ = ("cancelled", "task")

    def __init__(self, task: Callable[[], None]) -> None:
        self.task = task
        self.cancelled = False

    def cancel(self) -> None:
        self.cancelled = True


class Alarms:
    """Alarms by time, in nanoseconds; of two at the same time the first that was set goes first."""

    def __init__(self) -> None:
        self.heap: list[tuple[int, int, Alarm]] = []
        self._order = count()

    def set(self, clock: int, task: Callable[[], None]) -> Alarm:
        alarm = Alarm(task)
        heapq.heappush(self.heap, (clock, next(self._order), alarm))
        return alarm

    @property
    def next(self) -> int | None:
        """When the next one is due."""
        heap = self.heap
        while heap and heap[0][2].cancelled:
            heapq.heappop(heap)
        return heap[0][0] if heap else None

    def is_due(self, clock: int) -> bool:
        following = self.next
        return following is not None and following <= clock

    def ring(self, clock: int) -> None:
        """Runs what is due."""
        while self.is_due(clock):
            heapq.heappop(self.heap)[2].task()

    def clear(self) -> None:
        self.heap.clear()
