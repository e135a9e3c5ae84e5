"""The AGV of a trial, before it moves."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from typing import Any

from floorplan import Fault, Floorplan, Lane, time_fault
from navigation import Stop, longest_stop

from ...core.machine import MachineShape
from ...core.machine_model import MachineModel
from ...core.scenario import AgvMove
from ...core.stage import Stage
from .agv import Agv, agv_shape
from .keys import CartKeys


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
        return cls(given.lane(name), tuple(move.value() for move in given.moves), given.yields)

    def shape(self, name: str, plan: Floorplan) -> MachineShape:
        """Return its shape, as others see it."""
        return agv_shape(self.lane)

    def make(self, name: str, stage: Stage) -> Agv:
        """Return the AGV."""
        return Agv(stage, self.lane, self.moves, yields=self.yields)

    def faults(self, plan: Floorplan, vehicles: Iterable[str]) -> Iterator[Fault]:
        """Yield places that its lane does not have, and moves that are out of order."""
        if self.lane.start not in self.lane.locations:
            yield f"{self.lane.name} has no location {self.lane.start!r}", ("start",)
        for k, move in enumerate(self.moves):
            try:
                self.lane.lane_position(move.to)
            except ValueError as why:
                yield str(why), (k, "to")
            if fault := time_fault(move.time):
                yield fault, (k, "time")
            if k and move.time < self.moves[k - 1].time:
                message = f"{move.time:g} s is before the move above it; put moves in order"
                yield message, (k, "time")

    def longest_stop(self, plan: Floorplan) -> Stop | None:
        """Return the longest stop on its lane."""
        return longest_stop(self.lane)
