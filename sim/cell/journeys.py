"""Journeys of people and machines: how they reach the targets of a task."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from functools import partial
from typing import Any

from simpy.events import Event as Occurrence

from floorplan import Lane, UserError

from ..core.body import is_there
from ..core.clock import then
from ..core.recorder import Event
from ..machines.agv.agv import Agv
from ..machines.commanded import CommandedMachine
from ..machines.gantry.robot import GantryRobot
from ..simulation import Simulation
from .people import PersonRoute
from .tasks import REPLACED, SUCCEEDED, Journey, required_targets, simplified
from .trajectories import JointTrajectory, follow
from .values import Pose, Target, target_of

NEAR = 1e-3
"""Metres and radians. A machine this close to its target has arrived."""


def journeys_of(simulation: Simulation) -> Iterator[tuple[str, Callable[[Any], Journey]]]:
    """Yield the names of all tasks, and the functions that make their journeys."""
    for person in simulation.people:
        if not person.is_recorded:
            walk = partial(PersonJourney, PersonRoute(simulation, person))
            yield from _driving(f"people/{person.name}", walk)
    for machine in simulation.machines.values():
        name = f"machines/{machine.name}"
        if isinstance(machine, CommandedMachine):
            read = partial(on_lane, machine.lane) if isinstance(machine, Agv) else target_of
            yield from _driving(name, partial(MachineJourney, machine), read)
        if isinstance(machine, GantryRobot):
            yield f"{name}/trajectory", partial(TrajectoryJourney, machine)


def _driving(
    name: str,
    journey: Callable[[Sequence[Target]], Journey],
    read: Callable[[Any], Target] = target_of,
) -> Iterator[tuple[str, Callable[[Any], Journey]]]:
    """Yield the tasks of a person or machine. `read` returns the target of a pose."""
    yield f"{name}/go_to", lambda goal: journey([read(goal)])
    yield f"{name}/go_through", lambda goal: journey([*map(read, required_targets(goal))])
    yield f"{name}/follow", lambda goal: journey(simplified([*map(read, required_targets(goal))]))


class MachineJourney(Journey):
    """Drive of a machine to targets, one after the other."""

    def __init__(self, machine: CommandedMachine, targets: Sequence[Target]) -> None:
        self.body = machine.body
        self.left = [*targets]
        self._machine = machine

    def begin(self) -> None:
        """Set out for the next target."""
        x, y, *heading = self.left[0]
        self.ended = ""
        move = self._machine.move_to(x, y, *heading)
        then(move, partial(self._has_ended, self.left[0]))

    def _has_ended(self, target: Target, _: Occurrence) -> None:
        there = is_there(self._machine.position, target, NEAR)
        self.ended = SUCCEEDED if there else REPLACED

    def stop(self) -> None:
        """Stop the machine."""
        self._machine.stop()


class TrajectoryJourney(MachineJourney):
    """Motion of a gantry along a joint trajectory."""

    def __init__(self, gantry: GantryRobot, trajectory: JointTrajectory) -> None:
        super().__init__(gantry, [gantry.position])
        self._gantry = gantry
        self._trajectory = trajectory

    def begin(self) -> None:
        """Follow the trajectory."""
        end = follow(self._gantry, self._trajectory)
        motion = self.body.motion
        self.left = [motion.state(motion.end).position]
        then(end, partial(self._has_ended, self.left[0]))


ASIDE = 0.5
"""Distance in metres of a goal from the lane of an AGV."""


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


class PersonJourney(Journey):
    """Walk of a person to targets, one after the other."""

    def __init__(self, route: PersonRoute, targets: Sequence[Target]) -> None:
        for target in targets:
            route.require(target)
        self.body = route.person.body
        self.left = [*targets]
        self._route = route
        self._goal: list[float] | None = None

    def begin(self) -> None:
        """Set out for the next target."""
        self._goal, self.ended = None, ""
        self._route.go(self.left[0])

    def see(self, event: Event) -> None:
        """Follow the events of the person."""
        if event.get("person") != self._route.person.name or self.ended:
            return
        match event["kind"]:
            case "goal" if self._goal is None:
                self._goal = event["at"]
            case "goal" if event["at"] != self._goal:
                self.ended = "failed: another goal replaced it"
            case "arrived" if self._goal is not None:
                self.ended = SUCCEEDED
            case "path_blocked" if self._goal is not None:
                self.ended = f"failed: {event['message']}"
            case "teleport" | "left":
                self.ended = f"failed: {event['kind']}"

    def stop(self) -> None:
        """Stop the person."""
        self._route.stop()
