"""The kinds of events of a run: a class each, from which all else about them follows."""

from __future__ import annotations

import dataclasses
import re
from collections.abc import Mapping
from dataclasses import dataclass
from types import NoneType, UnionType
from typing import (
    Annotated,
    Any,
    ClassVar,
    Literal,
    TypeAlias,
    Union,
    cast,
    get_args,
    get_origin,
    get_type_hints,
)

from typing_extensions import dataclass_transform

from floorplan import Point

from .entries import is_number

Named = Literal[
    "person",
    "machine",
    "agv",
    "station",
    "door",
    "obstacle",
    "location",
    "place",
    "part",
    "order",
    "personality",
    "kind of job",
    "type of order",
    "cause",
    "reason",
]
"""Things with names in a trial. A location, which an AGV goes to, may be a lane position too."""

Form: TypeAlias = Named | Literal["number", "text", "flag", "point", "list"]
"""Content of a field: the name of something in the trial, or a plain value."""

_Person: TypeAlias = Annotated[str, "person"]
_Machine: TypeAlias = Annotated[str, "machine"]
_Agv: TypeAlias = Annotated[str, "agv"]
_Station: TypeAlias = Annotated[str, "station"]
_Door: TypeAlias = Annotated[str, "door"]
_Obstacle: TypeAlias = Annotated[str, "obstacle"]
_Location: TypeAlias = Annotated[str | float, "location"]
_Place: TypeAlias = Annotated[str, "place"]
_Part: TypeAlias = Annotated[str, "part"]
_Order: TypeAlias = Annotated[str, "order"]
_Cause: TypeAlias = Annotated[str, "cause"]

EVENT_KINDS: dict[str, type[EventKind]] = {}
"""Every kind of event that is defined, by its name in recordings."""


class _Forms:
    """The forms of a kind's fields, found out when they are asked for the first time."""

    def __get__(self, _: object, kind: type[EventKind]) -> Mapping[str, Form]:
        hints = get_type_hints(kind, include_extras=True)
        found = {name: _form(hints[here], kind.kind, name) for name, here in kind._here.items()}
        kind.forms = found
        return found


