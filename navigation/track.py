"""Tracks of bodies as plain numbers: a day of walking takes some megabytes."""

from __future__ import annotations

from array import array
from collections.abc import Iterator, Sequence
from typing import overload

import numpy as np

from .motion import JUMP_TOLERANCE, Array, Motion, Piece, gap, pieces_of

_NUMBERS = 14
"""Numbers of a piece: begin, end, and the coefficients of x, y and rotation."""


class Track:
    """Motions one after another, as they were carried out."""

    def __init__(self) -> None:
        self._numbers = array("d")
        self._jumps: set[float] = set()
        self._last: Piece | None = None

    def __repr__(self) -> str:
        return f"<Track of {len(self._numbers) // _NUMBERS} pieces>"

    def __bool__(self) -> bool:
        return self._last is not None

    def add(self, motion: Motion) -> None:
        """Go on with `motion`; if it starts elsewhere than the last one ended, that is a jump.

        `ValueError` if it doesn't start when the last one ended.
        """
        first, last = motion.pieces[0], self._last
        if last is not None:
            if last.end != first.begin:
                raise ValueError(f"a track has a gap from t = {last.end} s to {first.begin} s")
            if gap(last, first) > JUMP_TOLERANCE:
                self._jumps.add(first.begin)
        self._jumps |= motion.jumps
        self._numbers.extend(motion.table)
        self._last = motion.pieces[-1]

    def motion(self) -> Motion:
        """Return all of it until now as one motion."""
        table = np.frombuffer(self._numbers.tobytes()).reshape(-1, _NUMBERS)
        return Motion(PackedPieces(table), frozenset(self._jumps))


class PackedPieces(Sequence[Piece]):
    """Pieces that are made of a table (N, 14) of numbers as they are looked at."""

    def __init__(self, table: Array) -> None:
        self._table = table

    def __len__(self) -> int:
        return len(self._table)

    def __iter__(self) -> Iterator[Piece]:
        return pieces_of(self.flat())

    @overload
    def __getitem__(self, index: int) -> Piece: ...

    @overload
    def __getitem__(self, index: slice) -> PackedPieces: ...

    def __getitem__(self, index: int | slice) -> Piece | PackedPieces:
        if isinstance(index, slice):
            return PackedPieces(self._table[index])
        return next(pieces_of(self._table[index].tolist()))

    def flat(self) -> list[float]:
        """Return all numbers, one piece after another."""
        return list(self._table.ravel().tolist())

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, (PackedPieces, tuple)):
            return NotImplemented
        return tuple(self) == tuple(other)

    def __hash__(self) -> int:
        return hash(tuple(self))
