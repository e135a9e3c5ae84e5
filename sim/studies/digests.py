"""Digests of the rows of a study's table: changed rows are found before they are gone on with."""

from __future__ import annotations

import errno
import hashlib
import os
from collections.abc import Iterable
from itertools import takewhile
from pathlib import Path

LENGTH = 16
"""Characters of one digest."""


class Digests:
    """The file at `path`, with the digest of one row after the other, opened to be gone on with.

    A last one that was not written to its end is taken off again.
    """

    def __init__(self, path: Path) -> None:
        self._file = path.open("a+b", buffering=0)
        self._file.seek(0)
        lines = self._file.read().decode("ascii", "replace").split("\n")[:-1]
        self._known: list[str] = [*takewhile(lambda line: len(line) == LENGTH, lines)]
        self.keep(len(self._known))

    def __len__(self) -> int:
        """Return the number of rows that are known."""
        return len(self._known)

    def knows(self, row: int, digest: str) -> bool:
        """Return whether the row of that number had this digest when it was measured."""
        return self._known[row] == digest

    def keep(self, rows: int) -> None:
        """Forget all but the first `rows`."""
        del self._known[rows:]
        self._file.truncate(rows * (LENGTH + 1))

    def add(self, digest: str) -> None:
        """Note the digest of the next row."""
        line = f"{digest}\n".encode()
        if self._file.write(line) < len(line):
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
        self._known.append(digest)

    def close(self) -> None:
        """Stop writing."""
        self._file.close()


def digest_of(cells: Iterable[tuple[str, str]]) -> str:
    """The digest of a row: of its columns and texts, empty ones left out.

    So it stays the same when the table gets columns that the row has nothing in.
    """
    text = "".join(f"{name}\0{cell}\0" for name, cell in cells if cell)
    return hashlib.sha256(text.encode()).hexdigest()[:LENGTH]
