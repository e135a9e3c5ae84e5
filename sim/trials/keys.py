"""Keys of a trial file and of commands that stand for more than one value of a trial."""

from dataclasses import dataclass, fields, replace
from pathlib import Path
from typing import Annotated, Any, Literal, TypeVar

from pydantic import (
    AfterValidator,
    BeforeValidator,
    Discriminator,
    Tag,
    model_validator,
)
from pydantic_core import PydanticCustomError
from typing_extensions import Self

from floorplan import UserError
from floorplan.files.documents import read_yaml
from floorplan.files.fields import Flag, Number, Strictly, whole
from floorplan.files.forms import Written, called
from floorplan.files.problems import suggestion

from ..core.entries import UNSIGNED, Blackout, Command, SignOff
from ..core.fields import MachineFields
from ..core.rules import PAPER
from ..core.scenario import (
    ASSUMED,
    USUAL_PLANNER,
    GantryEntry,
    Name,
    PersonEntry,
    Planner,
    Scenario,
    Source,
    TrialError,
)
from ..core.schedule import (
    Delay,
    DoorTimes,
    Length,
    TimedObstacle,
    WorkList,
    time_of_day,
)
from ..machines.agv.model import AgvKeys
from .checks import LARGEST_SEED
from .feasibility import command_faults
from .rules_file import RuleForm, RuleKeys

_Made = TypeVar("_Made", bound=Scenario)


CommandEntries = Annotated[
    Annotated[str, Tag("file")] | Annotated[tuple[Command, ...], Tag("list")],
    Discriminator(lambda value: "file" if isinstance(value, str) else "list"),
]
"""Commands in order of time, or the file that has them."""


class _CommandFile(Strictly):
    commands: tuple[Command, ...]


class _OneCommand(Strictly):
    command: Command


def commanded(trial: _Made, path: Path) -> _Made:
    """Return the trial with the commands in the file at `path`.

    `TrialError` names the file, and the lines in it that can't be or can't be in this trial.
    """
    document = read_yaml(path, TrialError)
    made = replace(trial, commands=document.checked(_CommandFile, TrialError).commands)
    problems = [document.problem(said, "commands", *at) for said, at in command_faults(made)]
    if problems:
        raise TrialError(document.file, problems)
    return made


def read_command(keys: Any) -> Command:
    """Return the command with these keys; pydantic's `ValidationError` says what is wrong."""
    return _OneCommand.model_validate({"command": keys}).command


@dataclass(frozen=True, kw_only=True)
class SourceKeys(Source):
    """A source of one person, or of so many."""

    count: Annotated[int, whole(1)] | None = None

    @model_validator(mode="after")
    def _one_or_many(self) -> Self:
        if (self.count is None) == (not self.stream):
            raise UserError("give count, the number of people who come")
        return self


OF_RECORDED = frozenset({"name", "start", "radius", "recorded"})
"""Keys of somebody who walks as they were measured."""


@dataclass(frozen=True, kw_only=True)
class PersonKeys(PersonEntry):
    """One person, or so many alike."""

    count: Annotated[int, whole(1)] | None = None
    source: SourceKeys | None = None

    @model_validator(mode="wrap")
    @classmethod
    def _fit_together(cls, keys: Any, read: Any) -> Any:
        recorded = keys.get("recorded") if isinstance(keys, dict) else None
        if isinstance(recorded, dict) and recorded.get("everybody"):
            keys = {"name": "person", **keys}
        made = read(keys)
        if not isinstance(keys, dict):
            return made
        needless = sorted(keys.keys() - OF_RECORDED)
        if made.recorded is not None and needless:
            raise UserError(f"a recorded person walks as measured: omit {', '.join(needless)}")
        for key in ("at", "count", "start"):
            if made.source is not None and key in keys:
                raise UserError(f"{key} cannot be combined with source; omit it")
        return made

    @property
    def many(self) -> int | None:
        """The number of people that this stands for, None for one who is called as it says."""
        return self.count if self.source is None else self.source.count

    def values(self) -> list[PersonEntry]:
        """Return the people: the one, or so many of them, who are numbered from 1."""
        one = PersonEntry(**{key.name: getattr(self, key.name) for key in fields(PersonEntry)})
        if self.source is not None:
            source = Source(**{key.name: getattr(self.source, key.name) for key in fields(Source)})
            one = replace(one, source=source)
        if self.many is None:
            return [one]
        people = [replace(one, name=f"{one.name}{k + 1}") for k in range(self.many)]
        if one.source is None:
            return people
        return [
            replace(who, source=replace(one.source, stream=one.name, number=k + 1))
            for k, who in enumerate(people)
        ]


def _name_or_keys(value: Any) -> Any:
    if not isinstance(value, str | dict):
        raise PydanticCustomError("floor", "expected a name, a file or the keys of a floor")
    return value


def begins_in(data: Any) -> float:
    """Return the time of day (s) at which the trial in a file begins; 0 if none can be told."""
    try:
        return time_of_day(data["begins"])
    except (LookupError, TypeError, UserError):
        return 0.0


def _as_assumed(name: str) -> str:
    if name not in ASSUMED:
        raise UserError(f"{name!r} is not an assumed value; {suggestion(name, ASSUMED)}")
    return name


class TrialKeys(Strictly):
    """A whole trial."""

    name: str | None = None
    floorplan: Annotated[Any, BeforeValidator(_name_or_keys)]
    folder: str = "."
    duration: Length = 275.0
    seed: Annotated[int, whole(0, LARGEST_SEED)] = 0
    rules: Annotated[RuleKeys, Written(RuleForm)] = RuleKeys.model_validate(PAPER.name)
    planner: Planner = USUAL_PLANNER
    people: list[PersonKeys] = []
    steering: str | None = None
    actions: str | None = None
    gantry: GantryEntry = GantryEntry()
    agvs: dict[str, AgvKeys] = {}
    machines: dict[Name, dict[str, Any]] = {}
    fields: dict[str, MachineFields] = {}
    ariac: str | None = None
    until_submitted: Flag | None = None
    begins: Annotated[Number, BeforeValidator(time_of_day)] = 0.0
    work: dict[Name, WorkList] = {}
    doors: dict[str, DoorTimes] = {}
    obstacles: Annotated[dict[str, TimedObstacle], BeforeValidator(called)] = {}
    blackouts: tuple[Blackout, ...] = ()
    commands: CommandEntries = ()
    sources: dict[Annotated[str, AfterValidator(_as_assumed)], str] = {}
    counterfactual: Literal["without machines", "without people"] | None = None
    warm_up: Delay = 0.0
    sign_off: SignOff = UNSIGNED
    traffic: Flag = True
    expect: dict[str, Any] = {}
