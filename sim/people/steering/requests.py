"""Requests to step aside: somebody who is stuck asks those in the way, and they ask on."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from itertools import pairwise

from floorplan import Point
from navigation import Swath, first_conflict, pace, touches

from .course import first, length_of, rest
from .outlook import GAP, STEP, Among, Ground, Others, Outlook
from .traveller import Traveller

DEEPEST = 4
"""People ask on along a chain of so many."""

MOST = 12
"""At most so many people move for one request."""

TRIES = 200
"""At most so many courses are tried for one request."""

RINGS = (0.3, 0.5, 0.7, 1.0, 1.4, 2.0, 2.8)
"""Metres. So far people look around them for a place to step aside to."""

ANGLES = 16

AROUND = [
    (r * math.cos(2 * math.pi * k / ANGLES), r * math.sin(2 * math.pi * k / ANGLES))
    for r in RINGS
    for k in range(ANGLES)
]
"""Metres. The places around them, the nearest first."""

WIDE = 6
"""Places that one person tries."""

PASSED = 1.0
"""Metres. So far beyond the one in the way whoever asks wants to get."""

WAITS = (0.0, 0.5, 1.0, 2.0, 4.0)
"""Seconds that whoever asks waits for the others to be out of the way."""


class Request:
    """One request of `asker`, and what comes of it: where all go who move for it.

    Depth first: each asked looks for the nearest place off the way of whoever asks, else ahead of
    them, and asks those who stand in the way of that step. Nobody is asked who ranks higher than
    the first asker, or who moves: passages that are agreed stay so. All of it is checked together.
    """

    def __init__(
        self,
        asker: Traveller,
        now: float,
        among: Among,
        ground_of: Callable[[Traveller], Ground],
    ) -> None:
        self._asker = asker
        self._now = now
        self._among = among
        self._ground_of = ground_of
        self._left = TRIES
        self.drafts: dict[Traveller, Swath] = {}
        """Where everybody goes who moves for it."""

    def succeeds(self, outlook: Outlook, passed: float) -> bool:
        """Return whether all can move so that the asker gets past `passed` metres of its course."""
        whole = length_of(outlook.course)
        near = min(outlook.stop_beyond(passed + PASSED), whole)
        far = outlook.stop_beyond(outlook.reach)
        for length in dict.fromkeys((near, far)):
            course = first(outlook.course, length)
            for wait in WAITS:
                draft = outlook.draft(course, delay=wait)
                if draft is None:
                    continue
                self.drafts = {self._asker: draft}
                if self._clear(self._asker, course, 0):
                    return True
        return False

    def make_way(self, course: Sequence[Point]) -> None:
        """Let all who can step off the motion that the asker is committed to, along `course`."""
        self.drafts = {self._asker: self._asker.swath}
        self._clear(self._asker, course, 0)

    def _clear(self, mover: Traveller, course: Sequence[Point], depth: int) -> bool:
        """Let all step aside who stand in the way of `mover`; return whether they can."""
        draft = self.drafts[mover]
        near = self._among(mover, draft.box)
        while True:
            others = Others(mover, [one for one in near if one not in self.drafts], self._now)
            hit = others.first_hit(draft)
            if hit is None:
                return True
            if depth >= DEEPEST or len(self.drafts) > MOST or not self._may_ask(hit.other):
                return False
            if not self._step(hit.other, course, depth):
                return False

    def _may_ask(self, other: Traveller) -> bool:
        return (
            other is not self._asker
            and other.manners.steps_aside
            and not other.recorded
            and other.body.motion.end <= self._now
            and other.rank > self._asker.rank
        )

    def _step(self, who: Traveller, course: Sequence[Point], depth: int) -> bool:
        """Let `who` step off `course`, and whoever is in the way of that; else leave all as is."""
        before = dict(self.drafts)
        tried = 0
        for retreat in self._retreats(who, course):
            self._left -= 1
            if self._left < 0 or tried >= WIDE:
                break
            points, top = who.zones.along(retreat, who.top_speed)
            draft = pace(
                points,
                self._now,
                top_speed=top,
                max_speed=who.human.max_speed,
                max_acceleration=who.human.max_acceleration,
            )
            if draft is None:
                continue
            if not self._meets(who, draft, before):
                tried += 1
                self.drafts[who] = draft
                if self._clear(who, retreat, depth + 1):
                    return True
            self.drafts = dict(before)
        return False

    def _meets(self, who: Traveller, draft: Swath, others: dict[Traveller, Swath]) -> bool:
        """Return whether `who` would come too close to any of those who move."""
        here = who.body.motion.state(self._now).at
        for other, theirs in others.items():
            apart = math.dist(here, other.body.motion.state(self._now).at)
            least = min(who.radius + other.radius + GAP, apart - 1e-9)
            if first_conflict(draft, theirs, least, self._now) is not None:
                return True
        return False

    def _retreats(self, who: Traveller, course: Sequence[Point]) -> Iterator[list[Point]]:
        """Yield courses off `course`: to the nearest places around, then to places ahead of it."""
        at = who.body.motion.state(self._now).at
        needed, ground = 2 * who.radius + GAP, self._ground_of(who)
        legs = [number for a, b in pairwise(course) for number in (*a, *b)]
        for dx, dy in AROUND:
            x, y = at[0] + dx, at[1] + dy
            if not touches(legs, x, y, x, y, needed) and ground.free(at, (x, y)):
                yield [at, (x, y)]
        gone, near = 0.0, math.inf
        whole = length_of(course)
        steps = [k * STEP for k in range(math.ceil(whole / STEP) + 1)]
        for s in steps:
            away = math.dist(rest(course, s)[0], at)
            if away < near:
                near, gone = away, s
        for s in steps:
            if s <= gone + STEP:
                continue
            onwards = rest(course, s)[0]
            path = [at, *first(rest(course, gone + STEP), s - gone - STEP)]
            if not all(ground.free(a, b) for a, b in pairwise(path)):
                return
            for k in range(ANGLES // 2):
                angle = 4 * math.pi * k / ANGLES
                for r in (needed + 0.02, 1.3 * needed):
                    x, y = onwards[0] + r * math.cos(angle), onwards[1] + r * math.sin(angle)
                    if not touches(legs, x, y, x, y, needed) and ground.free(onwards, (x, y)):
                        yield [*path, (x, y)]
