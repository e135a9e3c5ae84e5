"""The replay page: a recorded run as one HTML file that needs nothing else.

The page (`data/replay.html`) draws from the motions themselves, so that a recording is small and
exact at any speed. Here the recording is put into it.
"""

from __future__ import annotations

import html
import json
from collections.abc import Mapping
from importlib.resources import files
from typing import Any

FORMAT = "floorwalker-replay/1"
"""What `recording["format"]` says, so that a page can tell a recording it does not know."""

_TITLE = "{{title}}"
_RECORDING = "{{recording}}"


def render(recording: Mapping[str, Any]) -> str:
    """The page that replays `recording`, as HTML (to be written as UTF-8).

    `recording` has the form described in `docs/replay.md`: plain dicts, lists, strings and finite
    numbers. `ValueError` if its `format` is another, or if it holds what JSON can't say.
    """
    if recording.get("format") != FORMAT:
        raise ValueError(
            f"the replay page reads recordings of format {FORMAT!r}, "
            f"not {recording.get('format')!r}"
        )
    template = (files("sim") / "data" / "replay.html").read_text(encoding="utf-8")
    before_title, after_title = template.split(_TITLE)
    before_recording, after_recording = after_title.split(_RECORDING)
    title = html.escape(str(recording.get("title", "replay")))
    return "".join((before_title, title, before_recording, _embeddable(recording), after_recording))


def _embeddable(recording: Mapping[str, Any]) -> str:
    """`recording` as JSON that can stand inside an HTML script element.

    No `<` is left, so that neither `</script>` nor `<!--` in a name ends or upsets the element.
    """
    try:
        text = json.dumps(recording, allow_nan=False, separators=(",", ":"))
    except (TypeError, ValueError) as why:
        raise ValueError(f"the recording cannot be written as JSON: {why}") from None
    return text.replace("<", "\\u003c")
