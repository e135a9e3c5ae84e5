"""Kinds of events of a run. Each is declared by one class."""

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
    """Forms of the fields of a kind, computed at their first use."""

    def __get__(self, _: object, kind: type[EventKind]) -> Mapping[str, Form]:
        hints = get_type_hints(kind, include_extras=True)
        forms = {name: _form(hints[here], kind.kind, name) for name, here in kind._here.items()}
        kind.forms = forms
        return forms


@dataclass_transform(frozen_default=True, kw_only_default=True)
class EventKind:
    """Base class of events. Each subclass is a kind of event.

    In recordings and trial files, the `kind` is the name of the class in snake_case. Declare fields
    as in a dataclass. A field may have the type `str`, `float`, `int`, `bool`, `list`,
    `tuple[float, float]` (a position in metres), or `Annotated[str, "person"]` for a name in the
    trial, with a word of `Named`. Recordings omit a trailing underscore of a field's name, and
    fields that have the default None and no value.

    Parameters
    ----------
    **fields
        Values of the fields by name. Fields with a default may be omitted.

    Attributes
    ----------
    kind : str
        Name of the kind.
    forms : mapping
        Type of each field, by its name in recordings.
    optional : frozenset of str
        Names in recordings of the fields that may be missing.

    Raises
    ------
    TypeError
        If a field is missing or unknown. When a subclass is defined: if a field has another type,
        or if the library has a kind of that name.

    Examples
    --------
    >>> class ToolChanged(sim.EventKind):
    ...     tool: str
    >>> ToolChanged(tool="vacuum").fields
    {'tool': 'vacuum'}
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

    _defaults: ClassVar[Mapping[str, Any]]
    """The defaults of the fields that have one, by their names in Python."""

    def __init_subclass__(cls, kind: str = "") -> None:
        """Make the subclass a frozen dataclass, and register it under `kind`, or its own name."""
        kind = kind or kind_of(cls.__name__)
        registered = EVENT_KINDS.get(kind, cls)
        if registered.__module__ == __name__ != cls.__module__:
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
        cls._defaults = {
            field.name: field.default
            for field in declared
            if field.default is not dataclasses.MISSING
        }
        optional = (field.name for field in declared if field.default is None)
        cls.optional = frozenset(name.removesuffix("_") for name in optional)
        EVENT_KINDS[kind] = cls

    def __init__(self, **fields: Any) -> None:
        """Set the fields."""
        values = vars(self)
        values.update(self._defaults)
        values.update(fields)
        if values.keys() != self.__dataclass_fields__.keys():  # type: ignore[attr-defined]
            names = ", ".join(self._here.values())
            raise TypeError(f"{type(self).__name__} takes {names}; found {', '.join(fields)}")

    def __setattr__(self, name: str, value: Any) -> None:
        """Raise an error, because events are immutable."""
        raise dataclasses.FrozenInstanceError(f"cannot assign to field {name!r}")

    def __delattr__(self, name: str) -> None:
        """Raise an error, because events are immutable."""
        raise dataclasses.FrozenInstanceError(f"cannot delete field {name!r}")

    @classmethod
    def of(cls, named: Mapping[str, Any]) -> EventKind:
        """Return an event with fields as in recordings.

        Parameters
        ----------
        named : mapping
            Values of the fields, by their names in recordings.
        """
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
        """Fields as in recordings. Optional fields without a value are omitted."""
        values, optional = vars(self), self.optional
        return {
            name: values[here]
            for name, here in self._here.items()
            if values[here] is not None or name not in optional
        }


def has_form(value: object, form: Form) -> bool:
    """Return whether a recorded field has a value of its type. Names and numbers may be None."""
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
    """Return the form of a field with this annotation."""
    if get_origin(hint) in (Union, UnionType):
        members = [one for one in get_args(hint) if one is not NoneType]
        hint = members[0] if len(members) == 1 else hint
    if get_origin(hint) is Annotated and hint.__metadata__[0] in get_args(Named):
        named: Named = hint.__metadata__[0]
        return named
    for plain in (hint, get_origin(hint)):
        if plain in _PLAIN:
            return _PLAIN[plain]
    raise TypeError(f"{kind}: the field {name} of an event can't be a {hint}")


class TrialStarted(EventKind):
    """The trial starts."""

    trial: str
    floorplan: str


class TrialEnded(EventKind):
    """The trial ends, normally or `interrupted`."""

    interrupted: bool


class HumanStarted(EventKind):
    """A person starts."""

    person: _Person


class Awaited(EventKind):
    """At the start: a person will enter later, near this place."""

    person: _Person
    at: Point


class Entered(EventKind):
    """A person enters the floor."""

    person: _Person
    at: Point


class Left(EventKind):
    """A person leaves the floor. Only recorded people may enter again."""

    person: _Person
    at: Point


class PersonalityChanged(EventKind):
    """Another program controls the person from now on."""

    person: _Person
    personality: Annotated[str, "personality"]


class GoalChanged(EventKind, kind="goal"):
    """A person has a new goal. `station` is null for other places."""

    person: _Person
    station: _Station | None
    at: Point


class Arrived(EventKind):
    """A person has reached the goal. `station` is null for other places."""

    person: _Person
    station: _Station | None
    at: Point


class GantryDetected(EventKind):
    """A person notices the gantry, within `noticing_distance`."""

    person: _Person
    noticing_distance: float
    distance: float
    required: float
    human_speed: float
    robot_speed: float


class Violation(EventKind):
    """A person and a machine come closer than required."""

    person: _Person
    with_: _Machine
    penalty: bool
    cause: _Cause
    distance: float
    required: float
    human_speed: float
    robot_speed: float


class Penalty(EventKind):
    """A client of the [ROS bridge](ros-bridge.md) requests a penalty."""

    person: _Person
    cause: _Cause


class Teleport(EventKind):
    """A person is moved home because of the `gantry` or an `agv`."""

    person: _Person
    reason: Annotated[str, "reason"]
    to: Point


class ProtectiveStop(EventKind):
    """A machine stops for a person."""

    machine: _Machine
    person: _Person


class ProtectiveStopEnded(EventKind):
    """The machine may move again."""

    machine: _Machine


class FieldOccupied(EventKind):
    """A person enters the "protective" or the "warning" field of a machine, of this `set`."""

    machine: _Machine
    person: _Person
    field: str
    set_: str


class FieldFree(EventKind):
    """The person is no longer in this field of the machine."""

    machine: _Machine
    person: _Person
    field: str
    set_: str


class FieldStop(EventKind):
    """The fields stop a machine by "intrusion", "blackout", or "no field set" for its speed."""

    machine: _Machine
    cause: str
    person: _Person | None = None


class FieldStopEnded(EventKind):
    """The protective fields have been free for the restart delay: the machine may move again."""

    machine: _Machine


class FieldSlowdown(EventKind):
    """A machine slows down: a person is in its warning field."""

    machine: _Machine
    person: _Person


class FieldSlowdownEnded(EventKind):
    """The warning fields are free: the machine may drive at its top speed again."""

    machine: _Machine


class FieldsMuted(EventKind):
    """The fields of a machine are muted from now on."""

    machine: _Machine


class FieldsUnmuted(EventKind):
    """The fields of a machine are no longer muted."""

    machine: _Machine


class GantryDisabled(EventKind):
    """The gantry stops for `seconds`, as a penalty."""

    seconds: float
    machine: _Machine | None = None


class GantryEnabled(EventKind):
    """The gantry may move again."""

    machine: _Machine | None = None


class GantryYielded(EventKind):
    """A gantry or vehicle waits, to keep the `required` distance to a person."""

    person: _Person
    distance: float
    required: float
    machine: _Machine | None = None


class AgvMoved(EventKind):
    """An AGV starts. It `arrives` at that time (s) unless it stops on the way."""

    agv: _Agv
    to: _Location
    arrives: float


class AgvYielded(EventKind):
    """An AGV waits, to keep the `required` distance to a person."""

    agv: _Agv
    person: _Person
    distance: float
    required: float


class AgvBlocked(EventKind):
    """An AGV stops at the lane position `at` (m), blocked `by` an object."""

    agv: _Agv
    by: str
    at: float


class MachineBlocked(EventKind):
    """A vehicle has no free path to its goal, for the reason in `message`."""

    machine: _Machine
    goal: Point
    message: str


class MachineWaiting(EventKind):
    """A machine waits, because its path leads through the area claimed by another machine."""

    machine: _Machine
    for_machine: _Machine


class MachineProceeds(EventKind):
    """A machine that has waited for another one for `waited` seconds may move again."""

    machine: _Machine
    waited: float


class MachineEvades(EventKind):
    """A machine takes another path, or moves aside `to` a passing place, for another to pass."""

    machine: _Machine
    for_machine: _Machine
    to: Point | None = None


class TrafficDeadlock(EventKind):
    """Machines wait for each other, and none of them can evade."""

    machines: list[str]


class Contact(EventKind):
    """A machine begins to touch a person, or something on the floor, at a speed (m/s) there.

    That is an obstacle, a closed door or the boundary.
    """

    machine: _Machine
    person: _Person | None = None
    with_: str | None = None
    at: Point
    speed: float


class Collision(EventKind):
    """The footprints of two machines begin to overlap, at relative `speed` (m/s)."""

    machine: _Machine
    with_: _Machine
    speed: float


class BlackoutBegan(EventKind):
    """A machine no longer perceives people."""

    machine: _Machine


class BlackoutEnded(EventKind):
    """A machine perceives people again."""

    machine: _Machine


class DoorOpened(EventKind):
    """A door opens."""

    door: _Door


class DoorClosed(EventKind):
    """A door closes."""

    door: _Door


class ObstacleCame(EventKind):
    """An obstacle appears."""

    obstacle: _Obstacle


class ObstacleWent(EventKind):
    """An obstacle disappears."""

    obstacle: _Obstacle


class Commanded(EventKind):
    """A [command](changes.md#commands) takes effect."""

    send: _Person | None = None
    to: Point | None = None
    block: _Obstacle | None = None
    footprint: list[Any] | None = None
    bottom: float | None = None
    top: float | None = None
    clear: _Obstacle | None = None
    hold: _Machine | None = None
    release: _Machine | None = None
    call: str | None = None
    machine: _Machine | None = None
    arguments: list[Any] | None = None


class JobStarted(EventKind):
    """The gantry starts a job of the trial or [of an order](ariac.md#scores)."""

    job: Annotated[str, "kind of job"]
    part: _Part | None = None
    tray: int | None = None
    from_: _Place | None = None
    to: _Place | None = None
    quadrant: int | None = None
    order: _Order | None = None
    machine: _Machine | None = None


class JobDone(JobStarted):
    """The gantry has finished a job. A `submit` is recorded as `order_submitted`."""


class PartDropped(EventKind):
    """The gripper has lost a part. Its job restarts."""

    part: _Part | None = None
    order: _Order | None = None
    at: tuple[float, float]
    machine: _Machine | None = None


class PartFaulty(EventKind):
    """The quality check finds a faulty part, which the gantry replaces."""

    part: _Part
    order: _Order
    agv: _Agv
    quadrant: int


class PartCame(EventKind):
    """A part appears on the conveyor. It would fall off at `to` at time `falls`."""

    part: _Part
    number: int
    at: tuple[float, float]
    to: tuple[float, float]
    falls: float


class PartTaken(EventKind):
    """The gantry has picked a part from the conveyor."""

    part: _Part
    number: int
    at: tuple[float, float]


class PartMissed(PartTaken):
    """A part falls off the end of the conveyor."""


class OrderAnnounced(EventKind):
    """An order of an [ARIAC trial](ariac.md#scores) is announced."""

    order: _Order
    type: Annotated[str, "type of order"]
    priority: bool


class OrderSubmitted(EventKind):
    """An order is submitted, in ARIAC trials with its score and `missing` parts."""

    order: _Order
    type: Annotated[str, "type of order"] | None = None
    score: float | None = None
    best: float | None = None
    missing: list[str] | None = None


class RobotMalfunction(EventKind):
    """The gantry stops for `seconds`, a challenge of an ARIAC trial."""

    seconds: float
    machine: _Machine | None = None


class PathBlocked(EventKind):
    """A person has no free path, for the reason in `message`."""

    person: _Person
    goal: Point
    message: str | None = None


class GoalOccupied(EventKind):
    """An AGV occupies the goal, and the person waits beside it."""

    person: _Person
    goal: Point
    by: _Agv | None


class GoalFree(EventKind):
    """The AGV has left the goal, and the person continues."""

    person: _Person
    goal: Point


class Replanned(EventKind):
    """A person takes another path to the same goal."""

    person: _Person
    goal: Point


class Met(EventKind):
    """A person first anticipates a conflict with another person."""

    person: _Person
    other: _Person


class GaveWay(EventKind):
    """A person steps aside for another person who has requested it."""

    person: _Person
    to: _Person


class WalksWith(EventKind):
    """A person walks with another person from now on, as in a group."""

    person: _Person
    other: _Person


class PeopleTooNear(EventKind):
    """Two bodies come closer than the rule `between_people` requires."""

    person: _Person
    other: _Person
    distance: float
    required: float


class Blocked(EventKind):
    """Other people have blocked a person for longer than their patience."""

    person: _Person
    by: _Person


class Deadlock(EventKind):
    """All people under way have lost patience, and no person has changed motion for 30 s."""

    people: list[str]


class ShiftBegan(EventKind):
    """A person is offered tasks from now on."""

    person: _Person


class ShiftEnded(EventKind):
    """A person is offered no more tasks."""

    person: _Person


class TaskTaken(EventKind):
    """A person takes a task."""

    person: _Person
    task: str
    station: _Station


class TaskBegun(EventKind):
    """A person starts work at the station of the task, or resumes it."""

    person: _Person
    task: str
    station: _Station


class TaskPaused(EventKind):
    """A person leaves a task with `left` seconds of work remaining."""

    person: _Person
    task: str
    station: _Station
    left: float


class TaskDone(EventKind):
    """A task is done: `waited` before its start, `took` until its end (s)."""

    person: _Person
    task: str
    station: _Station
    waited: float
    took: float


class TaskGivenBack(EventKind):
    """A person returns a task, or has `refused` it."""

    person: _Person
    task: str
    station: _Station
    refused: bool


class Said(EventKind):
    """A program prints text."""

    person: _Person
    text: str


class FileNotice(EventKind, kind="notice"):
    """Part of an ARIAC trial file is interpreted differently than written."""

    text: str
    field: str | None
    line: int | None


class Warning(EventKind):
    """A program has a problem that does not stop the run."""

    person: _Person
    text: str
    file: str | None = None
    line: int | None = None
