"""Playback: a body walks as somebody was measured, whatever happens around it."""

from __future__ import annotations

from bisect import bisect_right

from navigation import Motion, Piece

from ..core.clock import Alarm, Turn
from ..core.stage import Stage
from .steering.crowd import Crowd
from .steering.traveller import Traveller
from .tracks.walks import RecordedWalk

AHEAD = 6.0
"""Seconds of the walk that others can foresee, at most. They see others' courses about as far."""

EVERY = 2.0
"""Seconds from one look ahead to the next."""


class Playback:
    """The walk of a `traveller`, from `begin` on. Others of the `crowd` walk round them.

    The body is committed to a part of the walk at a time, as people are to their courses: those
    who watch and those who steer see as far ahead as with anybody.
    """

    def __init__(
        self, stage: Stage, traveller: Traveller, walk: RecordedWalk, crowd: Crowd
    ) -> None:
        self._clock = stage.clock
        self._traveller = traveller
        self._walk = walk
        self._crowd = crowd
        self._begun_at = 0.0
        self._begins = [piece.begin for piece in walk.motion.pieces]
        self._next = Alarm(stage.clock, self._go_on, Turn.MOTION_ENDS)

    def begin(self) -> None:
        """Walk from now on."""
        self._begun_at = self._clock.now
        self._go_on()

    def _go_on(self) -> None:
        now = self._clock.now
        self._traveller.body.follow(self._part(now, now + AHEAD))
        self._crowd.make_way_for(self._traveller)
        if self._begun_at + self._walk.motion.end > now + EVERY:
            self._next.set(now + EVERY)

    def _part(self, begin: float, end: float) -> Motion:
        """Return the walk between two instants of the clock; it ends earlier if the walk does."""
        pieces, since = self._walk.motion.pieces, self._begun_at
        first = max(0, bisect_right(self._begins, begin - since) - 1)
        last = bisect_right(self._begins, end - since)
        near = tuple(_later(piece, since) for piece in pieces[first:last])
        jumps = frozenset(t + since for t in self._walk.motion.jumps)
        part = Motion(near, jumps & {piece.begin for piece in near[1:]})
        return part.cut(begin, max(begin, min(end, part.end)))


def _later(piece: Piece, seconds: float) -> Piece:
    return piece._replace(begin=piece.begin + seconds, end=piece.end + seconds)
