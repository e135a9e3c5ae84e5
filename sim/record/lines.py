"""Lines of files: in CSV, and in a file that never ends within one."""

from __future__ import annotations

import csv
import io
from collections.abc import Iterable
from pathlib import Path


def csv_line(cells: Iterable[str]) -> str:
    """Return texts as a line of CSV, in quotes where they have to be."""
    line = io.StringIO()
    csv.writer(line, lineterminator="\n").writerow(cells)
    return line.getvalue()


class WholeLines:
    """Writes lines into a new file at `path` (UTF-8), each at once and whole or not at all.

    `FileExistsError` if there is a file already.
    """

    def __init__(self, path: Path) -> None:
        self._file = path.open("xb", buffering=0)
        self._end = 0

    def write(self, line: str) -> None:
        """Add a line; `OSError` if there is no room, and then nothing of it is left."""
        data = memoryview(f"{line}\n".encode())
        at = 0
        try:
            while at < len(data):
                at += self._file.write(data[at:])
        except OSError:
            self._file.truncate(self._end)
            self._file.seek(self._end)
            raise
        self._end += len(data)

    def close(self) -> None:
        """Write no more."""
        self._file.close()
