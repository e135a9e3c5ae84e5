"""Limits of the built-in kinds of machines, from which the lengths of their fields follow."""

from __future__ import annotations

from floorplan import Floorplan
from navigation import VehicleLimits
from navigation.machines import AxisLimits, gantry_limits

from ..core.stage import MachineModel
from .agv.model import AgvModel
from .amr.model import AmrModel
from .gantry.model import GantryModel


def field_limits(model: MachineModel, plan: Floorplan) -> VehicleLimits | AxisLimits | None:
    """Return the limits of a machine for `navigation.short_fields`; None of a custom kind.

    An AGV has those of its lane. A gantry moves along both axes at once, so it has the limits of a
    holonomic drive: the higher speed of both axes, and the lower acceleration and jerk.
    """
    if isinstance(model, AmrModel):
        return model.limits
    if isinstance(model, AgvModel):
        return AxisLimits(model.lane.max_speed, model.lane.max_acceleration)
    if isinstance(model, GantryModel) and plan.gantry is not None:
        x, y, rotation = gantry_limits(plan.gantry)
        speed = max(x.max_speed, y.max_speed)
        return VehicleLimits(
            speed=speed,
            acceleration=min(x.max_acceleration, y.max_acceleration),
            jerk=min(x.max_jerk, y.max_jerk),
            turn_speed=rotation.max_speed,
            turn_acceleration=rotation.max_acceleration,
            turn_jerk=rotation.max_jerk,
            side_speed=speed,
        )
    return None
