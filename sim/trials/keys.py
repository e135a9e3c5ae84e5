"""Keys of a trial file."""

from dataclasses import fields, replace
from functools import lru_cache
from pathlib import Path
from typing import Annotated, Any, TypeVar

from pydantic import (
    BaseModel,
    BeforeValidator,
    Discriminator,
    Tag,
    create_model,
    model_validator,
)
from pydantic_core import PydanticCustomError
from typing_extensions import Self

from floorplan import UserError
from floorplan.files.dataclass import dataclass
from floorplan.files.documents import Document, read_yaml
from floorplan.files.fields import Flag, Number, whole
from floorplan.files.forms import Written, called, fields_of
from floorplan.files.models import Strictly

from ..core.entries import Command
from ..core.rules import PAPER
from ..core.scenario import (
    Name,
    PersonEntry,
    Scenario,
    Source,
    TrialError,
)
from ..core.schedule import (
    TimedObstacle,
    time_of_day,
)
from ..machines.agv.model import AgvKeys
from .feasibility import command_faults
from .rules_file import RuleForm, RuleKeys

_Made = TypeVar("_Made", bound=Scenario)


CommandEntries = Annotated[
    Annotated[str, Tag("file")] | Annotated[tuple[Command, ...], Tag("list")],
    Discriminator(lambda value: "file" if isinstance(value, str) else "list"),
]
"""Commands in order of time, or the name of their file."""


class _CommandFile(Strictly):
    commands: tuple[Command, ...]


class _OneCommand(Strictly):
    command: Command


def commanded(trial: _Made, path: Path) -> _Made:
    """Return the trial with the commands in the file at `path`.

    `TrialError` lists the faults of the file, with its lines.
    """
    document = read_yaml(path, TrialError)
    made = replace(trial, commands=document.checked(_CommandFile, TrialError).commands)
    problems = [document.problem(message, "commands", *at) for message, at in command_faults(made)]
    if problems:
        raise TrialError(document.file, problems)
    return made


def read_command(keys: Any) -> Command:
    """Return the command with these keys. Raise `ValidationError` if they are invalid."""
    return _OneCommand.model_validate({"command": keys}).command


@dataclass(frozen=True, kw_only=True)
class SourceKeys(Source):
    """Keys of a source of one or several people."""

    count: Annotated[int, whole(1)] | None = None

    @model_validator(mode="after")
    def _one_or_many(self) -> Self:
        if (self.count is None) == (not self.stream):
            raise UserError("give count, the number of people who come")
        return self


OF_RECORDED = frozenset({"name", "start", "radius", "recorded"})
"""Keys of a recorded person."""


@dataclass(frozen=True, kw_only=True)
class PersonKeys(PersonEntry):
    """Keys of one or several people."""

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
        """Number of people of the entry, or None for one person with its name."""
        return self.count if self.source is None else self.source.count

    def values(self) -> list[PersonEntry]:
        """Return the people of the entry. Several are numbered from 1."""
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


def _begins_in(data: Any) -> float:
    """Return the time of day (s) at which the trial in a file begins, or 0 if it is invalid."""
    try:
        return time_of_day(data["begins"])
    except (LookupError, TypeError, UserError):
        return 0.0


class DerivedKeys(Strictly):
    """Keys of a trial whose values differ from the fields of a `Scenario`."""

    name: str | None = None
    floorplan: Annotated[Any, BeforeValidator(_name_or_keys)]
    folder: str = "."
    rules: Annotated[RuleKeys, Written(RuleForm)] = RuleKeys.model_validate(PAPER.name)
    people: list[PersonKeys] = []
    agvs: dict[str, AgvKeys] = {}
    machines: dict[Name, dict[str, Any]] = {}
    ariac: str | None = None
    until_submitted: Flag | None = None
    begins: Annotated[Number, BeforeValidator(time_of_day)] = 0.0
    obstacles: Annotated[dict[str, TimedObstacle], BeforeValidator(called)] = {}
    commands: CommandEntries = ()


_OF_OTHER_KEYS = ("yielding", "workload")
"""Fields that are given by `agvs` and `ariac`."""

_ALIKE: dict[str, Any] = {
    key.name: (key.kind, key.default)
    for key in fields_of(Scenario)
    if key.compared and key.name not in (*DerivedKeys.model_fields, *_OF_OTHER_KEYS)
}
TrialKeys = create_model("TrialKeys", __base__=DerivedKeys, **_ALIKE)
"""All keys of a trial."""


@lru_cache(maxsize=64)
def _part(keys: frozenset[str]) -> type[BaseModel]:
    """Return a model of some keys of a trial, because most of the schema is for other keys."""
    fields: dict[str, Any] = {
        name: (field.annotation, field)
        for name, field in TrialKeys.model_fields.items()
        if name in keys or field.is_required()
    }
    return create_model("TrialKeys", __base__=Strictly, **fields)


def read_keys(document: Document) -> DerivedKeys:
    """Return the keys of a trial. `TrialError` lists the problems of the document."""
    data = document.data
    keys = data.keys() if isinstance(data, dict) else ()
    part = _part(frozenset(TrialKeys.model_fields.keys() & keys))
    context = {"begins": _begins_in(data)}
    read: BaseModel = document.checked(TrialKeys, TrialError, context, part)
    return TrialKeys.model_construct(read.model_fields_set, **dict(read))
