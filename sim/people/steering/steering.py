"""Steering: the choice of a course among people."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from typing import Protocol

from navigation import Motion, Swath

from .course import nearest_length
from .following import Behind, behind, is_opposed, speed_beside
from .outlook import Outlook
from .traveller import Traveller
from .whereabouts import GAP, Hit

SIDEWAYS = (0.45, 0.9, 1.35)
"""Metres. Shifts to the side that are tried besides the one that just gets past."""

TO_EITHER_SIDE = [side for width in SIDEWAYS for side in (-width, width)]
"""Metres to the left. The same to the right first, then to the left."""

DETOURS = (2.0, 2.8, 3.6)
"""Metres. Shifts that somebody tries who stands before others who don't go the same way."""

WIDEST = 3.6
"""Metres. Nobody shifts further to the side than this."""

SHARES = (0.75, 0.5, 0.25)
"""Shares of the top speed that are tried."""

DELAYS = (0.5, 1.0, 2.0, 4.0)
"""Seconds that somebody who stands waits before setting out."""

SHORTEST = 0.5
"""Metres. Nobody who stands sets out for less."""

PHANTOM = 0.3
"""Share that a stop behind somebody who is about to walk on counts of the metres it loses."""

PARTS = (1.0, 0.8, 0.6, 0.4, 0.2)
"""Parts of the free stretch ahead after which a stop is tried."""

FILES = (0.25, 0.5)
"""Metres to either side. There somebody who follows looks for room to walk faster beside others."""

FASTER = 0.15
"""m/s. For less nobody leaves a file."""

BESIDE = 0.4
"""Share of the foresight after which somebody who leaves a file is beside it."""

STANDS = 1e-6
"""m/s. Slower than this is standing."""

PAST = 0.3
"""Metres beyond the place beside somebody who comes where one who passes them may stop."""

OTHER_SIDE = 0.15
"""Metres. What passing on the less usual side costs."""

BRUSH = 0.5
"""Metres. Detour that keeping the comfort distance is worth."""


class Steering(Protocol):
    """Interface of a steering: it decides how somebody walks on among others."""

    def replan(
        self, body: Traveller, neighbours: Sequence[Traveller], outlook: Outlook
    ) -> Motion | None:
        """Return the motion that `body` should follow from now on; None to leave it as it is.

        `neighbours` are those who may come near, with the motions that they are committed to.
        A motion that comes too close to any of them, its final standing included, is not followed:
        the old one goes on, which is safe.
        """
        ...


