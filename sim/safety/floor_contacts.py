"""Contacts of machines with the floor: its boundary, its obstacles, closed doors.

Every motion is checked that was not planned around them: twists, motions that are followed, and
those of custom kinds. The instant of a contact is solved for.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from functools import cache, lru_cache, partial
from itertools import pairwise

import shapely
from shapely.geometry.base import BaseGeometry

from floorplan import Floorplan, Obstacle
from floorplan.files.dataclass import dataclass
from navigation import Motion, standing
from navigation.contacts import Extent, Outlines, bounds_from, shrunk
from navigation.kernels.edges import come_into
from navigation.kernels.numbers import numbers

from ..core.body import Machine
from ..core.clock import Alarm, Clock, Turn
from ..core.events import Contact
from ..core.stage import Stage
from .contacts import impact_speed
from .proximity import PARTED

DEPTH = 1e-6
"""Metres. A machine that is no deeper in something may slide along it."""

ROUNDING = 1e-8
"""Metres. A machine that has touched something may get so much deeper."""

LEAST = 1e-5
"""Metres. A machine that pushes against something and would move by less does not move."""

REST = standing((0.0, 0.0))


@dataclass(frozen=True, eq=False)
class FloorPart:
    """Something that a machine may touch, and since when it is there (seconds)."""

    name: str
    area: BaseGeometry
    since: float = -math.inf
    outside: bool = False
    """Whether it covers all that is not within the area."""


class FloorContacts:
    """Contacts of some machines with the floor."""

    def __init__(self, stage: Stage, machines: Iterable[Machine]) -> None:
        self.count = 0
        """Number of contacts until now."""
        self._stage = stage
        parts_at = cache(partial(FloorParts.at, stage.floorplan))
        self._monitors = [
            FloorMonitor(
                stage.clock,
                machine,
                parts_at(machine.shape.category, machine.shape.bottom, machine.shape.top),
                self._touched,
            )
            for machine in machines
        ]
        stage.triggers.each("door_closed", lambda event: self._came(event["door"]))
        stage.triggers.each("obstacle_came", lambda event: self._came(event["obstacle"]))
        stage.triggers.each("door_opened", lambda event: self._went(event["door"]))
        stage.triggers.each("obstacle_went", lambda event: self._went(event["obstacle"]))

    def begin(self) -> None:
        """Begin to watch. A machine touches the objects that it overlaps now."""
        for monitor in self._monitors:
            monitor.begin()

    def _touched(self, event: Contact) -> None:
        self.count += 1
        self._stage.record(event)

    def _came(self, name: str) -> None:
        for monitor in self._monitors:
            monitor.came(self._stage.active_closures[name])

    def _went(self, name: str) -> None:
        for monitor in self._monitors:
            monitor.went(name)


class FloorParts:
    """Parts of a floor that a machine may touch, found by their bounds."""

    def __init__(self, parts: Iterable[FloorPart]) -> None:
        self.parts = tuple(parts)
        bounds = [(one, each) for one in self.parts for each in _parts(one.area, one.outside)]
        self._owners = [one for one, _ in bounds]
        self._bounds = numbers([bound for _, each in bounds for bound in each])

    @classmethod
    def at(cls, plan: Floorplan, category: str, bottom: float, top: float) -> FloorParts:
        """Return the parts between two heights (m). Only vehicles may touch the boundary."""
        obstacles = [one for one in plan.obstacles if one.overlaps(bottom, top)]
        parts = [FloorPart(one.name, one.footprint) for one in obstacles]
        if category == "vehicle":
            parts.insert(0, FloorPart("boundary", plan.boundary, outside=True))
        return cls(parts)

    def near(self, motion: Motion, begin: float, reach: float) -> list[FloorPart]:
        """Return the parts within `reach` (m) of the bounds of a motion from `begin` (s) on."""
        x, y, most_x, most_y = bounds_from(motion, begin)
        near = come_into(self._bounds, [(x, y), (most_x, most_y)], reach)
        return [*dict.fromkeys(self._owners[k] for _, k in near)]


class FloorMonitor:
    """Finds the contacts of a machine with the floor, at which it stops or goes on."""

    def __init__(
        self,
        clock: Clock,
        machine: Machine,
        parts: FloorParts,
        touched: Callable[[Contact], None],
    ) -> None:
        self._machine = machine
        self._body = machine.body
        self._clock = clock
        self._notify = touched
        self._reach = machine.shape.farthest
        self._parts = parts
        self._touches: dict[FloorPart, float] = {}
        """What it touches, and how deep it may be in it (metres)."""
        self._outlines: dict[tuple[FloorPart, float], Outlines] = {}
        self._next: Callable[[], None] = self.reconsider
        self._alarm = Alarm(clock, lambda: self._next(), Turn.MOTION_ENDS)

    def begin(self) -> None:
        """Begin to watch."""
        self._body.on_change.append(self.reconsider)
        for thing in self._near(self._body.motion):
            self._may_be_in(thing)
        self.reconsider()

    def came(self, one: Obstacle) -> None:
        """Watch something that is there from now on."""
        shape = self._machine.shape
        if one.overlaps(shape.bottom, shape.top):
            thing = FloorPart(one.name, one.footprint, self._clock.now)
            self._parts = FloorParts((*self._parts.parts, thing))
            self._may_be_in(thing)
            self.reconsider()

    def went(self, name: str) -> None:
        """Forget something that is there no longer."""
        self._parts = FloorParts(one for one in self._parts.parts if one.name != name)
        self._touches = {one: depth for one, depth in self._touches.items() if one.name != name}
        if not self._touches:
            self._machine.contact_gone()
        self.reconsider()

    def reconsider(self) -> None:
        """Compute the next contact or parting, for each new motion."""
        now, motion = self._clock.now, self._body.motion
        if motion.end <= now:
            self._alarm.set(None)
            return
        planned = self._machine.planned_at
        first, stops = math.inf, self._machine.on_contact == "stop"
        for thing in (*self._touches, *self._near(motion)):
            if thing in self._touches:
                if (t := self._parting(thing, motion, now)) is not None and t < first:
                    first, self._next = t, partial(self._part, thing)
                if stops and (t := self._contact(thing, motion, now)) is not None:
                    # A machine that pushes against an object must not creep.
                    t = now if self._moves_little(motion, now, t) else t
                    if t < first:
                        first, self._next = t, self._stop
            elif thing.since >= planned:
                t = self._contact(thing, motion, now)
                if t is not None and t < first:
                    first, self._next = t, partial(self._touch, thing)
        self._alarm.set(None if first == math.inf else first)

    def _near(self, motion: Motion) -> list[FloorPart]:
        """Return the parts that a motion may touch from now on."""
        return self._parts.near(motion, self._clock.now, self._reach)

    def _between(self, thing: FloorPart, depth: float) -> Outlines:
        """Return the outlines of the machine, smaller by a depth, and of a thing."""
        if (thing, depth) not in self._outlines:
            area = shrunk(self._machine.shape.footprint((0.0, 0.0), 0.0), depth)
            self._outlines[thing, depth] = Outlines(area, thing.area, outside=thing.outside)
        return self._outlines[thing, depth]

    def _contact(self, thing: FloorPart, motion: Motion, now: float) -> float | None:
        outlines = self._between(thing, self._touches.get(thing, DEPTH))
        return outlines.first_contact(motion, REST, now, motion.end)

    def _parting(self, thing: FloorPart, motion: Motion, now: float) -> float | None:
        return self._between(thing, 0.0).first_parting(motion, REST, now, motion.end, PARTED)

    def _moves_little(self, motion: Motion, now: float, t: float) -> bool:
        here, there = motion.state(now).position, motion.state(t).position
        turned = self._reach * abs(there[2] - here[2])
        return math.dist(here[:2], there[:2]) + turned < LEAST

    def _may_be_in(self, thing: FloorPart) -> None:
        """Touch a thing if the machine is in it now."""
        if self._is_in(thing, DEPTH):
            self._touch(thing)

    def _is_in(self, thing: FloorPart, depth: float) -> bool:
        outlines = self._between(thing, depth)
        return outlines.overlap(self._body.motion, REST, self._clock.now)

    def _touch(self, thing: FloorPart) -> None:
        depth = high = DEPTH + ROUNDING
        while self._is_in(thing, high):  # it was put down on the machine, or was there before
            depth, high = high, 2 * high
        while high - depth > ROUNDING:
            middle = (depth + high) / 2
            depth, high = (middle, high) if self._is_in(thing, middle) else (depth, middle)
        self._touches[thing] = high
        x, y, rotation = self._body.state.position
        covered = shrunk(self._machine.shape.footprint((x, y), rotation), DEPTH)
        at = shapely.shortest_line(thing.area.boundary, covered).coords[0]
        self._notify(
            Contact(
                machine=self._machine.name,
                with_=thing.name,
                at=at,
                speed=impact_speed(self._body.state, at),
            )
        )
        self._machine.touched()
        if self._machine.on_contact == "stop" and self._body.motion.end > self._clock.now:
            self._stop()
        else:
            self.reconsider()

    def _stop(self) -> None:
        """Stop the machine where it is."""
        (x, y, rotation), now = self._body.state.position, self._clock.now
        self._body.follow(standing((x, y), heading=rotation, start=now))
        self._machine.stopped_by_contact()

    def _part(self, thing: FloorPart) -> None:
        del self._touches[thing]
        self.reconsider()


@lru_cache(maxsize=4096)
def _parts(area: BaseGeometry, outside: bool) -> tuple[Extent, ...]:
    """Return the bounds of an area, or of the sides of its rings if the rest is covered."""
    if not outside:
        return (area.bounds,)
    rings = [shapely.get_coordinates(ring).tolist() for ring in shapely.get_rings(area)]
    return tuple(
        (min(x, u), min(y, v), max(x, u), max(y, v))
        for ring in rings
        for (x, y), (u, v) in pairwise(ring)
    )
