"""Waiting: somebody whom others keep from going on, and how that ends without them."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field

from floorplan import Point
from navigation import Motion
from navigation.walking import Swath

from ...core.clock import Alarm
from .course import length_of
from .detour import AROUND
from .outlook import Outlook
from .traveller import AT_THE_DOOR, Traveller
from .whereabouts import Hit, Sight, Whereabouts

PAUSE, LONGEST = 1.0, 8.0
"""Seconds until somebody who waits looks again for a way round what has not changed: at first, and
at most, as each pause is twice as long as the one before."""

AFRESH = 8.0
"""Seconds until somebody looks anew though everybody around stands where they stood: at first, as
each time is twice as long as the one before."""

APART = 0.5
"""Seconds between two decisions of a person, so that they change course twice in one at most."""

NOWHERE = 8.0
"""Seconds after which somebody who walks to and fro, and gets no nearer, looks for another path."""

NEARER = 0.3
"""Metres. Less than this is no nearer."""

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
    weighed: float = -math.inf
    """When they last weighed other courses, seconds."""
    waits_on: Motion | None = None
    """The motion of whom they wait for, when they last looked for a way round it."""
    tries_again: float = 0.0
    """When they look again though it is still the same, seconds."""
    pause: float = 0.0
    """How long they have paused until then, seconds."""
    search: float = 0.0
    """How long they have asked with little effort until they look at all that others could do."""
    searches_again: float = 0.0
    """When they look at all of that again, seconds."""
    sight: Sight | None = None
    """All that they saw when they last looked for a way round, where all of it stood."""
    afresh: float = AFRESH
    """How long they go on waiting without a look while it is still the same, seconds."""
    said: bool = False
    least_left: float = math.inf
    """The least that was left of their path to the goal, metres."""
    least_since: float = 0.0
    """When that was, seconds."""

    def waits_on_the_same(self, hit: Hit, now: float) -> bool:
        """Return whether nothing has changed for somebody who waits since they last looked."""
        return (
            self.waits_for is not None
            and hit.other is self.waits_for.me
            and hit.other.body.motion is self.waits_on
            and self.me.body.motion.end <= now
            and now < max(self.tries_again, self.weighed + APART)
        )

    def waits_unchanged(self, now: float) -> bool:
        """Return whether they wait for somebody who goes on as they did, and pause meanwhile."""
        other = self.waits_for
        return (
            other is not None and other.me.body.motion is self.waits_on and now < self.tries_again
        )

    def note_progress(self, left: float, now: float) -> float:
        """Take note of it; return for how long they have walked without any, seconds.

        `left` is what is left of their path, metres. Who waits does not count, and it begins anew
        with each answer.
        """
        since = self.least_since
        if self.me.stands_since is not None or left < self.least_left - NEARER:
            self.least_left, self.least_since = min(left, self.least_left), now
            return 0.0
        if now - since < NOWHERE:
            return 0.0
        self.least_left, self.least_since = left, now
        return now - since

    def pause_longer(self, now: float) -> None:
        """Look again for a way round after a pause, twice as long as the one before."""
        self.pause = min(2 * self.pause, LONGEST) if self.pause else PAUSE
        self.tries_again = now + self.pause

    def begin_search(self, now: float) -> bool:
        """Begin to look at what others could do if the pause is over; return whether it is."""
        if self.pause < LONGEST or now < self.searches_again:
            return False
        self.search = 2 * self.search if self.search else 2 * LONGEST
        self.searches_again = now + self.search
        return True

    def goes_on(self, now: float) -> None:
        """Take note that they are not kept from going on any more."""
        me = self.me
        if me.stands_since is not None:
            me.lost += now - me.stands_since
        self.wait_for(None)
        me.stands_since, self.said, self.sight = None, False, None
        self.waits_on, self.tries_again, self.pause, self.afresh = None, 0.0, 0.0, AFRESH
        self.search = self.searches_again = 0.0

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
