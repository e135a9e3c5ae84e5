"""Regard for others: what a person perceives of who is near, in the way, and giving way."""

from __future__ import annotations

import re
from functools import lru_cache, partial

import bdi
from navigation import Apart, FixedDistance, TooClose

from ..core.body import Body
from ..core.stage import Stage
from ..safety.nearness import NearWatch
from .minds import Mind, Outside
from .percepts import Senses

NEAR = TooClose(FixedDistance(3.6))
"""So near is who counts as near: within 3.6 m of centres, where Hall's social space ends."""

GONE = Apart(4.1)
"""So far has to go who is gone: 0.5 m more between centres, in metres."""

NEARNESS = ("person_near", "person_gone")
"""Percepts that need a watch on every other person."""

PERCEPTS = (*NEARNESS, "in_the_way", "gives_way", "wants_to_pass", "has_left")
"""Percepts about another person, `functor(Who, N)`."""


class Regard:
    """What one person perceives of others, from their start on: what their program mentions."""

    def __init__(self, stage: Stage, body: Body, senses: Senses) -> None:
        self._stage = stage
        self._body = body
        self._senses = senses
        self._heeded: frozenset[str] = frozenset()
        self._started = False
        self._watches: list[NearWatch] = []

    def belong_to(self, mind: Mind) -> None:
        """Perceive from now on what the program of `mind` mentions; a mind outside hears all."""
        if isinstance(mind, bdi.Agent):
            self._heeded = mentioned(mind.program)
        elif isinstance(mind, Outside):
            self._heeded = frozenset(PERCEPTS)
        self._look_round()

    def start(self) -> None:
        """Begin to perceive: the person starts."""
        self._started = True
        self._look_round()

    def heeds(self, percept: str) -> bool:
        """Return whether the mind heeds a percept about another person."""
        return percept in self._heeded

    def perceive(self, percept: str, who: str) -> None:
        """Perceive something about `who`, if the mind heeds such percepts."""
        if self._started and self.heeds(percept):
            self._senses.count(percept, who)

    def _look_round(self) -> None:
        if self._started and not self._watches and self._heeded.intersection(NEARNESS):
            self._watches = [
                NearWatch(
                    self._stage,
                    (self._body, one.body),
                    NEAR,
                    GONE,
                    partial(self._nearness, one.name),
                )
                for one in self._stage.people
                if one.body is not self._body
            ]

    def _nearness(self, who: str, is_near: bool) -> None:
        self.perceive(NEARNESS[0] if is_near else NEARNESS[1], who)


@lru_cache(maxsize=1024)
def mentioned(program: bdi.Program) -> frozenset[str]:
    """Return those of the percepts about other people that stand anywhere in a program."""
    clauses = (*program.beliefs, *program.goals, *program.plans)
    words = set(re.findall(r"\w+", " ".join(map(str, clauses))))
    return frozenset(words.intersection(PERCEPTS))
