"""Files with tracks: find and read them by their kind."""

from __future__ import annotations

import stat
from collections.abc import Iterator
from functools import lru_cache
from pathlib import Path

from floorplan.files.reading import is_there

from ...core.entries import RecordedTrack
from .tables import (
    TrackError,
    Tracks,
    read_hdf5_tracks,
    read_jupedsim_tracks,
    read_parquet_tracks,
    read_text_tracks,
)

METADATA = "metadata.yaml"
"""File that marks a folder as a bag."""

LIBRARIES = ("rosbags", "mcap", "mcap_protobuf")
"""Packages of the extra that reads them."""


def read_bag_tracks(path: Path) -> Tracks:
    """Return the bodies in the bag at `path`: a folder, or a single file of its storage.

    An MCAP file may have Foxglove's schemas instead.

    A `TrackError` names the problem, or the package to install.
    """
    for file in files_of(path):
        if not stat.S_ISREG(file.stat().st_mode):
            raise TrackError.of(path, f"{file.name} is not a regular file")
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
    """Yield the files of a track: `path`, or the files of a bag in this folder."""
    if not path.is_dir():
        yield path
        return
    if (path / "scene.json").is_file():
        raise TrackError.of(path, "this folder is a recorded run: give its trajectory.csv")
    if not (path / METADATA).is_file():
        raise TrackError.of(path, f"there is no {METADATA} in it: this folder is not a ROS 2 bag")
    yield from sorted(file for file in path.iterdir() if not file.is_dir())


READERS = {
    ".csv": read_text_tracks,
    ".txt": read_text_tracks,
    ".parquet": read_parquet_tracks,
    ".h5": read_hdf5_tracks,
    ".hdf5": read_hdf5_tracks,
    ".sqlite": read_jupedsim_tracks,
    ".mcap": read_bag_tracks,
    ".db3": read_bag_tracks,
}
"""Readers of files with tracks, by suffix. A folder is a bag of ROS 2."""


def read_tracks(recorded: RecordedTrack, folder: Path) -> Tracks:
    """Return the tracks of a file in `folder`, or raise a `TrackError`."""
    path = folder / recorded.file
    try:
        if path.suffix.lower() not in READERS and not path.is_dir():
            known = ", ".join(READERS)
            message = (
                f"the name of a file of tracks ends in one of {known}, or it is a bag's folder"
            )
            raise TrackError.of(recorded.file, message)
        if not is_there(path):
            raise TrackError.of(recorded.file, "there is no such file")
        stamps = [(file.stat().st_mtime_ns, file.stat().st_size) for file in files_of(path)]
        return _read(path, tuple(stamps))
    except TrackError as why:
        raise TrackError(recorded.file, why.problems) from None
    except OSError as why:
        raise TrackError.of(recorded.file, f"can't be read: {why.strerror}") from None


@lru_cache(maxsize=8)
def _read(path: Path, stamps: tuple[tuple[int, int], ...]) -> Tracks:
    """Return the tracks at `path`, cached until the times or sizes of its files change."""
    read = read_bag_tracks if path.is_dir() else READERS[path.suffix.lower()]
    return read(path)
