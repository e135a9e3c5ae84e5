"""Bodies and machines: their motions, planned motions, shapes, and the machine interface."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from bisect import bisect_left, bisect_right
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import Any, Literal, get_args

from shapely.geometry import Polygon

from floorplan import Point, rectangle
from navigation import Box, CollisionWorld, Motion, Moving, first_time
from navigation.motion import State, Track
from navigation.walking import leg_to

from .clock import Clock, InProgress


class Plans:
    """The motions that a body set out on. A track has only what came of them.

    A law that looks ahead asks for what somebody is about to do.
    """

    def __init__(self, since: float, motion: Motion) -> None:
        self.changes = [since]
        """Instants (seconds) from which on it was about to do each of them."""
        self._motions = [motion]

    def add(self, t: float, motion: Motion) -> None:
        """Add `motion` as its plan from `t` (seconds) on."""
        self.changes.append(t)
        self._motions.append(motion)

    def at(self, t: float) -> Motion:
        """Return its plan from `t` (seconds) on."""
        return self._motions[max(0, bisect_right(self.changes, t) - 1)]

    def before(self, t: float) -> Motion:
        """Return its plan just before `t` (seconds)."""
        return self._motions[max(0, bisect_left(self.changes, t) - 1)]


JUMP = 1e-6
"""Metres. A body that is further than this from where it was has been put there."""

PERSON = "person"
"""The kind of a body that is a person's; that of a machine's is the machine's."""


class Body(InProgress):
    """Something that moves, with its present motion and the track of those before."""

    def __init__(self, clock: Clock, name: str, kind: str, motion: Motion) -> None:
        self.name = name
        self.kind = kind
        self.motion = motion
        self.on_change: list[Callable[[], None]] = []
        self.on_jump: list[Callable[[], None]] = []
        self.on_record: Callable[[Body, Motion], None] | None = None
        self.clock = clock
        self._track = Track()
        self._since = clock.now
        self._turned = clock.now
        """When it was last asked on which leg it came, seconds."""
        self._leg = (0.0, 0.0)
        """That leg, metres."""

    def __repr__(self) -> str:
        return f"<{self.kind} {self.name}>"

    @property
    def state(self) -> State:
        """Pose and velocity now."""
        return self.motion.state(self.clock.now)

    @property
    def at(self) -> tuple[float, float]:
        """Position now: x, y in metres."""
        return self.state.at

    @property
    def leg(self) -> tuple[float, float]:
        """The straight leg on which a person comes to where they are now: see `leg_to`.

        However often their course changes at one instant, it is the leg before all of that.
        """
        now = self.clock.now
        if now != self._turned:
            self._leg = leg_to(self.motion, self._turned, now, self._leg)
            self._turned = now
        return self._leg

    def follow(self, motion: Motion) -> None:
        """Follow `motion` from now on, in place of the motion before it.

        `on_jump` is called where the body is put elsewhere by it, `on_change` in any case.
        """
        self.settle()
        # Settled first: what was carried out until now belongs to the old motion.
        now = self.clock.now
        before, after = self.motion.state(now).position, motion.state(now).position
        if self.kind == PERSON:
            _ = self.leg  # what leads here belongs to the old motion as well
        self.motion = motion
        if before != after and math.dist(before[:2], after[:2]) > JUMP:
            self._leg = (0.0, 0.0)
            for jumped in self.on_jump:
                jumped()
        for changed in self.on_change:
            changed()

    def settle(self) -> None:
        """Add the motion carried out until now to the track."""
        now = self.clock.now
        if now > self._since:
            since, self._since = self._since, now
            self._track.add(self.motion, since, now)
            if self.on_record is not None:
                self.on_record(self, self.motion.cut(since, now))

    def track(self) -> Motion:
        """Return all that it did so far, as one motion (it jumps where it was put elsewhere)."""
        self.settle()
        return self._track.motion() if self._track else self.motion

    def remember_plans(self) -> Plans:
        """Return its plans, kept from now on: the motion it set out on at every instant."""
        plans = Plans(self.clock.now, self.motion)
        self.on_change.append(lambda: plans.add(self.clock.now, self.motion))
        return plans


Category = Literal["robot", "vehicle"]
"""A robot works above people's heads or behind its own range, and is watched at all times. A
vehicle drives on the floor, where it can block people's paths, and is watched while it moves."""


