"""Vehicles: the discs that people avoid, and waiting for a vehicle before departure."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import cached_property, lru_cache

from floorplan import Human, Point
from navigation import (
    Cylinder,
    FixedDistance,
    Motion,
    Mover,
    PathPlanner,
    PlanningError,
    Shapes,
    TooClose,
    first_time,
    plan_among,
    standing,
    violations,
)
from navigation.carried import carried
from navigation.encounter import Solid
from navigation.moving_obstacles import Passage

from ...core.body import Body, Machine, MachineShape
from ...core.clock import Alarm, Turn
from ...core.stage import Stage
from .commitments import Commitments
from .parameters import Manners
from .speed_zones import SpeedZones
from .traveller import Traveller

TOUCH = 0.1
"""Distance from a moving AGV at which a person counts as touched, m."""

TOUCHING = TooClose(FixedDistance(TOUCH))
"""Condition under which a person counts as touched."""

STRIKING = FixedDistance(1e-3)
"""Distance from a vehicle at which it strikes a person."""

KNOWN = 10.0
"""Time before an announced departure at which people avoid the vehicle, s."""

LONGEST_WAIT = 5.0
"""Time for which people wait before they set out, s. Later vehicles are not about to come."""

LEEWAY = 1e-3
"""Distance that people keep beyond `TOUCH`, m."""


class Vehicle:
    """One vehicle as discs with its announced motion, which people cannot change.

    The discs exist while the vehicle drives, or will within `KNOWN` seconds. A stationary vehicle
    is an obstacle of the collision world. `changed` is called with the discs after each change.
    """

    def __init__(
        self,
        stage: Stage,
        machine: Machine,
        commitments: Commitments,
        changed: Callable[[Sequence[Traveller]], None],
    ) -> None:
        self._clock = stage.clock
        self._machine = machine
        self._commitments = commitments
        self._changed = changed
        self._stage = stage
        self.is_there = False
        """Whether the discs are in people's way."""
        self._alarm = Alarm(stage.clock, self._look, Turn.MOTION_ENDS)
        machine.body.on_change.append(self._look)
        self._look()

    @cached_property
    def _places(self) -> list[Point]:
        """Centres of the discs relative to the vehicle's axis."""
        return cover(self._machine.shape)[0]

    @cached_property
    def _reach(self) -> float:
        """Distance from the axis of the vehicle within which all discs are, m."""
        places, radius = cover(self._machine.shape)
        return max(math.hypot(*place) for place in places) + radius + TOUCH + 2 * LEEWAY

    @cached_property
    def discs(self) -> list[Traveller]:
        """Discs that move like parts of the vehicle, made when it first drives."""
        stage, machine = self._stage, self._machine
        radius = cover(machine.shape)[1] + TOUCH + LEEWAY
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

    def _part(self, motion: Motion, place: Point) -> Motion:
        """Return the motion of a disc of the vehicle."""
        if self._machine.shape.direction is None:
            return carried(motion, *place)
        return motion.translated(*place)

    def surrounds(self, me: Traveller) -> bool:
        """Return whether a person is among the discs.

        These are larger than the vehicle, so the person may leave one and walk into a corner.
        """
        if not self.is_there:
            return False
        at = me.body.at
        return math.dist(self._machine.body.at, at) < self._reach + me.radius and any(
            math.dist(disc.body.at, at) < disc.radius + me.radius for disc in self.discs
        )

    def strikes(self, me: Traveller, motion: Motion, until: float) -> bool:
        """Return whether the vehicle strikes a person who follows `motion`, by `until` (s)."""
        now = self._clock.now
        drive = self._machine.foreseen(now + KNOWN)
        shapes = _shapes(me.human, self._machine.shape.chassis)
        until = min(until, max(motion.end, drive.end, now))
        contacts = violations(motion, drive, STRIKING, now, until, shapes=shapes)
        return any(begin > now for begin, _ in contacts)

    def _look(self) -> None:
        """Update the discs to the announced motion of the vehicle."""
        now = self._clock.now
        # Yielding vehicles announce their present drive only.
        motion = self._machine.foreseen(now + KNOWN)
        announced = self._machine.sets_out(now + KNOWN) - KNOWN
        if motion.end > now:
            for disc, place in zip(self.discs, self._places, strict=True):
                disc.body.motion = self._part(motion, place)
                self._commitments.put(disc)
            self._changed(self.discs)
            self.is_there = True
        elif self.is_there:
            for disc in self.discs:
                self._commitments.take_away(disc)
            self.is_there = False
        due = min(motion.end if motion.end > now else math.inf, announced)
        self._alarm.set(None if due == math.inf else max(due, now))


