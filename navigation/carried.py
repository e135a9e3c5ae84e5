"""Motions of points that a body carries beside its axis."""

from __future__ import annotations

from .kernels import carrying
from .motion import Motion, motion_of

CLOSE = 1e-4
"""Metres. Maximum error of the cubics of a point that turns on an arc."""


def carried(motion: Motion, ahead: float, aside: float) -> Motion:
    """Return the motion of a point `ahead` of a body's axis and `aside` to its left, in metres.

    If the body turns, the point moves on an arc. The error of its cubics is at most `CLOSE`.
    """
    if not ahead and not aside:
        return motion
    return motion_of(carrying.carried(motion.table, ahead, aside, CLOSE), motion.jumps)
