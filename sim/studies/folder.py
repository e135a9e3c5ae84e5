"""Folder of a study: its identity, its lock, and its results."""

from __future__ import annotations

import json
from collections.abc import Mapping
from contextlib import suppress
from functools import partial
from pathlib import Path
from typing import IO, Any

from floorplan import InputError
from floorplan.files.reading import read_text

from ..record.output import OutputError, write_whole, writing
from ..record.scene_file import parse_json
from .design import Study
from .identity import digest, identity
from .table import LINES, RESULTS, ResultsTable

IDENTITY = "study.json"
"""File of the digests of all inputs."""

LONGEST = 500
"""Maximum number of characters of a list of changes in a message, because a file may be damaged."""


class StudyFolder:
    """Folder of one study, created if necessary. Use it in a `with` statement.

    `others` are further texts that decide the results, by name. `OutputError` if the folder
    contains another study, is in use by another process, or cannot be written.
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
                self.table = ResultsTable(self.path)
            except BaseException:
                self._release()
                raise
        return self

    def __exit__(self, error: type[BaseException] | None, *_: object) -> None:
        try:
            # After an error the table is a convenience, and its own error would hide the first.
            with suppress(OSError) if error else writing_to(self.path):
                self.table.write_csv()
        finally:
            self.table.close()
            self._release()

    def _identify(self) -> None:
        """Write the digests of the inputs, or raise `OutputError` if they differ from earlier."""
        path, now = self.path / IDENTITY, self._identity
        if not path.exists():
            if any((self.path / name).exists() for name in (RESULTS, LINES)):
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
        """Raise `OutputError` if an input has changed since the results began."""
        if changed := self._changed(self._identity):
            raise OutputError(
                f"the results in {self.path} don't belong together (changed while they were made:"
                f" {changed}); run the study again with another folder as --out"
            )

    def _changed(self, now: dict[str, str]) -> str:
        """Return the names of changed inputs."""
        before = _read_identity(self.path / IDENTITY)
        changed = [name for name in {**before, **now} if before.get(name) != now.get(name)]
        listed = ", ".join(changed)
        return listed if len(listed) <= LONGEST else f"{listed[:LONGEST]}…"

    def _take(self) -> None:
        """Lock the folder against other processes, if the system can."""
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
    """Write the trial of one row into `folder` and return the path of the file.

    A run of the trial has the same figures as the row. `ValueError` if there is no such row, or if
    the trial's files cannot be found from there.
    """
    row = study.row(number)
    path = Path(folder) / "trials" / f"{number:06d}.yaml"
    text = row.trial.to_yaml(path.parent)
    with writing_to(path):
        path.parent.mkdir(parents=True, exist_ok=True)
        write_whole(path, text)
    return path


writing_to = partial(writing, words="can't write to")
"""Context that reports the system's errors as errors of writing to a folder."""


def _read_identity(path: Path) -> dict[str, Any]:
    try:
        digests = parse_json(read_text(path, InputError))
    except ValueError:
        digests = None
    return digests if isinstance(digests, dict) else {IDENTITY: "unreadable"}
