"""Reading a recording back: the folder of a run, as `Recording` writes it."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any, TypeVar

from pydantic import BaseModel, Field, ValidationError, model_validator

from floorplan import (
    LARGEST,
    LARGEST_RECORDED,
    InputError,
    Problem,
    UserError,
    read_lines,
    read_text,
)
from navigation import Motion, Piece, join, standing, when

from ..core.events import EVENT_KINDS, Form, has_form
from ..core.plans import Plans
from ..core.recorder import Event, Thought
from ..core.scene import Pose, Scene
from ..record.scene_file import ForeignLaw, SceneError, read_scene
from ..record.strict_json import LARGEST_OF_ALL, parse_json
from ..safety.requirement_curve import Curve, is_plain, requirement_curve
from .run import Recorded

Violations = dict[tuple[str, str], tuple[tuple[float, float], ...]]

Requirements = dict[tuple[str, str], Curve]

_Number = Annotated[float, Field(ge=-LARGEST, le=LARGEST, allow_inf_nan=False)]

_Coefficient = Annotated[float, Field(ge=-LARGEST_OF_ALL, le=LARGEST_OF_ALL, allow_inf_nan=False)]

_Cubic = tuple[_Number, _Coefficient, _Coefficient, _Coefficient]


_Line = TypeVar("_Line", bound=BaseModel)


class RecordingError(InputError):
    """A folder that does not hold a run, or one that is damaged."""


class _Event(BaseModel, extra="allow", defer_build=True):
    t: _Number
    kind: str

    @model_validator(mode="after")
    def _fields_of_its_kind(self) -> _Event:
        forms: Mapping[str, Form] = getattr(EVENT_KINDS.get(self.kind), "forms", {})
        for name, value in (self.model_extra or {}).items():
            if name in forms and not has_form(value, forms[name]):
                raise UserError(f"{name} of {self.kind} can't be {str(value)[:60]!r}")
        return self


class _Intention(BaseModel, defer_build=True):
    stack: list[str]
    at: str


class _Thought(BaseModel, extra="allow", defer_build=True):
    t: _Number
    person: str
    steps: list[list[str]] = []
    believes: list[str] = []
    forgets: list[str] = []
    intends: list[_Intention] = []


class _Motion(BaseModel, defer_build=True):
    body: str
    start: _Number = 0.0
    end: _Number = 0.0
    pieces: Annotated[list[tuple[_Number, _Number, _Cubic, _Cubic, _Cubic]], Field(min_length=1)]


class _Violation(BaseModel, defer_build=True):
    person: str
    machine: str = Field(alias="with")
    intervals: tuple[tuple[_Number, _Number], ...]
    required: Curve | None = None


@dataclass(frozen=True)
class _Reading:
    """Reads a recording: with `damage`, that is told what can't be read, and the rest is used.

    `torn`: the run was broken off, so that the last line of a file may be half a line.
    """

    torn: bool
    damage: Callable[[str], None] | None

    def refuse(self, error: RecordingError) -> None:
        """Raise the error, or tell what it says."""
        if self.damage is None:
            raise error from None
        place = Path(error.file).name
        for problem in error.problems:
            self.damage(f"{place}: {problem}; the recording is shown as far as it can be read")


def load_run(folder: str | Path, *, damage: Callable[[str], None] | None = None) -> Recorded:
    """Return the run that `floorwalker run` (or a `Recording`) has left in `folder`.

    A run that was broken off goes as far as it was written: its summary is empty, everybody stands
    from the last line about them on, and violations are worked out anew. `RecordingError` says
    which line of which file is damaged. With `damage` a damaged recording, or one of a later
    version, goes as far as it can be read in the same manner, and `damage(sentence)` says what is
    missing; `RecordingError` is raised only where there is nothing to show.
    """
    folder = Path(folder)
    damages: list[str] = []

    def note(sentence: str) -> None:
        damages.append(sentence)
        assert damage is not None
        damage(sentence)

    told = None if damage is None else note
    scene = _scene(folder / "scene.json", told)
    summary = _summary(folder / "summary.json", _Reading(False, told))
    broken_off = summary is None
    reading = _Reading(broken_off, told)
    events = _events(folder / "events.jsonl", reading)
    motions = _motions(folder / "motions.jsonl", scene, reading)
    # What is left of a damaged recording is worked out as that of a run that was broken off.
    broken_off = broken_off or bool(damages)
    # Events are rounded; the end of a finished run is the end of all motions.
    ends = [motion.end for motion in motions.values()]
    ends += [event["t"] for event in events] if broken_off else []
    duration = max(ends, default=0.0)
    if damages and not duration:
        raise RecordingError.of(folder, f"holds nothing that can be shown: {damages[-1]}")
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


def _summary(path: Path, reading: _Reading) -> dict[str, Any] | None:
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


def _events(path: Path, reading: _Reading) -> tuple[Event, ...]:
    return tuple(event.model_dump() for _, event in _lines(path, _Event, reading))


def _thoughts(path: Path, reading: _Reading) -> tuple[Thought, ...]:
    if not path.exists():
        return ()
    return tuple(
        thought.model_dump(exclude_unset=True) for _, thought in _lines(path, _Thought, reading)
    )


def _motions(path: Path, scene: Scene, reading: _Reading) -> dict[str, Motion]:
    done: dict[str, list[Motion]] = {body: [] for body in scene.starts}
    for line, motion in _lines(path, _Motion, reading):
        try:
            _require("body", motion.body, done, path, line)
            done[motion.body].append(_motion(motion, done[motion.body]))
        except RecordingError as why:
            reading.refuse(why)
            break
        except ValueError as why:
            reading.refuse(RecordingError.of(path, str(why), line))
            break
    return {body: _joined(pieces, scene.starts[body]) for body, pieces in done.items()}


def _motion(line: _Motion, before: Sequence[Motion]) -> Motion:
    """Return the motion of a line after those `before` it; `ValueError` if it can't be."""
    motion = Motion(tuple(Piece(*piece) for piece in line.pieces))
    if before and motion.start < before[-1].start:
        raise UserError(f"a motion from t = {motion.start} s on stands below a later one")
    if any(_reach(piece) > LARGEST for piece in motion.pieces):
        raise UserError(f"a motion goes further than {LARGEST:g} m")
    return motion


