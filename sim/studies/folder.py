"""Folder of a study: its table of results with digests."""

from __future__ import annotations

import csv
import errno
import hashlib
import json
import os
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import suppress
from functools import partial
from itertools import takewhile
from pathlib import Path
from typing import IO, Any

from floorplan import InputError, UserError
from floorplan.files.reading import read_text

from ..record.outcome import csv_line
from ..record.output import OutputError, replacing, write_whole, writing
from ..record.scene_file import LARGEST_OF_ALL, parse_json
from .design import Study
from .identity import digest, identity

RESULTS = "results.csv"
"""One line for each row."""

IDENTITY = "study.json"
"""File of what the results were made from."""

LONGEST = 500
"""Longest list of changes in a message, in characters: a damaged file may hold anything."""


class StudyFolder:
    """The folder of one study, made if it isn't there; use it in a `with` statement.

    `others` are texts that decide the results as well, by what they are.
    `OutputError` if it holds another study, is in use by another process, or can't be written to.
    """

    def __init__(
        self, path: str | Path, study: Study, others: Mapping[str, str] | None = None
    ) -> None:
        self.path = Path(path)
        self._study = study
        self._others = {name: digest(text) for name, text in (others or {}).items()}
        self._lock: IO[bytes] | None = None

    def __enter__(self) -> StudyFolder:
        with writing_to(self.path):
            self.path.mkdir(parents=True, exist_ok=True)
            self._identify()
            self._take()
            try:
                self.table = ResultsTable(self.path / RESULTS)
            except BaseException:
                self._release()
                raise
        return self

    def __exit__(self, *_: object) -> None:
        # What could not be written has been reported; closing would report it again.
        with suppress(OSError):
            self.table.close()
        self._release()

    def _identify(self) -> None:
        """Write down which study this is, or refuse the folder of another one."""
        path, now = self.path / IDENTITY, self._identity
        if not path.exists():
            if (self.path / RESULTS).exists():
                raise OutputError(
                    f"{self.path} holds results, but no {IDENTITY} that says of what;"
                    " give another folder with --out"
                )
            write_whole(path, json.dumps(now, indent=2) + "\n")
        elif changed := self._changed(now):
            raise OutputError(
                f"{self.path} holds results of another study (changed since: {changed});"
                " give another folder with --out"
            )

    @property
    def _identity(self) -> dict[str, str]:
        return identity(self._study) | self._others

    def check_unchanged(self) -> None:
        """`OutputError` if a file that decides the results is not as it was when they began."""
        if changed := self._changed(self._identity):
            raise OutputError(
                f"the results in {self.path} don't belong together (changed while they were made:"
                f" {changed}); run the study again with another folder as --out"
            )

    def _changed(self, now: dict[str, str]) -> str:
        """Return the names of changed files on which the results depend."""
        known = _known(self.path / IDENTITY)
        changed = [name for name in {**known, **now} if known.get(name) != now.get(name)]
        listed = ", ".join(changed)
        return listed if len(listed) <= LONGEST else f"{listed[:LONGEST]}…"

    def _take(self) -> None:
        """Keep other processes out, where the system can, until this one ends."""
        try:
            import fcntl
        except ImportError:
            return
        self._lock = (self.path / IDENTITY).open("rb")
        try:
            fcntl.flock(self._lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError:
            self._lock.close()
            raise OutputError(f"another process works on {self.path} already") from None

    def _release(self) -> None:
        if self._lock is not None:
            self._lock.close()


def save_trial(study: Study, number: int, folder: str | Path) -> Path:
    """Write the trial of one row into `folder`; running it gives the row's figures again.

    The path of the file; `ValueError` if there is no such row, or if its trial can't stand there.
    """
    row = study.row(number)
    path = Path(folder) / "trials" / f"{number:06d}.yaml"
    text = row.trial.to_yaml(path.parent)
    with writing_to(path):
        path.parent.mkdir(parents=True, exist_ok=True)
        write_whole(path, text)
    return path


writing_to = partial(writing, words="can't write to")
"""Tells the system's errors in its context as ones of writing to a folder."""


def _known(path: Path) -> dict[str, str]:
    try:
        found = parse_json(read_text(path, InputError))
    except ValueError:
        found = None
    return found if isinstance(found, dict) else {IDENTITY: "unreadable"}


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
    """Return the digest of a row: of its columns and texts without empty ones.

    So it stays the same when the table gets columns that the row has nothing in.
    """
    text = "".join(f"{name}\0{cell}\0" for name, cell in cells if cell)
    return hashlib.sha256(text.encode()).hexdigest()[:LENGTH]


Record = dict[str, Any]
"""One line of a study's results: column by column, numbers, texts, or None."""


Cell = str | float | None
"""A text, a number, or nothing."""

DIGESTS = "results.sha256"
"""The digest of each row."""

DIGITS = 19
"""A whole number of so many characters may not fit into 64 bits; it is taken for a float."""


class TableError(UserError):
    """A file that holds no results, or damaged ones."""


class ResultsTable:
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
    """Return the columns of a table by name. A column is numeric if all its texts are numbers.

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
    """Yield the cells of each line: first the names of columns, then the rows from 0 on."""
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
        raise TableError(f"{path} is not a regular file; give another folder with --out")


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


def write_parquet(columns: Mapping[str, Sequence[Cell]], path: Path) -> bool:
    """Write `columns` to `path`; whether pyarrow was there to do it."""
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
