"""Commands and tasks of machines: twists, drives, and trajectories of gantries."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from functools import partial
from typing import Any

from simpy.events import Event as Occurrence

from floorplan import Lane, UserError
from navigation.vehicles import Twist

from ..core.body import Machine, is_there
from ..core.clock import then
from ..machines.agv.agv import Agv
from ..machines.amr.amr import Amr
from ..machines.commanded import CommandedMachine
from ..machines.gantry.robot import GantryRobot
from ..machines.gantry.trajectories import JointTrajectory, follow
from ..simulation import BY_COMMAND
from .tasks import REPLACED, SUCCEEDED, Running, tasks_to
from .values import Pose, Target, target_of

TWIST_TIME = 0.5
"""Seconds that a machine follows a twist unless another one comes before."""

AT_POSE = 0.1
"""Metres and radians. An initial pose must be this close to the pose of the machine."""

NEAR = 1e-3
"""Metres and radians. A machine this close to its target has arrived."""

ASIDE = 0.5
"""Distance in metres of a goal from the lane of an AGV."""


def commands_of_machine(machine: Machine) -> dict[str, Callable[[Any], object]]:
    """Return the commands of a machine, by name."""
    body = f"machines/{machine.name}"
    commands: dict[str, Callable[[Any], object]] = {
        f"{body}/hold": lambda hold: machine.stand_for(BY_COMMAND, bool(hold))
    }
    if isinstance(machine, CommandedMachine):
        commands[f"{body}/stop"] = lambda _: machine.stop()
        commands[f"{body}/pose"] = partial(_require_pose, machine)
    if isinstance(machine, Amr):
        commands[f"{body}/twist"] = lambda twist: machine.twist(Twist.of(twist), TWIST_TIME)
    if isinstance(machine, GantryRobot):
        commands[f"{body}/joints"] = partial(follow, machine)
    if isinstance(machine, Agv):
        commands[f"{body}/drive"] = machine.drive
    return commands


def tasks_of_machine(machine: Machine) -> dict[str, Callable[[Any], Running]]:
    """Return the tasks of a machine, by name."""
    if not isinstance(machine, CommandedMachine):
        return {}
    body = f"machines/{machine.name}"
    read = partial(on_lane, machine.lane) if isinstance(machine, Agv) else target_of
    tasks = tasks_to(body, read, partial(MachineTask, machine))
    if isinstance(machine, GantryRobot):
        tasks[f"{body}/trajectory"] = partial(TrajectoryTask, machine)
    return tasks


def _require_pose(machine: CommandedMachine, pose: Pose) -> None:
    """Check an initial pose. The simulation knows where the machine is."""
    if not is_there(machine.position, target_of(pose), AT_POSE):
        x, y, heading = machine.position
        raise UserError(
            f"{machine.name} is at ({x:g}, {y:g}, {heading:g}); set its key `at` in the trial"
        )


def on_lane(lane: Lane, goal: str | float | Pose | Sequence[float]) -> Target:
    """Return the point on a lane of a location, a lane position (m) or a pose near the lane."""
    if isinstance(goal, str | float | int):
        return lane.position(lane.lane_position(goal))
    x, y, *_ = target_of(goal)
    low, high = lane.limits
    point = lane.position(min(max(lane.along((x, y)), low), high))
    if math.dist(point, (x, y)) > ASIDE:
        raise UserError(f"must be within {ASIDE:g} m of the lane of {lane.name}")
    return point


class MachineTask(Running):
    """Drive of a machine to targets, one after the other."""

    def __init__(self, machine: CommandedMachine, goal: Any, targets: Sequence[Target]) -> None:
        super().__init__(goal, machine.body, targets)
        self._machine = machine

    def begin(self) -> None:
        """Set out for the first target."""
        x, y, *heading = self._left[0]
        self._wait_for(self._machine.move_to(x, y, *heading))

    def _wait_for(self, end: Occurrence) -> None:
        """Wait for the end of a move to the first target."""
        target, self._outcome = self._left[0], ""
        then(end, lambda _: self._has_stopped(target))

    def _has_stopped(self, target: Target) -> None:
        there = is_there(self._machine.position, target, NEAR)
        self._outcome = SUCCEEDED if there else REPLACED

    def _stop(self) -> None:
        self._machine.stop()


class TrajectoryTask(MachineTask):
    """Motion of a gantry along a joint trajectory."""

    def __init__(self, gantry: GantryRobot, trajectory: JointTrajectory) -> None:
        super().__init__(gantry, trajectory, ())
        self._gantry = gantry

    def begin(self) -> None:
        """Follow the trajectory."""
        end = follow(self._gantry, self.goal)
        motion = self._body.motion
        self._left = [motion.state(motion.end).position]
        self._wait_for(end)
