"""Folder of a study, and the identity of its inputs."""

from __future__ import annotations

import hashlib
import inspect
import json
from collections.abc import Iterator
from contextlib import suppress
from dataclasses import asdict
from functools import partial
from importlib.metadata import version
from pathlib import Path
from typing import IO

from shapely.geometry.base import BaseGeometry

from floorplan import InputError
from floorplan.files.reading import read_text
from floorplan.model import LEFT_OUT_IF_EMPTY

from ..core.entries import RecordedTrack
from ..core.output import OutputError, write_whole, writing
from ..core.scenario import PersonalityChange, PersonEntry
from ..machines.gantry.controllers import controller_source, find_controller
from ..machines.kinds import is_own, own_kind
from ..people.programs import load_program, modules_of, planner_of, planner_source, sources_of
from ..people.steering.own_steering import steering_source
from ..people.tracks.recorded_walks import files_of
from ..record.scene_file import parse_json
from ..trials.loading import Trial
from .design import Study
from .table import ResultsTable


def identity(study: Study) -> dict[str, str]:
    """Digests of all that decides the results of `study`, by what it is."""
    found = {"floorwalker": version("floorwalker"), "the study": _digest(_definition(study))}
    for trial in study.trials:
        found[f"the trial {trial.name}"] = _digest(trial.to_yaml(trial.folder))
    for combination in study.combinations:
        found |= dict(_parts(combination.trial))
    return found


def _definition(study: Study) -> str:
    parts = [
        [trial.name for trial in study.trials],
        [[what.name, values] for what, values in study.grid.items()],
        [[what.name, repr(distribution)] for what, distribution in study.random.items()],
        study.repeat,
        study.seed,
        study.metrics,
    ]
    return json.dumps(parts)


def _parts(trial: Trial) -> Iterator[tuple[str, str]]:
    """Return what a trial names and doesn't contain: floorplan, programs, orders, controller."""
    plan = trial.floorplan
    empty = {name for name in LEFT_OUT_IF_EMPTY if not getattr(plan, name)}
    facts = {k: value for k, value in asdict(plan).items() if k not in {"notices", *empty}}
    yield f"the floorplan {plan.name}", _digest(json.dumps(facts, default=_wkt))
    for person in trial.people:
        modules = modules_of(person.actions, trial.actions)
        named: list[PersonEntry | PersonalityChange] = [person, *person.changes]
        for one in named:
            program = load_program(one.personality, trial.folder, modules, own_code=trial.own_code)
            yield f"the program {one.personality_name}", _digest(str(program))
            if program is not None:
                for module in sources_of(program, modules, trial.folder, own_code=True):
                    text = module.file.read_text(encoding="utf-8")
                    yield f"the actions {module.module}", _digest(text)
        if isinstance(person.recorded, RecordedTrack):
            track = hashlib.sha256()
            for part in files_of(trial.folder / person.recorded.file):
                track.update(part.read_bytes())
            yield f"the track {person.recorded.file}", track.hexdigest()[:16]
        choice = planner_of(person, trial)
        source = planner_source(choice, trial.folder)
        if source is not None:
            yield f"the planner {choice.name}", _digest(source.file.read_text(encoding="utf-8"))
    if trial.steering is not None:
        source = steering_source(trial.steering, trial.folder)
        yield f"the steering {trial.steering}", _digest(source.file.read_text(encoding="utf-8"))
    if trial.workload is not None:
        yield f"the orders of {trial.name}", _digest(repr(trial.workload))
    controller = trial.gantry.controller
    own = controller_source(controller, trial.folder)
    file = own.file if own else inspect.getsourcefile(find_controller(controller, trial.folder))
    if file is not None:
        name = trial.gantry.controller_name
        yield f"the controller {name}", _digest(Path(file).read_text(encoding="utf-8"))
    for name, entry in trial.machines.items():
        if is_own(entry):
            kind = own_kind(entry, trial.folder).file.read_text(encoding="utf-8")
            yield f"the machine {name}", _digest(kind)


def _digest(text: str) -> str:
    return hashlib.sha256(text.encode()).hexdigest()[:16]


def _wkt(value: object) -> str:
    assert isinstance(value, BaseGeometry)  # all else in a floorplan is plain
    return str(value.wkt)


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