ROUNDING = 1e-6
"""Share of a top speed, and m/s. A machine that is faster by no more is not too fast."""


@dataclass(frozen=True, kw_only=True)
class MachineShape:
    """A machine as others see it; lengths in metres, speeds in m/s, heights above the floor.

    Its box, `length` along its heading and `width` across, stands around its axis. `reach` is the
    radius of a circle around the axis that a folded arm stays within, `mount` metres ahead of it.
    `course` are the points of the line on which it moves, if there is one, and `direction` the
    unit vector along which it looks at all times, if it never turns.
    """

    name: str
    kind: str
    category: Category
    length: float
    width: float
    bottom: float = 0.0
    top: float
    top_speed: float
    reach: float = 0.0
    mount: float = 0.0
    course: tuple[Point, ...] = ()
    direction: Point | None = None

    def __post_init__(self) -> None:
        if self.category not in get_args(Category):
            known = " or ".join(get_args(Category))
            raise ValueError(f"the category of a machine is {known}, not {self.category!r}")

    @cached_property
    def box(self) -> Box:
        """The solid around its axis."""
        return Box(length=self.length, width=self.width, bottom=self.bottom, top=self.top)

    def too_fast(self, motion: Motion, now: float) -> float | None:
        """Return when a motion of it is first faster than its top speed, from `now` on (seconds).

        None if it never is.
        """
        too_fast = Moving(self.top_speed * (1 + ROUNDING) + ROUNDING)
        return first_time(too_fast, motion, motion, now, max(now, motion.end))

    def footprint(self, at: Point, rotation: float) -> Polygon:
        """Return the rectangle that it covers at `at` (x, y), turned by `rotation` (radians)."""
        direction = (math.cos(rotation), math.sin(rotation))
        return rectangle(at, direction, self.length, self.width)


class Machine(InProgress, ABC):
    """A machine while a trial runs; a kind of machine is a subclass.

    `shape` is what others know of it, `body` where it is and how it moves.
    """

    shape: MachineShape
    body: Body
    _stands_for: frozenset[str] = frozenset()

    @property
    def name(self) -> str:
        """The name by which the trial, events and figures call it."""
        return self.shape.name

    def begin(self) -> None:
        """Begin to act: the trial starts."""

    @abstractmethod
    def hold(self, stands: bool) -> None:
        """Brake and stand until `hold(False)`, then go on: a protective stop."""

    def stand_for(self, reason: str, stands: bool) -> None:
        """Hold the machine for a `reason`, or no longer; it goes on once there is none left."""
        before = self._stands_for
        self._stands_for = before | {reason} if stands else before - {reason}
        if bool(before) != bool(self._stands_for):
            self.hold(stands)

    def disable(self, seconds: float) -> None:
        """Brake and stand for so long: a penalty, which only robots get."""

    def floor_changed(self) -> None:
        """Take note that a machine has come to rest, or that a place has opened or closed."""

    def sight_changed(self) -> None:
        """Take note that it sees people no longer, or again."""

    def look_out_for(self, person: Body, top_speed: float) -> None:
        """Take note of a person, who walks at `top_speed` (m/s) at most."""

    def foreseen(self, until: float) -> Motion:
        """Return its motion as anybody may know it now, with all that begins by `until` (s)."""
        return self.body.motion

    def sets_out(self, after: float) -> float:
        """Return when it is known to set out next, later than `after` (s); infinite if never."""
        return math.inf

    def stand_in(self, world: CollisionWorld) -> None:
        """Put a vehicle into `world` where it is now; what works above the floor is not in it."""
        if self.shape.category == "vehicle":
            x, y, rotation = self.body.state.position
            footprint = self.shape.footprint((x, y), rotation)
            world.place(self.name, footprint, self.shape.bottom, self.shape.top)

    @property
    def centre(self) -> Point:
        """The point (x, y) from which `zone` is measured."""
        return self.body.at

    def zone(self, top_speed: float) -> float:
        """Return how far (metres) somebody has to stand from it so that it sets out.

        For somebody who may walk at `top_speed` (m/s).
        """
        return math.hypot(self.shape.length, self.shape.width) / 2

    def close(self) -> None:
        """Settle what is still open: the trial is over."""

    def figures(self, motion: Motion, now: float) -> dict[str, Any]:
        """Return what belongs into the summary about it alone; `motion` is all that it did."""
        return {}
