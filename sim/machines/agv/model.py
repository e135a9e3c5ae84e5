"""The AGV of a trial, before it moves."""

from __future__ import annotations

from dataclasses import dataclass

from floorplan import Floorplan, Lane
from navigation import Stop, longest_stop

from ...core.machine import MachineShape
from ...core.machine_model import MachineModel
from ...core.scenario import AgvMove
from ...core.stage import Stage
from .agv import Agv, agv_shape


@dataclass(frozen=True)
class AgvModel(MachineModel):
    """An AGV on its lane, with the moves that it makes; one that `yields` stops for people."""

    lane: Lane
    moves: tuple[AgvMove, ...] = ()
    yields: bool = False

    def shape(self, name: str, plan: Floorplan) -> MachineShape:
        """Return what others know of it."""
        return agv_shape(self.lane)

    def make(self, name: str, stage: Stage) -> Agv:
        """Return the AGV."""
        return Agv(stage, self.lane, self.moves, yields=self.yields)

    def longest_stop(self, plan: Floorplan) -> Stop:
        """Return the longest stop on its lane."""
        return longest_stop(self.lane)
