"""Following: how fast somebody walks behind others who go the same way."""

from __future__ import annotations

import math
from typing import NamedTuple

from .outlook import Outlook
from .traveller import Traveller

AHEAD = 1.0
"""Seconds in which somebody who follows comes to the distance that they keep."""

SEES = 0.5
"""Seconds over which the speed of the one ahead is taken."""

LEAST = 0.05
"""m/s. Nobody who follows creeps more slowly than this."""

SAME_WAY = 0.7
"""Least cosine of the angle between the directions of two of whom one follows the other."""


CLOSES_UP = 1.5
"""Metres to either side within which those who come the other way let people close up."""


class Behind(NamedTuple):
    """Who is followed, at up to what speed, and how fast they walk on (m/s)."""

    other: Traveller
    speed: float
    walks_on: float

    def loses(self, top_speed: float) -> float:
        """Return the share of their `top_speed` (m/s) that following costs somebody."""
        return max(1.0 - max(self.speed, self.walks_on) / top_speed, 0.0)


def behind(me: Traveller, outlook: Outlook) -> Behind | None:
    """Return whom somebody follows who walks on; None if nobody keeps them below their top speed.

    In `AHEAD` seconds they have come to the distance of their time gap, times their speed, beyond
    the bodies; who is beside the path of the one ahead keeps less. Who stands, or goes another
    way, is not followed, and nobody keeps a gap into which somebody who comes the other way would
    step: that jams aisles.
    """
    gap = me.manners.time_gap
    if gap <= 0.0:
        return None
    t, found, speed, on = outlook.t, None, me.top_speed, 0.0
    x, y, c, s = outlook.walks.at(0.0)
    widest = max(CLOSES_UP, me.radius + outlook.others.widest)
    for other in outlook.others.ahead(t, (x, y), (c, s), widest):
        (ox, oy), towards = other.body.motion.state(t).at, other.direction(t)
        along, beside = (ox - x) * c + (oy - y) * s, abs((oy - y) * c - (ox - x) * s)
        if along <= 0.0 or towards is None:
            continue
        same = towards[0] * c + towards[1] * s
        if same < -SAME_WAY and beside < CLOSES_UP:
            return None
        touch = me.radius + other.radius
        if same <= SAME_WAY or beside >= touch or other.body.motion.end <= t:
            continue
        then_x, then_y = other.body.motion.state(t + SEES).at
        gone = (then_x - ox) * c + (then_y - oy) * s
        room = along - math.sqrt(touch * touch - beside * beside)
        most = (room + gone / SEES * AHEAD) / (gap * (1.0 - beside / touch) + AHEAD)
        if most < speed:
            found, speed, on = other, most, gone / SEES
    return None if found is None else Behind(found, max(speed, LEAST), on)
