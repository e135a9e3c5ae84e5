"""A person under way among people: what they have committed themselves to, and where they go."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field

from floorplan import Human, Point
from navigation import CollisionWorld, Motion
from navigation.walking import Swath, swath

from ...core.body import Body
from .manners import Manners
from .speed_zones import SpeedZones

AT_THE_DOOR = 1.0
"""Metres. So near to it people come in where they come in, and leave where they leave."""


@dataclass(eq=False)
class Traveller:
    """One person on the floor among others.

    `goal` is where they walk to, if anywhere, `route` the points that lead there from where they
    are; `since` is when they set out (seconds), `index` their place among all people.
    `top_speed` is that of the errand they are on, in m/s; before the first it is the most they can.
    They walk in `world`, and keep to the limits of `zones`.
    Somebody who is `recorded` walks as they were measured, and gives way to nobody; the same is
    true of a part of a vehicle.
    """

    index: int
    body: Body
    human: Human
    manners: Manners
    world: CollisionWorld
    zones: SpeedZones
    recorded: bool = False
    is_vehicle: bool = False
    goal: Point | None = None
    route: list[Point] = field(default_factory=list)
    goes_round: bool = False
    """Whether the route leads round those who stand."""
    leaves_at: Point | None = None
    """Where they leave the floor, if anywhere: there they queue."""
    since: float = 0.0
    top_speed: float = field(init=False)
    name: str = field(init=False)
    """Their name."""
    radius: float = field(init=False)
    """The radius of their body, metres."""
    decided: float = -math.inf
    """Instant of their last change of course, seconds."""
    stands_since: float | None = None
    """Instant since which they are kept from going on, seconds."""
    lost: float = 0.0
    """Seconds that others have cost them."""

    def __post_init__(self) -> None:
        self.top_speed = self.human.max_speed
        self.name, self.radius = self.body.name, self.human.radius
        self._of: Motion | None = None
        self._swath: Swath | None = None

    def __repr__(self) -> str:
        return f"<Traveller {self.name} to {self.goal}>"

    @property
    def swath(self) -> Swath:
        """The floor that they have committed themselves to from some instant until now on."""
        motion = self.body.motion
        if self._swath is None or self._of is not motion:
            self._of, self._swath = motion, swath(motion, self.body.clock.now)
        return self._swath

    def follow(self, motion: Motion, ahead: Swath) -> None:
        """Follow `motion` from now on, which goes `ahead`."""
        self._of, self._swath = motion, ahead
        self.body.follow(motion)

    def draft(self, course: Sequence[Point], now: float, delay: float = 0.0) -> Swath | None:
        """Return where they would go who stand, along a course, `delay` seconds from now on.

        None where they can't.
        """
        top: float | list[float] = self.top_speed
        if self.zones:
            course, top = self.zones.along(course, self.top_speed)
        return Swath.along(
            course,
            now + delay,
            top_speed=top,
            max_speed=self.human.max_speed,
            max_acceleration=self.human.max_acceleration,
            since=now,
        )

    @property
    def rank(self) -> tuple[bool, float, int]:
        """Their place in the order in which people give way: the least goes first.

        Who walks goes before who rests, who set out earlier before who set out later; whoever has
        just arrived comes last with their next errand. It is fixed while somebody is under way.
        Everybody gives way to who is recorded.
        """
        if self.recorded:
            return (False, -math.inf, self.index)
        return (self.goal is None, self.since, self.index)

    @property
    def usual_side(self) -> float:
        """The side on which they pass: 1 for the left, -1 for the right."""
        return -1.0 if self.manners.passing_side == "right" else 1.0

    def time_lost(self, now: float) -> float:
        """Return the seconds that others have cost them until now."""
        return self.lost + self.time_blocked(now)

    def time_blocked(self, now: float) -> float:
        """Return the seconds for which they have been kept from going on."""
        return 0.0 if self.stands_since is None else now - self.stands_since

    def stands(self, now: float) -> bool:
        """Return whether their motion is over, or all but."""
        return self.swath.rests <= now + 0.3
