"""The keys of places that change in a trial file: doors, and obstacles that come and go."""

import math
from typing import Annotated, Any

from pydantic import BeforeValidator, Field, model_validator

from floorplan import Obstacle, ObstacleSchema, Strictly, UserError, footprint

from ..core.closures import DoorTimes, Interval, TimedObstacle
from ..core.keys import Keys
from .work_keys import ShiftEntry, Time, shift_at_instants

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
        return TimedObstacle(Obstacle(name, footprint(self), *self.z), _at(self.there, begins))


def _at(spans: list[Any], begins: float) -> tuple[Interval, ...]:
    return tuple(
        (shift_at_instants((span.since, span.since), begins)[0], FOR_EVER)
        if isinstance(span, _Since)
        else shift_at_instants(span, begins)
        for span in spans
    )
