"""Those who move for a request to step aside, checked against each other and all others."""

from __future__ import annotations

from navigation.kernels.movers import Movers
from navigation.walking import Swath

from .traveller import Traveller
from .whereabouts import Whereabouts


class RequestedMoves(Movers):
    """Those who move for a request, of all on a `floor`, as of `now` (seconds): where each goes."""

    def __init__(self, floor: Whereabouts, now: float) -> None:
        super().__init__(floor.throng, now)
        self._floor = floor

    @property
    def drafts(self) -> dict[Traveller, Swath]:
        """Where everybody goes who moves."""
        people, boxes = self._floor.people, self.boxes
        return {
            people[k]: Swath.of(table, boxes[4 * i : 4 * i + 4])
            for i, (k, table) in enumerate(zip(self.indices, self.tables, strict=True))
        }
