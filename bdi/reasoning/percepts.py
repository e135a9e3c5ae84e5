"""Percepts of an agent, and their way into the belief base."""

from __future__ import annotations

from collections.abc import Iterable

from ..language.terms import Literal
from .beliefs import BeliefBase


class Percepts:
    """The percepts that hold now, and those that come or go with the next `advance`.

    Attributes:
        coming: those that wait for the next `advance`, in order, as `change` takes them.
        changed: by their identity, those that have come or gone since the belief base was updated.
    """

    def __init__(self) -> None:
        self.coming: list[tuple[bool, Literal]] = []
        self.changed: dict[object, Literal] = {}
        self._now: dict[object, Literal] = {}

    @property
    def current(self) -> list[Literal]:
        """The percepts that hold, in the order in which they came."""
        return list(self._now.values())

    def change(self, changes: Iterable[tuple[bool, Literal]]) -> None:
        """Let percepts come, with True, and go."""
        now, changed = self._now, self.changed
        for added, percept in changes:
            key = percept.identity
            if (key in now) is added:
                continue
            if added:
                now[key] = percept
            else:
                del now[key]
            changed.pop(key, None)
            changed[key] = percept

    def update(self, beliefs: BeliefBase) -> list[tuple[str, Literal]]:
        """Update the beliefs from the percepts; return the changes, deletions before additions.

        A percept that the program has stopped believing although it still holds is new again.
        """
        changed, self.changed = self.changed, {}
        now = self._now
        changes = []
        for key, percept in changed.items():
            if key not in now:
                removed = beliefs.forget_percept(percept)
                if removed is not None:
                    changes.append(("-", removed))
        if beliefs.lost_percepts:
            changed = {**beliefs.lost_percepts, **changed}
            beliefs.lost_percepts = {}
        for key in changed:
            if key in now:
                belief = beliefs.perceive(now[key])
                if belief is not None:
                    changes.append(("+", belief))
        return changes
