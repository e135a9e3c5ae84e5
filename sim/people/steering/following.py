"""Following: how fast somebody walks behind others who go the same way."""

from __future__ import annotations

from typing import NamedTuple

from navigation import followed, speed_behind

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


Frame = tuple[float, float, float, float]
"""A place (x, y in metres) and the cosine and sine of the direction in which somebody walks."""


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
    if me.manners.time_gap <= 0.0:
        return None
    t, frame, floor, slow = outlook.t, outlook.walks.at(0.0), outlook.others.floor, list[int]()
    found = _followed(me, outlook, frame, slow)
    people, rests = floor.people, floor.rests
    # Who has hardly set out yet may be followed too, and comes where their route leads them.
    for other in [people[k] for k in slow if rests[k] > t]:
        if _cosine(other, t, frame) > SAME_WAY:
            one = _behind(me, other, t, frame)
            if one is not None and one.speed < (me.top_speed if found is None else found.speed):
                found = one
    if found is None or any(_comes(people[k], t, frame) for k in slow):
        return None
    return found._replace(speed=max(found.speed, LEAST))


def speed_beside(me: Traveller, outlook: Outlook, side: float) -> float:
    """Return how fast (m/s) somebody would come on `side` metres to the left, behind others."""
    x, y, c, s = outlook.walks.at(0.0)
    other = _followed(me, outlook, (x - side * s, y + side * c, c, s), [])
    return me.top_speed if other is None else max(other.speed, LEAST)


def is_opposed(outlook: Outlook, length: float) -> bool:
    """Return whether somebody in a narrow place ahead comes, where one has gone `length` metres."""
    t, frame = outlook.t, outlook.walks.at(length)
    (x, y, c, s), (narrow, abreast) = frame, (outlook.ground.narrow, outlook.abreast)
    for other in outlook.near:
        at = other.body.motion.state(t).at
        if (
            (at[0] - outlook.at[0]) * c + (at[1] - outlook.at[1]) * s > 0.0
            and abs((at[1] - y) * c - (at[0] - x) * s) < CLOSES_UP
            and _cosine(other, t, frame) < 0.0
            and (narrow(at, abreast) or narrow(other.swath.place, abreast))
        ):
            return True
    return False


def _followed(me: Traveller, outlook: Outlook, frame: Frame, slow: list[int]) -> Behind | None:
    """Return who keeps somebody below their top speed most, of those who walk.

    `slow` receives those ahead who hardly move.
    """
    others, t = outlook.others, outlook.t
    # The kernel decides among all who are near; `_behind` below says for the one it finds what the
    # formula gives, and for those who set out only now, who have no velocity yet.
    k = followed(
        others.near,
        others.floor.tables,
        others.floor.radii,
        t,
        SEES,
        *frame,
        me.radius,
        me.manners.time_gap,
        AHEAD,
        me.top_speed,
        SAME_WAY,
        CLOSES_UP,
        slow,
    )
    return None if k < 0 else _behind(me, others.floor.people[k], t, frame)


def _behind(me: Traveller, other: Traveller, t: float, frame: Frame) -> Behind | None:
    """Return what it is to follow the other; None for who is not in the way."""
    x, y, c, s = frame
    ox, oy = other.body.motion.state(t).at
    along, beside = (ox - x) * c + (oy - y) * s, abs((oy - y) * c - (ox - x) * s)
    touch = me.radius + other.radius
    if beside >= touch:
        return None
    then_x, then_y = other.body.motion.state(t + SEES).at
    walks_on = ((then_x - ox) * c + (then_y - oy) * s) / SEES
    most = speed_behind(along, beside, touch, walks_on, me.manners.time_gap, AHEAD)
    return Behind(other, most, walks_on)


def _cosine(other: Traveller, t: float, frame: Frame) -> float:
    """Return the cosine of the angle between two directions; 0 for who goes nowhere."""
    towards = other.direction(t)
    return 0.0 if towards is None else towards[0] * frame[2] + towards[1] * frame[3]


def _comes(other: Traveller, t: float, frame: Frame) -> bool:
    """Return whether the other comes the other way, so near to the path that it matters."""
    x, y, c, s = frame
    ox, oy, _ = other.body.motion.state(t).position
    return abs((oy - y) * c - (ox - x) * s) < CLOSES_UP and _cosine(other, t, frame) < -SAME_WAY
