"""Bags of ROS 2 and files of Foxglove: where one is, and what reads it."""

from __future__ import annotations

import stat
from collections.abc import Iterator
from pathlib import Path

from .samples import TrackError, Tracks

METADATA = "metadata.yaml"
"""File that a folder has which is a bag."""

LIBRARIES = ("rosbags", "mcap", "mcap_protobuf")
"""Packages of the extra that reads them."""


def read_bag_tracks(path: Path) -> Tracks:
    """Return the bodies in the bag at `path`: a folder, or a single file of its storage.

    An MCAP file may have Foxglove's schemas instead.

    `TrackError` says what is wrong with it, or what to install.
    """
    for file in files_of(path):
        if not stat.S_ISREG(file.stat().st_mode):
            raise TrackError.of(path, f"{file.name} is no regular file")
    try:
        from .bag_file import read

        return read(path)
    except ModuleNotFoundError as why:
        if (why.name or "").partition(".")[0] not in LIBRARIES:
            raise
        raise TrackError.of(
            path, f"{why.name} reads such files and is missing: pip install 'floorwalker[tracks]'"
        ) from None


def files_of(path: Path) -> Iterator[Path]:
    """Yield the files that a track is read from: `path`, or those of the bag in this folder."""
    if not path.is_dir():
        yield path
        return
    if (path / "scene.json").is_file():
        raise TrackError.of(path, "this folder is a recorded run: give its trajectory.csv")
    if not (path / METADATA).is_file():
        raise TrackError.of(path, f"there is no {METADATA} in it: this folder is no ROS 2 bag")
    yield from sorted(file for file in path.iterdir() if not file.is_dir())
