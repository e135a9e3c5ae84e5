"""A study's results as CSV that grows line by line, and can be gone on with after any stop."""

from __future__ import annotations

import csv
from collections.abc import Iterable, Iterator
from contextlib import suppress
from pathlib import Path
from typing import Any

from floorplan import UserError

from ..core.output import replacing
from ..record.lines import csv_line
from ..record.strict_json import LARGEST_OF_ALL
from .digests import Digests, digest_of
from .measuring import Record

Cell = str | float | None
"""A text, a number, or nothing."""

DIGESTS = "results.sha256"
"""The digest of each row."""

DIGITS = 19
"""A whole number of so many characters may not fit into 64 bits; it is taken for a float."""


class TableError(UserError):
    """A file that holds no results, or damaged ones."""


class Table:
    """The CSV file at `path`, opened to be gone on with.

    Every line is on disk as soon as it is added, and its digest in the file `DIGESTS` beside it. A
    last line that was not written to its end is taken off again, and so are lines without a digest.
    When a record brings a column that no record before had, the file is written anew with that
    column, and takes the old one's place at once. `TableError` if it is damaged, or if a line is
    not as it was written.
    """

    def __init__(self, path: Path) -> None:
        self._path = path
        self._columns: list[str] = []
        self.rows = 0
        """Number of lines, without that of the columns' names."""
        self._digests = Digests(path.with_name(DIGESTS))
        try:
            if path.exists():
                _require_regular(path)
                _take_off_torn_line(path)
                self._verify()
            self._digests.keep(self.rows)
            self._file = path.open("a", encoding="utf-8", newline="")
        except BaseException:
            self._digests.close()
            raise

    def add(self, record: Record) -> None:
        """Write `record` as the next line."""
        fresh = [column for column in record if column not in self._columns]
        if fresh:
            self._widen([*self._columns, *fresh])
        self._file.write(csv_line(_text(record.get(column)) for column in self._columns))
        self._file.flush()
        self._digests.add(
            digest_of((column, _text(record.get(column))) for column in self._columns)
        )
        self.rows += 1

    def close(self) -> None:
        """Stop writing."""
        self._digests.close()
        self._file.close()

    def _verify(self) -> None:
        """Hold the lines to their digests; those without one are taken off."""
        lines = _lines(self._path)
        self._columns = next(lines, [])
        for cells in lines:
            if self.rows < len(self._digests):
                digest = digest_of(zip(self._columns, cells, strict=True))
                if not self._digests.knows(self.rows, digest):
                    message = f"row {self.rows} is not as it was measured; take this line and all"
                    message += " below off to have them measured again, or give another folder"
                    raise TableError(f"{self._path}, line {self.rows + 2}: {message} with --out")
                self.rows += 1
        if not self.rows:
            self._columns = []
        _keep_lines(self._path, self.rows + 1 if self.rows else 0)

    def _widen(self, columns: list[str]) -> None:
        """Give every line the columns that it lacks, empty."""
        self._file.close()
        lack = [""] * (len(columns) - len(self._columns))
        with (
            replacing(self._path) as wider,
            wider.open("w", encoding="utf-8", newline="") as file,
        ):
            file.write(csv_line(columns))
            lines = _lines(self._path)
            next(lines, None)
            file.writelines(csv_line([*line, *lack]) for line in lines)
        self._columns = columns
        self._file = self._path.open("a", encoding="utf-8", newline="")


def read_table(path: Path) -> dict[str, list[Cell]]:
    """The columns of a table by name. A column is of numbers if all that it has are numbers.

    `TableError` if the table is damaged.
    """
    lines = _lines(path)
    names = next(lines, [])
    columns = list(zip(*lines, strict=True)) or [()] * len(names)
    return {name: _typed(column) for name, column in zip(names, columns, strict=True)}


def _typed(column: Iterable[str]) -> list[Cell]:
    texts = [text or None for text in column]
    try:
        return [None if text is None else _number(text) for text in texts]
    except ValueError:
        return list(texts)


def _number(text: str) -> float:
    if len(text) < DIGITS:
        with suppress(ValueError):
            return int(text)
    value = float(text)
    if not abs(value) <= LARGEST_OF_ALL:
        raise UserError(f"{text} is no figure")
    return value


def _text(value: Any) -> str:
    return "" if value is None else str(value)


def _lines(path: Path) -> Iterator[list[str]]:
    """The cells of each line: first the columns' names, then row after row, from 0 on."""
    names: list[str] | None = None
    number = 1
    _require_regular(path)
    with path.open(encoding="utf-8", newline="") as file:
        lines = csv.reader(file)
        try:
            for row, cells in enumerate(lines, -1):
                number = lines.line_num
                if names is None:
                    names = cells
                    _check_names(path, names)
                elif len(cells) != len(names):
                    message = f"it has {len(cells)} cells where there are {len(names)} columns"
                    raise _damaged(path, number, message)
                elif cells[0] != str(row):
                    raise _damaged(path, number, f"it is row {row}, not {cells[0][:20]!r}")
                yield cells
        except csv.Error as why:
            raise _damaged(path, lines.line_num, f"it is not CSV: {why}") from None
        except UnicodeDecodeError:
            raise _damaged(path, number + 1, "it is not UTF-8 text") from None


def _damaged(path: Path, line: int, message: str) -> TableError:
    return TableError(f"{path}, line {line}: {message}; mend it, or give another folder with --out")


def _require_regular(path: Path) -> None:
    """`TableError` if `path` is a named pipe or the like, which would be waited for."""
    if path.exists() and not path.is_file():
        raise TableError(f"{path} is no regular file; give another folder with --out")


def _check_names(path: Path, names: list[str]) -> None:
    if names[:1] != ["row"] or "error" not in names:
        raise _damaged(path, 1, "the columns row and error are missing: these are no results")
    for name in names:
        if names.count(name) > 1:
            raise _damaged(path, 1, f"the column {name[:60]!r} is there twice")


def _take_off_torn_line(path: Path) -> None:
    """Cut the file after its last line break: values have none within."""
    with path.open("rb+") as file:
        text = file.read()
        whole = text.rfind(b"\n") + 1
        if whole < len(text):
            file.truncate(whole)


def _keep_lines(path: Path, count: int) -> None:
    """Cut the file after its first `count` lines, if it has more."""
    with path.open("rb+") as file:
        for _ in range(count):
            file.readline()
        end = file.tell()
        if file.read(1):
            file.truncate(end)
