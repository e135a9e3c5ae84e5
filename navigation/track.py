"""Tracks of bodies as plain numbers: a day of walking takes some megabytes."""

from __future__ import annotations

from array import array
from typing import overload

import numpy as np

from .kernels.pieces import breaks
from .motion import JUMP_TOLERANCE, WIDTH, Array, Motion, Piece, TablePieces, pieces_of


class Track:
    """Motions one after another, as they were carried out."""

    def __init__(self) -> None:
        self._numbers = array("d")
        self._jumps: set[float] = set()
        self._last: list[float] | None = None

    def __repr__(self) -> str:
        return f"<Track of {len(self._numbers) // WIDTH} pieces>"

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
        self._numbers.extend(table)
        self._last = table[-WIDTH:]

    def motion(self) -> Motion:
        """Return all of it until now as one motion."""
        table = np.frombuffer(self._numbers.tobytes()).reshape(-1, WIDTH)
        return Motion(PackedPieces(table), frozenset(self._jumps))


class PackedPieces(TablePieces):
    """Pieces that are made of a table (N, 14) of numbers as they are looked at."""

    def __init__(self, table: Array) -> None:
        self._table = table

    def __len__(self) -> int:
        return len(self._table)

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
