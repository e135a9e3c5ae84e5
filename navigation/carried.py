"""Motions of points that a body carries along: beside its axis, they turn with it."""

from __future__ import annotations

from .kernels import carrying
from .motion import Motion, motion_of

CLOSE = 1e-4
"""Metres. The cubics of a point stay this close to the arc on which it turns."""


def carried(motion: Motion, ahead: float, aside: float) -> Motion:
    """Return the motion of a point `ahead` of a body's axis and `aside` to its left, in metres.

    Where the body turns, the point is on an arc. Its cubics stay within `CLOSE` metres of it.
    """
    if not ahead and not aside:
        return motion
    return motion_of(carrying.carried(motion.table, ahead, aside, CLOSE), motion.jumps)
