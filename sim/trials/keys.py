"""Keys of a trial file and of commands, and the values that they stand for."""

from dataclasses import replace
from pathlib import Path
from typing import Annotated, Any, TypeVar

from pydantic import AfterValidator, BeforeValidator, Discriminator, Field, Tag, model_validator
from pydantic_core import PydanticCustomError

from floorplan import Obstacle, UserError
from floorplan.building import ObstacleSchema, footprint
from floorplan.files.documents import read_yaml
from floorplan.files.fields import Flag, NotNegative, Number, Pair, Positive, Range, Strictly, whole
from floorplan.files.problems import suggestion
from navigation.catalog import PlannerChoice

from ..core.entries import (
    COMMANDS,
    Blackout,
    Command,
    Keys,
    MannersEntry,
    NoticingEntry,
    RecordedTrack,
    Side,
    Start,
)
from ..core.rules import PAPER
from ..core.scenario import (
    ASSUMED,
    USUAL_PLANNER,
    PersonalityChange,
    PersonEntry,
    Scenario,
    Source,
    TrialError,
)
from ..machines.agv.model import AgvKeys
from ..machines.gantry.model import GantryKeys
from .checks import CONDITIONS, LARGEST_SEED, NAME
from .feasibility import command_faults
from .rules_file import RuleKeys
from .schedule_keys import (
    DoorKeys,
    DrawnKeys,
    Length,
    TimedKeys,
    TimeOfDay,
    WorkerKeys,
    WorkListEntry,
    time_of_day,
)

_Made = TypeVar("_Made", bound=Scenario)


class _Keys(Keys):
    stands_for = Command
    time: NotNegative


class _Send(_Keys):
    send: str
    to: Pair | str


class _Block(ObstacleSchema):
    time: NotNegative
    block: Annotated[str, Field(min_length=1)]
    z: Range = (0.0, 1.0)

    def value(self) -> Command:
        return Command(
            self.time,
            block=Obstacle(
                name=self.block, footprint=footprint(self), bottom=self.z[0], top=self.z[1]
            ),
        )


class _Clear(_Keys):
    clear: str


class _Hold(_Keys):
    hold: str


class _Release(_Keys):
    release: str


def _one_command(value: Any) -> Any:
    if isinstance(value, dict) and len(value.keys() & {*COMMANDS}) != 1:
        raise UserError(f"give a time and one of {', '.join(COMMANDS)}")
    return value


def _command_tag(value: Any) -> str:
    """Return which command it is, by a word that is none of its keys."""
    named = (name for name in COMMANDS if isinstance(value, dict) and name in value)
    return f"to {next(named, COMMANDS[0])}"


_Command = Annotated[
    Annotated[
        Annotated[_Send, Tag("to send")]
        | Annotated[_Block, Tag("to block")]
        | Annotated[_Clear, Tag("to clear")]
        | Annotated[_Hold, Tag("to hold")]
        | Annotated[_Release, Tag("to release")],
        Discriminator(_command_tag),
    ],
    BeforeValidator(_one_command),
]

CommandEntries = Annotated[
    Annotated[str, Tag("file")] | Annotated[list[_Command], Tag("list")],
    Discriminator(lambda value: "file" if isinstance(value, str) else "list"),
]
"""Commands in order of time, or the file that has them."""


class _CommandFile(Strictly):
    commands: list[_Command]


class _OneCommand(Strictly):
    command: _Command


def commanded(trial: _Made, path: Path) -> _Made:
    """Return the trial with the commands in the file at `path`.

    `TrialError` names the file, and the lines in it that can't be or can't be in this trial.
    """
    document = read_yaml(path, TrialError)
    commands = commands_of(document.checked(_CommandFile, TrialError).commands)
    made = replace(trial, commands=commands)
    problems = [document.problem(said, "commands", *at) for said, at in command_faults(made)]
    if problems:
        raise TrialError(document.file, problems)
    return made


def commands_of(entries: list[Any]) -> tuple[Command, ...]:
    """Return the commands that the keys stand for."""
    return tuple(entry.value() for entry in entries)


def read_command(keys: Any) -> Command:
    """Return the command with these keys; pydantic's `ValidationError` says what is wrong."""
    command: Command = _OneCommand.model_validate({"command": keys}).command.value()
    return command


_Planner = Annotated[Any, AfterValidator(PlannerChoice.of)]
"""A planner: its name, or `{name: RRTConnect, range: 1.0}`."""


class _PartPlaced(Keys):
    part: str | None = None
    agv: str | None = None

    def value(self) -> dict[str, str]:
        return self.model_dump(exclude_none=True)


class _Start(Keys):
    stands_for = Start
    time: NotNegative | None = None
    part_placed: _PartPlaced | None = None
    order_submitted: str | None = None
    event: str | None = None
    count: Annotated[int, whole(1)] = 1
    person: str | None = None

    @model_validator(mode="after")
    def _one_condition(self) -> "_Start":
        given = self.model_fields_set
        if len(given & {*CONDITIONS}) != 1:
            raise UserError(f"give one of {', '.join(CONDITIONS)}")
        if self.event is None and given & {"count", "person"}:
            raise UserError("count and person belong to an event")
        return self


class _Change(Keys):
    stands_for = PersonalityChange
    when: _Start
    personality: str


def _as_name(value: Any) -> Any:
    number = isinstance(value, int) and not isinstance(value, bool)
    return str(value) if number else value


class MannersKeys(Keys):
    """Manners of people towards others: a figure, or [least, most] to draw each person's from."""

    stands_for = MannersEntry
    comfort: NotNegative | Range | None = None
    time_gap: NotNegative | Range | None = None
    foresight: Positive | Range | None = None
    reaction_time: NotNegative | Range | None = None
    patience: Positive | Range | None = None
    passing_side: Side | None = None
    steps_aside: Flag | None = None


