"""Motions in the page of a long run, where a number that follows from others takes a byte or two.

A number of a recording is a multiple of 10⁻⁹ (`rounded`), so that it is an integer here, and comes
back as it was. Most pieces begin where, when and as fast as the piece before them ends: of the
begin, the place and the velocity only the difference from that is written. Integers are written in
groups of seven bits, the lowest first, as Protocol Buffers do (zigzag, base 128).

Pieces lie in blocks of `BLOCK` pieces of one body, which are read one by one: the page reads what
it is about to show. All blocks stand in the order of time: what there is of a page that is cut off
holds everybody up to some instant.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from floorplan import UserError

BLOCK = 512
"""Pieces in a block, but for the last one of a body."""

UNIT = 1e9
"""Integers to a second, metre or radian."""

LARGEST = 2**51
"""Integers up to here, and their differences, are exact as the floats that the page has."""

JUMP = 1000
"""Integers: a body that is so far (1 µm) from where the piece before ended has jumped."""

_Integers = NDArray[np.int64]
_Floats = NDArray[np.float64]


def pack(motions: Mapping[str, Sequence[Any]]) -> tuple[dict[str, Any], bytes] | None:
    """Return an index by body, and the bytes of all blocks; None where numbers have other forms.

    A body has the `count` of its pieces, the numbers of those with which it `jumps`, and for each
    of its `blocks` the time at which it begins (s), how far the body has gone by then (m), and
    which bytes it is: the first, and how many.
    """
    index: dict[str, dict[str, Any]] = {}
    blocks = []
    for name, pieces in motions.items():
        packed = _packed(pieces)
        if packed is None:
            return None
        lengths, table = packed
        gone = np.concatenate([[0.0], np.cumsum(_path_lengths(table))])
        jumps = np.hypot(*_gaps(table)[1:, [2, 6]].T) > JUMP
        index[name] = {
            "count": len(table),
            "jumps": (np.flatnonzero(jumps) + 1).tolist(),
            "blocks": [],
        }
        for first in range(0, len(table), BLOCK):
            part = slice(first, first + BLOCK)
            begin, block = pieces[first][0], _written(lengths[part], table[part])
            blocks.append((begin, name, round(float(gone[first]), 3), block))
    blocks.sort(key=lambda block: block[0])
    at = 0
    for begin, name, way, block in blocks:
        index[name]["blocks"].append([begin, way, at, len(block)])
        at += len(block)
    return index, b"".join(block for *_, block in blocks)


def unpack(index: Mapping[str, Any], blocks: bytes) -> dict[str, list[Any]]:
    """Return the motions that `pack` was given; `ValueError` where index or blocks are damaged."""
    try:
        return {name: _pieces_of(body, blocks) for name, body in index.items()}
    except (LookupError, TypeError, AttributeError, ValueError) as why:
        raise UserError(f"its motions can't be read: {why}") from None


def _packed(pieces: Sequence[Any]) -> tuple[_Integers, _Integers] | None:
    """Return the numbers of coefficients of each piece, (N, 3), and all its figures, (N, 14)."""
    try:
        lengths = np.array([list(map(len, piece[2:])) for piece in pieces], dtype=np.int64)
        flat = [n for b, e, *axes in pieces for n in (b, e, *axes[0], *axes[1], *axes[2])]
        numbers = np.array(flat, dtype=np.float64)
    except (LookupError, TypeError, ValueError):
        return None
    if lengths.ndim != 2 or lengths.shape[1] != 3 or not ((lengths > 0) & (lengths < 5)).all():
        return None
    if not np.abs(numbers * UNIT).max() < LARGEST:
        return None
    integers = np.rint(numbers * UNIT).astype(np.int64)
    # Each number must come back to the last bit, or the page would not show what was recorded.
    if not (integers / UNIT == numbers).all():
        return None
    table = np.zeros((len(pieces), 14), dtype=np.int64)
    table[_written_ones(lengths)] = integers
    steady = all(np.abs(values).max() < LARGEST for values in (_gaps(table), _ahead(table)))
    return (lengths, table) if steady else None


def _written_ones(lengths: _Integers) -> NDArray[np.bool_]:
    """Return which figures of pieces are written: begin, end, and the coefficients there are."""
    there = np.arange(4) < lengths[:, :, None]
    return np.hstack([np.ones((len(lengths), 2), dtype=np.bool_), there.reshape(-1, 12)])


def _gaps(table: _Integers) -> _Integers:
    """Return all numbers, less what follows from the piece before, or (the end) from the begin."""
    gaps = table.copy()
    gaps[:, 1] -= table[:, 0]
    gaps[1:, 0] -= table[:-1, 1]
    gaps[1:] -= _ahead(table)[:-1]
    return gaps


def _ahead(table: _Integers) -> _Integers:
    """Return place and velocity at the end of each piece, in the columns of c₀ and c₁."""
    ahead = np.zeros_like(table)
    for k in (2, 6, 10):
        place, velocity = _gains(table[:, 1] - table[:, 0], table[:, k : k + 4])
        ahead[:, k] = table[:, k] + place
        ahead[:, k + 1] = table[:, k + 1] + velocity
    return ahead


def _gains(duration: _Integers, cubic: _Integers) -> tuple[_Integers, _Integers]:
    """Return what place and velocity gain in pieces of that duration.

    The page does the same, operation by operation: the result is the same to the last bit.
    """
    u = duration / UNIT
    _, c1, c2, c3 = (cubic / UNIT).T
    gains = u * (c1 + u * (c2 + u * c3)), u * (2.0 * c2 + u * (3.0 * c3))
    # What is cut here is beyond `LARGEST`, whatever it is added to.
    place, velocity = (np.clip(np.floor(UNIT * g + 0.5), -4 * LARGEST, 4 * LARGEST) for g in gains)
    return place.astype(np.int64), velocity.astype(np.int64)


def _path_lengths(table: _Integers) -> _Floats:
    """Return how far the body goes in each piece, by Gauss's rule with three points."""
    numbers = table / UNIT
    half = (numbers[:, 1] - numbers[:, 0]) / 2
    # Its nodes are 0 and ± √(3 / 5), its weights 8 / 9 and 5 / 9.
    aside = half * np.sqrt(0.6)

    def speed(u: _Floats) -> _Floats:
        vx, vy = (
            numbers[:, k + 1] + u * (2 * numbers[:, k + 2] + 3 * u * numbers[:, k + 3])
            for k in (2, 6)
        )
        return np.asarray(np.hypot(vx, vy))

    return (half / 9) * (5 * speed(half - aside) + 8 * speed(half) + 5 * speed(half + aside))


