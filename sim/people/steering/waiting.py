"""Waiting: somebody whom others keep from going on, and how that ends without them."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field

from floorplan import Point
from navigation.walking import Swath

from ...core.clock import Alarm
from .course import length_of
from .detour import AROUND
from .outlook import Outlook
from .traveller import AT_THE_DOOR, Traveller
from .whereabouts import Hit, Whereabouts

PAUSE, LONGEST = 1.0, 8.0
"""Seconds until somebody who waits looks again for a way round what has not changed: at first, and
at most, as each pause is twice as long as the one before."""

APART = 0.5
"""Seconds between two decisions of a person, so that they change course twice in one at most."""

IN_REACH = 1.25
"""Metres. Whoever is kept from a goal so near by somebody who is at it has arrived."""

BESIDE = 6.0
"""Metres. Whoever is kept from a goal so near by those who stand around it has arrived."""


@dataclass(eq=False)
class Party:
    """A traveller in the crowd: how their path is planned, and whom they wait for."""

    me: Traveller
    reroute: Callable[[Point], list[Point]]
    arrive: Callable[[], None]
    blocked: Callable[[], None]
    deciding: Alarm
    arriving: Alarm
    waits_for: Party | None = None
    kept: dict[Party, None] = field(default_factory=dict)
    """Those who wait for them."""
    looked: float = -math.inf
    """When they last looked whether they can go on, seconds."""
    rounded: float = -math.inf
    """When they last looked for a path round those who stand, seconds."""
    tries_again: float = 0.0
    """When they look again though it is still the same, seconds."""
    pause: float = 0.0
    """How long they have paused until then, seconds."""
    said: bool = False

    def pause_longer(self, now: float) -> None:
        """Look again for a way round after a pause, twice as long as the one before."""
        self.pause = min(2 * self.pause, LONGEST) if self.pause else PAUSE
        self.tries_again = now + self.pause

    def goes_on(self, now: float) -> None:
        """Take note that they are not kept from going on any more."""
        me = self.me
        if me.stands_since is not None:
            me.lost += now - me.stands_since
        self.wait_for(None)
        me.stands_since, self.said = None, False
        self.tries_again, self.pause = 0.0, 0.0

    def wait_for(self, other: Party | None) -> None:
        """Take note of whom they wait for."""
        if self.waits_for is not other:
            if self.waits_for is not None:
                del self.waits_for.kept[self]
            self.waits_for = other
            if other is not None:
                other.kept[self] = None

    def behind(self) -> set[Traveller]:
        """Return those who wait for them, and for those, but none whom they wait for in turn.

        Those as well once they have lost patience: who waits for each other gains by any way out.
        """
        found, left = set[Party](), [*self.kept]
        while left:
            party = left.pop()
            if party not in found:
                found.add(party)
                left += party.kept
        ahead = None if self.said else self.waits_for
        while ahead is not None and ahead in found:
            found.discard(ahead)
            ahead = ahead.waits_for
        return {party.me for party in found}


def takes_way_round(me: Traveller, outlook: Outlook, stood: float) -> bool:
    """Take a path round those who stand, if it is worth the wait; return whether it is.

    They have `stood` so long already, seconds.
    """
    goal = me.goal
    assert goal is not None
    ground, standing = outlook.ground, outlook.standing(AROUND, outlook.at, goal)
    path = ground.detours.path(outlook.at, goal, standing, ground.legs)
    # Worth it if it is longer by no more than they would have walked while they stood, and in a
    # pause more: the longer they stand, the longer a way round they take.
    if not path or length_of(path) > outlook.whole + me.top_speed * (stood + LONGEST):
        return False
    me.goes_round = True
    outlook.send_by(path[1:])
    return True


def is_beside_goal(me: Traveller, hit: Hit, floor: Whereabouts, now: float) -> bool:
    """Return whether who keeps somebody from their goal is one of those around it.

    These are who is on the goal, or about to be; who is as near to it as `me`, who stands in
    reach of it; and farther away who stands so close to one of them that nobody gets through
    between the two: around the goal, a ring grows from neighbour to neighbour.
    """
    here, goal, other = me.swath.place, me.goal, hit.other
    assert goal is not None
    if other.is_vehicle:
        return False
    leaves = goal == me.leaves_at
    if math.dist(here, goal) < (AT_THE_DOOR if leaves else IN_REACH):
        return math.dist(other.body.at, goal) < IN_REACH + me.radius
    if leaves or math.dist(here, goal) >= BESIDE or not hit.at_rest or other.body.motion.end > now:
        return False
    indices = floor.indices
    return floor.throng.encloses(indices[me], indices[other], *goal, BESIDE, now)


def is_no_nearer(me: Traveller, hit: Hit, ahead: Swath, floor: Whereabouts, now: float) -> bool:
    """Return whether somebody whom others keep from their goal would go `ahead` in vain.

    They stand beside the goal, as those do who keep them from it, and would end no nearer to it:
    then they would come back, to set out again, and never arrive.
    """
    goal = me.goal
    assert goal is not None
    return (
        hit.at_rest
        and me.body.motion.end <= now
        and math.dist(ahead.place, goal) >= math.dist(me.body.at, goal)
        and is_beside_goal(me, hit, floor, now)
    )
