"""What an agent perceives, and how that becomes beliefs."""

from __future__ import annotations

from .beliefs import BeliefBase
from .intentions import Event
from .terms import Literal


class Percepts:
    """What is perceived now, and what comes or goes with the next `advance`."""

    def __init__(self) -> None:
        self._now: dict[Literal, Literal] = {}
        self._coming: list[tuple[bool, Literal]] = []
        #: What has come or gone since it was last made beliefs of.
        self.changed: dict[Literal, None] = {}

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
        if added and key in self._now:
            return
        if added:
            self._now[key] = percept
        elif self._now.pop(key, None) is None:
            return
        self.changed.pop(key, None)
        self.changed[key] = None

    def update(self, beliefs: BeliefBase) -> list[Event]:
        """Makes beliefs of what is perceived: the events of what is gone, then of what is new.

        What the program has stopped believing although it is still perceived
        is new again.
        """
        changed, self.changed = self.changed, {}
        gone = [key for key in changed if key not in self._now and key in beliefs.percepts]
        removed = [beliefs.forget_percept(key) for key in gone]
        events = [Event("-", belief) for belief in removed if belief is not None]
        if beliefs.lost_percepts:
            changed = {**beliefs.lost_percepts, **changed}
            beliefs.lost_percepts = {}
        for key in changed:
            percept = self._now.get(key)
            if percept is not None and key not in beliefs.percepts:
                belief = beliefs.perceive(key, percept)
                if belief is not None:
                    events.append(Event("+", belief))
        return events