def _written(lengths: _Integers, table: _Integers) -> bytes:
    """Return a block: a byte for the lengths of each piece, then its numbers."""
    gaps = _gaps(table)[_written_ones(lengths)]
    heads = ((lengths - 1) << np.array([0, 2, 4])).sum(axis=1).astype(np.uint8)
    return bytes(heads.tobytes()) + _bytes_of(gaps)


def _bytes_of(integers: _Integers) -> bytes:
    # Zigzag: 0, -1, 1, -2 … become 0, 1, 2, 3 …, so that small ones of either sign are short.
    coded = ((integers << 1) ^ (integers >> 63)).astype(np.uint64)
    groups = np.ones(len(coded), dtype=np.int64)
    for bits in range(7, 64, 7):
        groups += coded >= np.uint64(1 << bits)
    at = np.cumsum(groups) - groups
    written = np.zeros(int(groups.sum()), dtype=np.uint8)
    for k in range(int(groups.max(initial=0))):
        some = groups > k
        seven = (coded[some] >> np.uint64(7 * k)) & np.uint64(127)
        written[at[some] + k] = seven | ((groups[some] > k + 1).astype(np.uint64) << np.uint64(7))
    return written.tobytes()


def _pieces_of(body: Mapping[str, Any], blocks: bytes) -> list[Any]:
    pieces: list[Any] = []
    for _, _, at, size in body["blocks"]:
        count = min(BLOCK, body["count"] - len(pieces))
        pieces += _read(blocks[at : at + size], count)
    if len(pieces) != body["count"]:
        raise UserError("blocks are missing")
    return pieces


def _read(block: bytes, count: int) -> list[Any]:
    """Return the pieces of a block; `ValueError` if it has more or fewer numbers."""
    heads = np.frombuffer(block[:count], dtype=np.uint8).astype(np.int64)
    lengths = 1 + ((heads[:, None] >> np.array([0, 2, 4])) & 3)
    there = _written_ones(lengths)
    integers = _integers_in(np.frombuffer(block[count:], dtype=np.uint8))
    if len(integers) != there.sum():
        raise UserError("numbers are missing")
    table = np.zeros((count, 14), dtype=np.int64)
    table[there] = integers
    # As they follow from each other: times alone, velocities from these and from c₂ and c₃, which
    # stand as they are, and places from all of them.
    table[:, 1] = np.cumsum(table[:, 0] + table[:, 1])
    table[1:, 0] += table[:-1, 1]
    duration = table[:, 1] - table[:, 0]
    for k in (2, 6, 10):
        cubic = table[:, k : k + 4]
        cubic[1:, 1] += _gains(duration, cubic)[1][:-1]
        cubic[:, 1] = _sums(cubic[:, 1], ~there[:, k + 1])
        cubic[1:, 0] += _gains(duration, cubic)[0][:-1]
        cubic[:, 0] = np.cumsum(cubic[:, 0])
    numbers = (table / UNIT).tolist()
    return [
        [row[0], row[1], *(row[k : k + n] for k, n in zip((2, 6, 10), sizes, strict=True))]
        for row, sizes in zip(numbers, lengths.tolist(), strict=True)
    ]


def _sums(steps: _Integers, starts: NDArray[np.bool_]) -> _Integers:
    """Return the running sums of steps, which are 0 again at each of the `starts`."""
    # The sum of all steps so far, less what that was at the last start.
    steps = np.where(starts, 0, steps)
    sums = np.cumsum(steps)
    last = np.maximum.accumulate(np.where(starts, np.arange(len(steps)), -1))
    return sums - np.where(last >= 0, sums[last], 0)


def _integers_in(written: NDArray[np.uint8]) -> _Integers:
    """Return the integers that `_bytes_of` has written."""
    ends = np.flatnonzero(written < 128)
    if not len(ends) or ends[-1] != len(written) - 1:
        return np.zeros(0, dtype=np.int64)
    begins = np.concatenate([[0], ends[:-1] + 1])
    place = np.arange(len(written)) - np.repeat(begins, ends - begins + 1)
    # Nine groups of seven bits are all of 63; more would be a damaged file.
    if place.max() > 8:
        return np.zeros(0, dtype=np.int64)
    parts = (written & 127).astype(np.int64) << (7 * place)
    coded = np.add.reduceat(parts, begins)
    return np.asarray((coded >> 1) ^ -(coded & 1))