@dataclass_transform(frozen_default=True, kw_only_default=True)
class EventKind:
    """Something that happens in a run. A subclass is a kind of event, known once it is defined.

    In recordings and trial files its `kind` is the name of the class in snake_case. Its fields are
    declared as those of a dataclass. One whose name ends in "_" stands there without it, one with
    the default None only where it has a value. Its annotation says what it holds: `str`, `float`,
    `int`, `bool`, a `list`, a point as `tuple[float, float]`, or the name of something in the trial
    as `Annotated[str, "person"]`, with one of the words in `Named`. `TypeError` if it says nothing
    of these, or if the library has a kind of that name.
    """

    kind: ClassVar[str]
    forms: ClassVar[Mapping[str, Form]]
    """The form of each field, by its name in recordings."""

    optional: ClassVar[frozenset[str]]
    """The fields that may be missing, by their names in recordings."""

    _own: ClassVar[bool]
    """True for a kind that is not the library's."""

    _here: ClassVar[Mapping[str, str]]
    """The name of each field in Python, by its name in recordings."""

    _given: ClassVar[Mapping[str, Any]]
    """The defaults of the fields that have one, by their names in Python."""

    def __init_subclass__(cls, kind: str = "") -> None:
        """Make the subclass a frozen dataclass, and register it under `kind`, or its own name."""
        kind = kind or kind_of(cls.__name__)
        known = EVENT_KINDS.get(kind, cls)
        if known.__module__ == __name__ != cls.__module__:
            raise TypeError(f"there is a kind of event {kind!r} already; take another name")
        # The methods of all kinds are below, and forms are found out when they are asked for:
        # making them for each takes most of the time that it takes to import this module.
        dataclass(init=False, kw_only=True, eq=False, repr=False)(cls)
        declared = dataclasses.fields(cast(Any, cls))
        reserved = {"t", *vars(EventKind), *EventKind.__annotations__}
        for name in reserved.intersection(field.name for field in declared):
            raise TypeError(f"{kind}: no field of an event can be called {name!r}")
        cls.kind = kind
        cls._own = cls.__module__ != __name__
        cls._here = {field.name.removesuffix("_"): field.name for field in declared}
        cls.forms = cast(Any, _Forms())
        if cls._own:
            cls.forms  # noqa: B018 - refuses what is no form
        cls._given = {
            field.name: field.default
            for field in declared
            if field.default is not dataclasses.MISSING
        }
        optional = (field.name for field in declared if field.default is None)
        cls.optional = frozenset(name.removesuffix("_") for name in optional)
        EVENT_KINDS[kind] = cls

    def __init__(self, **given: Any) -> None:
        """Take the values of all fields by name; those with a default may be left out."""
        values = vars(self)
        values.update(self._given)
        values.update(given)
        if values.keys() != self.__dataclass_fields__.keys():  # type: ignore[attr-defined]
            wanted = ", ".join(self._here.values())
            raise TypeError(f"{type(self).__name__} takes {wanted}; found {', '.join(given)}")

    def __setattr__(self, name: str, value: Any) -> None:
        """Refuse every change."""
        raise dataclasses.FrozenInstanceError(f"cannot assign to field {name!r}")

    def __delattr__(self, name: str) -> None:
        """Refuse every change."""
        raise dataclasses.FrozenInstanceError(f"cannot delete field {name!r}")

    @classmethod
    def of(cls, named: Mapping[str, Any]) -> EventKind:
        """Return the event whose fields are `named` as in recordings."""
        return cls(**{cls._here[name]: value for name, value in named.items()})

    def __eq__(self, other: object) -> bool:
        return isinstance(other, EventKind) and (type(self), self._values) == (
            type(other),
            other._values,
        )

    def __hash__(self) -> int:
        return hash(self._values)

    def __repr__(self) -> str:
        values = ", ".join(f"{name}={getattr(self, name)!r}" for name in self._here.values())
        return f"{type(self).__qualname__}({values})"

    @property
    def _values(self) -> tuple[Any, ...]:
        return tuple(getattr(self, here) for here in self._here.values())

    @property
    def fields(self) -> dict[str, Any]:
        """The fields as recordings name them; optional ones without a value are left out."""
        values, optional = vars(self), self.optional
        return {
            name: values[here]
            for name, here in self._here.items()
            if values[here] is not None or name not in optional
        }


def has_form(value: object, form: Form) -> bool:
    """Return whether a field holds what it should, as recorded; names and numbers may be None."""
    if form == "point":
        return isinstance(value, list) and len(value) == 2 and all(map(is_number, value))
    if form == "number":
        return value is None or is_number(value)
    if form in ("flag", "list"):
        return isinstance(value, bool if form == "flag" else list)
    return value is None or isinstance(value, str) or (form == "location" and is_number(value))


def kind_of(class_name: str) -> str:
    """Return the name in recordings of the kind of event that a class of that name is."""
    return re.sub(r"(?<!^)(?=[A-Z])", "_", class_name).lower()


_PLAIN: dict[Any, Form] = {
    str: "text",
    float: "number",
    int: "number",
    bool: "flag",
    list: "list",
    Point: "point",
}


def _form(hint: Any, kind: str, name: str) -> Form:
    """Return what a field of that annotation holds."""
    if get_origin(hint) in (Union, UnionType):
        given = [one for one in get_args(hint) if one is not NoneType]
        hint = given[0] if len(given) == 1 else hint
    if get_origin(hint) is Annotated and hint.__metadata__[0] in get_args(Named):
        named: Named = hint.__metadata__[0]
        return named
    for plain in (hint, get_origin(hint)):
        if plain in _PLAIN:
            return _PLAIN[plain]
    raise TypeError(f"{kind}: the field {name} of an event can't be a {hint}")


class TrialStarted(EventKind):
    """The trial begins."""

    trial: str
    floorplan: str


class TrialEnded(EventKind):
    """The trial is over, or was `interrupted` before its end."""

    interrupted: bool


class HumanStarted(EventKind):
    """A person begins."""

    person: _Person


class Awaited(EventKind):
    """A person is not on the floor yet: they come in later, at about that place."""

    person: _Person
    at: Point


class Entered(EventKind):
    """A person comes in."""

    person: _Person
    at: Point


