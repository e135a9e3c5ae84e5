"""A study on disk: whose folder it is, what stands in it, and how it is gone on with."""

from __future__ import annotations

import json
from contextlib import suppress
from functools import partial
from pathlib import Path
from typing import IO

from floorplan import InputError, read_text

from ..core.output import OutputError, write_whole, writing
from ..record.strict_json import parse_json
from .identity import identity
from .study import Study
from .table import Table

RESULTS = "results.csv"
"""One line for each row."""

IDENTITY = "study.json"
"""File of what the results were made from."""

LONGEST = 500
"""Longest list of changes in a message, in characters: a damaged file may hold anything."""


class StudyFolder:
    """The folder of one study, made if it isn't there; use it in a `with` statement.

    `OutputError` if it holds another study, is in use by another process, or can't be written to.
    """

    def __init__(self, path: str | Path, study: Study) -> None:
        self.path = Path(path)
        self._study = study
        self._lock: IO[bytes] | None = None

    def __enter__(self) -> StudyFolder:
        with writing_to(self.path):
            self.path.mkdir(parents=True, exist_ok=True)
            self._identify()
            self._take()
            try:
                self.table = Table(self.path / RESULTS)
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
        path, now = self.path / IDENTITY, identity(self._study)
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

    def check_unchanged(self) -> None:
        """`OutputError` if a file that decides the results is not as it was when they began."""
        if changed := self._changed(identity(self._study)):
            raise OutputError(
                f"the results in {self.path} don't belong together (changed while they were made:"
                f" {changed}); run the study again with another folder as --out"
            )

    def _changed(self, now: dict[str, str]) -> str:
        """The names of what the results depend on and is no longer as it was, if anything."""
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
