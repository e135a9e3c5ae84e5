"""Tracks of bodies as plain numbers: a day of walking takes some megabytes."""

from __future__ import annotations

from array import array

from .kernels.odometer import WIDTH
from .kernels.pieces import breaks, packed, unpacked
from .motion import JUMP_TOLERANCE, Motion, TablePieces


class Track:
    """Motions one after another, as they were carried out."""

    def __init__(self) -> None:
        self._masks = array("H")
        self._kept = array("d")
        """The numbers of all pieces as `packed`."""
        self._jumps: set[float] = set()
        self._last: list[float] | None = None

    def __repr__(self) -> str:
        return f"<Track of {len(self._masks)} pieces>"

    def __bool__(self) -> bool:
        return self._last is not None

    def add(self, motion: Motion) -> None:
        """Go on with `motion`; if it starts elsewhere than the last one ended, that is a jump.

        `ValueError` if it doesn't start when the last one ended.
        """
        table, last = motion.table, self._last
        if last is not None:
            if last[1] != table[0]:
                raise ValueError(f"a track has a gap from t = {last[1]} s to {table[0]} s")
            if breaks([*last, *table[:WIDTH]], JUMP_TOLERANCE):
                self._jumps.add(table[0])
        self._jumps |= motion.jumps
        masks, kept = packed(table)
        self._masks.extend(masks)
        self._kept.extend(kept)
        self._last = table[-WIDTH:]

    def motion(self) -> Motion:
        """Return all of it until now as one motion."""
        table = unpacked(self._masks.tolist(), self._kept.tolist())
        return Motion(TablePieces(table), frozenset(self._jumps))
