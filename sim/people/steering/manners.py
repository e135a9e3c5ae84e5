"""Manners of a person towards others: the figures that decide how they walk among people."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

Side = Literal["right", "left"]


@dataclass(frozen=True, kw_only=True)
class Manners:
    """Figures of a person among people.

    `comfort` is the distance between the bodies (metres) that they keep where there is room;
    `foresight` how far ahead (seconds) they commit themselves to a course, and so how early they
    see others; `reaction_time` how long (seconds) they stand before somebody in the way until they
    ask to be let past, and until they reconsider; `patience` how long (seconds) they stand blocked
    until they perceive that they are; `passing_side` the side on which they pass who comes the
    other way, where both are as good.

    Defaults: 0.1 m and right as observed in bidirectional streams (M. Moussaïd et al.,
    "Experimental study of the behavioural mechanisms underlying self-organization in human
    crowds", Proc. R. Soc. B 276, 2009); 0.4 s as a simple visual reaction with the onset of a
    step (M. Moussaïd et al., "How simple rules determine pedestrian behavior and crowd
    disasters", PNAS 108, 2011, has 0.5 s).
    """

    comfort: float = 0.1
    foresight: float = 5.0
    reaction_time: float = 0.4
    patience: float = 10.0
    passing_side: Side = "right"