class Foresighted:
    """Takes the free course that loses least: aside, slower, shorter, or later.

    People see what others have committed themselves to, and test each course against all of it.
    """

    def replan(
        self, body: Traveller, neighbours: Sequence[Traveller], outlook: Outlook
    ) -> Motion | None:
        """See `Steering`."""
        wished = outlook.wished
        if wished is None:
            return None
        near = outlook.others.first_hit(wished, comfort=True)
        ahead = behind(body, outlook)
        if near is None and ahead is None:
            return outlook.wish
        walks = outlook.walks
        walks.clear()
        hit = None if near is None else outlook.others.first_hit(wished)
        if near is None or hit is None:
            return self._keep_apart(body, outlook, near, ahead)
        # Who walks the same way leaves the place where they would be met: slowing down is enough.
        # Past who comes the other way, or stands, one has to get.
        follows = _same_way(body, hit, outlook.now)
        if not follows:
            ahead = None
        self._add_later_or_shorter(body, outlook, hit, follows, ahead)
        if hit.at_rest and follows:
            # They are about to walk on: nobody passes them where they can get nearer.
            draft = _first_free(outlook)
            if draft is not None:
                return outlook.made(draft)
            walks.clear()
        opposed = not follows and hit.other.goal is not None and not outlook.inside
        _add_asides(body, outlook, near, opposed=opposed)
        if near.other is not hit.other:
            _add_asides(body, outlook, hit, opposed=opposed)
        draft = _first_free(outlook)
        # Only who stands, and before nobody who walks on, tries wide detours: they cost the most.
        if draft is None and outlook.speed < STANDS and not follows:
            outlook.look_around(DETOURS[-1])
            walks.clear()
            _add_asides(body, outlook, hit, widths=DETOURS)
            draft = _first_free(outlook)
        return None if draft is None else outlook.made(draft)

    def _keep_apart(
        self, me: Traveller, outlook: Outlook, near: Hit | None, ahead: Behind | None
    ) -> Motion | None:
        """Return the wish, where nobody is in its way, or a walk farther from others than it is."""
        walks, stop = outlook.walks, outlook.stop
        brush = 0.0 if near is None else BRUSH
        if ahead is None:
            walks.add(brush, stop, me.top_speed, 0.0)
        else:
            walks.add(brush + ahead.loses(me.top_speed) * outlook.reach, stop, ahead.speed, 0.0)
            _add_asides(me, outlook, Hit(outlook.t, ahead.other, False))
        if near is not None:
            _add_asides(me, outlook, near)
        draft = _first_free(outlook)
        if draft is None or (ahead is None and walks.row == 0):
            return outlook.wish
        return outlook.made(draft)

    def _add_later_or_shorter(
        self, me: Traveller, outlook: Outlook, hit: Hit, follows: bool, ahead: Behind | None
    ) -> None:
        """Add walks along the course that are slower, later, or end before the other.

        Who `follows` goes the same way as the other; `ahead` is whom they walk behind.
        """
        walks, stop = outlook.walks, outlook.stop
        top = me.top_speed if ahead is None else ahead.speed
        whole = min(outlook.reach, outlook.whole)
        if not hit.at_rest:  # else it would be as much in the way later on
            for pace in SHARES:
                walks.add((1 - pace * top / me.top_speed) * whole, stop, pace * top, 0.0)
            if outlook.speed < STANDS:
                for delay in DELAYS:
                    walks.add(delay * top, stop, top, delay)
        # In a single file all come as near as their time gap lets them, and then slow down.
        in_file = ahead is not None and outlook.is_narrow(0.0)
        share = PHANTOM if follows and (hit.at_rest or in_file) else 1.0
        # A stop behind somebody who is about to walk on loses less than it seems: they soon go on.
        for length in self._stops(me, outlook, outlook.gone(hit.t), follows):
            walks.add(share * max(whole - length, 0.0), length, top, 0.0)
        if ahead is not None and outlook.speed >= STANDS and ahead.speed + FASTER < me.top_speed:
            _add_files(me, outlook, ahead)

    def _stops(
        self, me: Traveller, outlook: Outlook, gone: float, follows: bool
    ) -> Iterator[float]:
        """Yield the lengths after which to stop short of a conflict `gone` metres ahead.

        Who `follows` goes the same way as whom they would run into.
        """
        stands = outlook.speed < STANDS
        # v² / (2 a), the shortest stop there is, and a little more against rounding.
        braking = outlook.speed**2 / (2 * me.human.max_acceleration) * 1.001
        goes_in: bool | None = None
        for part in PARTS:
            length = part * gone
            if outlook.is_narrow(length):
                if goes_in is None:
                    goes_in = _goes_in(me, outlook, length, follows)
                if not goes_in:
                    length = outlook.stop_before(length)
            if length >= (SHORTEST if stands else braking):
                yield length
        if not stands:
            yield braking


def _first_free(outlook: Outlook) -> Swath | None:
    """Return the draft of the walk that loses least of those that are free."""
    while True:
        draft = outlook.next_free()
        if draft is None or outlook.has_room():
            return draft


def _goes_in(me: Traveller, outlook: Outlook, length: float, follows: bool) -> bool:
    """Return whether somebody may stop in a narrow place, after `length` metres of their course.

    Only against nobody who comes, else two files would go in from either end behind those who come
    out, and meet inside: who is in it already, or follows somebody who leaves it the same way. Who
    is in it and has lost patience does in any case.
    """
    inside = outlook.is_narrow(0.0)
    if inside and me.time_blocked(outlook.now) >= me.manners.patience:
        return True
    return (inside or follows) and not is_opposed(outlook, length)


def _same_way(me: Traveller, hit: Hit, now: float) -> bool:
    """Return whether the other walks the same way, or will."""
    mine, theirs = me.direction(now), hit.other.direction(now)
    if mine is None or theirs is None:
        return False
    return mine[0] * theirs[0] + mine[1] * theirs[1] > 0.3


