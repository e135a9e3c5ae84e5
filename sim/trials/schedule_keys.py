"""Keys of times in a trial file: tasks, shifts, doors, and timed obstacles."""

import math
import re
from dataclasses import replace
from typing import Annotated, Any

from pydantic import (
    BeforeValidator,
    Field,
    ValidatorFunctionWrapHandler,
    WrapValidator,
    field_validator,
    model_validator,
)

from floorplan import Obstacle, UserError
from floorplan.building import ObstacleSchema, footprint
from floorplan.files.fields import Flag, NotNegative, Number, Positive, Strictly, whole

from ..core.entries import ClockTime, Duration, Keys, Shift, WorkList, WorkTask
from ..core.stage import DoorTimes, Interval, TimedObstacle

DAY = 86_400.0

_UNITS = {"s": 1.0, "sec": 1.0, "min": 60.0, "h": 3600.0}
_LENGTH = r"(\d+(?:\.\d+)?)\s*(s|sec|min|h)"
_TIME = r"\d{1,2}:\d{2}(?::\d{2})?"
_ENTRY = rf"({_TIME})\s+(\S.*?)\s+for\s+(\S.*)"
_SHIFT = rf"({_TIME})\s*(?:-|–|to)\s*({_TIME})"


class TimeOfDay(ClockTime):
    """A time of day in seconds since midnight: an instant once it is known when a trial begins."""

    def instant(self, begins: float) -> ClockTime:
        """Return the seconds from `begins` (a time of day) to it, on the same day or the next."""
        return ClockTime((float(self) - begins) % DAY, self.given)


def time_of_day(text: str) -> TimeOfDay:
    """Return the time of day in `text`, as 09:00 or 09:00:30; `ValueError` if it is none."""
    parts = [int(part) for part in text.split(":")] if re.fullmatch(_TIME, text) else [24]
    hours, minutes, seconds = (*parts, 0, 0)[:3]
    if not (hours < 24 and minutes < 60 and seconds < 60):
        raise UserError(f"expected a time of day as 09:00, found {text!r}")
    return TimeOfDay(3600 * hours + 60 * minutes + seconds, text)


def _seconds(text: str) -> float:
    found = re.fullmatch(_LENGTH, text)
    if found is None:
        raise UserError(f"expected a length of time as 12 min, 90 s or 1.5 h, found {text!r}")
    return float(found[1]) * _UNITS[found[2]]


def _time(value: Any, number: ValidatorFunctionWrapHandler) -> Any:
    return time_of_day(value) if isinstance(value, str) else number(value)


Time = Annotated[NotNegative, WrapValidator(_time)]
"""Seconds, or a time of day."""


class DrawnKeys(Keys):
    """A distribution, one of these, with its figures."""

    uniform: tuple[NotNegative, NotNegative] | None = None
    triangular: tuple[NotNegative, NotNegative, NotNegative] | None = None
    normal: tuple[Number, NotNegative] | None = None
    lognormal: tuple[Positive, NotNegative] | None = None
    exponential: Positive | None = None

    @model_validator(mode="after")
    def _one(self) -> "DrawnKeys":
        if len(self.model_fields_set) != 1:
            raise UserError(f"give one of {', '.join(type(self).model_fields)}")
        for name in ("uniform", "triangular"):
            given = getattr(self, name)
            if given is not None and list(given) != sorted(given):
                raise UserError(f"{name} must rise, found {list(given)}")
        return self

    def value(self) -> Duration:
        """Return the distribution."""
        (kind,) = self.model_fields_set
        given = getattr(self, kind)
        values = given if isinstance(given, tuple) else (given,)
        return Duration(kind, tuple(map(float, values)))  # type: ignore[arg-type]


def _length(value: Any) -> Any:
    # Text without a unit is left to the check of numbers, which explains 1e3.
    has_unit = isinstance(value, str) and not value[-1:].isdigit()
    return _seconds(value) if has_unit else value


Length = Annotated[Positive, BeforeValidator(_length)]
"""Seconds, or a text as `12 min`."""


class TaskKeys(Keys):
    """One task, or a text: `09:00 station2 for 12 min`."""

    at: Annotated[str, Field(min_length=1)]
    duration: Annotated[Positive | DrawnKeys, BeforeValidator(_length)]
    name: str = ""
    time: Time = 0.0
    priority: Annotated[int, whole()] = 0
    every: Length | None = None
    count: Annotated[int, whole(1)] | None = None

    @model_validator(mode="after")
    def _count_of_what(self) -> "TaskKeys":
        if self.count is not None and self.every is None:
            raise UserError("a count needs every: the seconds from one to the next")
        return self

    def value(self) -> WorkTask:
        """Return the task."""
        given = self.fields()
        if not isinstance(self.duration, DrawnKeys):
            given["duration"] = Duration("fixed", (float(self.duration),))
        return WorkTask(**given)


