"""Times of a trial: times of day, durations, tasks, shifts, times of doors and obstacles."""

from __future__ import annotations

import math
import re
from collections.abc import Iterable
from dataclasses import KW_ONLY, replace
from random import Random
from typing import Annotated, Any, Literal

from pydantic import (
    AfterValidator,
    BeforeValidator,
    ValidationInfo,
    ValidatorFunctionWrapHandler,
    WrapValidator,
    model_validator,
)
from typing_extensions import Self

from floorplan import Obstacle, UserError
from floorplan.files.dataclass import dataclass
from floorplan.files.fields import (
    LARGEST,
    SMALLEST,
    ComposedKeys,
    Constrained,
    Expected,
    Fits,
    Flag,
    Keyed,
    NotNegative,
    Number,
    Positive,
    Range,
    size_fault,
    whole,
)
from floorplan.files.forms import Alias, Composed, Data, Tagged, Written, written

DAY = 86_400.0
"""Seconds."""

_UNITS = {"s": 1.0, "sec": 1.0, "min": 60.0, "h": 3600.0}
_LENGTH = r"(\d+(?:\.\d+)?)\s*(s|sec|min|h)"
_TIME = r"\d{1,2}:\d{2}(?::\d{2})?"
_ENTRY = rf"({_TIME})\s+(\S.*?)\s+for\s+(\S.*)"
_SHIFT = rf"({_TIME})\s*(?:-|–|to)\s*({_TIME})"


class ClockTime(float):
    """Time of a trial (s) that was given as the time of day `given`."""

    given: str

    def __new__(cls, seconds: float, given: str = "") -> ClockTime:
        """Return the seconds with their text."""
        made = super().__new__(cls, seconds)
        made.given = given
        return made


def as_given(time: float) -> str:
    """Return a time of a trial in the form of its file: a time of day, or seconds."""
    return time.given if isinstance(time, ClockTime) else f"{time:,.12g} s"


def time_of_day(text: Any) -> float:
    """Return the seconds since midnight of a text such as 09:00 or 09:00:30."""
    if not isinstance(text, str):
        raise UserError(f"expected a time of day in quotes, as '09:00', found {text!r}")
    parts = [int(part) for part in text.split(":")] if re.fullmatch(_TIME, text) else [24]
    hours, minutes, seconds = (*parts, 0, 0)[:3]
    if not (hours < 24 and minutes < 60 and seconds < 60):
        raise UserError(f"expected a time of day as 09:00, found {text!r}")
    return 3600.0 * hours + 60.0 * minutes + seconds


def _instant(value: Any, number: ValidatorFunctionWrapHandler, info: ValidationInfo) -> Any:
    """Return the time of a trial (s) at a time of day, within a day of its begin.

    The context contains the time of day at which it `begins`.
    """
    if value is _FOR_EVER:
        return math.inf
    if not isinstance(value, str):
        return number(value)
    begins = (info.context or {}).get("begins", 0.0)
    return ClockTime((time_of_day(value) - begins) % DAY, value)


_FOR_EVER = object()
"""End of an interval without an end."""

Time = Annotated[NotNegative, WrapValidator(_instant)]
"""Seconds, or a time of day."""


def _seconds(value: Any) -> Any:
    # The check of numbers explains text without a unit, such as 1e3.
    if not isinstance(value, str) or value[-1:].isdigit():
        return value
    match = re.fullmatch(_LENGTH, value)
    if match is None:
        raise UserError(f"expected a length of time as 12 min, 90 s or 1.5 h, found {value!r}")
    return float(match[1]) * _UNITS[match[2]]


Length = Annotated[Positive, BeforeValidator(_seconds)]
"""Seconds, or a text such as `12 min`."""

Delay = Annotated[NotNegative, BeforeValidator(_seconds)]
"""Seconds, or a text such as `12 min`, including 0."""


Kind = Literal["fixed", "uniform", "triangular", "normal", "lognormal", "exponential"]

SHORTEST = 0.1
"""Seconds. Minimum of random durations."""


