"""Table of results: lines of JSON with digests while rows are run, then CSV and Parquet."""

from __future__ import annotations

import json
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any

from floorplan import UserError

from ..record.outcome import WholeLines, csv_line
from ..record.output import replacing, write_whole
from ..record.scene_file import LARGEST_OF_ALL
from .identity import digest

RESULTS = "results.csv"
"""File of the table."""

LINES = "results.jsonl"
"""File to which rows are added: one line per row, with its digest."""

Record = dict[str, Any]
"""One row by column: numbers, texts, or None."""

Cell = str | float | None
"""A text, a number, or nothing."""

DIGITS = 19
"""Whole numbers with this many characters may exceed 64 bits, and are read as floats."""


class TableError(UserError):
    """Error of a table that contains no results, or damaged ones."""


class ResultsTable:
    """Rows of results in a folder, opened to add more.

    Each row is on disk as soon as it is added. An incomplete last line is removed. `TableError` if
    a line is not as it was written.
    """

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        self._path = folder / LINES
        self.rows = 0
        """Number of rows."""
        if not self._path.exists():
            self._file = WholeLines(self._path)
            return
        if not self._path.is_file():  # reading a named pipe would wait
            raise TableError(f"{self._path} is not a regular file; give another folder with --out")
        end = 0
        for line in self._lines():
            self._verify(line)
            self.rows += 1
            end += len(line)
        self._file = WholeLines(self._path, end)

    def add(self, record: Record) -> None:
        """Write `record` as the next row."""
        text = json.dumps(record, default=str)
        self._file.write(f"{_prefix(text)}{text[1:]}")
        self.rows += 1

    def records(self) -> list[Record]:
        """Return all rows."""
        records: list[Record] = [json.loads(line) for line in self._lines()]
        for record in records:
            del record["digest"]
        return records

    def columns(self) -> dict[str, list[Cell]]:
        """Return the columns by name. A column is numeric if all its values are numbers."""
        records = self.records()
        return {
            name: _typed(_text(record.get(name)) for record in records) for name in _names(records)
        }

    def write_csv(self) -> None:
        """Write the rows as CSV, unless the file has them already."""
        records = self.records()
        names = _names(records)
        lines = [names, *([_text(record.get(name)) for name in names] for record in records)]
        text = "".join(map(csv_line, lines)) if records else ""
        path = self._folder / RESULTS
        if text and not (path.is_file() and path.read_bytes() == text.encode()):
            write_whole(path, text)

    def close(self) -> None:
        """Close the file of rows."""
        self._file.close()

    def _lines(self) -> Iterator[bytes]:
        with self._path.open("rb") as file:
            yield from (line for line in file if line.endswith(b"\n"))

    def _verify(self, line: bytes) -> None:
        """Raise `TableError` if a line is not the next row as it was written."""
        words = line.decode(errors="replace").rstrip("\n")
        text = f"{{{words[len(_prefix('')) :]}"
        is_intact = words == f"{_prefix(text)}{text[1:]}"
        if is_intact and json.loads(text)["row"] == self.rows:
            return
        raise TableError(
            f"{self._path}, line {self.rows + 1}: row {self.rows} is not as it was measured; take"
            " this line and all below off to have them measured again, or give another folder with"
            " --out"
        )


def _prefix(text: str) -> str:
    return f'{{"digest": "{digest(text)}", '


def _names(records: Iterable[Record]) -> list[str]:
    return [*dict.fromkeys(name for record in records for name in record)]


def _text(value: Any) -> str:
    return "" if value is None else str(value)


def _typed(texts: Iterable[str]) -> list[Cell]:
    cells = [text or None for text in texts]
    try:
        return [None if text is None else _number(text) for text in cells]
    except ValueError:
        return list(cells)


def _number(text: str) -> float:
    if len(text) < DIGITS:
        with suppress(ValueError):
            return int(text)
    value = float(text)
    if not abs(value) <= LARGEST_OF_ALL:
        raise UserError(f"{text} is no figure")
    return value


def plain(value: Any) -> Any:
    """Return a value as a cell: several numbers as one text."""
    return " ".join(map(str, value)) if isinstance(value, tuple) else value


def write_parquet(columns: Mapping[str, Sequence[Cell]], path: Path) -> bool:
    """Write `columns` to `path`. Return whether pyarrow is installed."""
    try:
        import pyarrow
        from pyarrow import parquet
    except ImportError:
        return False
    arrays = {name: pyarrow.array(_alike(values)) for name, values in columns.items()}
    with replacing(path) as unfinished:
        parquet.write_table(pyarrow.table(arrays), unfinished)
    return True


def _alike(values: Sequence[Cell]) -> list[Cell]:
    """Return the values of a column, whole numbers as floats if others are not whole."""
    if any(isinstance(value, float) for value in values):
        return [float(value) if isinstance(value, int) else value for value in values]
    return list(values)