class Left(EventKind):
    """A person leaves the floor for good."""

    person: _Person
    at: Point


class PersonalityChanged(EventKind):
    """Another program decides for a person from now on."""

    person: _Person
    personality: Annotated[str, "personality"]


class GoalChanged(EventKind, kind="goal"):
    """A person wants to go somewhere; `station` is null where there is none."""

    person: _Person
    station: _Station | None
    at: Point


class Arrived(EventKind):
    """A person has reached the goal; `station` is null where there is none."""

    person: _Person
    station: _Station | None
    at: Point


class GantryDetected(EventKind):
    """A person notices the gantry, nearer than `noticing_distance`."""

    person: _Person
    noticing_distance: float
    distance: float
    required: float
    human_speed: float
    robot_speed: float


class Violation(EventKind):
    """A person and a machine are nearer to each other than the law requires."""

    person: _Person
    with_: _Machine
    penalty: bool
    cause: _Cause
    distance: float
    required: float
    human_speed: float
    robot_speed: float


class Penalty(EventKind):
    """A penalty that was asked for from outside, over the [ROS bridge](ros-bridge.md)."""

    person: _Person
    cause: _Cause


class Teleport(EventKind):
    """A person is put home, because of the `gantry` or an `agv`."""

    person: _Person
    reason: Annotated[str, "reason"]
    to: Point


class ProtectiveStop(EventKind):
    """A machine brakes for a person, and stands."""

    machine: _Machine
    person: _Person


class ProtectiveStopEnded(EventKind):
    """Nobody needs the machine to stand any more."""

    machine: _Machine


class GantryDisabled(EventKind):
    """The gantry brakes, and stands for `seconds`, for a penalty."""

    seconds: float
    machine: _Machine | None = None


class GantryEnabled(EventKind):
    """The gantry may move again."""

    machine: _Machine | None = None


class AgvMoved(EventKind):
    """An AGV sets out, and `arrives` at that time (s) if nothing stops it."""

    agv: _Agv
    to: _Location
    arrives: float


class AgvYielded(EventKind):
    """An AGV waits for a person at that `distance`, as it wants to keep the `required` one."""

    agv: _Agv
    person: _Person
    distance: float
    required: float


class AgvBlocked(EventKind):
    """An AGV goes no further than the lane position `at` (m): the way is closed `by` something."""

    agv: _Agv
    by: str
    at: float


class Collision(EventKind):
    """The boxes of two machines begin to overlap; `speed` (m/s) is that of each from the other."""

    machine: _Machine
    with_: _Machine
    speed: float


class BlackoutBegan(EventKind):
    """A machine does not see people from now on."""

    machine: _Machine


class BlackoutEnded(EventKind):
    """A machine sees people again."""

    machine: _Machine


class DoorOpened(EventKind):
    """A door is open from now on."""

    door: _Door


class DoorClosed(EventKind):
    """A door is closed from now on."""

    door: _Door


class ObstacleCame(EventKind):
    """An obstacle is there from now on."""

    obstacle: _Obstacle


class ObstacleWent(EventKind):
    """An obstacle is gone from now on."""

    obstacle: _Obstacle


class Commanded(EventKind):
    """Somebody outside has something [done](trials.md#commands): a person sent, a place blocked."""

    send: _Person | None = None
    to: Point | None = None
    block: _Obstacle | None = None
    footprint: list[Any] | None = None
    bottom: float | None = None
    top: float | None = None
    clear: _Obstacle | None = None
    hold: _Machine | None = None
    release: _Machine | None = None


class JobStarted(EventKind):
    """The gantry begins a job: that of a trial file, or one [of an order](ariac.md#scores)."""

    job: Annotated[str, "kind of job"]
    part: _Part | None = None
    tray: int | None = None
    from_: _Place | None = None
    to: _Place | None = None
    quadrant: int | None = None
    order: _Order | None = None
    machine: _Machine | None = None


class JobDone(JobStarted):
    """The gantry has done a job; a `submit` is recorded as `order_submitted`."""


class PartDropped(EventKind):
    """The gantry's gripper has lost a part: its job begins again with another, if there is one."""

    part: _Part | None = None
    order: _Order | None = None
    at: tuple[float, float]
    machine: _Machine | None = None