def _form(value: Any) -> str:
    """Return which form a figure that may be drawn has."""
    if isinstance(value, dict | DrawnKeys):
        return "distribution"
    return "range" if isinstance(value, list | tuple) else "figure"


Drawn = Annotated[
    Annotated[Positive, Tag("figure")]
    | Annotated[Range, Tag("range")]
    | Annotated[DrawnKeys, Tag("distribution")],
    Discriminator(_form),
]
"""A figure, [least, most], or a distribution."""


class _NoticingKeys(Keys):
    stands_for = NoticingEntry
    field_of_view: Drawn | None = None
    occlusion: Flag = False
    reaction_time: Drawn | None = None


class _RecordedKeys(Keys):
    stands_for = RecordedTrack
    file: Annotated[str, Field(min_length=1)]
    body: Annotated[str, BeforeValidator(_as_name)] | None = None
    since: Number = 0.0
    longest_gap: Positive = 1.0
    top_speed: Positive = 4.0
    frame_rate: Positive | None = None


def _as_track(value: Any) -> Any:
    return {"file": value} if isinstance(value, str) else value


OF_RECORDED = frozenset({"name", "start", "radius", "recorded"})
"""Keys of somebody who walks as they were measured."""


class _Source(Keys):
    at: Pair | str
    rate: Positive
    count: Annotated[int, whole(1)] | None = None
    start: NotNegative = 0.0
    stream: str = ""
    number: Annotated[int, whole(1)] = 1

    @model_validator(mode="after")
    def _one_or_many(self) -> "_Source":
        if (self.count is None) == (not self.stream):
            raise UserError("give count, the number of people who come")
        return self

    def value(self) -> Source:
        fields = self.fields()
        del fields["count"]
        return Source(**fields)


class PersonKeys(WorkerKeys):
    """One person."""

    name: Annotated[str, Field(pattern=f"^{NAME}$")]
    personality: str = "indifferent"
    start: _Start = _Start(time=0.0)
    count: Annotated[int, whole(1)] | None = None
    at: Pair | str | None = None
    home: Pair | str | None = None
    beliefs: list[str] = []
    radius: Positive | None = None
    max_speed: Drawn | None = None
    max_acceleration: Positive | None = None
    changes: list[_Change] = []
    planner: _Planner | None = None
    manners: MannersKeys = MannersKeys()
    actions: str | None = None
    recorded: Annotated[_RecordedKeys, BeforeValidator(_as_track)] | None = None
    source: _Source | None = None
    sink: Pair | str | None = None
    group: Annotated[str, Field(pattern=f"^{NAME}$")] | None = None
    noticing: _NoticingKeys = _NoticingKeys()
    agent_lag: NotNegative | Range | None = None

    @model_validator(mode="after")
    def _recorded_or_not(self) -> "PersonKeys":
        needless = sorted(self.model_fields_set - OF_RECORDED)
        if self.recorded is not None and needless:
            raise UserError(
                f"somebody who is recorded walks as measured: leave out {', '.join(needless)}"
            )
        return self

    @model_validator(mode="after")
    def _comes_or_is_there(self) -> "PersonKeys":
        if self.source is not None:
            for key in ("at", "count", "start"):
                if key in self.model_fields_set:
                    raise UserError(f"{key} and source don't go together; leave it out")
        return self

    @property
    def many(self) -> int | None:
        """The number of people that this stands for, None for one who is called as it says."""
        return self.count if self.source is None else self.source.count

    def value(self) -> PersonEntry:
        """Return the person."""
        fields = self.fields()
        del fields["count"]
        return PersonEntry(**fields)

    def values(self) -> list[PersonEntry]:
        """Return the people: the one, or so many of them, who are numbered from 1."""
        one, many = self.value(), self.many
        if many is None:
            return [one]
        people = [replace(one, name=f"{one.name}{k + 1}") for k in range(many)]
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


def _begin(value: Any) -> TimeOfDay:
    if not isinstance(value, str):
        raise UserError(f"expected a time of day in quotes, as '09:00', found {value!r}")
    return time_of_day(value)


class _BlackoutKeys(Keys):
    stands_for = Blackout
    machine: str
    start: _Start = _Start(time=0.0)
    seconds: Positive


def _as_assumed(name: str) -> str:
    if name not in ASSUMED:
        raise UserError(f"{name!r} is nothing that has a source; {suggestion(name, ASSUMED)}")
    return name


class TrialKeys(Strictly):
    """A whole trial."""

    name: str | None = None
    floorplan: Annotated[Any, BeforeValidator(_name_or_keys)]
    folder: str = "."
    duration: Length = 275.0
    seed: Annotated[int, whole(0, LARGEST_SEED)] = 0
    rules: RuleKeys = RuleKeys.model_validate(PAPER.name)
    planner: _Planner = USUAL_PLANNER
    people: list[PersonKeys] = []
    steering: str | None = None
    actions: str | None = None
    gantry: GantryKeys = GantryKeys()
    agvs: dict[str, AgvKeys] = {}
    machines: dict[Annotated[str, Field(pattern=f"^{NAME}$")], dict[str, Any]] = {}
    ariac: str | None = None
    until_submitted: Flag | None = None
    begins: Annotated[Number, BeforeValidator(_begin)] = 0.0
    work: dict[Annotated[str, Field(pattern=f"^{NAME}$")], WorkListEntry] = {}
    doors: dict[str, DoorKeys] = {}
    obstacles: dict[str, TimedKeys] = {}
    blackouts: list[_BlackoutKeys] = []
    commands: CommandEntries = []
    sources: dict[Annotated[str, AfterValidator(_as_assumed)], str] = {}
    expect: dict[str, Any] = {}
