"""Noticing, and other figures of people that may be drawn from a distribution."""

from __future__ import annotations

from dataclasses import dataclass
from random import Random

from .seeds import seed_of
from .work import Duration

Drawn = float | tuple[float, float] | Duration
"""A figure; the least and the most, between which it is drawn evenly; or a distribution."""


@dataclass(frozen=True, kw_only=True)
class NoticingEntry:
    """How somebody notices machines; what is None is as if they had eyes all round.

    Theirs is a `field_of_view` of so many degrees, half of it on each side of where they look.
    With `occlusion` they see nothing through walls, obstacles and machines. They perceive
    something `reaction_time` seconds after they have seen it.
    """

    field_of_view: Drawn | None = None
    occlusion: bool = False
    reaction_time: Drawn | None = None


ALL_ROUND = NoticingEntry()
"""Noticing of which nothing is given: by distance alone, and at once."""


def drawn_figure(value: Drawn, seed: int, what: str) -> float:
    """Return a figure, drawn for `what` from the `seed` of a trial unless it is fixed."""
    random = Random(seed_of(seed, what))
    if isinstance(value, Duration):
        return value.draw(random)
    return random.uniform(*value) if isinstance(value, tuple) else value
