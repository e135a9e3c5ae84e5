"""Playback of recorded walks among other people."""

from __future__ import annotations

import math
from bisect import bisect_right
from collections.abc import Callable
from functools import partial

from navigation import Motion, Piece, join, standing

from ...core.clock import Alarm, Turn
from ...core.stage import Stage
from ..crowd.crowd import Crowd
from ..crowd.traveller import Traveller
from .recorded_walks import RecordedWalk

AHEAD = 6.0
"""Part of the walk that other people can foresee, s, similar to their own foresight."""

EVERY = 2.0
"""Time between two updates of that part, s."""


class Playback:
    """Recorded walk of a `traveller` among the other people of a `crowd`.

    The body is committed to one part of the walk at a time, so that monitors and other people see
    as far ahead as for people who decide.
    """

    def __init__(
        self,
        stage: Stage,
        traveller: Traveller,
        walk: RecordedWalk,
        crowd: Crowd,
        notify: Callable[[bool], None],
    ) -> None:
        self._clock = stage.clock
        self._traveller = traveller
        self._stays = walk.stays
        x, y, heading = walk.motion.state(0.0).position
        self._motion = join([standing((x, y), heading=heading, start=0.0), walk.motion])
        self._crowd = crowd
        self._notify = notify
        self._begun_at = 0.0
        self._begins = [piece.begin for piece in self._motion.pieces]
        self._next = Alarm(stage.clock, self._go_on, Turn.MOTION_ENDS)

    def begin(self) -> None:
        """Walk from now on, and notify of later entries (True) and exits (False)."""
        self._begun_at = now = self._clock.now
        self._go_on()
        for stay in self._stays:
            for t, on_floor in zip(stay, (True, False), strict=True):
                if 0.0 < t < math.inf:
                    change = partial(self._come_or_go, on_floor)
                    self._clock.call_at(now + t, change, Turn.MOTION_ENDS)

    def _come_or_go(self, on_floor: bool) -> None:
        self._go_on()
        for jumped in self._traveller.body.on_jump:
            jumped()
        self._notify(on_floor)

    def _go_on(self) -> None:
        now = self._clock.now
        self._traveller.body.follow(self._part(now, now + AHEAD))
        self._crowd.make_way_for(self._traveller)
        if self._begun_at + self._motion.end > now + EVERY:
            self._next.set(now + EVERY)

    def _part(self, begin: float, end: float) -> Motion:
        """Return the walk between two times of the clock (s), or up to its end."""
        pieces, since = self._motion.pieces, self._begun_at
        first = max(0, bisect_right(self._begins, begin - since) - 1)
        last = bisect_right(self._begins, end - since)
        near = tuple(_later(piece, since) for piece in pieces[first:last])
        jumps = frozenset(t + since for t in self._motion.jumps)
        part = Motion(near, jumps & {piece.begin for piece in near[1:]})
        return part.cut(begin, max(begin, min(end, part.end)))


def _later(piece: Piece, seconds: float) -> Piece:
    return piece._replace(begin=piece.begin + seconds, end=piece.end + seconds)
