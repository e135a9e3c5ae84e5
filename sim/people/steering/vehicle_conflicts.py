"""Conflicts of a path with moving vehicles: whether to wait, and which space to avoid."""

from __future__ import annotations

from functools import lru_cache

from floorplan import Human
from navigation import (
    Box,
    Cylinder,
    FixedDistance,
    Motion,
    Mover,
    PathPlanner,
    PlanningError,
    Shapes,
    TooClose,
    first_time,
    plan_among,
)
from navigation.moving_obstacles import Passage

from ...core.body import Body, Machine
from ...core.stage import Stage

GAP = 0.1
"""Metres. Nearer than this to the surface of an AGV that drives, a person counts as touched."""

TOUCHING = TooClose(FixedDistance(GAP))
"""The condition under which somebody counts as touched."""


def among_vehicles(
    stage: Stage,
    planner: PathPlanner,
    human: Human,
    body: Body,
    goal: tuple[float, float],
    motion: Motion,
    top: float,
    gap: float,
) -> Passage | None:
    """Return the passage of somebody who stands to `goal`, at up to `top` m/s, among vehicles.

    They keep `gap` metres from the surfaces of those. None if no vehicle would touch them on
    `motion`, neither one under way nor one that is known to set out before they arrive. None, too,
    if there is no passage: they set out all the same then, and let the vehicle pass when it comes.
    """
    if not any_touches(stage, human, motion):
        return None
    now = stage.clock.now
    try:
        return plan_among(
            planner,
            body.at,
            goal,
            _moving(stage, now, motion.end),
            at=now,
            heading=body.state.position[2],
            max_speed=top,
            max_acceleration=human.max_acceleration,
            height=human.height,
            gap=gap,
        )
    except PlanningError:
        return None


def any_touches(stage: Stage, human: Human, motion: Motion) -> bool:
    """Return whether a vehicle touches somebody on `motion`, as far as it is known how it drives.

    That is, under way or known to set out before they arrive.
    """
    now = stage.clock.now
    return any(_touches(mover, motion, human, now) for mover in _moving(stage, now, motion.end))


def any_moves(stage: Stage, until: float) -> bool:
    """Return whether a vehicle drives now, or is known to set out by `until` (seconds)."""
    return bool(_moving(stage, stage.clock.now, until))


def _moving(stage: Stage, now: float, until: float) -> list[Mover]:
    """Return the vehicles that drive now or set out by `until`, as far as that is known."""
    known = ((machine, machine.foreseen(until)) for machine in stage.vehicles)
    return [_mover(machine, motion) for machine, motion in known if motion.end > now]


def _mover(machine: Machine, motion: Motion) -> Mover:
    return Mover(machine.name, motion, machine.shape.box)


def _touches(mover: Mover, motion: Motion, human: Human, now: float) -> bool:
    shapes = _shapes(human, mover.solid)
    return first_time(TOUCHING, motion, mover.motion, now, motion.end, shapes=shapes) is not None


@lru_cache
def _shapes(human: Human, vehicle: Box | Cylinder) -> Shapes:
    """Return the solids of a person and of a vehicle; most people are alike."""
    return Shapes(person=Cylinder(radius=human.radius, top=human.height), machine=(vehicle,))
