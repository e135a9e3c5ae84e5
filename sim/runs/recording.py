"""Recordings: writing the folder of a run, and reading it back.

`scene.json` comes first. `events.jsonl`, `motions.jsonl` and `thoughts.jsonl` are written line by
line, so that a run that is broken off leaves whole and readable files; so is `commands.yaml`, where
there are commands. `violations.jsonl`, `summary.json`, `trajectory.csv` and `replay.html` follow.
`load_run` reads them back.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from functools import cache
from pathlib import Path
from typing import Annotated, Any, TextIO

from pydantic import Field, TypeAdapter, ValidationError
from typing_extensions import NotRequired, TypedDict, override

from floorplan import InputError, Problem, UserError
from floorplan.files.dataclass import dataclass
from floorplan.files.fields import LARGEST
from floorplan.files.reading import LARGEST_RECORDED, read_lines, read_text
from navigation import Motion, Piece, join, standing, when

from ..core.body import Body, Plans
from ..core.clock import InProgress
from ..core.entries import Command, Pose
from ..core.events import EVENT_KINDS, Form, has_form
from ..core.recorder import Event, Listener, Scene, Thought, rounded
from ..record.outcome import WholeLines, write_trajectory
from ..record.output import OutputError, replacing
from ..record.scene_file import (
    LARGEST_OF_ALL,
    ForeignLaw,
    SceneError,
    parse_json,
    read_scene,
    write_scene,
)
from ..safety.laws import Curve, is_of_speeds_alone, requirement_curve
from ..trials.writing import command_keys
from ..views.replay import render
from ..views.replay_data import replay_data
from .run import Recorded, Run

LINES = ("events.jsonl", "motions.jsonl", "thoughts.jsonl")
"""Files that are written line by line."""

COMMANDS = "commands.yaml"
"""Commands of a run, in the form of a trial file."""

FILES = (
    *("summary.json", "scene.json", *LINES, "violations.jsonl"),
    *("trajectory.csv", "replay.html"),
)
"""All files of a recording except its commands."""

TRAJECTORY_RATE = 10.0
"""Rate of trajectory.csv, Hz."""


class RecordingError(InputError):
    """Error of a folder that contains no run or a damaged one."""


Violations = dict[tuple[str, str], tuple[tuple[float, float], ...]]

Requirements = dict[tuple[str, str], Curve]

_Number = Annotated[float, Field(ge=-LARGEST, le=LARGEST, allow_inf_nan=False)]

_Coefficient = Annotated[float, Field(ge=-LARGEST_OF_ALL, le=LARGEST_OF_ALL, allow_inf_nan=False)]

_Cubic = tuple[_Number, _Coefficient, _Coefficient, _Coefficient]

_Pieces = Annotated[list[tuple[_Number, _Number, _Cubic, _Cubic, _Cubic]], Field(min_length=1)]


class EventLine(TypedDict):
    """A line of events.jsonl. Each kind has additional fields."""

    t: _Number
    kind: str


class MotionLine(TypedDict):
    """A line of motions.jsonl: part of the motion of a body, as coefficients of cubics."""

    body: str
    kind: NotRequired[str]
    start: NotRequired[_Number]
    end: NotRequired[_Number]
    pieces: _Pieces


class IntentionLine(TypedDict):
    """An intention in a line of thoughts.jsonl."""

    stack: list[str]
    at: str


class ThoughtLine(TypedDict):
    """A line of thoughts.jsonl: changes of an agent by a thought."""

    t: _Number
    person: str
    steps: NotRequired[list[list[str]]]
    believes: NotRequired[list[str]]
    forgets: NotRequired[list[str]]
    intends: NotRequired[list[IntentionLine]]


ViolationLine = TypedDict(
    "ViolationLine",
    {
        "person": str,
        "with": str,
        "intervals": tuple[tuple[_Number, _Number], ...],
        "required": NotRequired[Curve],
    },
)
"""A line of violations.jsonl."""


class Recording(InProgress, Listener):
    """Listener that writes a run into a folder.

    The folder is created when the run begins.

    Parameters
    ----------
    folder : str or Path
        Folder.
    numbered : bool, optional
        Whether to use the first unused name of NAME, NAME-2, NAME-3 and so on. This is safe with
        several processes.
    trajectory : bool, optional
        Whether to write `trajectory.csv`. It is the largest file of a long run and can be created
        from the others.

    Raises
    ------
    OutputError
        When the run begins: if the folder contains another run or cannot be written.
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

    @override
    def begin(self, scene: Scene) -> None:
        try:
            if self._numbered:
                self.folder = _made(self.folder)
            self.folder.mkdir(parents=True, exist_ok=True)
            for name in LINES:
                self._lines[name] = WholeLines(self.folder / name)
        except FileExistsError as why:
            if why.filename == str(self.folder):
                raise OutputError(f"can't write to {self.folder}: it is not a folder") from None
            raise self._taken(Path(why.filename).name) from None
        except OSError as why:
            raise OutputError(f"can't write to {self.folder}: {why.strerror}") from None
        with self._whole("scene.json") as file:
            file.write(write_scene(scene))

    @override
    def event(self, event: Event) -> None:
        self._add("events.jsonl", json.dumps(event, ensure_ascii=False))

    def command(self, command: Command) -> None:
        """Write a command as one line.

        Parameters
        ----------
        command : Command
            The command.
        """
        if COMMANDS not in self._lines:
            self._lines[COMMANDS] = WholeLines(self.folder / COMMANDS)
            self._add(COMMANDS, "commands:")
        self._add(COMMANDS, f"  - {json.dumps(command_keys(command), ensure_ascii=False)}")

    @override
    def motion(self, body: Body, motion: Motion) -> None:
        line: MotionLine = {
            "body": body.name,
            "kind": body.kind,
            "start": motion.start,
            "end": motion.end,
            "pieces": list(motion.pieces),
        }
        self._add("motions.jsonl", json.dumps(line))

    @override
    def thought(self, thought: Thought) -> None:
        self._add("thoughts.jsonl", json.dumps(thought, ensure_ascii=False))

    def close(self) -> None:
        """Stop writing. Files that exist are kept."""
        for lines in self._lines.values():
            lines.close()

    def finish(self, run: Run) -> None:
        """Write the summary and the other files of a finished run.

        Parameters
        ----------
        run : Run
            Finished run.
        """
        self.close()
        with self._whole("violations.jsonl") as file:
            for (person, machine), intervals in run.violations.items():
                line: ViolationLine = {"person": person, "with": machine, "intervals": intervals}
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
            f"{self.folder} already contains a run ({name}); give another folder with --out"
        )

    def _add(self, name: str, line: str) -> None:
        try:
            self._lines[name].write(line)
        except OSError as why:
            raise self._full(why) from None

    @contextmanager
    def _whole(self, name: str) -> Iterator[TextIO]:
        """Yield a text file that appears in the folder when it is complete."""
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
            f"cannot continue writing to {self.folder}: {why.strerror or why};"
            " the recording up to then is kept"
        )


