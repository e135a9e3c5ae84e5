"""Percepts of an agent, and their way into the belief base."""

from __future__ import annotations

from ..language.terms import Literal
from .beliefs import BeliefBase
from .intentions import Event


class Percepts:
    """The percepts that hold now, and those that come or go with the next `advance`.

    `changed` are the percepts that have come or gone since the belief base was updated.
    """

    def __init__(self) -> None:
        self._now: dict[Literal, Literal] = {}
        self._coming: list[tuple[bool, Literal]] = []
        self.changed: dict[Literal, None] = {}

    def arrive(self, percept: Literal, *, added: bool, at_once: bool) -> None:
        """Add or remove a percept, now or with the next `come`."""
        if at_once:
            self._change(percept, added)
        else:
            self._coming.append((added, percept))

    @property
    def are_coming(self) -> bool:
        """True if some wait for the next `come`."""
        return bool(self._coming)

    @property
    def current(self) -> list[Literal]:
        """The percepts that hold, in the order in which they came."""
        return list(self._now.values())

    def come(self) -> None:
        """Let those that wait come and go."""
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
        """Update the beliefs from the percepts; return the events, deletions before additions.

        A percept that the program has stopped believing although it still holds is new again.
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
                belief = beliefs.perceive(percept)
                if belief is not None:
                    events.append(Event("+", belief))
        return events
