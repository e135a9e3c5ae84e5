"""Entries of a trial: start conditions, work, manners, noticing, tracks, blackouts, commands."""

from __future__ import annotations

import math
import sys
import zlib
from collections.abc import Mapping
from dataclasses import KW_ONLY, dataclass
from random import Random
from typing import Any, ClassVar, Literal

from floorplan import Obstacle, Point
from floorplan.files.fields import Number, Strictly

Pose = tuple[Number, Number, Number]


class Keys(Strictly):
    """Keys that stand for a value: a dataclass whose fields have the same names."""

    stands_for: ClassVar[type]

    def value(self) -> Any:
        """Return the value."""
        return self.stands_for(**self.fields())

    def fields(self) -> dict[str, Any]:
        """Return the fields of the value."""
        return {name: _value(getattr(self, name)) for name in type(self).model_fields}


def _value(key: Any) -> Any:
    """Return a key's value as a field has it."""
    if isinstance(key, list):
        return tuple(map(_value, key))
    return key.value() if isinstance(key, Keys) else key


def is_number(value: Any) -> bool:
    """Return whether `value` is a finite number, and not true or false."""
    number = isinstance(value, int | float) and not isinstance(value, bool)
    return number and abs(value) <= sys.float_info.max


def times_until(end: float, begin: float, every: float | None) -> int:
    """Return how often something is there until `end` being there at `begin` and `every` so often.

    All are seconds. It is there at least once, and only once where a figure can't be.
    """
    found = (end - begin) / every if every else 0.0
    return max(1, math.ceil(found)) if math.isfinite(found) else 1


def seed_of(seed: int, what: str) -> int:
    """Return the seed for `what` in a trial with this `seed`: the same whatever else is there."""
    # Not `hash`, which is salted anew in every process.
    return zlib.crc32(f"{seed} {what}".encode())


@dataclass(frozen=True)
class Start:
    """Condition that is waited for: a time (seconds), or something that happens.

    `part_placed` holds the fields a placed part must have (part, agv), `order_submitted` the
    order's name, `event` the kind of an event; it must happen for the `count`th time. Events
    that name a person count if that is `person`, or who waits if none is given. The `time` is None
    where something else is waited for.
    """

    time: float | None = 0.0
    _: KW_ONLY
    part_placed: dict[str, str] | None = None
    order_submitted: str | None = None
    event: str | None = None
    count: int = 1
    person: str | None = None

    def __post_init__(self) -> None:
        waits = (self.part_placed, self.order_submitted, self.event) != (None, None, None)
        if waits and self.time == 0.0:
            object.__setattr__(self, "time", None)


AT_ONCE = Start()
"""The beginning of the trial."""


Kind = Literal["fixed", "uniform", "triangular", "normal", "lognormal", "exponential"]

SHORTEST = 0.1
"""Seconds. Draws that are shorter count as this long."""


@dataclass(frozen=True)
class Duration:
    """Length of a task in seconds, fixed or drawn.

    `values` are the seconds if fixed; [low, high] if uniform; [low, most likely, high] if
    triangular; [mean, standard deviation] if normal; [median, standard deviation of the
    logarithm] if lognormal; the mean if exponential. No draw is shorter than `SHORTEST`.
    """

    kind: Kind
    values: tuple[float, ...]

    @property
    def mean(self) -> float:
        """The length (seconds) that is usual: the mean, or of a lognormal one the median."""
        values = self.values
        if self.kind == "fixed":
            return values[0]
        usual = sum(values) / len(values) if self.kind in ("uniform", "triangular") else values[0]
        return max(usual, SHORTEST)

    def draw(self, random: Random) -> float:
        """Return a length (seconds), drawn from `random` unless it is fixed."""
        values = self.values
        if self.kind == "fixed":
            return values[0]
        if self.kind == "uniform":
            drawn = random.uniform(values[0], values[1])
        elif self.kind == "triangular":
            drawn = random.triangular(values[0], values[2], values[1])
        elif self.kind == "normal":
            drawn = random.normalvariate(values[0], values[1])
        elif self.kind == "lognormal":
            drawn = random.lognormvariate(math.log(values[0]), values[1])
        else:
            drawn = random.expovariate(1 / values[0])
        return max(drawn, SHORTEST)


@dataclass(frozen=True)
class WorkTask:
    """Something to do at the station `at`.

    It is there from `time` (seconds) on. With `every` it comes again every so many seconds, `count`
    times in all, or until the end. Those of a higher `priority` are offered first.
    """

    at: str
    duration: Duration
    _: KW_ONLY
    name: str = ""
    time: float = 0.0
    priority: int = 0
    every: float | None = None
    count: int | None = None

    @property
    def label(self) -> str:
        """Its name, or that of its station where it has none."""
        return self.name or self.at


