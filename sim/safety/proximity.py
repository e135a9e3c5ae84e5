"""Proximity of two bodies: distance between people, and approach notifications."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from functools import partial
from itertools import combinations

from navigation import Apart, Condition, FixedDistance, Motion, TooClose, first_time
from navigation.kernels.watched import WatchRow

from ..core.body import Body, Machine
from ..core.clock import Alarm, Turn
from ..core.events import PeopleTooNear
from ..core.stage import Bystander, Stage
from .monitors import Pair

Change = Callable[[bool, Motion, Motion, float, float], float | None]
"""Returns when two motions part that are near (True), or come near that are not, if they do (s).

Its last arguments are begin and end of the search (seconds).
"""


def by_conditions(near: Condition, parted: Condition) -> Change:
    """Return the change by a condition for each state."""
    return lambda is_near, *when: first_time(parted if is_near else near, *when)


class NearnessMonitor:
    """Calls `notify` as two bodies come so near that something holds (True), and as they part.

    It reconsiders after each new motion of both bodies, unless it has a `row`.
    """

    def __init__(
        self,
        stage: Stage,
        bodies: tuple[Body, Body],
        change: Change,
        notify: Callable[[bool], None],
        turn: Turn = Turn.NOTICE,
        row: WatchRow | None = None,
    ) -> None:
        self.alarm = Alarm(stage.clock, self._ring, turn)
        self._stage = stage
        self._bodies = bodies
        self._change = change
        self._notify = notify
        self._row = row
        self._is_near = False
        if row is None:
            for body in bodies:
                body.on_change.append(self.reconsider)
        self.reconsider()

    def reconsider(self) -> None:
        """Compute the next change, for each new motion."""
        one, other = self._bodies
        mine, theirs = one.motion, other.motion
        now = self._stage.clock.now
        if self._row is not None:
            self._row.search(mine, theirs, now)
        end = max(now, min(max(mine.end, theirs.end), self._stage.end))
        self.alarm.set(self._change(self._is_near, mine, theirs, now, end))

    def _ring(self) -> None:
        self._is_near = not self._is_near
        if self._row is not None:
            self._row.asks = self._is_near
        self.reconsider()
        self._notify(self._is_near)


PARTED = 1e-3
"""Metres beyond the distance at which two have parted: rounding does not count twice."""


class Distancing:
    """Watches every two of some people, who have `radii` (m), for bodies nearer than `required`."""

    def __init__(
        self, stage: Stage, people: Sequence[Bystander], radii: Sequence[float], required: float
    ) -> None:
        self.count = 0
        """Number of times that two came too near to each other."""
        self._stage = stage
        self._required = required
        self._time = 0.0
        self._since: dict[tuple[Bystander, Bystander], float] = {}
        for (one, mine), (other, theirs) in combinations(zip(people, radii, strict=True), 2):
            near = required + mine + theirs
            change = by_conditions(TooClose(FixedDistance(near)), Apart(near + PARTED))
            notify = partial(self._changed, one, other, near)
            NearnessMonitor(stage, (one.body, other.body), change, notify)

    @property
    def time(self) -> float:
        """How long (s) people were too near until now, all pairs together."""
        now = self._stage.clock.now
        return self._time + sum(now - since for since in self._since.values())

    def _changed(self, one: Bystander, other: Bystander, near: float, is_near: bool) -> None:
        now = self._stage.clock.now
        if not is_near:
            self._time += now - self._since.pop((one, other))
            return
        self.count += 1
        self._since[one, other] = now
        # From surface to surface: `near` is between centres.
        apart = math.dist(one.body.at, other.body.at) - near + self._required
        self._stage.record(
            PeopleTooNear(
                person=one.name, other=other.name, distance=apart, required=self._required
            )
        )


PARTING = 0.1
"""Metres. Distance beyond the watched one to which the two have to part before another approach."""


class ApproachMonitor:
    """Calls `came_near` when a person comes within a distance of a machine's axis.

    It watches from when `near` gives the distance on.
    """

    def __init__(self, stage: Stage, machine: Machine, came_near: Callable[[], None]) -> None:
        people = stage.people
        self._pairs = [Pair(stage, person, machine) for person in people]
        self._bodies = [*(person.body for person in people), machine.body]
        self._came_near = came_near
        self._close = TooClose(FixedDistance(0.0))
        self._parted = Apart(PARTING)
        self._is_near = [False] * len(people)
        self._watching = False
        self._alarms = [
            Alarm(stage.clock, partial(self._ring, k), Turn.NOTICE) for k in range(len(people))
        ]

    def near(self, distance: float | None) -> None:
        """Watch for this distance in metres from now on."""
        if distance is None:
            return
        self._close = TooClose(FixedDistance(distance))
        self._parted = Apart(distance + PARTING)
        if not self._watching:
            self._watching = True
            for body in self._bodies:
                body.on_change.append(self._reconsider)
        self._reconsider()

    def _reconsider(self) -> None:
        for k, pair in enumerate(self._pairs):
            self._alarms[k].set(pair.first_time(self._parted if self._is_near[k] else self._close))

    def _ring(self, k: int) -> None:
        # Hysteresis: near until parted, apart until near, so that no rounding notifies twice.
        self._is_near[k] = not self._is_near[k]
        self._reconsider()
        if self._is_near[k]:
            self._came_near()