@dataclass(frozen=True)
class Duration:
    """Duration of a task, fixed or random.

    Random durations have a minimum, `SHORTEST`.

    Parameters
    ----------
    kind : {"fixed", "uniform", "triangular", "normal", "lognormal", "exponential"}
        Distribution.
    values : tuple of float
        Parameters in seconds: (duration) if fixed; (low, high) if uniform; (low, mode, high) if
        triangular; (mean, standard deviation) if normal; (median, standard deviation of the
        logarithm) if lognormal; (mean) if exponential.
    """

    kind: Kind
    values: tuple[float, ...]

    @property
    def mean(self) -> float:
        """Mean in seconds. For lognormal durations this is the median."""
        values = self.values or (math.nan,)
        if self.kind == "fixed":
            return values[0]
        usual = sum(values) / len(values) if self.kind in ("uniform", "triangular") else values[0]
        return max(usual, SHORTEST)

    def written(self) -> Any:
        """Return the value in a trial file: seconds, or a distribution as in `DrawnKeys`."""
        if self.kind == "fixed":
            return self.values[0]
        return {self.kind: self.values[0] if len(self.values) == 1 else self.values}

    def draw(self, random: Random) -> float:
        """Return a duration in seconds.

        Parameters
        ----------
        random : Random
            Random numbers. They are not used if the duration is fixed.
        """
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


@dataclass(frozen=True, kw_only=True)
class DrawnKeys(Keyed):
    """Keys of a distribution: its kind with its parameters."""

    uniform: tuple[NotNegative, NotNegative] | None = None
    triangular: tuple[NotNegative, NotNegative, NotNegative] | None = None
    normal: tuple[Number, NotNegative] | None = None
    lognormal: tuple[Positive, NotNegative] | None = None
    exponential: Positive | None = None

    @model_validator(mode="after")
    def _one(self) -> Self:
        if len(self._present) != 1:
            raise UserError(f"give one of {', '.join(vars(self))}")
        return self

    @property
    def _present(self) -> dict[str, Any]:
        return {name: value for name, value in vars(self).items() if value is not None}

    def value(self) -> Duration:
        """Return the distribution."""
        ((kind, parameters),) = self._present.items()
        values = parameters if isinstance(parameters, tuple) else (parameters,)
        return Duration(kind, tuple(map(float, values)))  # type: ignore[arg-type]


_Distribution = Annotated[DrawnKeys, AfterValidator(DrawnKeys.value)]


def _form(value: Any) -> str:
    """Return the form of a value that may be drawn."""
    if isinstance(value, dict | DrawnKeys):
        return "distribution"
    return "range" if isinstance(value, list | tuple) else "figure"


_VALUES = {
    "fixed": 1,
    "uniform": 2,
    "triangular": 3,
    "normal": 2,
    "lognormal": 2,
    "exponential": 1,
}
"""Number of values of each distribution."""


def _duration_fault(duration: Duration) -> str:
    """Return why a duration cannot be drawn, or an empty text."""
    kind, values = duration.kind, duration.values
    if kind not in _VALUES:
        return f"must be one of {', '.join(_VALUES)}, not {kind!r}"
    if len(values) != _VALUES[kind]:
        return f"{kind} needs {_VALUES[kind]} values, not {values!r}"
    scale = values[0] if kind in ("lognormal", "exponential") else max(values)
    if scale <= 0 or not all(0 <= value <= LARGEST for value in values):
        return f"must be seconds from 0 to {LARGEST:g}, not {values!r}"
    rises = kind not in ("uniform", "triangular") or [*values] == sorted(values)
    return "" if rises else f"{kind} must rise, found {[*values]}"


def _drawn_fault(value: float | tuple[float, float] | Duration) -> str:
    """Return why a value cannot be drawn, or an empty text."""
    if isinstance(value, tuple):
        fits = SMALLEST <= value[0] <= value[1] <= LARGEST
        return "" if fits else f"must be [least, most], above 0, not {[*value]}"
    return _duration_fault(value) if isinstance(value, Duration) else size_fault(value)


Drawn = Annotated[
    float | tuple[float, float] | Duration,
    Tagged(_form, {"figure": Positive, "range": Range, "distribution": _Distribution}),
    Fits(_drawn_fault),
]
"""Number, range of a uniform distribution, or other distribution."""


def _fixed(value: Duration | float) -> Duration:
    return value if isinstance(value, Duration) else Duration("fixed", (float(value),))


