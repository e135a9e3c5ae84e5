"""Those who move for a request to step aside, checked against each other."""

from __future__ import annotations

import math
from collections.abc import Mapping

from navigation import Swath, first_met

from .traveller import Traveller
from .whereabouts import GAP


class Moving:
    """Those who move for a request, as of `now` (seconds): where each of them goes."""

    def __init__(self, drafts: Mapping[Traveller, Swath], now: float) -> None:
        self._now = now
        self.all = (
            [draft.table for draft in drafts.values()],
            [bound for draft in drafts.values() for bound in draft.box],
            [who.radius for who in drafts],
        )
        """Tables, bounds and radii."""

    def meet(self, who: Traveller, draft: Swath) -> bool:
        """Return whether somebody who goes like this would come too close to any of them."""
        found = first_met(
            draft.table,
            draft.box,
            [*range(len(self.all[0]))],
            *self.all,
            who.radius + GAP,
            self._now,
            [math.inf],
        )
        return found >= 0
