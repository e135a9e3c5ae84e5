"""Percepts: what happens around a person, as their mind gets to know it."""

from __future__ import annotations

from collections.abc import Callable

import bdi

from ..core.clock import Alarm, Clock, Turn
from .minds import Mind


class Percepts:
    """The percepts of one mind. Of each functor it has the latest alone, so that it stays small."""

    def __init__(self, mind: Mind) -> None:
        self._mind = mind
        self._counts: dict[str, int] = {}
        self._latest: dict[str, bdi.Literal] = {}
        self._unheard: set[str] = set()

    def see(self, functor: str, *arguments: float) -> None:
        """Perceive `functor(arguments)`, and no longer what was perceived of it before."""
        percept = bdi.Literal(functor, tuple(map(float, arguments)))
        before = self._latest.get(functor)
        if before is not None:
            self._mind.remove_percept(before)
        self._latest[functor] = percept
        self._unheard.add(functor)
        self._mind.add_percept(percept)

    def count(self, functor: str) -> None:
        """Perceive `functor(N)`, with N the number of times that it was perceived before."""
        n = self._counts.get(functor, 0)
        self._counts[functor] = n + 1
        self.see(functor, float(n))

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
        for functor, percept in self._latest.items():
            if functor not in self._counts or functor in self._unheard:
                new._latest[functor] = percept
                new._unheard.add(functor)
                mind.add_percept(percept)
        return new


class Senses:
    """The percepts of a person, whichever mind they have; it thinks as soon as there are any."""

    def __init__(self, clock: Clock, think: Callable[[], None]) -> None:
        self._clock = clock
        self._percepts: Percepts | None = None
        self._thinking = Alarm(clock, think, Turn.THOUGHT)

    def belong_to(self, mind: Mind) -> None:
        """Let `mind` perceive from now on, and what the one before it did not think about."""
        before = self._percepts
        self._percepts = Percepts(mind) if before is None else before.pass_on(mind)
        self._thinking.set(self._clock.now)

    def count(self, functor: str) -> None:
        """Perceive `functor(N)` for the Nth time, from 0."""
        if self._percepts is not None:
            self._percepts.count(functor)
            self._thinking.set(self._clock.now)

    def see(self, functor: str, *arguments: float) -> None:
        """Perceive `functor(arguments)`, in place of what was perceived of it before."""
        if self._percepts is not None:
            self._percepts.see(functor, *arguments)
            self._thinking.set(self._clock.now)

    def heard(self) -> None:
        """Take note that the mind has thought about all of it."""
        if self._percepts is not None:
            self._percepts.heard()

    def think_by(self, t: float) -> None:
        """Let the mind think at `t` (seconds) at the latest."""
        t = max(t, self._clock.now)
        if self._thinking.time is None or t < self._thinking.time:
            self._thinking.set(t)
