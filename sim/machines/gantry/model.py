"""The gantry of a trial, before it moves."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import partial

from floorplan import Floorplan, Gantry
from navigation import Stop, longest_stop

from ...core.machine import MachineShape
from ...core.machine_model import MachineModel
from ...core.scenario import GantryEntry
from ...core.stage import Stage
from .controllers import find_controller, supervised
from .robot import GantryRobot, gantry_shape


@dataclass(frozen=True)
class GantryModel(MachineModel):
    """A gantry with its controller and jobs, on rails of its own or on those of the floor."""

    entry: GantryEntry = field(default_factory=GantryEntry)
    rails: Gantry | None = None

    def shape(self, name: str, plan: Floorplan) -> MachineShape:
        """Return what others know of it."""
        return gantry_shape(self._on(plan), name)

    def make(self, name: str, stage: Stage) -> GantryRobot:
        """Return the robot; `ControllerError` if its controller can't be found."""
        entry = self.entry
        found = find_controller(entry.controller, stage.folder, own_code=stage.own_code)
        controller = partial(supervised, entry.controller_name, found)
        return GantryRobot(stage, self._on(stage.floorplan), entry, name, controller=controller)

    def longest_stop(self, plan: Floorplan) -> Stop:
        """Return the longest and farthest stop of its axes."""
        return longest_stop(self._on(plan))

    def _on(self, plan: Floorplan) -> Gantry:
        rails = self.rails or plan.gantry
        if rails is None:
            raise ValueError(f"the floorplan {plan.name!r} has no gantry: give its rails")
        return rails
