"""What is told where something can't be written."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path


class OutputError(OSError):
    """A file or folder that can't be written to."""


@contextmanager
def writing(path: Path, words: str = "can't write") -> Iterator[None]:
    """Tell the system's errors in this context as ones of writing `path`, in these `words`."""
    try:
        yield
    except OutputError:
        raise
    except OSError as why:
        raise OutputError(f"{words} {path}: {why.strerror or why}") from None