def cover(shape: MachineShape) -> tuple[list[Point], float]:
    """Return the centres of discs that cover a vehicle relative to its axis, and their radius (m).

    The axes are those of the floor if the vehicle never turns, otherwise those of its heading.
    """
    west, south, east, north = shape.bounds
    length, width = east - west, north - south
    crosswise = shape.direction is None and width > length
    long, short = (width, length) if crosswise else (length, width)
    # Discs stick out to the sides by 12 % of half the width, of one that turns by 5 %.
    count = max(1, math.ceil((2 if shape.direction else 3) * long / short))
    part = long / count
    along = [(k + 0.5) * part + (south if crosswise else west) for k in range(count)]
    middle = ((west + east) if crosswise else (south + north)) / 2
    c, s = shape.direction or (1.0, 0.0)
    places = [(middle, q) if crosswise else (q, middle) for q in along]
    return [(x * c - y * s, x * s + y * c) for x, y in places], math.hypot(part, short) / 2


def among_vehicles(
    stage: Stage,
    planner: PathPlanner,
    human: Human,
    body: Body,
    goal: tuple[float, float],
    motion: Motion,
    top: float,
    gap: float,
) -> Passage | None:
    """Return the passage of a stationary person to `goal` among vehicles, at up to `top` m/s.

    It keeps `gap` metres from their surfaces. None if no vehicle would touch the person on
    `motion`, and also if there is no passage with a wait of at most `LONGEST_WAIT`. Then the person
    starts anyway, and steps aside when the vehicle comes.
    """
    if not any_touches(stage, human, motion):
        return None
    now = stage.clock.now
    try:
        return plan_among(
            planner,
            body.at,
            goal,
            _moving(stage, now, motion.end),
            at=now,
            heading=body.state.position[2],
            max_speed=top,
            max_acceleration=human.max_acceleration,
            height=human.height,
            gap=gap,
            patience=LONGEST_WAIT,
        )
    except PlanningError:
        return None


def any_touches(stage: Stage, human: Human, motion: Motion) -> bool:
    """Return whether a vehicle touches a person on `motion`.

    Vehicles count that drive now, or whose start before the arrival is announced.
    """
    now = stage.clock.now
    return any(_touches(mover, motion, human, now) for mover in _moving(stage, now, motion.end))


def any_moves(stage: Stage, until: float) -> bool:
    """Return whether a vehicle drives now, or will start by `until` (s)."""
    now = stage.clock.now
    return any(machine.foreseen(until).end > now for machine in stage.vehicles)


def _moving(stage: Stage, now: float, until: float) -> list[Mover]:
    """Return the vehicles that drive now, or will start by `until` (s)."""
    motions = ((machine, machine.foreseen(until)) for machine in stage.vehicles)
    return [_mover(machine, motion) for machine, motion in motions if motion.end > now]


def _mover(machine: Machine, motion: Motion) -> Mover:
    return Mover(machine.name, motion, machine.shape.chassis)


def _touches(mover: Mover, motion: Motion, human: Human, now: float) -> bool:
    shapes = _shapes(human, mover.solid)
    return first_time(TOUCHING, motion, mover.motion, now, motion.end, shapes=shapes) is not None


@lru_cache
def _shapes(human: Human, vehicle: Solid) -> Shapes:
    """Return the solids of a person and of a vehicle."""
    return Shapes(person=Cylinder(radius=human.radius, top=human.height), machine=(vehicle,))
