"""State of one person in the crowd."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import field

from floorplan import Human, Point
from floorplan.files.dataclass import dataclass
from navigation import CollisionWorld, Motion
from navigation.kernels.discs import Swath
from navigation.walking import swath, swath_along

from ...core.body import Body
from ...core.clock import Alarm
from .parameters import PARAMETERS, Manners
from .speed_zones import SpeedZones

AT_THE_DOOR = PARAMETERS.at_the_door


@dataclass(eq=False)
class Traveller:
    """One person in the crowd, or one disc of a vehicle.

    A `recorded` person walks as measured and gives way to no other person, and so does each part
    of a vehicle. The crowd sets the callbacks and alarms of the others when they `enter`.
    """

    index: int
    """Place among all people."""
    body: Body
    human: Human
    manners: Manners
    world: CollisionWorld
    zones: SpeedZones
    recorded: bool = False
    is_vehicle: bool = False

    goal: Point | None = None
    route: list[Point] = field(default_factory=list)
    """Waypoints from `routed_from` to the goal."""
    routed_from: Point = (0.0, 0.0)
    routed: float = -math.inf
    """Time at which the route began at the position of the person, s."""
    goes_round: bool = False
    """Whether the route is a detour around stationary people."""
    leaves_at: Point | None = None
    """Where the person leaves the floor, if anywhere. People queue there."""
    since: float = 0.0
    """Time of departure for this goal, s."""
    top_speed: float = field(init=False)
    """Top speed of the current errand, m/s."""
    name: str = field(init=False)
    radius: float = field(init=False)
    """Radius of the body, m."""

    reroute: Callable[[Point], list[Point]] = field(init=False)
    """Plans the route from a position."""
    arrive: Callable[[], None] = field(init=False)
    """Called on arrival."""
    blocked: Callable[[], None] = field(init=False)
    """Called when the person has been blocked for as long as their patience."""
    deciding: Alarm = field(init=False)
    """Alarm of the next decision."""
    arriving: Alarm = field(init=False)
    """Alarm of the arrival."""
    stepping: Alarm = field(init=False)
    """Alarm before a vehicle comes."""

    decided: float = -math.inf
    """Time of the last change of motion, s."""
    looked: float = -math.inf
    """Time of the last decision, s."""
    stepped: float = -math.inf
    """Time at which the person last looked for a place off the course of a vehicle, s."""
    rounded: float = -math.inf
    """Time of the last detour, s."""
    nearest: float = math.inf
    """Length of the shortest course at a decision for this goal, m."""
    neared: float = -math.inf
    """Time since which the person has walked without coming nearer, s."""

    stands_since: float | None = None
    """Time since which others have blocked the person, s."""
    lost: float = 0.0
    """Time lost to others before that, s."""
    waits_for: Traveller | None = None
    kept: dict[Traveller, None] = field(default_factory=dict)
    """People who wait for this person."""
    tries_again: float = 0.0
    """End of the pause between two searches, s."""
    pause: float = 0.0
    """Length of that pause, s."""
    said: bool = False
    """Whether the person has perceived `blocked`."""

    def __post_init__(self) -> None:
        self.top_speed = self.human.max_speed
        self.name, self.radius = self.body.name, self.human.radius
        self._of: Motion | None = None
        self._swath: Swath | None = None

    def __repr__(self) -> str:
        return f"<Traveller {self.name} to {self.goal}>"

    @property
    def swath(self) -> Swath:
        """Floor area of the committed motion."""
        motion = self.body.motion
        if self._swath is None or self._of is not motion:
            self._of, self._swath = motion, swath(motion, self.body.clock.now)
        return self._swath

    def follow(self, motion: Motion, ahead: Swath | None) -> None:
        """Follow `motion`, with the swath `ahead` if it is known, from now on."""
        self._of, self._swath = motion, ahead
        self.body.follow(motion)

    def draft(self, course: Sequence[Point], now: float, lead: Swath | None = None) -> Swath | None:
        """Return the swath of a walk from rest along a course, or None if it is impossible.

        It follows on `lead`, if there is one.
        """
        top: float | list[float] = self.top_speed
        if self.zones:
            course, top = self.zones.along(course, self.top_speed)
        return swath_along(
            course,
            now if lead is None else lead.rests,
            top_speed=top,
            max_speed=self.human.max_speed,
            max_acceleration=self.human.max_acceleration,
            lead=lead,
            since=now,
        )

    @property
    def rank(self) -> tuple[bool, float, int]:
        """Priority: people with lower values go first.

        People with a goal precede people at rest, and earlier departures precede later ones. The
        rank does not change between departure and arrival. Recorded people precede all others.
        """
        if self.recorded:
            return (False, -math.inf, self.index)
        return (self.goal is None, self.since, self.index)

    @property
    def usual_side(self) -> float:
        """Preferred passing side: 1 for the left, -1 for the right."""
        return -1.0 if self.manners.passing_side == "right" else 1.0

    def time_lost(self, now: float) -> float:
        """Return the time lost to others until now, s."""
        return self.lost + self.time_blocked(now)

    def time_blocked(self, now: float) -> float:
        """Return the time for which the person has been blocked, s."""
        return 0.0 if self.stands_since is None else now - self.stands_since

    def stands(self, now: float) -> bool:
        """Return whether the motion ends within 0.3 s."""
        return self.swath.rests <= now + 0.3

    def note_course(self, length: float, now: float) -> None:
        """Note the length of the course at a decision, m."""
        if length < self.nearest - PARAMETERS.nearer or self.stands_since is not None:
            self.nearest, self.neared = length, now

    def strays(self, now: float) -> bool:
        """Return whether the person walks on and on without coming nearer to the goal."""
        return now - self.neared >= PARAMETERS.strays

    def pause_longer(self, now: float) -> None:
        """Start a pause before the next search, twice as long as the last."""
        longest = PARAMETERS.longest_pause
        self.pause = min(2 * self.pause, longest) if self.pause else PARAMETERS.pause
        self.tries_again = now + self.pause

    def continues(self, now: float) -> None:
        """End the state of being blocked."""
        if self.stands_since is not None:
            self.lost += now - self.stands_since
        self.wait_for(None)
        self.stands_since, self.said = None, False
        self.tries_again, self.pause = 0.0, 0.0

    def wait_for(self, other: Traveller | None) -> None:
        """Set the person who blocks this one."""
        if self.waits_for is not other:
            if self.waits_for is not None:
                del self.waits_for.kept[self]
            self.waits_for = other
            if other is not None:
                other.kept[self] = None

    def behind(self) -> set[Traveller]:
        """Return the people who wait for this person, directly or through others.

        People for whom this person waits in turn are excluded until patience runs out, because
        both sides of a circle profit from any way out.
        """
        behind, left = set[Traveller](), [*self.kept]
        while left:
            one = left.pop()
            if one not in behind:
                behind.add(one)
                left += one.kept
        ahead = None if self.said else self.waits_for
        while ahead is not None and ahead in behind:
            behind.discard(ahead)
            ahead = ahead.waits_for
        return behind
