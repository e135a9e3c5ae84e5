"""Walks in closed form along paths, as `walk`'s, for those who change their pace all the time.

A person among others weighs many courses before taking one, and slows down to speeds below the
one they have. Courses that are weighed are tables (see `pacing`); the one taken becomes a motion.
"""

from __future__ import annotations

from collections.abc import Sequence

from .clearance import Swath, walked
from .kernels.candidates import bound
from .kernels.numbers import flat, numbers, room
from .kernels.pacing import walk_table
from .motion import Motion

Corner = tuple[float, float]

_NONE = numbers(())


def pace(
    corners: Sequence[Corner],
    start: float,
    *,
    initial_speed: float = 0.0,
    top_speed: float | Sequence[float],
    max_speed: float,
    max_acceleration: float,
    lead: Swath | None = None,
    since: float | None = None,
) -> Swath | None:
    """Return where a walk along `corners` (x, y in metres) goes, from `start` (seconds) to rest.

    It sets out at `initial_speed` along the first leg, and keeps to `top_speed` as soon as
    `max_acceleration` lets it; corners are taken as `walk` takes them, and never faster than
    `max_speed` (m/s, m/s²). `top_speed` may be a speed for each leg. It follows on the walk `lead`,
    if there is one, or on standing from `since` on. None where it can't come to rest, or slow down
    enough for a corner.
    """
    places, before, bounds = flat([*corners]), _NONE, _NONE
    if lead is not None:
        before, bounds, since = lead.walk, lead.box, lead.rests
    tops = numbers((top_speed,) if isinstance(top_speed, float | int) else top_speed)
    table = walk_table(
        places,
        tops,
        start if since is None else since,
        start,
        initial_speed,
        max_speed,
        max_acceleration,
        before,
    )
    if not table:
        return None
    box = room(4)
    bound(places, len(places), bounds, box)
    return Swath.of(table, box)


def paced(
    corners: Sequence[Corner],
    start: float,
    *,
    initial_speed: float = 0.0,
    top_speed: float | Sequence[float],
    max_speed: float,
    max_acceleration: float,
) -> Motion | None:
    """Return the walk of `pace` as a motion.

    Along `corners` (x, y in metres) from `start` (seconds), at `initial_speed` first, then at
    `top_speed` (or those of each leg), at corners at `max_speed` at most (m/s), with
    `max_acceleration` (m/s²). None where there is none.
    """
    found = pace(
        corners,
        float(start),
        initial_speed=initial_speed,
        top_speed=top_speed,
        max_speed=max_speed,
        max_acceleration=max_acceleration,
    )
    return None if found is None else walked(found, 0.0)