def _made(first: Path) -> Path:
    """Create the folder `first`, or the first new one of NAME-2, NAME-3 and so on. Return it."""
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


@dataclass(frozen=True)
class _RecordingReader:
    """Reader of a recording. If there is `damage`, it is called with errors, which are not raised.

    `torn` is whether the run was interrupted, so that the last line of a file may be incomplete.
    """

    torn: bool
    damage: Callable[[str], None] | None

    def refuse(self, error: RecordingError) -> None:
        """Raise the error, or pass its messages to `damage`."""
        if self.damage is None:
            raise error from None
        place = Path(error.file).name
        for problem in error.problems:
            self.damage(f"{place}: {problem}; the recording is shown as far as it can be read")


def load_run(folder: str | Path, *, damage: Callable[[str], None] | None = None) -> Recorded:
    """Return the run in a folder written by `floorwalker run` or a `Recording`.

    An interrupted run is loaded as far as it was written. Its summary is empty, bodies are
    stationary after their last line, and violations are computed again.

    Parameters
    ----------
    folder : str or Path
        Folder.
    damage : callable, optional
        Function called with a message if the recording is damaged or of a later version. The run is
        then loaded as far as possible.

    Returns
    -------
    Recorded
        The run.

    Raises
    ------
    RecordingError
        If a file is damaged (without `damage`) or the folder contains no run. The message includes
        the line.
    """
    folder = Path(folder)
    damages: list[str] = []

    def note(sentence: str) -> None:
        damages.append(sentence)
        assert damage is not None
        damage(sentence)

    report = None if damage is None else note
    scene = _scene(folder / "scene.json", report)
    summary = _summary(folder / "summary.json", _RecordingReader(False, report))
    broken_off = summary is None
    reading = _RecordingReader(broken_off, report)
    events = _events(folder / "events.jsonl", reading)
    motions = _motions(folder / "motions.jsonl", scene, reading)
    # A damaged recording is read like that of an interrupted run.
    broken_off = broken_off or bool(damages)
    # The end of a finished run is the end of all motions, because events are rounded.
    ends = [motion.end for motion in motions.values()]
    ends += [event["t"] for event in events] if broken_off else []
    duration = max(ends, default=0.0)
    if damages and not duration:
        raise RecordingError.of(folder, f"contains nothing that can be shown: {damages[-1]}")
    if not broken_off:
        violations, requirements = _violations(folder / "violations.jsonl", scene, reading)
    if broken_off or damages:
        violations, requirements = _worked_out(scene, motions, duration)
    return Recorded(
        scene=scene,
        duration=duration,
        summary=summary or {},
        events=events,
        motions=motions,
        violations=violations,
        requirements=requirements,
        thoughts=_thoughts(folder / "thoughts.jsonl", reading),
    )


