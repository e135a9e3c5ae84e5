"""The keys of an AGV in a trial file."""

import math

from pydantic import Field, model_validator

from floorplan import Flag, Lane, NotNegative, Number, Pair, Positive, Range, Strictly

from ...core.keys import Keys
from ...core.scenario import AgvMove

MOST_MOVES = 100_000
"""Moves of one AGV in a trial; more of them are a slip."""


class _Move(Keys):
    time: NotNegative
    to: str | Number

    def value(self) -> AgvMove:
        return AgvMove(self.time, self.to)


class _RepeatedMove(_Move):
    every: Positive | None = None

    def count(self, end: float) -> int:
        """Return how often it is made until `end` (seconds)."""
        return 1 if self.every is None else max(1, math.ceil((end - self.time) / self.every))


class _Agv(Strictly):
    """One AGV; where it does not yield, a list of its moves will do."""

    yields: Flag = Field(default=False, alias="yield")

    @model_validator(mode="before")
    @classmethod
    def _only_moves(cls, value: object) -> object:
        return {"moves": value} if isinstance(value, list) else value


class AgvKeys(_Agv):
    """One AGV of the floor: its moves may come again and again."""

    moves: list[_RepeatedMove] = []

    def count(self, end: float) -> int:
        """Return the number of its moves until `end` (seconds)."""
        return sum(move.count(end) for move in self.moves)

    def moves_until(self, end: float, lane: Lane | None) -> tuple[AgvMove, ...]:
        """Return its moves on a lane until `end` (seconds); in order of time if any is repeated.

        If there is something wrong with one, they are as given, so that it is found at its place.
        """
        given = tuple(move.value() for move in self.moves)
        if lane is None or self.count(end) > MOST_MOVES or all(m.every is None for m in self.moves):
            return given
        try:
            for move in given:
                lane.lane_position(move.to)
        except ValueError:
            return given
        found = [
            AgvMove(move.time + k * (move.every or 0.0), move.to)
            for move in self.moves
            for k in range(move.count(end))
        ]
        return tuple(sorted(found, key=lambda move: move.time))


class CartKeys(_Agv):
    """An AGV on a lane that the floor does not have; lengths in metres."""

    moves: list[_Move] = []
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