def _reach(piece: Piece) -> float:
    """Return a bound on how far from 0 a coordinate of the piece gets."""
    begin, end, *cubics = piece
    u = end - begin
    return max(abs(a) + u * (abs(b) + u * (abs(c) + u * abs(d))) for a, b, c, d in cubics)


def _joined(motions: list[Motion], start: Pose) -> Motion:
    x, y, rotation = start
    return join(motions) if motions else standing((x, y), heading=rotation)


def _require(kind: str, name: str, known: Iterable[str], path: Path, line: int) -> None:
    """Raise `RecordingError` if the body that a line is about is not in the scene."""
    if name not in known:
        field = "with" if kind == "machine" else kind
        message = f"no {kind} of the scene is called {name!r}"
        raise RecordingError(str(path), [Problem(message, field, line)])


def _violations(path: Path, scene: Scene, reading: _Reading) -> tuple[Violations, Requirements]:
    people = [person.name for person in scene.people]
    machines = [machine.name for machine in scene.machines]
    lines = []
    try:
        for number, line in _lines(path, _Violation, reading):
            _require("person", line.person, people, path, number)
            _require("machine", line.machine, machines, path, number)
            lines.append(line)
    except RecordingError as why:
        reading.refuse(why)
    return (
        {(line.person, line.machine): line.intervals for line in lines},
        {(line.person, line.machine): line.required for line in lines if line.required},
    )


def _worked_out(
    scene: Scene, motions: dict[str, Motion], end: float
) -> tuple[Violations, Requirements]:
    """Return what the referee would have found, as far as the laws are known.

    It is worked out from what everybody did, not from what they were about to do.
    """
    found: Violations = {}
    requirements: Requirements = {}
    for person in scene.people:
        for machine in scene.machines:
            rules, law = scene.rules, scene.rules.law_of(machine)
            if isinstance(law, ForeignLaw):
                continue
            measured = motions[machine.name].translated(*rules.measured_at(machine))
            pair, tracks = (person.name, machine.name), (motions[person.name], measured)
            found[pair] = tuple(when(rules.condition_of(machine), *tracks, 0.0, end))
            if not is_plain(law):
                one, other = (Plans(0.0, track) for track in tracks)
                requirements[pair] = requirement_curve(law, one, other, end)
    return found, requirements


def _lines(path: Path, form: type[_Line], reading: _Reading) -> Iterator[tuple[int, _Line]]:
    """Yield the lines of a file, numbered from 1, up to one that is damaged.

    Where a run was broken off, the last line may be half a line; it is left out.
    """
    try:
        for number, line in enumerate(read_lines(path, RecordingError, torn=reading.torn), 1):
            yield number, _whole_line(form, line, path, number)
    except RecordingError as why:
        reading.refuse(why)


def _whole_line(form: type[_Line], line: str, path: Path, number: int) -> _Line:
    try:
        return _read_line(form, line)
    except ValidationError as misfits:
        first = misfits.errors()[0]
        field = ".".join(str(part) for part in first["loc"])
        said = first["msg"].removeprefix("Value error, ")
        problem = Problem(said[:1].lower() + said[1:], field, number)
        raise RecordingError(str(path), [problem]) from None
    except ValueError as why:
        raise RecordingError.of(path, f"is not JSON: {why}", number) from None


def _read_line(form: type[_Line], line: str) -> _Line:
    """Return a line as `form`; what the form does not know is JSON as well."""
    if form.model_config.get("extra") == "allow":
        return form.model_validate(parse_json(line))
    return form.model_validate_json(line)
