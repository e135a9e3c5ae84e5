"""A run on disk: what happened as it happens, and at the end everything else.

`scene.json` comes first. `events.jsonl`, `motions.jsonl` and `thoughts.jsonl` are written line by
line, so that a run that is broken off leaves whole and readable files; so is `commands.yaml`, where
there are commands. `violations.jsonl`, `summary.json`, `trajectory.csv` and `replay.html` follow.
`load_run` reads them back.
"""

from __future__ import annotations

import json
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, TextIO

from navigation import Motion, Piece

from ..core.body import Body
from ..core.commands import written_command
from ..core.events import Commanded
from ..core.output import OutputError, replacing
from ..core.recorder import Event, Listener, Thought, rounded
from ..core.scene import Scene
from ..record.lines import WholeLines
from ..record.scene_file import write_scene
from ..record.trajectory import write_trajectory
from ..views.replay import render
from ..views.replay_data import replay_data
from .run import Run

LINES = ("events.jsonl", "motions.jsonl", "thoughts.jsonl")
"""Files that are written line by line."""

COMMANDS = "commands.yaml"
"""The commands of a run, as a trial file names them."""

FILES = (
    *("summary.json", "scene.json", *LINES, "violations.jsonl"),
    *("trajectory.csv", "replay.html"),
)
"""All files of a recording, but for its commands."""

TRAJECTORY_RATE = 10.0
"""Hz. Rate of trajectory.csv."""


class Recording(Listener):
    """Writes a run into a folder, which is made as the run begins if it isn't there.

    A `numbered` one goes into a `folder` of its own: as the run begins it takes the first name that
    isn't there of NAME, NAME-2, NAME-3 …, also where other processes do the same. `OutputError` if
    the folder holds another run already, or can't be written to. Without a `trajectory` there is
    no `trajectory.csv`: of a long run it is the largest file, and can be made of the others.
    """

    wants_thoughts = True

    def __init__(
        self, folder: str | Path, *, numbered: bool = False, trajectory: bool = True
    ) -> None:
        self.folder = Path(folder)
        self._trajectory = trajectory
        self._numbered = numbered
        self._lines: dict[str, WholeLines] = {}
        for name in () if numbered else (*FILES, COMMANDS):
            if (self.folder / name).exists():
                raise self._taken(name)

    def begin(self, scene: Scene) -> None:
        """Take the folder, and write down where the run takes place."""
        try:
            if self._numbered:
                self.folder = _made(self.folder)
            self.folder.mkdir(parents=True, exist_ok=True)
            for name in LINES:
                self._lines[name] = WholeLines(self.folder / name)
        except FileExistsError as why:
            if why.filename == str(self.folder):
                raise OutputError(f"can't write to {self.folder}: it is no folder") from None
            raise self._taken(Path(why.filename).name) from None
        except OSError as why:
            raise OutputError(f"can't write to {self.folder}: {why.strerror}") from None
        with self._whole("scene.json") as file:
            file.write(write_scene(scene))

    def event(self, event: Event) -> None:
        """Write an event as one line."""
        self._add("events.jsonl", json.dumps(event, ensure_ascii=False))
        if event["kind"] == Commanded.kind:
            self._command(event)

    def _command(self, event: Event) -> None:
        if COMMANDS not in self._lines:
            self._lines[COMMANDS] = WholeLines(self.folder / COMMANDS)
            self._add(COMMANDS, "commands:")
        command = json.dumps(written_command(event), ensure_ascii=False)
        self._add(COMMANDS, f"  - {command}")

    def motion(self, body: Body, motion: Motion) -> None:
        """Write what a body has done as one line: its pieces as coefficients of cubics."""
        line = {
            "body": body.name,
            "kind": body.kind,
            "start": motion.start,
            "end": motion.end,
            "pieces": [_piece(piece) for piece in motion.pieces],
        }
        self._add("motions.jsonl", json.dumps(line))

    def thought(self, thought: Thought) -> None:
        """Write what a thought has changed in a mind as one line."""
        self._add("thoughts.jsonl", json.dumps(thought, ensure_ascii=False))

    def close(self) -> None:
        """Stop writing; what is written stays."""
        for lines in self._lines.values():
            lines.close()

    def finish(self, run: Run) -> None:
        """Write what belongs to a finished run."""
        self.close()
        with self._whole("violations.jsonl") as file:
            for (person, machine), intervals in run.violations.items():
                line = {"person": person, "with": machine, "intervals": intervals}
                if (person, machine) in run.requirements:
                    line["required"] = rounded(run.requirements[person, machine])
                file.write(json.dumps(line, ensure_ascii=False) + "\n")
        with self._whole("summary.json") as file:
            json.dump(run.summary, file, indent=2, ensure_ascii=False)
            file.write("\n")
        if self._trajectory:
            with self._whole("trajectory.csv") as file:
                write_trajectory(run, file, TRAJECTORY_RATE)
        with self._whole("replay.html") as file:
            file.write(render(replay_data(run)))

    def _taken(self, name: str) -> OutputError:
        return OutputError(
            f"{self.folder} holds a run already ({name}); give another folder with --out"
        )

    def _add(self, name: str, line: str) -> None:
        try:
            self._lines[name].write(line)
        except OSError as why:
            raise self._full(why) from None

    @contextmanager
    def _whole(self, name: str) -> Iterator[TextIO]:
        """A file to write that is there only when all of it is."""
        try:
            with (
                replacing(self.folder / name) as unfinished,
                unfinished.open("w", encoding="utf-8", newline="\n") as file,
            ):
                yield file
        except OSError as why:
            raise self._full(why) from None

    def _full(self, why: OSError) -> OutputError:
        return OutputError(
            f"can't go on writing to {self.folder}: {why.strerror or why};"
            " what was recorded until then is kept"
        )


def _made(first: Path) -> Path:
    """Return the folder `first`, or the first of NAME-2, NAME-3 … that wasn't there, made."""
    first.parent.mkdir(parents=True, exist_ok=True)
    folder, number = first, 1
    while True:
        try:
            folder.mkdir()
        except FileExistsError:
            number += 1
            folder = first.with_name(f"{first.name}-{number}")
        else:
            return folder


def _piece(piece: Piece) -> list[Any]:
    return [piece.begin, piece.end, list(piece.x), list(piece.y), list(piece.rotation)]
