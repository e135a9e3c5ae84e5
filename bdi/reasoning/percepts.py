"""Percepts of an agent, and their way into the belief base."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TypeAlias

from ..language.terms import Literal
from .beliefs import BeliefBase

Change: TypeAlias = tuple[bool, Literal]
"""A percept that comes, with True, or goes."""


class Percepts:
    """The percepts that hold now, and those that come or go with the next `advance`.

    Attributes:
        at_once: True while the agent runs: percepts come and go without waiting.
        coming: those that wait for the next `advance`, in order.
        changed: by their identity, those that have come or gone since the belief base was updated,
            with True for one that has come.
    """

    def __init__(self) -> None:
        self.at_once = False
        self.coming: list[Change] = []
        self.changed: dict[object, Change] = {}
        self._now: dict[object, Literal] = {}

    @property
    def current(self) -> list[Literal]:
        """The percepts that hold, in the order in which they came."""
        return list(self._now.values())

    def notice(self, change: Change) -> None:
        """Let a percept come or go, with the next `advance` or at once."""
        if self.at_once:
            self._change((change,))
        else:
            self.coming.append(change)

    def take(self) -> None:
        """Let those come and go that wait for it."""
        changes, self.coming = self.coming, []
        self._change(changes)

    def _change(self, changes: Iterable[Change]) -> None:
        now, changed = self._now, self.changed
        for change in changes:
            added, percept = change
            key = percept.identity
            if (key in now) is added:
                continue
            if added:
                now[key] = percept
            else:
                del now[key]
            # Last in order is last in time: what comes again after it went counts from then.
            if changed:
                changed.pop(key, None)
            changed[key] = change

    def update(self, beliefs: BeliefBase) -> list[tuple[str, Literal]]:
        """Update the beliefs from the percepts; return the changes, deletions before additions.

        A percept that the program has stopped believing although it still holds is new again.
        """
        changed, self.changed = self.changed, {}
        changes = []
        for there, percept in changed.values():
            if not there:
                removed = beliefs.forget_percept(percept)
                if removed is not None:
                    changes.append(("-", removed))
        if beliefs.lost_percepts:
            changed = self._with_lost(beliefs, changed)
        for there, percept in changed.values():
            if there:
                belief = beliefs.perceive(percept)
                if belief is not None:
                    changes.append(("+", belief))
        return changes

    def _with_lost(
        self, beliefs: BeliefBase, changed: dict[object, Change]
    ) -> dict[object, Change]:
        """Return what has changed, those first that the program has stopped believing."""
        lost, beliefs.lost_percepts = beliefs.lost_percepts, {}
        known = ((key, self._now[key]) for key in {**lost, **changed} if key in self._now)
        return {key: (True, percept) for key, percept in known}
