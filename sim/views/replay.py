"""Replay page: a recording as one HTML file without external resources.

A number of a recording is a multiple of 10⁻⁹ (`rounded`), so that it is an integer here, and comes
back as it was. Most pieces begin where, when and as fast as the piece before them ends: of the
begin, the place and the velocity only the difference from that is written. Integers are written in
groups of seven bits, the lowest first, as Protocol Buffers do (zigzag, base 128).

Pieces lie in blocks of `BLOCK` pieces of one body, which are read one by one: the page reads what
it is about to show. All blocks stand in the order of time: what there is of a page that is cut off
holds everybody up to some instant.

The page draws from the motions themselves, so that a recording is small and exact at any speed.
Its parts lie in `data/replay/`, one idea a file; here they are joined, and the recording is put
into them.
"""

from __future__ import annotations

import base64
import html
import json
import re
import zlib
from collections.abc import Mapping, Sequence
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from floorplan import UserError

from ..record.scene_file import parse_json

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


FORMAT = "floorwalker-replay/1"
"""The `format` of a recording, by which a page knows one that it can read."""

PARTS = Path(__file__).parents[1] / "data" / "replay"
"""Folder of the parts of the page."""

PACKED_FROM = 1_500_000
"""Characters of a recording from which it stands packed in its page."""

PIECE = 100
"""Characters of a piece of a motion, about."""

SCRIPTS = (
    "cut",
    "packed",
    "recording",
    "motion",
    "track",
    "separation",
    "mind",
    "run",
    "events",
    "canvas",
    "camera",
    "floor",
    "bodies",
    "passing",
    "field",
    "scene",
    "frames",
    "sight",
    "solids",
    "renderer",
    "furniture",
    "path_ahead",
    "figure",
    "machinery",
    "world",
    "eye",
    "marks",
    "gestures",
    "view",
    "space_view",
    "views",
    "chart",
    "panel",
    "mind_panel",
    "event_list",
    "summary",
    "panels",
    "clock",
    "replay",
    "start",
)
"""The page's scripts in reading order."""

LIVE_SCRIPTS = ("placing", "control", "live")
"""Those that only the page of a run under way has: they ask for more than the page holds."""


def render(
    recording: Mapping[str, Any],
    other: Mapping[str, Any] | None = None,
    *,
    stream: str = "",
    speed: float = 1.0,
) -> str:
    """Return the page that replays `recording`, as HTML (to be written as UTF-8).

    `recording` has the form described in `docs/replay-format.md`, with plain dicts, lists, strings
    and finite numbers. `other` is shown beside it. With `stream`, the page follows a live run: it
    receives additions from that address beside the page, at `speed` times real time.

    Raises `ValueError` for a recording of another `format`, or one that is not JSON.
    """
    live = {"data-stream": stream, "data-speed": f"{speed:g}"} if stream else {}
    scripts = (*SCRIPTS, *LIVE_SCRIPTS) if stream else SCRIPTS
    contents = {
        "title": html.escape(str(recording.get("title", "replay"))),
        "style": _part("page.css"),
        "script": "\n".join(_part(f"{name}.js") for name in scripts),
        "recording": _elements("recording", recording),
        "other": "" if other is None else _elements("other", other),
        "attributes": "".join(f' {name}="{html.escape(live[name])}"' for name in live),
        "sources": "; connect-src 'self'" if stream else "",
    }
    return re.sub(r"\{\{(\w+)\}\}", lambda place: contents[place[1]], _part("page.html"))


def recordings_in(page: str) -> list[dict[str, Any]]:
    """Return the one or two recordings in a page made by `render`; `ValueError` if none."""
    recordings = []
    for name in ("recording", "other"):
        try:
            recording = _recording_in(page, name)
        except ValueError as why:
            raise UserError(f"the {name} in it is damaged: {why}") from None
        if recording is not None:
            _check_format(recording)
            recordings.append(recording)
    if not recordings:
        raise UserError("is no replay page: it holds no recording")
    return recordings


