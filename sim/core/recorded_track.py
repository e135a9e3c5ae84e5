"""Recorded tracks: where a file has the path that somebody walked."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class RecordedTrack:
    """The track of one body in `file`, which is looked up from the trial's folder.

    `body` is its name or number there: None for that of the person, or the only one there is. The
    person starts at the instant `since` of the file (seconds). Samples may be `longest_gap`
    seconds apart, and nobody moves faster than `top_speed` (m/s) from one to the next.
    `frame_rate` (1/s) is for files that count frames and don't say how many a second has.
    """

    file: str
    body: str | None = None
    since: float = 0.0
    longest_gap: float = 1.0
    top_speed: float = 4.0
    frame_rate: float | None = None
