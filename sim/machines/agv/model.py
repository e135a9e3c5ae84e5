"""AGV of a trial: its keys, its repeated moves, and its model."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import replace
from typing import Any

from pydantic import Field, model_validator
from shapely.geometry import Polygon

from floorplan import Floorplan, Lane, UserError
from floorplan.files.dataclass import dataclass
from floorplan.files.fields import (
    Angle,
    Flag,
    Number,
    Pair,
    Positive,
    Range,
)
from floorplan.files.models import Strictly
from floorplan.files.problems import Fault
from navigation.machines import AxisLimits, Stop, longest_stop

from ...core.body import MachineShape
from ...core.scenario import AgvMove
from ...core.schedule import times_until
from ...core.stage import MachineModel, Stage
from .agv import Agv, agv_shape
from .lanes import last_before, part_behind, part_within

MOST_MOVES = 100_000
"""Most moves of all AGVs in a trial. More are a mistake."""


def number_of(moves: Iterable[AgvMove], end: float) -> int:
    """Return the number of moves until `end` (seconds)."""
    return sum(times_until(end, move.time, move.every) for move in moves)


def repeated(moves: tuple[AgvMove, ...], end: float) -> tuple[AgvMove, ...]:
    """Return all moves until `end` (seconds), in order of time if any is repeated."""
    if all(move.every is None for move in moves):
        return moves
    single = [
        replace(move, time=move.time + k * (move.every or 0.0), every=None)
        for move in moves
        for k in range(times_until(end, move.time, move.every))
    ]
    return tuple(sorted(single, key=lambda move: move.time))


class AgvKeys(Strictly):
    """Keys of an AGV of the floor. A list is its moves."""

    moves: tuple[AgvMove, ...] = ()
    yields: Flag = Field(default=False, alias="yield")

    @model_validator(mode="before")
    @classmethod
    def _only_moves(cls, value: object) -> object:
        return {"moves": value} if isinstance(value, list) else value

    def moves_until(self, end: float, lane: Lane | None) -> tuple[AgvMove, ...]:
        """Return all its moves on a lane until `end` (seconds).

        Invalid moves are not repeated, so that the fault has its place.
        """
        if lane is None:
            return self.moves
        try:
            for move in self.moves:
                lane.lane_position(move.to)
        except UserError:
            return self.moves
        return repeated(self.moves, end)


class CartKeys(AgvKeys):
    """Keys of an AGV with its own lane. Lengths in metres."""

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


@dataclass(frozen=True)
class AgvModel(MachineModel):
    """An AGV on its lane, with its moves. It stops for people if it `yields`."""

    lane: Lane
    moves: tuple[AgvMove, ...] = ()
    yields: bool = False

    category = "vehicle"
    key_schema = CartKeys

    @classmethod
    def read(cls, name: str, keys: Mapping[str, Any]) -> AgvModel:
        """Return the model with these keys of a trial file."""
        checked = CartKeys.model_validate(keys)
        return cls(checked.lane(name), checked.moves, checked.yields)

    def shape(self, name: str, plan: Floorplan) -> MachineShape:
        """Return its shape."""
        return agv_shape(self.lane)

    def make(self, name: str, stage: Stage) -> Agv:
        """Return the AGV. `ValueError` if it moves too often."""
        return Agv(stage, self.lane, repeated(self.moves, stage.end), yields=self.yields)

    def faults(self, plan: Floorplan, vehicles: Iterable[str]) -> Iterator[Fault]:
        """Yield faults of places that its lane does not have, and of the order of moves."""
        if self.lane.start not in self.lane.locations:
            yield f"{self.lane.name} has no location {self.lane.start!r}", ("start",)
        are_in_order = all(move.every is None for move in self.moves)
        for k, move in enumerate(self.moves):
            try:
                self.lane.lane_position(move.to)
            except UserError as why:
                yield str(why), (k, "to")
            if are_in_order and k and move.time < self.moves[k - 1].time:
                message = f"{move.time:g} s is before the move above it; put moves in order"
                yield message, (k, "time")

    def place_faults(self, name: str, plan: Floorplan) -> Iterator[Fault]:
        """Yield faults of moves into a forbidden zone, or through a gate in the wrong direction."""
        lane = self.lane
        at = lane.locations.get(lane.start, 0.0)
        for k, move in enumerate(self.moves):
            try:
                to = lane.lane_position(move.to)
            except UserError:
                return  # reported already, and the next start is unknown
            for zone in plan.zones:
                if zone.forbidden and zone.is_about(name):
                    part = part_within(lane, zone.area)
                    if part is not None and last_before(part, at, to) is not None:
                        yield f"leads into the zone {zone.name!r}, forbidden to {name}", (k, "to")
            for gate in plan.one_ways:
                part = part_behind(lane, gate, at, to) if gate.is_about(name) else None
                if part is not None and last_before(part, at, to) is not None:
                    message = f"leads through the gate {gate.name!r} against its direction"
                    yield message, (k, "to")
            at = to

    def stands_at_start(self, name: str, plan: Floorplan) -> Polygon | None:
        """Return the area that it covers at the start."""
        at = self.lane.locations.get(self.lane.start)
        return None if at is None else self.lane.footprint(at)

    def longest_stop(self, plan: Floorplan) -> Stop | None:
        """Return time and distance of its longest stop."""
        return longest_stop(self.lane)

    def field_limits(self, plan: Floorplan) -> AxisLimits:
        """Return the limits of its lane."""
        return AxisLimits(self.lane.max_speed, self.lane.max_acceleration)