def _entry(value: Any) -> Any:
    if not isinstance(value, str):
        return value
    found = re.fullmatch(_ENTRY, value.strip())
    if found is None:
        raise UserError(f"expected keys, or text as '09:00 station2 for 12 min', found {value!r}")
    return {"time": found[1], "at": found[2], "duration": found[3]}


TaskEntry = Annotated[TaskKeys, BeforeValidator(_entry)]


class WorkListKeys(Keys):
    """A list of tasks, or only the tasks."""

    stands_for = WorkList
    tasks: Annotated[list[TaskEntry], Field(min_length=1)]
    repeat: Flag = False

    @model_validator(mode="after")
    def _repeats_once(self) -> "WorkListKeys":
        if self.repeat and any(task.every is not None for task in self.tasks):
            raise UserError("tasks of a list that repeats come again when they are done, not every")
        return self


def _as_list(value: Any) -> Any:
    return {"tasks": value} if isinstance(value, list) else value


WorkListEntry = Annotated[WorkListKeys, BeforeValidator(_as_list)]


def _shift(value: Any) -> Any:
    if not isinstance(value, str):
        return value
    found = re.fullmatch(_SHIFT, value.strip())
    if found is None:
        raise UserError(f"expected [begin, end] in seconds or '06:00 - 14:00', found {value!r}")
    return [found[1], found[2]]


ShiftEntry = Annotated[tuple[Time, Time], BeforeValidator(_shift)]


class WorkerKeys(Keys):
    """Keys of a person about their work."""

    work: list[str] = []
    schedule: list[TaskEntry] = []
    breaks: list[TaskEntry] = []
    shifts: list[ShiftEntry] = []

    @field_validator("work", mode="before")
    @classmethod
    def _one_list(cls, value: Any) -> Any:
        return [value] if isinstance(value, str) else value


def at_instants(task: WorkTask, begins: float) -> WorkTask:
    """Return `task` with its time of day, if it has one, as an instant of a trial."""
    return replace(task, time=_instant(task.time, begins))


def shift_at_instants(shift: Shift, begins: float) -> Shift:
    """Return `shift` as instants of a trial; one by times of day may end on the next day."""
    begin, end = (_instant(time, begins) for time in shift)
    if isinstance(shift[1], TimeOfDay) and end < begin:  # over midnight
        end = ClockTime(end + DAY, shift[1].given)
    return (begin, end)


def _instant(time: float, begins: float) -> float:
    return time.instant(begins) if isinstance(time, TimeOfDay) else time


FOR_EVER = math.inf
"""Seconds. The end of what never ends."""


def _span(value: Any) -> Any:
    """Return an interval as two times; one that begins and never ends has one."""
    if isinstance(value, list) and len(value) == 1:
        return {"since": value[0]}
    return value


class _Since(Keys):
    since: Time

    def value(self) -> Interval:
        return (self.since, FOR_EVER)


_Span = Annotated[_Since | ShiftEntry, BeforeValidator(_span)]

Spans = Annotated[list[_Span], Field(min_length=1)]
"""Intervals: `[begin, end]` in seconds, `[begin]` for ever, or '06:00 - 14:00'."""


class DoorKeys(Strictly):
    """When a door is closed, or when it is open."""

    closed: Spans | None = None
    open: Spans | None = None

    @model_validator(mode="after")
    def _one(self) -> "DoorKeys":
        if (self.closed is None) == (self.open is None):
            raise UserError("give one of closed and open: the times at which it is")
        return self

    def value_at(self, begins: float) -> DoorTimes:
        """Return the times of the door in a trial that `begins` at that time of day."""
        closed, opened = (None if one is None else _at(one, begins) for one in self._both)
        return DoorTimes(closed, opened)

    @property
    def _both(self) -> tuple[Any, Any]:
        return self.closed, self.open


class TimedKeys(ObstacleSchema):
    """An obstacle, and when it is there."""

    there: Spans

    def value_at(self, name: str, begins: float) -> TimedObstacle:
        """Return the obstacle in a trial that `begins` at that time of day."""
        return TimedObstacle(
            Obstacle(name=name, footprint=footprint(self), bottom=self.z[0], top=self.z[1]),
            _at(self.there, begins),
        )


def _at(spans: list[Any], begins: float) -> tuple[Interval, ...]:
    return tuple(
        (shift_at_instants((span.since, span.since), begins)[0], FOR_EVER)
        if isinstance(span, _Since)
        else shift_at_instants(span, begins)
        for span in spans
    )
