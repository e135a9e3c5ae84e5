"""Tracks of bodies as plain numbers: a day of walking takes some megabytes."""

from __future__ import annotations

from .kernels.pieces import Pack
from .motion import JUMP_TOLERANCE, Motion, TablePieces


class Track:
    """Motions one after another, as they were carried out."""

    def __init__(self) -> None:
        self._pack = Pack()
        self._jumps: set[float] = set()
        self._end: float | None = None

    def __repr__(self) -> str:
        return f"<Track of {self._pack.count} pieces>"

    def __bool__(self) -> bool:
        return self._end is not None

    def add(self, motion: Motion, begin: float, end: float) -> None:
        """Go on with `motion` from `begin` to `end` (seconds).

        If it is elsewhere then than where the last one ended, that is a jump. `ValueError` if it
        doesn't begin when the last one ended.
        """
        if self._end is not None and self._end != begin:
            raise ValueError(f"a track has a gap from t = {self._end} s to {begin} s")
        self._end = end
        if self._pack.add(motion.table, begin, end, JUMP_TOLERANCE):
            self._jumps.add(begin)
        if motion.jumps:
            self._jumps.update(t for t in motion.jumps if begin < t < end)

    def motion(self) -> Motion:
        """Return all of it until now as one motion."""
        return Motion(TablePieces(self._pack.pieces()), frozenset(self._jumps))
