"""What the commands write, and what they say where they can't."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path


@contextmanager
def writing(path: Path) -> Iterator[None]:
    """Say it in a sentence if `path` can't be written in this context."""
    try:
        yield
    except OSError as why:
        from ..recordings.recording import OutputError

        raise OutputError(f"can't write {path}: {why.strerror or why}") from None
