"""The gantry's gripper, which may lose what it holds."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable

from ...core.clock import Alarm, Clock, Turn
from ...core.workload import Drop
from .tasks import Task


class Gripper:
    """Holds what was picked for a task, and calls `lost(task)` when it loses that.

    It loses a part by each of its drops once. How long it has held it counts in simulated time,
    also while the gantry stands.
    """

    def __init__(self, clock: Clock, lost: Callable[[Task], None]) -> None:
        self._clock = clock
        self._lost = lost
        self.drops: list[Drop] = []
        """The parts that it loses."""
        self._picked: Counter[str] = Counter()
        self._holds: Task | None = None
        self._slips = Alarm(clock, self._slip, Turn.MOTION_ENDS)

    def will_lose(self, drops: Iterable[Drop]) -> None:
        """Lose parts by these drops as well."""
        self.drops += drops

    def close(self, task: Task) -> None:
        """Hold the part that was picked for `task`."""
        part = str(task.fields.get("part"))
        before = self._picked[part]
        self._picked[part] += 1
        self._holds = task
        delays = [drop.delay for drop in self.drops if (drop.part, drop.after) == (part, before)]
        delay = min(delays, default=None)
        self._slips.set(None if delay is None else self._clock.now + delay)

    def open(self) -> None:
        """Hold nothing any more."""
        self._holds = None
        self._slips.set(None)

    def _slip(self) -> None:
        task, self._holds = self._holds, None
        if task is not None:
            self._lost(task)