@dataclass(frozen=True)
class WorkList:
    """Tasks that people share; with `repeat` each is there again as soon as it is done."""

    tasks: tuple[WorkTask, ...]
    repeat: bool = False


Shift = tuple[float, float]
"""Begin and end, seconds."""


class ClockTime(float):
    """Seconds of a trial that were given as a time of day, which is the text `given`."""

    given: str

    def __new__(cls, seconds: float, given: str = "") -> ClockTime:
        """Return the seconds with their text."""
        made = super().__new__(cls, seconds)
        made.given = given
        return made


def as_given(time: float) -> str:
    """Return an instant of a trial as its file has it: a time of day, or seconds."""
    return time.given if isinstance(time, ClockTime) else f"{time:,.12g} s"


Drawn = float | tuple[float, float] | Duration
"""A figure; the least and the most, between which it is drawn evenly; or a distribution."""


@dataclass(frozen=True, kw_only=True)
class NoticingEntry:
    """How somebody notices machines; what is None is as if they had eyes all round.

    Theirs is a `field_of_view` of so many degrees, half of it on each side of where they look.
    With `occlusion` they see nothing through walls, obstacles and machines. They perceive
    something `reaction_time` seconds after they have seen it.
    """

    field_of_view: Drawn | None = None
    occlusion: bool = False
    reaction_time: Drawn | None = None


ALL_ROUND = NoticingEntry()
"""Noticing of which nothing is given: by distance alone, and at once."""


def drawn_figure(value: Drawn, seed: int, what: str) -> float:
    """Return a figure, drawn for `what` from the `seed` of a trial unless it is fixed."""
    random = Random(seed_of(seed, what))
    if isinstance(value, Duration):
        return value.draw(random)
    return random.uniform(*value) if isinstance(value, tuple) else value


Spread = float | tuple[float, float]
"""A figure, or the least and the most between which each person has one of their own."""

Side = Literal["right", "left"]


@dataclass(frozen=True, kw_only=True)
class MannersEntry:
    """Manners of one person, or of each of several; what is None is as usual.

    `comfort` is in metres, `time_gap`, `foresight`, `reaction_time` and `patience` in seconds. They
    mean what they do in `sim.people.steering.manners.Manners`.
    """

    comfort: Spread | None = None
    time_gap: Spread | None = None
    foresight: Spread | None = None
    reaction_time: Spread | None = None
    patience: Spread | None = None
    passing_side: Side | None = None
    steps_aside: bool | None = None


AS_USUAL = MannersEntry()
"""Manners of which nothing is given."""


@dataclass(frozen=True)
class RecordedTrack:
    """The track of one body in `file`, which is looked up from the trial's folder.

    `body` is its name or number there: None for that of the person, or the only one there is. The
    person starts at the instant `since` of the file (seconds). Samples may be `longest_gap`
    seconds apart, and nobody moves faster than `top_speed` (m/s) from one to the next.
    `frame_rate` (1/s) is for files that count frames and don't say how many a second has.
    """

    file: str
    _: KW_ONLY
    body: str | None = None
    since: float = 0.0
    longest_gap: float = 1.0
    top_speed: float = 4.0
    frame_rate: float | None = None


@dataclass(frozen=True)
class Blackout:
    """From `start` on, `machine` does not see people for `seconds`."""

    machine: str
    start: Start
    seconds: float


COMMANDS = ("send", "block", "clear", "hold", "release")
"""The fields of a command of which it has one."""


@dataclass(frozen=True)
class Command:
    """Something that is done from outside at `time` (seconds), after all else of that instant.

    One of: `send` a person `to` a place (x, y in metres, or the name of a station or a door), or as
    near to it as there is room; `block`: put down an obstacle; `clear`: take up the obstacle of
    that name again; `hold` a machine, which brakes and stands, or `release` it.
    """

    time: float
    _: KW_ONLY
    send: str | None = None
    to: Point | str | None = None
    block: Obstacle | None = None
    clear: str | None = None
    hold: str | None = None
    release: str | None = None


def written_command(event: Mapping[str, Any]) -> dict[str, Any]:
    """Return the keys of a trial file for the command that a `commanded` event records."""
    keys = {"time": event["t"], **{key: event[key] for key in COMMANDS if key in event}}
    if "send" in event:
        keys["to"] = event["to"]
    if "block" in event:
        keys |= {"polygon": event["footprint"], "z": [event["bottom"], event["top"]]}
    return keys