@dataclass(frozen=True)
class WorkTask(Keyed):
    """Task of a person at a station. A file may also contain `09:00 station2 for 12 min`.

    Parameters
    ----------
    at : str
        Name of the station.
    duration : Duration
        Duration of the work.
    name : str, optional
        Name of the task. By default the task has the name of the station.
    time : float, optional
        Time in seconds from which it is offered.
    priority : int, optional
        Tasks of a higher priority are offered first.
    every : float, optional
        Period in seconds after which it is offered again.
    count : int, optional
        Number of times it is offered with `every`. The default is no limit.
    """

    at: Annotated[str, Constrained(min_length=1), Expected("the name of a station", str)]
    duration: Annotated[
        Duration,
        Written(Positive | _Distribution),
        BeforeValidator(_seconds),
        AfterValidator(_fixed),
        Fits(_duration_fault),
    ]
    _: KW_ONLY
    name: str = ""
    time: Time = 0.0
    priority: Annotated[int, whole()] = 0
    every: Length | None = None
    count: Annotated[int, whole(1)] | None = None

    @model_validator(mode="before")
    @classmethod
    def _read_text(cls, value: Any) -> Any:
        if not isinstance(value, str):
            return value
        match = re.fullmatch(_ENTRY, value.strip())
        if match is None:
            raise UserError(
                f"expected keys, or text as '09:00 station2 for 12 min', found {value!r}"
            )
        return {"time": match[1], "at": match[2], "duration": match[3]}

    @model_validator(mode="after")
    def _count_of_what(self) -> Self:
        if self.count is not None and self.every is None:
            raise UserError("a count needs every: the seconds from one to the next")
        return self

    @property
    def label(self) -> str:
        """Name of the task, or of its station."""
        return self.name or self.at


Break = Annotated[WorkTask, AfterValidator(lambda task: replace(task, name=task.name or "break"))]
"""Task that is a break, which is its default name."""


@dataclass(frozen=True)
class WorkList(Keyed):
    """Tasks shared by several people.

    Parameters
    ----------
    tasks : tuple of WorkTask
        At least one task.
    repeat : bool, optional
        Whether each task is offered again as soon as it is done.
    """

    tasks: Annotated[tuple[WorkTask, ...], Constrained(min_length=1)]
    repeat: Flag = False

    @model_validator(mode="before")
    @classmethod
    def _read_list(cls, value: Any) -> Any:
        return {"tasks": value} if isinstance(value, list) else value

    @model_validator(mode="after")
    def _repeats_once(self) -> Self:
        if self.repeat and any(task.every is not None for task in self.tasks):
            raise UserError("tasks of a list that repeats come again when they are done, not every")
        return self


def _ends(value: Any) -> Any:
    if not isinstance(value, str):
        return value
    match = re.fullmatch(_SHIFT, value.strip())
    if match is None:
        raise UserError(f"expected [begin, end] in seconds or '06:00 - 14:00', found {value!r}")
    return [match[1], match[2]]


def _over_midnight(interval: tuple[float, float]) -> tuple[float, float]:
    begin, end = interval
    if isinstance(end, ClockTime) and end < begin:
        end = ClockTime(end + DAY, end.given)
    return begin, end


def _or_for_ever(value: Any) -> Any:
    return [value[0], _FOR_EVER] if isinstance(value, list) and len(value) == 1 else value


Shift = Annotated[
    tuple[float, float],
    Written(tuple[Time, Time]),
    BeforeValidator(_ends),
    AfterValidator(_over_midnight),
]
"""Begin and end in seconds. A file may contain a text, `06:00 - 14:00`."""

Interval = Annotated[Shift, BeforeValidator(_or_for_ever)]
"""Begin and end in seconds. The end may be infinite, which a file writes as the begin alone."""

Intervals = Annotated[tuple[Interval, ...], Constrained(min_length=1)]


@dataclass(frozen=True)
class DoorTimes(Keyed):
    """Times at which a door is closed, or open. In between it is the opposite."""

    closed: Intervals | None = None
    open: Intervals | None = None

    @model_validator(mode="after")
    def _one(self) -> Self:
        if (self.closed is None) == (self.open is None):
            raise UserError("give one of closed and open: the times at which it is")
        return self

    @property
    def intervals(self) -> tuple[Interval, ...]:
        """Intervals of either kind."""
        return (self.closed or ()) + (self.open or ())

    def is_open(self, t: float) -> bool:
        """Return whether the door is open at `t` (seconds)."""
        return (self.open is None) != within(self.intervals, t)


def _obstacle_keys(timed: TimedObstacle) -> Data:
    return written(timed.obstacle)


@dataclass(frozen=True)
class TimedObstacle(ComposedKeys):
    """Obstacle that is present during the intervals of `there`."""

    obstacle: Annotated[
        Obstacle,
        Alias("\0obstacle"),
        Composed(Obstacle, written=_obstacle_keys),
    ]
    there: Intervals


def within(intervals: Iterable[Interval], t: float) -> bool:
    """Return whether the time `t` (seconds) is in one of the intervals."""
    return any(begin <= t < end for begin, end in intervals)


def times_until(end: float, begin: float, every: float | None) -> int:
    """Return the number of repetitions from `begin` until `end` with the period `every` (s).

    It is at least 1, and 1 if the numbers are invalid.
    """
    periods = (end - begin) / every if every else 0.0
    return max(1, math.ceil(periods)) if math.isfinite(periods) else 1
