"""Vehicles that are under way when a person sets out: the person waits for them, or goes round."""

from __future__ import annotations

from floorplan import Human
from navigation import (
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

from ..core.body import Body
from ..core.stage import Stage
from .crossing import GAP


def among_vehicles(
    stage: Stage,
    planner: PathPlanner,
    human: Human,
    body: Body,
    goal: tuple[float, float],
    motion: Motion,
    top: float,
) -> Motion:
    """Return the motion on which somebody who stands gets to `goal` among the vehicles that drive.

    That is `motion` itself where no vehicle under way would touch them on it. Else it is one that
    waits or goes round, at up to `top` m/s; where there is none, they set out all the same, and let
    the vehicle pass when it comes.
    """
    now = stage.clock.now
    driving = [machine for machine in stage.vehicles if machine.body.motion.end > now]
    person = Cylinder(radius=human.radius, top=human.height)
    moving = [Mover(one.name, one.body.motion, one.shape.box) for one in driving]
    close = TooClose(FixedDistance(GAP))
    if not any(
        first_time(
            close,
            motion,
            mover.motion,
            now,
            motion.end,
            shapes=Shapes(person=person, machine=(mover.solid,)),
        )
        is not None
        for mover in moving
    ):
        return motion
    try:
        return plan_among(
            planner,
            body.at,
            goal,
            moving,
            at=now,
            heading=body.state.position[2],
            max_speed=top,
            max_acceleration=human.max_acceleration,
            height=human.height,
            gap=GAP,
        ).motion
    except PlanningError:
        return motion
