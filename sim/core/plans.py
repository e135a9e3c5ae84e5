"""Plans: the motions that a body set out on, whatever came of them."""

from __future__ import annotations

from bisect import bisect_left, bisect_right

from navigation import Motion


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
