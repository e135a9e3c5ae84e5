"""Clauses of the programs in the package, kept beside the bytecode once they have been read."""

from __future__ import annotations

import os
import pickle
import sys
from contextlib import suppress
from functools import cache
from importlib.util import cache_from_source
from pathlib import Path

from ..errors import Problem
from .program import Clause
from .texts import read_clauses

_Read = tuple[tuple[Clause, ...], tuple[Problem, ...]]


@cache
def kept_clauses(source: str, file: str) -> _Read:
    """Return what `read_clauses` does of a program in the package, without reading it again.

    It is kept wherever Python may keep the bytecode of this package, and like that read anew when
    its text, its place or a file of the reader has changed.
    """
    folder = Path(cache_from_source(__file__)).parent
    kept = folder / f"{Path(file).stem}.{sys.implementation.cache_tag}.clauses"
    key = (source, file, _reader())
    with suppress(Exception), kept.open("rb") as stream:  # not there, or whatever damage does
        if pickle.load(stream) == key:
            found: _Read = pickle.load(stream)
            return found
    found = read_clauses(source, file)
    if folder.is_dir() and not sys.dont_write_bytecode:
        unfinished = kept.with_suffix(f".{os.getpid()}")
        with suppress(OSError):
            unfinished.write_bytes(pickle.dumps(key) + pickle.dumps(found))
            unfinished.replace(kept)
    return found


def _reader() -> list[tuple[str, int, int]]:
    """Return name, time and size of the files that read programs, as Python knows its bytecode."""
    with os.scandir(Path(__file__).parent) as entries:
        files = [(entry.name, entry.stat()) for entry in entries if entry.is_file()]
    return sorted((name, status.st_mtime_ns, status.st_size) for name, status in files)
