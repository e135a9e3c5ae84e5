"""Replay page: a recording as one HTML file without external resources.

The page draws from the motions themselves, so that a recording is small and exact at any speed. Its
parts are in `data/replay/`, one idea per file. Here they are joined with the recording.

A long recording is compressed. Its motions are then columns of numbers, in blocks of `BLOCK` pieces
of one body. The blocks are in order of time, so that a truncated page contains all bodies up to
some time.
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

from floorplan import UserError

from ..record.scene_file import parse_json

BLOCK = 512
"""Pieces in a block, except in the last one of a body."""

NUMBERS = 14
"""Numbers of a piece: begin, end, and four coefficients for x, y and rotation."""

FLOAT = np.dtype("<f8")


def pack(motions: Mapping[str, Sequence[Any]]) -> tuple[dict[str, Any], bytes] | None:
    """Return an index by body, and the bytes of all blocks, or None for another form of pieces.

    The index has the `count` of pieces of a body, and the byte at which each of its `blocks`
    begins. A block has the begins, the ends and the coefficients of its pieces.
    """
    index: dict[str, dict[str, Any]] = {}
    blocks = []
    for name, pieces in motions.items():
        try:
            rows = [_row(piece) for piece in pieces]
            table = np.array(rows, dtype=FLOAT).reshape(-1, NUMBERS)
        except (LookupError, TypeError, ValueError):
            return None
        if not np.isfinite(table).all():
            return None
        index[name] = {"count": len(table), "blocks": []}
        for first in range(0, len(table), BLOCK):
            part = table[first : first + BLOCK]
            content = part[:, 0].tobytes() + part[:, 1].tobytes() + part[:, 2:].tobytes()
            blocks.append((float(part[0, 0]), name, content))
    blocks.sort(key=lambda block: block[0])
    at = 0
    for _, name, content in blocks:
        index[name]["blocks"].append(at)
        at += len(content)
    return index, b"".join(content for *_, content in blocks)


def unpack(index: Mapping[str, Any], blocks: bytes) -> dict[str, list[Any]]:
    """Return the motions that were packed. `UserError` if index or blocks are damaged."""
    try:
        return {name: _pieces_in(blocks, **body) for name, body in index.items()}
    except (LookupError, TypeError, AttributeError, ValueError) as why:
        raise UserError(f"its motions can't be read: {why}") from None


def without_zeros(cubic: Sequence[float]) -> list[float]:
    """Return coefficients without trailing zeros, but at least one."""
    coefficients = list(cubic)
    while len(coefficients) > 1 and coefficients[-1] == 0.0:
        coefficients.pop()
    return coefficients


def _row(piece: Sequence[Any]) -> list[float]:
    """Return the numbers of a piece. `ValueError` if it has another form."""
    begin, end, *cubics = piece
    row = [begin, end]
    for cubic in cubics:
        row += [*cubic, *[0.0] * (4 - len(cubic))]
    if len(row) != NUMBERS or not all(map(len, cubics)):
        raise ValueError("a piece has another form")
    return row


def _pieces_in(content: bytes, count: int, blocks: Sequence[int]) -> list[Any]:
    pieces: list[Any] = []
    for at in blocks:
        size = min(BLOCK, count - len(pieces))
        numbers = np.frombuffer(content, FLOAT, NUMBERS * size, at)
        begins, ends, cubics = numbers[:size], numbers[size : 2 * size], numbers[2 * size :]
        pieces += [
            [begin, end, *map(without_zeros, axes)]
            for begin, end, axes in zip(
                begins.tolist(), ends.tolist(), cubics.reshape(-1, 3, 4).tolist(), strict=True
            )
        ]
    if len(pieces) != count:
        raise UserError("blocks are missing")
    return pieces


FORMAT = "floorwalker-replay/1"
"""Value of `format` of a recording that the page can read."""

PARTS = Path(__file__).parents[1] / "data" / "replay"
"""Folder of the parts of the page."""

PACKED_FROM = 500_000
"""Number of characters from which a recording is packed in its page."""

PIECE = 100
"""Approximate number of characters of a piece of motion."""

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
    "scanner",
    "waits",
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
"""Scripts of the page of a live run, which request further data."""


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
    """Return the recordings in a page made by `render`. `ValueError` if there are none."""
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
        raise UserError("is not a replay page: it contains no recording")
    return recordings


def says_itself(page: str) -> bool:
    """Return True if a damaged page is complete enough to show the rest of its recording."""
    return "Nothing but the recording comes after this line" in page


@cache
def _part(name: str) -> str:
    return (PARTS / name).read_text(encoding="utf-8")


def _elements(name: str, recording: Mapping[str, Any]) -> str:
    """Return the elements of a recording in its page: JSON, or three packed parts if it is long.

    The first part contains everything that the page shows immediately. The second part contains the
    motions. The third part has lines of JSON with the events and with the agent of each person,
    whose line number the first part contains.
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
    """Return the recording of that name in a page, or None."""
    content = _content_of(page, name)
    if content is None:
        return None
    recording: dict[str, Any] = parse_json(content.decode())
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
    """Return the unpacked content of an element of a page, or None if there is no such element."""
    element = re.search(rf'<script type="[\w/]+" id="{name}"([^>]*)>', page)
    if element is None:
        return None
    text = page[element.end() : page.find("</script>", element.end())]
    if "data-packed" not in element[1]:
        return text.encode()
    try:
        return zlib.decompress(base64.b64decode(text, validate=True))
    except zlib.error as why:
        raise UserError(str(why)) from None


def _check_format(recording: Any) -> None:
    form = recording.get("format") if isinstance(recording, Mapping) else None
    if form != FORMAT:
        raise UserError(f"the replay page reads recordings of format {FORMAT!r}, not {form!r}")


def _embeddable(recording: Mapping[str, Any]) -> str:
    """Return `recording` as JSON for an HTML script element.

    No `<` is left, so that neither `</script>` nor `<!--` in a name ends the element.
    """
    try:
        text = json.dumps(recording, allow_nan=False, separators=(",", ":"))
    except (TypeError, ValueError) as why:
        raise UserError(f"the recording cannot be written as JSON: {why}") from None
    return text.replace("<", "\\u003c")
