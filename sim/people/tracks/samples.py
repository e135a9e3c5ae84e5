"""Samples of bodies that were tracked, as files have them."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from floorplan import LARGEST, SMALLEST, InputError

Array = NDArray[np.float64]


class TrackError(InputError):
    """A file of tracks that can't be used."""


def frame_rate(given: float, path: Path, line: int | None = None) -> float:
    """Return the number of frames a second that a file gives; `TrackError` if it can't be."""
    if not SMALLEST <= given <= LARGEST:
        message = f"the frame rate must be a number from {SMALLEST:g} to {LARGEST:g}"
        raise TrackError.of(path, message, line)
    return given


@dataclass(frozen=True, eq=False)
class Samples:
    """One body at N instants: `t` in seconds or frames, `x` and `y` in metres, each (N,).

    `rotation` is in radians, None where the file has none; `rows` says where in the file each
    sample stands: its line, its frame, or its message of what is called `place`.
    """

    rows: NDArray[np.int64]
    t: Array
    x: Array
    y: Array
    rotation: Array | None = None
    place: str = ""


@dataclass(frozen=True, eq=False)
class Tracks:
    """The bodies of a file, by name or number.

    Where `t` counts frames, `frame_rate` is how many a second has, None if the file says nothing.
    """

    bodies: dict[str, Samples]
    counts_frames: bool = False
    frame_rate: float | None = None
    row: Literal["line", "row", "frame", "message"] = "line"
