"""Percepts: what happens around a person, as their mind gets to know it."""

from __future__ import annotations

from collections.abc import Callable

import bdi

from ..core.clock import Alarm, Clock, Turn
from .minds import Mind, as_term

Key = tuple[str, ...]
"""A functor, and the name of whom the percept is about, if it is about somebody."""


class Percepts:
    """The percepts of one mind, which stays small: of each functor it has the latest alone.

    Of percepts about other people it has the latest about each.
    """

    def __init__(self, mind: Mind) -> None:
        self._mind = mind
        self._counts: dict[Key, int] = {}
        self._latest: dict[Key, bdi.Literal] = {}
        self._unheard: set[Key] = set()

    def see(self, functor: str, *arguments: float) -> None:
        """Perceive `functor(arguments)`, and no longer what was perceived of it before."""
        self._perceive((functor,), *map(float, arguments))

    def count(self, functor: str, *who: str) -> None:
        """Perceive `functor(N)`, with N the number of times that it was perceived before.

        About somebody, who is named, `functor(Who, N)`.
        """
        key = (functor, *who)
        n = self._counts.get(key, 0)
        self._counts[key] = n + 1
        self._perceive(key, *map(as_term, who), float(n))

    def _perceive(self, key: Key, *arguments: bdi.Term) -> None:
        """Perceive something in place of what was perceived under this key before."""
        percept = bdi.Literal(key[0], arguments)
        before = self._latest.get(key)
        if before is not None:
            self._mind.remove_percept(before)
        self._latest[key] = percept
        self._unheard.add(key)
        self._mind.add_percept(percept)

    def heard(self) -> None:
        """Take note that the mind has thought about all of it."""
        self._unheard.clear()

    def pass_on(self, mind: Mind) -> Percepts:
        """Return the percepts of `mind`, which takes the place of the mind so far.

        It perceives the present state of things and the happenings that nobody has thought about
        yet; happenings are counted on.
        """
        new = Percepts(mind)
        new._counts = self._counts
        for key, percept in self._latest.items():
            if key not in self._counts or key in self._unheard:
                new._latest[key] = percept
                new._unheard.add(key)
                mind.add_percept(percept)
        return new


class Senses:
    """The percepts of a person, whichever mind they have.

    The mind thinks as soon as there are any, or if there is a `lag`, that many seconds later. The
    percepts of that time are then thought about together.
    """

    def __init__(
        self, clock: Clock, think: Callable[[], None], lag: Callable[[], float] | None = None
    ) -> None:
        self._clock = clock
        self._lag = lag
        self._due: float | None = None
        self._percepts: Percepts | None = None
        self._thinking = Alarm(clock, think, Turn.THOUGHT)

    def belong_to(self, mind: Mind) -> None:
        """Let `mind` perceive from now on, and what the one before it did not think about."""
        before = self._percepts
        self._percepts = Percepts(mind) if before is None else before.pass_on(mind)
        self._thinking.set(self._clock.now)

    def count(self, functor: str, *who: str) -> None:
        """Perceive `functor(N)` for the Nth time, from 0; `functor(Who, N)` about somebody."""
        if self._percepts is not None:
            self._percepts.count(functor, *who)
            self._think_soon()

    def see(self, functor: str, *arguments: float) -> None:
        """Perceive `functor(arguments)`, in place of what was perceived of it before."""
        if self._percepts is not None:
            self._percepts.see(functor, *arguments)
            self._think_soon()

    @property
    def thinks_at(self) -> float:
        """Instant (seconds) by which the mind has thought about all that is perceived."""
        return self._clock.now if self._due is None else self._due

    def _think_soon(self) -> None:
        if self._lag is None:
            self._thinking.set(self._clock.now)
            return
        if self._due is None:
            self._due = self._clock.now + self._lag()
        self.think_by(self._due)

    def heard(self) -> None:
        """Take note that the mind has thought about all of it."""
        self._due = None
        if self._percepts is not None:
            self._percepts.heard()

    def think_by(self, t: float) -> None:
        """Let the mind think at `t` (seconds) at the latest."""
        t = max(t, self._clock.now)
        if self._thinking.time is None or t < self._thinking.time:
            self._thinking.set(t)