class PartFaulty(EventKind):
    """The quality check finds a part of a kit faulty: the gantry throws it away for another."""

    part: _Part
    order: _Order
    agv: _Agv
    quadrant: int


class PartCame(EventKind):
    """A part comes along the conveyor: it lies `at` a place, and falls off at `to`."""

    part: _Part
    number: int
    at: tuple[float, float]
    to: tuple[float, float]
    falls: float


class PartTaken(EventKind):
    """The gantry has picked a part from the conveyor, `at` the place where it was then."""

    part: _Part
    number: int
    at: tuple[float, float]


class PartMissed(PartTaken):
    """A part has come to the end of the conveyor, and falls off."""


class OrderAnnounced(EventKind):
    """An order of an [ARIAC trial](ariac.md#scores) is to be worked on."""

    order: _Order
    type: Annotated[str, "type of order"]
    priority: bool


class OrderSubmitted(EventKind):
    """An order is handed in; one of an ARIAC trial has the points it got, and what is `missing`."""

    order: _Order
    type: Annotated[str, "type of order"] | None = None
    score: float | None = None
    best: float | None = None
    missing: list[str] | None = None


class RobotMalfunction(EventKind):
    """The gantry stands for `seconds`: a challenge of an ARIAC trial."""

    seconds: float
    machine: _Machine | None = None


class PathBlocked(EventKind):
    """A person's path is not free: `message` says why there is none."""

    person: _Person
    goal: Point
    message: str | None = None


class GoalOccupied(EventKind):
    """An AGV stands on a person's goal, and the person goes to a place beside it to wait."""

    person: _Person
    goal: Point
    by: _Agv | None


class GoalFree(EventKind):
    """The AGV has left the goal, and the person goes on."""

    person: _Person
    goal: Point


class Replanned(EventKind):
    """A person goes to the same goal on another path."""

    person: _Person
    goal: Point


class Met(EventKind):
    """A person first sees that somebody else will come in their way."""

    person: _Person
    other: _Person


class GaveWay(EventKind):
    """A person steps aside because somebody asks `to` be let past."""

    person: _Person
    to: _Person


class WalksWith(EventKind):
    """A person walks with another one from now on, as those of a group with its leader."""

    person: _Person
    other: _Person


class PeopleTooNear(EventKind):
    """The bodies of two people come nearer to each other than the rules want between people."""

    person: _Person
    other: _Person
    distance: float
    required: float


class Blocked(EventKind):
    """A person could not go on for as long as their patience lasts, because of somebody else."""

    person: _Person
    by: _Person


class Deadlock(EventKind):
    """Nobody who is under way can go on because of the others, for as long as their patience."""

    people: list[str]


class ShiftBegan(EventKind):
    """From now on tasks are offered to a person."""

    person: _Person


class ShiftEnded(EventKind):
    """No more tasks are offered to a person; the one that they have is theirs."""

    person: _Person


class TaskTaken(EventKind):
    """A person takes on a task, so that nobody else does."""

    person: _Person
    task: str
    station: _Station


class TaskBegun(EventKind):
    """A person sets to work, at the station of their task; also after a pause."""

    person: _Person
    task: str
    station: _Station


class TaskPaused(EventKind):
    """A person leaves a task that takes `left` more seconds at the usual pace."""

    person: _Person
    task: str
    station: _Station
    left: float


class TaskDone(EventKind):
    """A person has done a task: `waited` seconds untouched, `took` from its begin to its end."""

    person: _Person
    task: str
    station: _Station
    waited: float
    took: float


class TaskGivenBack(EventKind):
    """A person gives a task back, for others, or does not take it on at all (`refused`)."""

    person: _Person
    task: str
    station: _Station
    refused: bool


class Said(EventKind):
    """A program prints something."""

    person: _Person
    text: str


class FileNotice(EventKind, kind="notice"):
    """Something in an ARIAC trial file that is read in another way than it is written there."""

    text: str
    field: str | None
    line: int | None


class Warning(EventKind):
    """Something about a program that its author should know."""

    person: _Person
    text: str
    file: str | None = None
    line: int | None = None