def says_itself(page: str) -> bool:
    """Return whether a page of ours is whole enough to show what there is of its recording."""
    return "Nothing but the recording comes after this line" in page


@cache
def _part(name: str) -> str:
    return (PARTS / name).read_text(encoding="utf-8")


def _elements(name: str, recording: Mapping[str, Any]) -> str:
    """Return a recording as it stands in the page: as JSON, or a long one packed in three parts.

    The first has what the page shows at once; then come the motions, and at last lines of JSON with
    the events, and with each person's mind, of which the first knows the number of the line.
    """
    _check_format(recording)
    motions = recording.get("motions", {})
    if PIECE * sum(map(len, motions.values())) < PACKED_FROM:
        text = _embeddable(recording)
        if len(text) < PACKED_FROM:
            return f'<script type="application/json" id="{name}">{text}</script>'
    minds = recording.get("minds", {})
    numbers = {person: number for number, person in enumerate(minds, 1)}
    first = {**recording, **({"minds": numbers} if minds else {})}
    rest = [{"events": first.pop("events", [])}, *({"minds": {who: minds[who]}} for who in minds)]
    packed = pack(motions)
    if packed is not None:
        first["motions"] = packed[0]
    parts = [
        (name, _embeddable(first).encode()),
        (f"{name}-motions", b"" if packed is None else packed[1]),
        (f"{name}-rest", "\n".join(map(_embeddable, rest)).encode()),
    ]
    return "\n".join(_packed_element(part, content) for part, content in parts)


def _packed_element(name: str, content: bytes) -> str:
    packed = base64.b64encode(zlib.compress(content, 6)).decode()
    return f'<script type="text/plain" id="{name}" data-packed="deflate">{packed}</script>'


def _recording_in(page: str, name: str) -> dict[str, Any] | None:
    """Return the recording of that name in a page, None if there is none."""
    found = _content_of(page, name)
    if found is None:
        return None
    recording: dict[str, Any] = parse_json(found.decode())
    rest, motions = (_content_of(page, f"{name}-{part}") for part in ("rest", "motions"))
    if rest is None or motions is None or not isinstance(recording, dict):
        return recording
    events, *minds = map(parse_json, rest.decode().split("\n"))
    try:
        recording |= events
        if minds:
            recording["minds"] = {
                who: mind["minds"][who] for who, mind in zip(recording["minds"], minds, strict=True)
            }
    except (LookupError, TypeError, ValueError) as why:
        raise UserError(f"its minds can't be read: {why}") from None
    if motions:
        recording["motions"] = unpack(recording["motions"], motions)
    return recording


def _content_of(page: str, name: str) -> bytes | None:
    """Return what stands in an element of a page, unpacked; None if there is no such element."""
    found = re.search(rf'<script type="[\w/]+" id="{name}"([^>]*)>', page)
    if found is None:
        return None
    text = page[found.end() : page.find("</script>", found.end())]
    if "data-packed" not in found[1]:
        return text.encode()
    try:
        return zlib.decompress(base64.b64decode(text, validate=True))
    except zlib.error as why:
        raise UserError(str(why)) from None


def _check_format(recording: Any) -> None:
    found = recording.get("format") if isinstance(recording, Mapping) else None
    if found != FORMAT:
        raise UserError(f"the replay page reads recordings of format {FORMAT!r}, not {found!r}")


def _embeddable(recording: Mapping[str, Any]) -> str:
    """`recording` as JSON that can stand inside an HTML script element.

    No `<` is left, so that neither `</script>` nor `<!--` in a name ends the element.
    """
    try:
        text = json.dumps(recording, allow_nan=False, separators=(",", ":"))
    except (TypeError, ValueError) as why:
        raise UserError(f"the recording cannot be written as JSON: {why}") from None
    return text.replace("<", "\\u003c")
