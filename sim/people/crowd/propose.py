"""Steering: the choice of a course among people."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from typing import Protocol

from navigation import Motion
from navigation.walking import Swath

from .commitments import GAP, Hit
from .ground import nearest_length
from .observe import Outlook
from .traveller import Traveller


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
    The courses that there are, and in what order they are tried, is what `navigation.Foresight` is
    about.
    """

    def replan(
        self, body: Traveller, neighbours: Sequence[Traveller], outlook: Outlook
    ) -> Motion | None:
        """See `Steering`."""
        if outlook.wished is None:
            return None
        return outlook.first_free()


def both_aside(
    me: Traveller, mine: Outlook, hit: Hit, look: Callable[[], Outlook]
) -> Iterator[tuple[Swath, Swath, Outlook]]:
    """Yield drafts in which two who meet head-on both shift to their side, the usual one first.

    And the outlook of the other, who comes to `look` only where there is room on this side.
    Neither meets anybody else.
    """
    theirs: Outlook | None = None
    our_others = mine.others.without([hit.other])
    gone = mine.gone(hit.t)
    x, y, c, s = mine.walks.at(gone)
    px, py = hit.other.body.motion.state(hit.t).at
    # Where the other is then, from where they would be: ahead, and to the left.
    ahead, beside = (px - x) * c + (py - y) * s, (py - y) * c - (px - x) * s
    x, y, _, _ = mine.walks.at(gone + max(ahead, 0.0) / 2)
    needed = me.radius + hit.other.radius + GAP + 1e-3
    comfort = min(me.manners.comfort, 0.1)
    usual = me.usual_side
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
                    if theirs.wished is None:
                        return
                    their_others = theirs.others.without([me])
                    passed = nearest_length(theirs.course, (x, y))
                yours = theirs.aside(max(passed, 0.1), way * (1 - share) * width, their_others)
                if yours is not None:
                    yield ours, yours, theirs
