"""The replay page: a recorded run as one HTML file that needs nothing else.

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
from collections.abc import Mapping
from functools import cache
from importlib.resources import files
from typing import Any

from ..record.strict_json import parse_json

FORMAT = "floorwalker-replay/1"
"""The `format` of a recording, by which a page knows one that it can read."""

PACKED_FROM = 1_500_000
"""Characters of a recording from which it stands packed in its page."""

SCRIPTS = (
    "cut",
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

LIVE_SCRIPTS = ("control", "live")
"""Those that only the page of a run under way has: they ask for more than the page holds."""


def render(
    recording: Mapping[str, Any],
    other: Mapping[str, Any] | None = None,
    *,
    stream: str = "",
    speed: float = 1.0,
) -> str:
    """Return the page that replays `recording`, as HTML (to be written as UTF-8).

    `recording` has the form described in `docs/replay.md`: plain dicts, lists, strings and finite
    numbers; an `other` is shown beside it. With a `stream`, the page follows a run under way:
    what is added to the recording comes from that address beside the page, `speed` times as fast
    as it happens. `ValueError` for a recording of another `format`, or one that isn't JSON.
    """
    live = {"data-stream": stream, "data-speed": f"{speed:g}"} if stream else {}
    scripts = (*SCRIPTS, *LIVE_SCRIPTS) if stream else SCRIPTS
    contents = {
        "title": html.escape(str(recording.get("title", "replay"))),
        "style": _part("page.css"),
        "script": "\n".join(_part(f"{name}.js") for name in scripts),
        "recording": _element("recording", recording),
        "other": "" if other is None else _element("other", other),
        "attributes": "".join(f' {name}="{html.escape(live[name])}"' for name in live),
        "sources": "; connect-src 'self'" if stream else "",
    }
    return re.sub(r"\{\{(\w+)\}\}", lambda place: contents[place[1]], _part("page.html"))


def recordings_in(page: str) -> list[dict[str, Any]]:
    """Return the one or two recordings in a page made by `render`; `ValueError` if none."""
    recordings = []
    for name in ("recording", "other"):
        found = re.search(rf'<script type="[\w/]+" id="{name}"([^>]*)>(.*?)</script>', page, re.S)
        if found is not None:
            try:
                text = _unpacked(found[2]) if "data-packed" in found[1] else found[2]
                recordings.append(parse_json(text))
            except ValueError as why:
                raise ValueError(f"the {name} in it is damaged: {why}") from None
            _check_format(recordings[-1])
    if not recordings:
        raise ValueError("is no replay page: it holds no recording")
    return recordings


@cache
def _part(name: str) -> str:
    return (files("sim") / "data" / "replay" / name).read_text(encoding="utf-8")


def _element(name: str, recording: Mapping[str, Any]) -> str:
    _check_format(recording)
    text = _embeddable(recording)
    if len(text) < PACKED_FROM:
        return f'<script type="application/json" id="{name}">{text}</script>'
    packed = base64.b64encode(zlib.compress(text.encode(), 6)).decode()
    return f'<script type="text/plain" id="{name}" data-packed="deflate">{packed}</script>'


def _unpacked(text: str) -> str:
    try:
        return zlib.decompress(base64.b64decode(text, validate=True)).decode()
    except zlib.error as why:
        raise ValueError(str(why)) from None


def _check_format(recording: Any) -> None:
    found = recording.get("format") if isinstance(recording, Mapping) else None
    if found != FORMAT:
        raise ValueError(f"the replay page reads recordings of format {FORMAT!r}, not {found!r}")


def _embeddable(recording: Mapping[str, Any]) -> str:
    """`recording` as JSON that can stand inside an HTML script element.

    No `<` is left, so that neither `</script>` nor `<!--` in a name ends the element.
    """
    try:
        text = json.dumps(recording, allow_nan=False, separators=(",", ":"))
    except (TypeError, ValueError) as why:
        raise ValueError(f"the recording cannot be written as JSON: {why}") from None
    return text.replace("<", "\\u003c")
