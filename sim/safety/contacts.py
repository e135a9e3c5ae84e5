"""Contacts of machines with people and with each other, exact for their footprints."""

from __future__ import annotations

import math
from collections.abc import Iterable
from functools import cached_property, lru_cache, partial
from itertools import combinations

import shapely

from floorplan import Point
from navigation import FieldSet, Motion, ProtectiveFields, intrusions
from navigation.contacts import Outlines, are_apart, shrunk
from navigation.kernels.watched import WatchRow
from navigation.monitor import RESOLUTION
from navigation.motion import State

from ..core.body import Machine, MachineShape
from ..core.clock import Turn
from ..core.events import Collision, Contact
from ..core.stage import Bystander, Stage
from .margins import moving_spans
from .monitors import PersonWatches
from .proximity import PARTED, NearnessMonitor

TOUCH = 1e-6
"""Metres. Surfaces that are no farther from each other touch."""

DEPTH = 1e-3
"""Metres. Machines that overlap by no more only touch, as those side by side may."""


def impact_speed(state: State, at: Point, velocity: Point = (0.0, 0.0)) -> float:
    """Return the speed of a body's point against something there that has a velocity (m/s)."""
    (x, y, _), (vx, vy, turning), _ = state
    vx, vy = vx - turning * (at[1] - y), vy + turning * (at[0] - x)
    return math.hypot(vx - velocity[0], vy - velocity[1])


class PersonContacts:
    """Watches people beside machines: robots, and vehicles while they drive or turn."""

    def __init__(self, stage: Stage) -> None:
        self.count = 0
        """Number of contacts until now."""
        self._stage = stage
        self._monitors: dict[Bystander, list[NearnessMonitor]] = {}
        self._fields: dict[Machine, ProtectiveFields] = {}

    def watch(self, person: Bystander, machine: Machine, watches: PersonWatches) -> None:
        """Add a watch beside a machine to those of a person, if it does not pass above them."""
        if machine.shape.bottom - self._stage.floorplan.human.height > TOUCH:
            return
        if machine not in self._fields:
            self._fields[machine] = _footprint_field(machine.shape)
        change = partial(self._change, person, machine)
        notify = partial(self._changed, person, machine)
        bodies, driven = (person.body, machine.body), machine.shape.category == "vehicle"
        reach = self._fields[machine].reach + person.radius + TOUCH
        row = WatchRow(self._stage.end, RESOLUTION, beyond=reach, driven=driven)
        monitor = NearnessMonitor(self._stage, bodies, change, notify, Turn.VIOLATION, row)
        watches.add(row, monitor.alarm, monitor.reconsider, machine.body)
        self._monitors.setdefault(person, []).append(monitor)

    def started(self, person: Bystander) -> None:
        """Count contacts of a person from now on."""
        for monitor in self._monitors.get(person, ()):
            monitor.reconsider()

    def _change(
        self,
        person: Bystander,
        machine: Machine,
        is_near: bool,
        walk: Motion,
        drive: Motion,
        begin: float,
        end: float,
    ) -> float | None:
        """Return when a contact begins or ends next (seconds), if one does."""
        is_vehicle = machine.shape.category == "vehicle"
        fields = self._fields[machine]
        radius = person.radius + (PARTED if is_near else TOUCH)
        if (
            person.started_at is None
            or (is_vehicle and drive.end <= begin)
            or are_apart(walk, drive, begin, fields.reach + radius)
            # Recorded people are far outside while they are away.
            or (person.away and not person.is_recorded)
        ):
            return begin if is_near else None
        spans = moving_spans(drive, begin, end, turning=True) if is_vehicle else [(begin, end)]
        if is_near:
            spans = [span for span in spans[:1] if span[0] <= begin]
        for since, until in spans:
            for one in intrusions(fields, drive, walk, radius, since, until):
                if not is_near:
                    return one.begin
                if one.begin <= begin:
                    lasts = one.end == end and (drive.end > end or not is_vehicle)
                    return None if lasts else one.end
        return begin if is_near else None

    def _changed(self, person: Bystander, machine: Machine, is_near: bool) -> None:
        if not is_near:
            return
        self.count += 1
        state, body = machine.body.state, person.body
        covered = machine.shape.footprint(state.at, state.position[2])
        at = shapely.shortest_line(covered, shapely.Point(body.at)).coords[0]
        speed = impact_speed(state, at, body.state.velocity[:2])
        self._stage.record(Contact(machine=machine.name, person=person.name, at=at, speed=speed))
        machine.touched()


@lru_cache(maxsize=256)
def _footprint_field(shape: MachineShape) -> ProtectiveFields:
    """Return the footprint as a field, in which a person is as soon as their body touches it."""
    return ProtectiveFields(sets=(FieldSet(name="footprint", protective=shape.corners),))


class Collisions:
    """Watches every two of some machines whose heights overlap."""

    def __init__(self, stage: Stage, machines: Iterable[Machine]) -> None:
        self.count = 0
        """Number of times that two machines ran into each other."""
        self._stage = stage
        for one, other in combinations(machines, 2):
            if one.shape.box.is_level_with(other.shape.box):
                change = Encroachment(one.shape, other.shape).next_change
                notify = partial(self._changed, one, other)
                NearnessMonitor(stage, (one.body, other.body), change, notify)

    def _changed(self, one: Machine, other: Machine, is_near: bool) -> None:
        if not is_near:
            return
        self.count += 1
        (vx, vy, _), (wx, wy, _) = one.body.state.velocity, other.body.state.velocity
        self._stage.record(
            Collision(machine=one.name, with_=other.name, speed=math.hypot(wx - vx, wy - vy))
        )


class Encroachment:
    """Collisions of two machines, whose outlines are made when the machines first come near."""

    def __init__(self, one: MachineShape, other: MachineShape) -> None:
        self._shapes = one, other
        self._reach = one.farthest + other.farthest

    @cached_property
    def _outer(self) -> Outlines:
        return Outlines(*(shape.footprint((0.0, 0.0), 0.0) for shape in self._shapes))

    @cached_property
    def _inner(self) -> Outlines:
        areas = (shape.footprint((0.0, 0.0), 0.0) for shape in self._shapes)
        return Outlines(*(shrunk(area, DEPTH / 2) for area in areas))

    def next_change(
        self, is_near: bool, one: Motion, other: Motion, begin: float, end: float
    ) -> float | None:
        """Return when two machines that do not collide do so, or have parted (seconds)."""
        if are_apart(one, other, begin, self._reach + PARTED):
            return begin if is_near else None
        if is_near:
            return self._outer.first_parting(one, other, begin, end, PARTED)
        if self._inner.overlap(one, other, begin):
            return begin
        return self._inner.first_contact(one, other, begin, end)
