"""Reading of regular files with limited size.

A named pipe could block forever, and a device is endless. Files that a shell passes (`/dev/stdin`,
or `/dev/fd/63` for `<(command)`) are read like regular files.
"""

from __future__ import annotations

import os
import re
import stat
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import BinaryIO

from .problems import InputError, Problem

LARGEST_DOCUMENT = 16_000_000
"""Bytes. Maximum size of a document. A floor of 10,000 obstacles takes 1 MB."""

LARGEST_RECORDED = 1_000_000_000
"""Bytes. Maximum size of a recorded file. 24 hours of one person take 20 MB."""

LARGEST_LINE = 64_000_000
"""Bytes. Maximum length of a line of a recorded file. A motion of 100,000 pieces takes 20 MB."""

_CHUNK = 1 << 20

_HANDED_OVER = re.compile(r"/dev/(stdin|fd/\d+)|/proc/self/fd/\d+")

_KINDS = {
    stat.S_IFDIR: "a folder",
    stat.S_IFIFO: "a named pipe",
    stat.S_IFSOCK: "a socket",
    stat.S_IFCHR: "a device",
    stat.S_IFBLK: "a device",
}


def is_there(path: Path) -> bool:
    """Return whether `path` exists. It is False for names that files cannot have."""
    try:
        return path.exists()
    except (OSError, ValueError):
        return False


def is_file(path: Path) -> bool:
    """Return whether `path` is a regular file. It is False for names that files cannot have."""
    return is_there(path) and path.is_file()


def read_bytes(path: Path, error: type[InputError], most: int = LARGEST_DOCUMENT) -> bytes:
    """Return the contents of the file at `path`.

    Raise `error` if it cannot be read, is no regular file, or has more than `most` bytes.
    """
    with _opened(path, error) as file:
        chunks: list[bytes] = []
        size = 0
        while size <= most and (chunk := file.read(_CHUNK)):
            chunks.append(chunk)
            size += len(chunk)
        if size > most:
            raise error.of(path, f"is larger than the {_megabytes(most)} it may have")
        return b"".join(chunks)


def read_text(path: Path, error: type[InputError], most: int = LARGEST_DOCUMENT) -> str:
    """Return the UTF-8 text of a file without its byte order mark. See `read_bytes`."""
    text = _decoded(read_bytes(path, error, most), path, error).removeprefix("\ufeff")
    return text.replace("\r\n", "\n").replace("\r", "\n") if "\r" in text else text


def read_lines(path: Path, error: type[InputError], *, torn: bool = False) -> Iterator[str]:
    """Yield the lines of the recorded UTF-8 file at `path`, without their ends.

    With `torn`, a last line without an end is omitted. Raise `error` if the file cannot be read.
    """
    with _opened(path, error) as file:
        size = number = 0
        while line := file.readline(LARGEST_LINE + 1):
            number += 1
            size += len(line)
            if size > LARGEST_RECORDED:
                message = f"is larger than the {_megabytes(LARGEST_RECORDED)} it may have"
                raise error.of(path, message)
            if len(line) > LARGEST_LINE:
                message = f"is longer than the {_megabytes(LARGEST_LINE)} a line may have"
                raise error.of(path, message, line=number)
            if torn and not line.endswith(b"\n"):
                return
            yield _decoded(line.removesuffix(b"\n"), path, error, number)


def require_readable(path: Path, error: type[InputError], most: int) -> None:
    """Raise `error` unless `path` is a readable file of at most `most` bytes."""
    with _opened(path, error) as file:
        if os.fstat(file.fileno()).st_size > most:
            raise error.of(path, f"is larger than the {_megabytes(most)} it may have")


@contextmanager
def _opened(path: Path, error: type[InputError]) -> Iterator[BinaryIO]:
    try:
        kind = stat.S_IFMT(path.stat().st_mode)
    except (FileNotFoundError, ValueError):  # or the name is invalid
        raise error.of(path, "there is no such file") from None
    except OSError as why:
        raise error.of(path, f"can't be read: {why.strerror}") from None
    try:
        if kind != stat.S_IFREG and not _HANDED_OVER.fullmatch(str(path)):
            what = _KINDS.get(kind, "something else")
            raise error.of(path, f"is {what}; give a regular file")
        with path.open("rb") as file:
            yield file
    except OSError as why:
        raise error.of(path, f"can't be read: {why.strerror}") from None


def _decoded(data: bytes, path: Path, error: type[InputError], line: int | None = None) -> str:
    try:
        return data.decode("utf-8")
    except UnicodeDecodeError as why:
        raise error(
            str(path), [Problem(f"is not UTF-8 text (byte {why.start})", line=line)]
        ) from None


def _megabytes(size: int) -> str:
    return f"{size / 1e6:,.0f} MB"