def _scene(path: Path, damage: Callable[[str], None] | None) -> Scene:
    folder = path.parent
    if not path.is_file():
        what = "there is no scene.json in it" if folder.is_dir() else "there is no such folder"
        message = f"{what}; a recording is a folder that `floorwalker run` has written"
        raise RecordingError(str(folder), [Problem(message)])
    try:
        return read_scene(read_text(path, RecordingError, LARGEST_RECORDED), later=damage)
    except SceneError as why:
        raise RecordingError(str(path), [Problem(str(why))]) from None


def _summary(path: Path, reading: _RecordingReader) -> dict[str, Any] | None:
    if not path.exists():
        return None
    try:
        summary = parse_json(read_text(path, RecordingError, LARGEST_RECORDED))
        if not isinstance(summary, dict):
            raise RecordingError.of(path, "is not a summary")
    except RecordingError as why:
        reading.refuse(why)
    except ValueError as why:
        reading.refuse(RecordingError.of(path, f"is not JSON: {why}"))
    else:
        return summary
    return None


def _events(path: Path, reading: _RecordingReader) -> tuple[Event, ...]:
    return tuple(event for _, event in _lines(path, EventLine, reading))


def _thoughts(path: Path, reading: _RecordingReader) -> tuple[Thought, ...]:
    if not path.exists():
        return ()
    return tuple(thought for _, thought in _lines(path, ThoughtLine, reading))


def _motions(path: Path, scene: Scene, reading: _RecordingReader) -> dict[str, Motion]:
    done: dict[str, list[Motion]] = {body: [] for body in scene.starts}
    for line, motion in _lines(path, MotionLine, reading):
        try:
            _require("body", motion["body"], done, path, line)
            before = done[motion["body"]]
            before.append(_motion(motion, before))
        except RecordingError as why:
            reading.refuse(why)
            break
        except ValueError as why:
            reading.refuse(RecordingError.of(path, str(why), line))
            break
    return {body: _joined(pieces, scene.starts[body]) for body, pieces in done.items()}


def _motion(line: MotionLine, before: Sequence[Motion]) -> Motion:
    """Return the motion of a line after the motions `before` it, or raise a `ValueError`."""
    motion = Motion(tuple(Piece(*piece) for piece in line["pieces"]))
    if before and motion.start < before[-1].start:
        raise UserError(f"a motion from t = {motion.start} s on comes after a later one")
    if any(_reach(piece) > LARGEST for piece in motion.pieces):
        raise UserError(f"a motion goes further than {LARGEST:g} m")
    return motion


