"""The keys of an AGV in a trial file."""

from __future__ import annotations

from pydantic import Field, model_validator

from floorplan import Lane, NotNegative, Number, Pair, Positive, Range, Strictly

from ...core.keys import Flag, Keys
from ...core.scenario import AgvMove


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


class CartKeys(AgvKeys):
    """An AGV on a lane that the floor does not have; lengths in metres."""

    origin: Pair
    heading: Number = 0.0
    limits: Range
    locations: dict[str, Number] = {}
    start: str | Number = 0.0
    size: tuple[Positive, Positive] = (1.4, 0.8)
    height: Positive = 1.0
    max_speed: Positive = 1.0
    max_acceleration: Positive = 0.5

    def lane(self, name: str) -> Lane:
        """Return the lane."""
        at = {} if isinstance(self.start, str) else {"start": self.start}
        return Lane(
            name=name,
            origin=self.origin,
            heading=self.heading,
            limits=self.limits,
            locations={**at, **self.locations},
            start=self.start if isinstance(self.start, str) else "start",
            length=self.size[0],
            width=self.size[1],
            height=self.height,
            max_speed=self.max_speed,
            max_acceleration=self.max_acceleration,
        )
