"""A part on its way to where an order needs it, and what becomes of it."""

from __future__ import annotations

from collections.abc import Callable

from ..core.workload import Item, Part
from ..machines.gantry.tasks import Step

Found = tuple[Item, Step]
"""A part, and the step by which it is picked."""


class Carried:
    """A part that the gantry carries for an order; another takes its place if it is lost.

    The `last` step brings it where it belongs, `put` takes note of that. `another()` finds the
    next one; where there is none, the part is one of those that are `missing`.
    """

    def __init__(
        self,
        item: Item,
        last: Step,
        put: Callable[[Item], None],
        *,
        another: Callable[[], Found | None],
        missing: list[Part],
    ) -> None:
        self.item: Item | None = item
        self._part = item.part
        self._last = last
        self._put = put
        self._another = another
        self._missing = missing

    def put_down(self) -> None:
        """Take note that it is where it belongs, if it has not been given up."""
        if self.item is not None:
            self._put(Item(self.item.part, faulty=self.item.faulty))  # turned over, if need be

    def lost(self) -> tuple[Step, ...]:
        """Return the steps that bring another; none if there is none."""
        found = self._another()
        if found is None:
            self.item = None
            self._missing.append(self._part)
            return ()
        self.item, pick = found
        return (pick, self._last)