def _reach(piece: Piece) -> float:
    """Return an upper bound on the absolute coordinates of a piece."""
    begin, end, *cubics = piece
    u = end - begin
    return max(abs(a) + u * (abs(b) + u * (abs(c) + u * abs(d))) for a, b, c, d in cubics)


def _joined(motions: list[Motion], start: Pose) -> Motion:
    x, y, rotation = start
    return join(motions) if motions else standing((x, y), heading=rotation)


def _require(kind: str, name: str, known: Iterable[str], path: Path, line: int) -> None:
    """Raise a `RecordingError` if the body of a line is not in the scene."""
    if name not in known:
        field = "with" if kind == "machine" else kind
        message = f"no {kind} of the scene is called {name!r}"
        raise RecordingError(str(path), [Problem(message, field, line)])


def _violations(
    path: Path, scene: Scene, reading: _RecordingReader
) -> tuple[Violations, Requirements]:
    people = [person.name for person in scene.people]
    machines = [machine.name for machine in scene.machines]
    lines = []
    try:
        for number, line in _lines(path, ViolationLine, reading):
            _require("person", line["person"], people, path, number)
            _require("machine", line["with"], machines, path, number)
            lines.append(line)
    except RecordingError as why:
        reading.refuse(why)
    return (
        {(line["person"], line["with"]): line["intervals"] for line in lines},
        {
            (line["person"], line["with"]): line["required"]
            for line in lines
            if line.get("required")
        },
    )


def _worked_out(
    scene: Scene, motions: dict[str, Motion], end: float
) -> tuple[Violations, Requirements]:
    """Return the violations and required distances for laws of this library.

    They are computed from the actual motions, because the plans were not recorded.
    """
    violations: Violations = {}
    requirements: Requirements = {}
    for person in scene.people:
        for machine in scene.machines:
            rules, law = scene.rules, scene.rules.law_of(machine)
            if isinstance(law, ForeignLaw):
                continue
            measured = motions[machine.name].translated(*rules.measured_at(machine))
            pair, tracks = (person.name, machine.name), (motions[person.name], measured)
            shapes = rules.shapes_of(machine, person.radius)
            condition = rules.condition_of(machine)
            violations[pair] = tuple(when(condition, *tracks, 0.0, end, shapes=shapes))
            if not is_of_speeds_alone(law):
                one, other = (Plans(0.0, track) for track in tracks)
                requirements[pair] = requirement_curve(law, one, other, end, shapes)
    return violations, requirements


def _lines(path: Path, form: Any, reading: _RecordingReader) -> Iterator[tuple[int, Any]]:
    """Yield the lines of a file, numbered from 1, up to a damaged one.

    The incomplete last line of an interrupted run is omitted.
    """
    try:
        for number, line in enumerate(read_lines(path, RecordingError, torn=reading.torn), 1):
            yield number, _whole_line(form, line, path, number)
    except RecordingError as why:
        reading.refuse(why)


def _whole_line(form: Any, line: str, path: Path, number: int) -> Any:
    """Return a line as `form`. Additional fields of events and thoughts are included."""
    try:
        if form not in (EventLine, ThoughtLine):
            return _checks(form).validate_json(line)
        written = parse_json(line)
        fields = {**written, **_checks(form).validate_python(written)}
    except ValidationError as misfits:
        first = misfits.errors()[0]
        field = ".".join(str(part) for part in first["loc"])
        problem = Problem(first["msg"][:1].lower() + first["msg"][1:], field, number)
        raise RecordingError(str(path), [problem]) from None
    except ValueError as why:
        raise RecordingError.of(path, f"is not JSON: {why}", number) from None
    if form is EventLine:
        kind = fields["kind"]
        forms: Mapping[str, Form] = getattr(EVENT_KINDS.get(kind), "forms", {})
        for name, value in fields.items():
            if name in forms and not has_form(value, forms[name]):
                message = f"{name} of {kind} can't be {str(value)[:60]!r}"
                raise RecordingError(str(path), [Problem(message, "", number)])
    return fields


@cache
def _checks(form: Any) -> TypeAdapter[Any]:
    """Return the validator of a form, which takes milliseconds to build."""
    return TypeAdapter(form)
