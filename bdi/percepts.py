"""What an agent perceives, and how that becomes beliefs."""

from __future__ import annotations

from .beliefs import BeliefBase
from .intentions import Event
from .order import sorted_annots
from .terms import FROM_PERCEPT, Literal


class Percepts:
    """What is perceived now, and what comes or goes with the next `advance`."""

    def __init__(self) -> None:
        self._now: dict[Literal, Literal] = {}
        self._coming: list[tuple[bool, Literal]] = []
        self.changed = False

    def arrive(self, percept: Literal, *, added: bool, at_once: bool) -> None:
        if at_once:
            self._change(percept, added)
        else:
            self._coming.append((added, percept))

    @property
    def are_coming(self) -> bool:
        return bool(self._coming)

    @property
    def current(self) -> list[Literal]:
        return list(self._now.values())

    def come(self) -> None:
        """The time has come for those that were to come."""
        coming, self._coming = self._coming, []
        for added, percept in coming:
            self._change(percept, added)

    def _change(self, percept: Literal, added: bool) -> None:
        key = percept.without_annots()
        if added:
            self._now.setdefault(key, percept)
        else:
            self._now.pop(key, None)
        self.changed = True

    def update(self, beliefs: BeliefBase) -> list[Event]:
        """Makes beliefs of what is perceived: the events of what is gone, then of what is new."""
        self.changed = False
        events = []
        for key in [key for key in beliefs.percepts if key not in self._now]:
            belief = Literal(key.functor, key.args, (FROM_PERCEPT,), key.negated)
            if beliefs.remove(belief, {}) is not None:
                events.append(Event("-", belief))
        for key, percept in self._now.items():
            if key not in beliefs.percepts:
                annots = sorted_annots((*percept.annots, FROM_PERCEPT))
                added = beliefs.add(percept.with_annots(annots))
                if added is not None:
                    events.append(Event("+", added))
        return events
