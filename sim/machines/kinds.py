"""The machines of a floor and of a trial, of whatever kind."""

from __future__ import annotations

from collections.abc import Mapping

from floorplan import Floorplan, Gantry

from ..core.machine import MachineShape
from ..core.machine_model import MachineModel
from ..core.scenario import AgvMove, GantryEntry, Scenario
from .agv.model import AgvModel
from .gantry.model import GantryModel

GANTRY = "gantry"
"""The name of the floor's own gantry."""


def models_of(scenario: Scenario) -> dict[str, MachineModel]:
    """Return the machines of a trial by name: the floor's gantry and AGVs, then its `machines`."""
    plan = scenario.floorplan
    return {
        **_on(plan, scenario.gantry, scenario.agvs, scenario.yielding),
        **scenario.machines,
    }


def machines_on(plan: Floorplan) -> tuple[MachineShape, ...]:
    """Return the machines that a floor itself has, as others see them."""
    models = _on(plan, GantryEntry(), {}, frozenset())
    return tuple(model.shape(name, plan) for name, model in models.items())


def rails_under(machine: str, plan: Floorplan) -> Gantry | None:
    """Return the rails of the floor, if `machine` is the name of the gantry that runs on them."""
    return plan.gantry if machine == GANTRY else None


def _on(
    plan: Floorplan,
    gantry: GantryEntry,
    moves: Mapping[str, tuple[AgvMove, ...]],
    yielding: frozenset[str],
) -> dict[str, MachineModel]:
    models: dict[str, MachineModel] = {} if plan.gantry is None else {GANTRY: GantryModel(gantry)}
    for lane in plan.lanes:
        models[lane.name] = AgvModel(lane, moves.get(lane.name, ()), lane.name in yielding)
    return models
