"""The keys of a trial file: how they are read, and the values that they stand for."""

from __future__ import annotations

from typing import Annotated, Any

from pydantic import Field, Strict, model_validator

from floorplan import NotNegative, Number, Pair, Positive, Strictly

from ..core.rules import PAPER
from ..core.scenario import AgvMove, GantryEntry, Job, PersonalityChange, PersonEntry
from ..core.start import Start
from .checks import CONDITIONS, LARGEST_SEED, NAME
from .rules_file import RuleKeys

Flag = Annotated[bool, Strict()]
Pose = tuple[Number, Number, Number]


class Keys(Strictly):
    """Keys that stand for a value whose fields have the same names."""

    def value(self) -> Any:
        """Return the value."""
        raise NotImplementedError

    def fields(self) -> dict[str, Any]:
        """Return the fields of the value."""
        return {name: _value(getattr(self, name)) for name in type(self).model_fields}


def _value(key: Any) -> Any:
    """Return a key's value as a field has it."""
    if isinstance(key, list):
        return tuple(map(_value, key))
    return key.value() if isinstance(key, Keys) else key


class _PartPlaced(Keys):
    part: str | None = None
    agv: str | None = None

    def value(self) -> dict[str, str]:
        return self.model_dump(exclude_none=True)


class _Start(Keys):
    time: NotNegative | None = None
    part_placed: _PartPlaced | None = None
    order_submitted: str | None = None
    event: str | None = None
    count: Annotated[int, Strict(), Field(ge=1)] = 1
    person: str | None = None

    @model_validator(mode="after")
    def _one_condition(self) -> _Start:
        given = self.model_fields_set
        if len(given & {*CONDITIONS}) != 1:
            raise ValueError(f"give one of {', '.join(CONDITIONS)}")
        if self.event is None and given & {"count", "person"}:
            raise ValueError("count and person belong to an event")
        return self

    def value(self) -> Start:
        return Start(**self.fields())


class _Change(Keys):
    when: _Start
    personality: str

    def value(self) -> PersonalityChange:
        return PersonalityChange(**self.fields())


class PersonKeys(Keys):
    """One person."""

    name: Annotated[str, Field(pattern=f"^{NAME}$")]
    personality: str = "indifferent"
    start: _Start = _Start(time=0.0)
    at: Pair | None = None
    home: Pair | None = None
    beliefs: list[str] = []
    radius: Positive | None = None
    max_speed: Positive | None = None
    max_acceleration: Positive | None = None
    changes: list[_Change] = []

    def value(self) -> PersonEntry:
        """Return the person."""
        return PersonEntry(**self.fields())


class _Job(Keys):
    move: Pose | None = None
    wait: Positive | None = None
    pick: str | None = None
    place: str | None = None
    part: str = "part"
    submit: str | None = None

    @model_validator(mode="after")
    def _one_kind(self) -> _Job:
        given = self.model_fields_set - {"part"}
        if given not in ({"move"}, {"wait"}, {"pick", "place"}, {"submit"}):
            raise ValueError("a job is one of move, wait, pick with place, or submit")
        return self

    def value(self) -> Job:
        if self.move is not None:
            return Job("move", target=self.move)
        if self.wait is not None:
            return Job("wait", seconds=self.wait)
        if self.submit is not None:
            return Job("submit", order=self.submit)
        return Job("pick_place", pick=self.pick or "", place=self.place or "", part=self.part)


class _Gantry(Keys):
    controller: str = "parked"
    at: Pose | None = None
    jobs: list[_Job] = []
    repeat: Flag = False

    def value(self) -> GantryEntry:
        return GantryEntry(**self.fields())


class _Move(Keys):
    time: NotNegative
    to: str | Number

    def value(self) -> AgvMove:
        return AgvMove(self.time, self.to)


class AgvKeys(Strictly):
    """One AGV; where it does not yield, a list of its moves will do."""

    moves: list[_Move] = []
    yields: Flag = Field(default=False, alias="yield")

    @model_validator(mode="before")
    @classmethod
    def _only_moves(cls, value: object) -> object:
        return {"moves": value} if isinstance(value, list) else value


class TrialKeys(Strictly):
    """A whole trial."""

    name: str | None = None
    floorplan: str
    folder: str = "."
    duration: Positive = 275.0
    seed: Annotated[int, Strict(), Field(ge=0, le=LARGEST_SEED)] = 0
    rules: RuleKeys = RuleKeys.model_validate(PAPER.name)
    people: list[PersonKeys] = []
    gantry: _Gantry = _Gantry()
    agvs: dict[str, AgvKeys] = {}
    ariac: str | None = None
    until_submitted: Flag | None = None
    expect: dict[str, Any] = {}
