"""Output files: names of folders, and files that are replaced completely or not changed."""

from __future__ import annotations

import os
import re
import shutil
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path


def folder_for(name: str, parent: str) -> Path:
    """Return the folder in `parent` for a trial or study of any name."""
    plain = re.sub(r"[/\\]", "-", name)
    return Path(parent) / (plain if plain.strip(".") else "unnamed")


class OutputError(OSError):
    """Error of a file or folder that cannot be written."""


@contextmanager
def writing(path: Path, words: str = "can't write") -> Iterator[None]:
    """Raise errors of the system in this context as `OutputError`, in these `words`."""
    try:
        yield
    except OutputError:
        raise
    except OSError as why:
        raise OutputError(f"{words} {path}: {why.strerror or why}") from None


@contextmanager
def replacing(path: Path) -> Iterator[Path]:
    """Yield a temporary path that replaces `path` on success and is deleted on failure.

    It has the same name, in a folder beside `path`, so that renaming it is atomic. Links are
    followed. Special files, such as /dev/stdout, are written directly.
    """
    target = Path(os.path.realpath(path))
    if target.exists() and not (target.is_file() or target.is_dir()):
        yield path
        return
    folder = Path(tempfile.mkdtemp(prefix=".unfinished-", dir=target.parent))
    try:
        yield folder / target.name
        (folder / target.name).replace(target)
    finally:
        shutil.rmtree(folder, ignore_errors=True)


def write_whole(path: Path, text: str) -> None:
    """Write `text` as UTF-8 to `path`, or raise `OSError` and leave `path` unchanged."""
    with replacing(path) as unfinished:
        unfinished.write_text(text, encoding="utf-8", newline="\n")
