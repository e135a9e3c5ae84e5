"""Bodies: people, the gantry and AGVs as things that are somewhere and move."""

from __future__ import annotations

import math
from collections.abc import Callable

from navigation import Motion, State, Track, leg_to

from .clock import Clock
from .plans import Plans

JUMP = 1e-6
"""Metres. A body that is further than this from where it was has been put there."""

PERSON = "person"
"""The kind of a body that is a person's; that of a machine's is the machine's."""


class Body:
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
