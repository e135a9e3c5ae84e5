"""The AGV of a trial, before it moves."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from typing import Any

from floorplan import Fault, Floorplan, Lane, UserError, size_fault, time_fault
from navigation import Stop, longest_stop

from ...core.machine import MachineShape
from ...core.machine_model import MachineModel
from ...core.scenario import AgvMove
from ...core.stage import Stage
from .agv import Agv, agv_shape
from .keys import CartKeys
from .moves import repeated


@dataclass(frozen=True)
class AgvModel(MachineModel):
    """An AGV on its lane, with the moves that it makes; one that `yields` stops for people."""

    lane: Lane
    moves: tuple[AgvMove, ...] = ()
    yields: bool = False

    category = "vehicle"
    key_schema = CartKeys

    @classmethod
    def read(cls, name: str, keys: Mapping[str, Any]) -> AgvModel:
        """Return the model with these keys of a trial file."""
        given = CartKeys.model_validate(keys)
        return cls(given.lane(name), given.values(), given.yields)

    def shape(self, name: str, plan: Floorplan) -> MachineShape:
        """Return its shape, as others see it."""
        return agv_shape(self.lane)

    def make(self, name: str, stage: Stage) -> Agv:
        """Return the AGV; `ValueError` if it moves too often."""
        return Agv(stage, self.lane, repeated(self.moves, stage.end), yields=self.yields)

    def faults(self, plan: Floorplan, vehicles: Iterable[str]) -> Iterator[Fault]:
        """Yield places that its lane does not have, and moves that are out of order."""
        if self.lane.start not in self.lane.locations:
            yield f"{self.lane.name} has no location {self.lane.start!r}", ("start",)
        are_in_order = all(move.every is None for move in self.moves)
        for k, move in enumerate(self.moves):
            try:
                self.lane.lane_position(move.to)
            except UserError as why:
                yield str(why), (k, "to")
            if fault := time_fault(move.time):
                yield fault, (k, "time")
            if move.every is not None and (fault := size_fault(move.every)):
                yield fault, (k, "every")
            if are_in_order and k and move.time < self.moves[k - 1].time:
                message = f"{move.time:g} s is before the move above it; put moves in order"
                yield message, (k, "time")

    def longest_stop(self, plan: Floorplan) -> Stop | None:
        """Return the longest stop on its lane."""
        return longest_stop(self.lane)
