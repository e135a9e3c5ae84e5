"""Manners of a person towards others: the figures that decide how they walk among people."""

from __future__ import annotations

from dataclasses import dataclass, fields
from random import Random

from ...core.entries import AS_USUAL, MannersEntry, Side, seed_of


@dataclass(frozen=True, kw_only=True)
class Manners:
    """Figures of a person among people.

    `comfort` is the distance between the bodies (metres) that they keep where there is room;
    `time_gap` the time (seconds) that they keep behind who walks ahead of them: their speed times
    this is the distance between the bodies; `foresight` how far ahead (seconds) they commit
    themselves to a course, and so how early they see others; `reaction_time` how long (seconds)
    they stand before somebody in the way until they ask to be let past; `patience` how long
    (seconds) they stand blocked until they perceive that they are; `passing_side` the side on which
    they pass who comes the other way, where both are as good. Those who don't `steps_aside` stay
    where they stand when they are asked to.

    That people keep to one side, the right in much of Europe, is measured by M. Moussaïd et al.,
    "Experimental study of the behavioural mechanisms underlying self-organization in human crowds",
    Proc. R. Soc. B 276, 2009. The time gap is that of people in single file, who take up 0.36 m and
    1.06 s times their speed each: A. Seyfried et al., "The fundamental diagram of pedestrian
    movement revisited", J. Stat. Mech. P10002, 2005. The reaction time is near the 0.5 s in which
    they adapt their course in "How simple rules determine pedestrian behavior and crowd disasters",
    PNAS 108, 2011. The others are choices with which people get past each other without jams.
    """

    comfort: float = 0.1
    time_gap: float = 1.0
    foresight: float = 5.0
    reaction_time: float = 0.4
    patience: float = 10.0
    passing_side: Side = "right"
    steps_aside: bool = True


USUAL = Manners()
"""Manners of somebody of whom nothing is given."""


def drawn(entry: MannersEntry, seed: int, name: str) -> Manners:
    """Return the manners of somebody: what is given as a spread is drawn evenly from it.

    From the trial's `seed` and their `name` alone, whoever else is there.
    """
    if entry == AS_USUAL:
        return USUAL
    random = Random(seed_of(seed, f"manners {name}"))
    given = {}
    for field in fields(entry):
        value = getattr(entry, field.name)
        if isinstance(value, tuple):
            value = random.uniform(*value)
        if value is not None:
            given[field.name] = value
    return Manners(**given)
