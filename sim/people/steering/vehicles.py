"""Vehicles as people among people see them: discs that cover one that drives, or is about to."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import cached_property

from floorplan import Point
from navigation import Motion, Piece, standing

from ...core.body import Body, Machine, MachineShape
from ...core.clock import Alarm, Turn
from ...core.stage import Stage
from .manners import Manners
from .speed_zones import SpeedZones
from .traveller import Traveller
from .vehicle_conflicts import GAP
from .whereabouts import Whereabouts

KNOWN = 10.0
"""Seconds before a vehicle sets out as announced at which people reckon with it."""

LEEWAY = 1e-3
"""Metres. Farther than counts as touched people keep from a vehicle that drives."""


class Vehicle:
    """One vehicle, as its known motion and final standing: as fixed as that of a recorded person.

    It is there while it drives, or will within `KNOWN` seconds; one that stands is an obstacle of
    the collision world. `changed` is called with its discs whenever it is to do something else.
    """

    def __init__(
        self,
        stage: Stage,
        machine: Machine,
        whereabouts: Whereabouts,
        changed: Callable[[Sequence[Traveller]], None],
    ) -> None:
        self._clock = stage.clock
        self._machine = machine
        self._whereabouts = whereabouts
        self._changed = changed
        self._stage = stage
        self.is_there = False
        """Whether the discs are in people's way."""
        self._alarm = Alarm(stage.clock, self._look, Turn.MOTION_ENDS)
        machine.body.on_change.append(self._look)
        self._look()

    @cached_property
    def _places(self) -> list[Point]:
        """The middles of the discs, from the vehicle's axis."""
        return cover(self._machine.shape)[0]

    @cached_property
    def discs(self) -> list[Traveller]:
        """Those who move like the vehicle's parts; most vehicles never drive."""
        stage, machine = self._stage, self._machine
        radius = cover(machine.shape)[1] + GAP + LEEWAY
        size, manners = replace(stage.floorplan.human, radius=radius), Manners(steps_aside=False)
        rests, zones = standing(machine.body.at), SpeedZones((), machine.name)
        return [
            Traveller(
                -1,
                Body(stage.clock, machine.name, machine.shape.kind, rests),
                size,
                manners,
                stage.world,
                zones,
                recorded=True,
                is_vehicle=True,
            )
            for _ in self._places
        ]

    def _look(self) -> None:
        """Take note of what the vehicle does from now on, as far as that is known."""
        now = self._clock.now
        # What is announced, as people know the plan; one that yields to them counts as it drives
        # now.
        motion = self._machine.foreseen(now + KNOWN)
        announced = self._machine.sets_out(now + KNOWN) - KNOWN
        if motion.end > now:
            for disc, place in zip(self.discs, self._places, strict=True):
                disc.body.motion = _shifted(motion, place)
                self._whereabouts.put(disc)
            self._changed(self.discs)
            self.is_there = True
        elif self.is_there:
            for disc in self.discs:
                self._whereabouts.take_away(disc)
            self.is_there = False
        due = min(motion.end if motion.end > now else math.inf, announced)
        self._alarm.set(None if due == math.inf else max(due, now))


def cover(shape: MachineShape) -> tuple[list[Point], float]:
    """Return the middles of discs that cover a vehicle, from its axis, and their radius (metres).

    One that turns is covered by a single disc.
    """
    if shape.direction is None:
        return [(0.0, 0.0)], math.hypot(shape.length, shape.width) / 2
    # Parts half as long as wide: discs then stick out to the sides by 12 % of half the width.
    count = max(1, math.ceil(2 * shape.length / shape.width))
    part, (c, s) = shape.length / count, shape.direction
    along = [(k + 0.5) * part - shape.length / 2 for k in range(count)]
    return [(q * c, q * s) for q in along], math.hypot(part, shape.width) / 2


def _shifted(motion: Motion, by: Point) -> Motion:
    """Return a motion so far to the side of another, metres."""

    def piece(one: Piece) -> Piece:
        x, y = (one.x[0] + by[0], *one.x[1:]), (one.y[0] + by[1], *one.y[1:])
        return one._replace(x=x, y=y)

    return Motion(tuple(map(piece, motion.pieces)), motion.jumps)
