"""The keys of an AGV in a trial file."""

from pydantic import Field, model_validator

from floorplan import (
    Angle,
    Flag,
    Lane,
    NotNegative,
    Number,
    Pair,
    Positive,
    Range,
    Strictly,
    UserError,
)

from ...core.keys import Keys
from ...core.scenario import AgvMove
from .moves import repeated


class _Move(Keys):
    stands_for = AgvMove
    time: NotNegative
    to: str | Number
    every: Positive | None = None


class AgvKeys(Strictly):
    """One AGV of the floor; where it does not yield, a list of its moves will do."""

    moves: list[_Move] = []
    yields: Flag = Field(default=False, alias="yield")

    @model_validator(mode="before")
    @classmethod
    def _only_moves(cls, value: object) -> object:
        return {"moves": value} if isinstance(value, list) else value

    def values(self) -> tuple[AgvMove, ...]:
        """Return its moves as they are given."""
        return tuple(move.value() for move in self.moves)

    def moves_until(self, end: float, lane: Lane | None) -> tuple[AgvMove, ...]:
        """Return all its moves on a lane until `end` (seconds).

        If there is something wrong with one, they are as given, so that it is found at its place.
        """
        given = self.values()
        if lane is None:
            return given
        try:
            for move in given:
                lane.lane_position(move.to)
        except UserError:
            return given
        return repeated(given, end)


class CartKeys(AgvKeys):
    """An AGV on a lane that the floor does not have; lengths in metres."""

    origin: Pair
    heading: Angle = 0.0
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
