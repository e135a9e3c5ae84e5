"""Proximity of two bodies: collisions, distance between people, and approach notifications."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Sequence
from functools import lru_cache, partial
from itertools import combinations

from floorplan import Point
from navigation import Apart, Box, Condition, FixedDistance, Overlapping, TooClose, first_time
from navigation.carried import carried

from ..core.body import Body, Machine, MachineShape
from ..core.clock import Alarm, Turn
from ..core.events import Collision, PeopleTooNear
from ..core.stage import Bystander, Stage
from .monitors import Pair

AXIS = (0.0, 0.0)
"""The point of a body around which it turns."""


class NearnessMonitor:
    """Calls `notify` as two bodies come so near that `near` holds (True), and as `parted` does.

    The conditions are about `points` of the bodies: metres ahead of their axes and to the left.
    """

    def __init__(
        self,
        stage: Stage,
        bodies: tuple[Body, Body],
        near: Condition,
        parted: Condition,
        notify: Callable[[bool], None],
        points: tuple[Point, Point] = (AXIS, AXIS),
    ) -> None:
        self.is_near = False
        self._points = points
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
        (one, other), (here, there) = self._bodies, self._points
        mine, theirs = carried(one.motion, *here), carried(other.motion, *there)
        now = self._stage.clock.now
        end = max(now, min(max(mine.end, theirs.end), self._stage.end))
        awaited = self._parted if self.is_near else self._near
        self._alarm.set(first_time(awaited, mine, theirs, now, end))

    def _ring(self) -> None:
        self.is_near = not self.is_near
        self._reconsider()
        self._notify(self.is_near)


DEPTH = 1e-3
"""Metres. Boxes that overlap by no more only touch, as those of machines side by side may."""


@lru_cache(maxsize=1024)
def _conditions(box: Box, others: Box) -> tuple[Condition, Condition]:
    """Return when two boxes collide, and when they have parted."""
    return Overlapping(box, others, DEPTH), ~Overlapping(box, others)


def _box_around(shape: MachineShape) -> tuple[Box, Point]:
    """Return the smallest box around a footprint, and its middle from the axis, metres."""
    if not shape.outline:
        return shape.box, AXIS
    x, y, most_x, most_y = shape.bounds
    box = Box(length=most_x - x, width=most_y - y, bottom=shape.bottom, top=shape.top)
    return box, ((x + most_x) / 2, (y + most_y) / 2)


class Collisions:
    """Watches every two of some machines whose boxes are not above each other.

    Each counts as the smallest rectangle around its footprint and along its heading.
    """

    def __init__(self, stage: Stage, machines: Iterable[Machine]) -> None:
        self.count = 0
        """Number of times that two machines ran into each other."""
        self._stage = stage
        boxes = [(machine, *_box_around(machine.shape)) for machine in machines]
        for (one, box, middle), (other, others, of_other) in combinations(boxes, 2):
            if box.is_level_with(others):
                near, parted = _conditions(box, others)
                notify = partial(self._changed, one, other)
                points = middle, of_other
                NearnessMonitor(stage, (one.body, other.body), near, parted, notify, points)

    def _changed(self, one: Machine, other: Machine, is_near: bool) -> None:
        if not is_near:
            return
        self.count += 1
        (vx, vy, _), (wx, wy, _) = one.body.state.velocity, other.body.state.velocity
        self._stage.record(
            Collision(machine=one.name, with_=other.name, speed=math.hypot(wx - vx, wy - vy))
        )


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
            NearnessMonitor(
                stage,
                (one.body, other.body),
                TooClose(FixedDistance(near)),
                Apart(near + PARTED),
                partial(self._changed, one, other, near),
            )

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
