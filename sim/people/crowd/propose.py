"""Steering: the method that proposes a motion."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from typing import Protocol

from navigation import Motion
from navigation.kernels.discs import Swath

from .commitments import GAP, Hit
from .ground import nearest_length
from .observe import Outlook
from .traveller import Traveller


class Steering(Protocol):
    """Interface of the method that proposes the next motion of a person."""

    def replan(
        self, body: Traveller, neighbours: Sequence[Traveller], outlook: Outlook
    ) -> Motion | None:
        """Return the next motion of `body`, or None to keep the current one.

        A motion that conflicts with another committed motion is rejected, and the old one
        continues.

        Parameters
        ----------
        body : Traveller
            The person who decides.
        neighbours : sequence of Traveller
            People nearby, with their committed motions.
        outlook : Outlook
            The course, the preferred motion, and tests for conflicts.
        """
        ...


class Foresighted:
    """Default steering: the free candidate with the least loss.

    Candidates pass on either side, are slower or shorter, or start later. Each is tested against
    the committed motions of all others. See `navigation.kernels.foresight`.
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
    """Yield drafts in which two people who meet head-on both shift aside, to the usual side first.

    Each pair of drafts comes with the observation of the other person. `look` makes it only if
    there is room on this side. Neither draft meets other people.
    """
    theirs: Outlook | None = None
    indices = mine.others.table.indices
    my_row, other_row = indices[me], indices[hit.other]
    gone = mine.gone(hit.t)
    x, y, c, s = mine.walks.course.after(gone)
    px, py = hit.other.body.motion.state(hit.t).at
    # Position of the other person at the conflict, relative to the walker: ahead, and to the left.
    ahead, beside = (px - x) * c + (py - y) * s, (py - y) * c - (px - x) * s
    x, y, _, _ = mine.walks.course.after(gone + max(ahead, 0.0) / 2)
    needed = me.radius + hit.other.radius + GAP + 1e-3
    comfort = min(me.manners.comfort, 0.1)
    usual = me.usual_side
    for spare in (comfort, 0.0):
        for way in (usual, -usual):
            width = needed + spare + way * beside
            if width <= 0.0:
                continue
            for share in (0.5, 0.7, 0.3):
                ours = mine.aside(max(gone + ahead / 2, 0.1), way * share * width, other_row)
                if ours is None:
                    continue
                if theirs is None:
                    theirs = look()
                    if theirs.wished is None:
                        return
                    theirs.look_again()
                    passed = nearest_length(theirs.course, (x, y))
                yours = theirs.aside(max(passed, 0.1), way * (1 - share) * width, my_row)
                if yours is not None:
                    yield ours, yours, theirs