def _add_files(me: Traveller, outlook: Outlook, ahead: Behind) -> None:
    """Add walks to a place beside the file of somebody who follows, where they come on faster.

    So a crowd takes up all the width that there is, but where others need it to come the other way.
    """
    if outlook.inside:
        return
    walks, usual = outlook.walks, _usual(me)
    for width in FILES:
        for side in (usual * width, -usual * width):
            speed = speed_beside(me, outlook, side)
            along = BESIDE * speed * me.manners.foresight
            if speed >= ahead.speed + FASTER and along < outlook.whole:
                walks.add_asides([side], WIDEST, usual, OTHER_SIDE, along, speed, along)


def _add_asides(
    me: Traveller,
    outlook: Outlook,
    hit: Hit,
    *,
    widths: Sequence[float] = (),
    opposed: bool = False,
) -> None:
    """Add the walks that pass the other on either side.

    Just past the other and a little wider, or else by these `widths` (metres) alone. Who is
    `opposed` may also stop beside the other: past the first of many there seldom is room for all
    that they look ahead.
    """
    gone, ahead, beside = _relative(outlook, hit)
    needed = me.radius + hit.other.radius + GAP
    wide = needed + me.manners.comfort
    # Just past them at the comfort distance, then at the least one, then by set widths; to either
    # side. Which is free, and loses least, is found out when they are drawn up.
    past = [beside - wide, beside + wide, beside - needed - 1e-3, beside + needed + 1e-3]
    sides = [*past, *TO_EITHER_SIDE]
    if widths:
        sides = [side for width in widths for side in (-width, width)]
    walks, length, along = outlook.walks, outlook.reach + 0.5, gone + max(ahead, 0.0)
    walks.add_asides(sides, WIDEST, _usual(me), OTHER_SIDE, length, me.top_speed, along)
    if opposed:
        length = along + PAST
        walks.add_asides(past[:2], WIDEST, _usual(me), OTHER_SIDE, length, me.top_speed, along)


def _usual(me: Traveller) -> float:
    """Return the side on which somebody passes: 1 for the left, -1 for the right."""
    return -1.0 if me.manners.passing_side == "right" else 1.0


def _relative(outlook: Outlook, hit: Hit) -> tuple[float, float, float]:
    """Return how far one would have gone by a conflict, and where the other is from there.

    Metres along the course, ahead, and to the left.
    """
    gone = outlook.gone(hit.t)
    x, y, c, s = outlook.walks.at(gone)
    px, py = hit.other.body.motion.state(hit.t).at
    return gone, (px - x) * c + (py - y) * s, (py - y) * c - (px - x) * s


def both_aside(
    me: Traveller, mine: Outlook, hit: Hit, look: Callable[[], Outlook]
) -> Iterator[tuple[Swath, Swath, Outlook]]:
    """Yield drafts in which two who meet head-on both shift to their side, the usual one first.

    And the outlook of the other, who comes to `look` only where there is room on this side.
    Neither meets anybody else.
    """
    theirs: Outlook | None = None
    our_others = mine.others.without([hit.other])
    gone, ahead, beside = _relative(mine, hit)
    x, y, _, _ = mine.walks.at(gone + max(ahead, 0.0) / 2)
    needed = me.radius + hit.other.radius + GAP + 1e-3
    comfort = min(me.manners.comfort, 0.1)
    usual = _usual(me)
    for spare in (comfort, 0.0):
        for way in (usual, -usual):
            width = needed + spare + way * beside
            if width <= 0.0:
                continue
            for share in (0.5, 0.7, 0.3):
                ours = mine.aside(max(gone + ahead / 2, 0.1), way * share * width, our_others)
                if ours is None:
                    continue
                if theirs is None:
                    theirs = look()
                    their_others = theirs.others.without([me])
                    passed = nearest_length(theirs.course, (x, y))
                if theirs.wished is None:
                    return
                yours = theirs.aside(max(passed, 0.1), way * (1 - share) * width, their_others)
                if yours is not None:
                    yield ours, yours, theirs
