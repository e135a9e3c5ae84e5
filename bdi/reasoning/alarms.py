"""Tasks for later times."""

from __future__ import annotations

import heapq
from collections.abc import Callable
from itertools import count


class Alarm:
    """Task that runs at a time, unless it is cancelled before."""

    __slots__ = ("cancelled", "task")

    def __init__(self, task: Callable[[], None]) -> None:
        self.task = task
        self.cancelled = False

    def cancel(self) -> None:
        """Have the task not run."""
        self.cancelled = True


class Alarms:
    """Alarms in order of time (ns), and of setting where they have the same time."""

    def __init__(self) -> None:
        self.heap: list[tuple[int, int, Alarm]] = []
        self._order = count()

    def set(self, clock: int, task: Callable[[], None]) -> Alarm:
        """Have `task` run at `clock` (ns)."""
        alarm = Alarm(task)
        heapq.heappush(self.heap, (clock, next(self._order), alarm))
        return alarm

    @property
    def next(self) -> int | None:
        """Time of the next alarm (ns), or None."""
        heap = self.heap
        while heap and heap[0][2].cancelled:
            heapq.heappop(heap)
        return heap[0][0] if heap else None

    def is_due(self, clock: int) -> bool:
        """Return True if an alarm is due at `clock` (ns)."""
        following = self.next
        return following is not None and following <= clock

    def ring(self, clock: int) -> None:
        """Run the tasks that are due at `clock` (ns)."""
        while self.is_due(clock):
            heapq.heappop(self.heap)[2].task()

    def clear(self) -> None:
        """Cancel all of them."""
        self.heap.clear()
