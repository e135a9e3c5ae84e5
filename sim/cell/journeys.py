"""Journeys of people and machines: how they reach the targets of a task."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from functools import partial
from typing import Any

from simpy.events import Event as Occurrence

from floorplan import Lane, UserError
from navigation.machines import lane_state

from ..core.body import is_there
from ..core.clock import then
from ..core.recorder import Event
from ..machines.agv.agv import Agv
from ..machines.commanded import CommandedMachine
from ..machines.gantry.robot import GantryRobot
from ..simulation import Simulation
from .people import PersonProgress, PersonRoute
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
            yield from _driving(name, partial(MachineJourney, machine))
        if isinstance(machine, GantryRobot):
            yield f"{name}/trajectory", partial(TrajectoryJourney, machine)
        if isinstance(machine, Agv):
            yield f"{name}/go_to", partial(LaneJourney, machine)


def _driving(
    name: str, journey: Callable[[Sequence[Target]], Journey]
) -> Iterator[tuple[str, Callable[[Any], Journey]]]:
    """Yield the tasks of a person or machine that can move freely."""
    yield f"{name}/go_to", lambda goal: journey([target_of(goal)])
    yield f"{name}/go_through", lambda goal: journey([*map(target_of, required_targets(goal))])
    yield (
        f"{name}/follow",
        lambda goal: journey(simplified([*map(target_of, required_targets(goal))])),
    )


class MachineJourney(Journey):
    """Drive of a machine to targets, one after the other."""

    def __init__(self, machine: CommandedMachine, targets: Sequence[Target]) -> None:
        self.body = machine.body
        self.left = [*targets]
        self._machine = machine
        self._ended = ""

    def begin(self) -> None:
        """Set out for the next target."""
        x, y, *heading = self.left[0]
        self._ended = ""
        move = self._machine.move_to(x, y, *heading)
        then(move, partial(self._has_ended, self.left[0]))

    def _has_ended(self, target: Target, _: Occurrence) -> None:
        there = is_there(self._machine.position, target, NEAR)
        self._ended = SUCCEEDED if there else REPLACED

    def outcome(self) -> str:
        """Return the outcome, or continue with the next target."""
        return self.proceed() if self._ended == SUCCEEDED else self._ended

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


class LaneJourney(Journey):
    """Drive of an AGV to a location or position of its lane."""

    def __init__(self, agv: Agv, to: str | float | Pose) -> None:
        if isinstance(to, Pose):
            to = _on_lane(agv.lane, to)
        locations = agv.lane.locations
        low, high = agv.lane.limits
        if isinstance(to, str) and to not in locations:
            raise UserError(f"{agv.name} has the locations {', '.join(locations)}")
        if not isinstance(to, str) and not low <= to <= high:
            raise UserError(f"the lane of {agv.name} is from {low:g} to {high:g} m")
        self.body = agv.body
        self._agv = agv
        self._to = to
        self._at = agv.lane.lane_position(to)
        self.left = [agv.lane.position(self._at)]

    def begin(self) -> None:
        """Set out."""
        self._agv.drive(self._to)

    def outcome(self) -> str:
        """Return the outcome once the AGV is at rest without a target."""
        if not self._agv.stands:
            return ""
        return SUCCEEDED if abs(self._agv.lane_position - self._at) < NEAR else REPLACED

    def stop(self) -> None:
        """Stop on the lane, as near as possible."""
        agv, lane = self._agv, self._agv.lane
        motion = agv.stopping(agv.body.state, agv.body.clock.now)
        low, high = lane.limits
        agv.drive(min(max(lane_state(lane, motion.state(motion.end)).position, low), high))


ASIDE = 0.5
"""Distance in metres of a goal from the lane of an AGV."""


def _on_lane(lane: Lane, pose: Pose) -> float:
    """Return the position on a lane (m) of a pose. `ValueError` if it is elsewhere."""
    (ax, ay), (bx, by) = lane.position(lane.limits[0]), lane.position(lane.limits[1])
    length = math.dist((ax, ay), (bx, by))
    along = ((pose.x - ax) * (bx - ax) + (pose.y - ay) * (by - ay)) / length
    position = lane.limits[0] + min(max(along, 0.0), length)
    if math.dist(lane.position(position), (pose.x, pose.y)) > ASIDE:
        raise UserError(f"must be within {ASIDE:g} m of the lane of {lane.name}")
    return position


class PersonJourney(Journey):
    """Walk of a person to targets, one after the other."""

    def __init__(self, route: PersonRoute, targets: Sequence[Target]) -> None:
        for target in targets:
            route.require(target)
        self.body = route.person.body
        self.left = [*targets]
        self._route = route
        self._progress = PersonProgress(route.person.name)

    def begin(self) -> None:
        """Set out for the next target."""
        self._progress = PersonProgress(self._route.person.name)
        self._route.go(self.left[0])

    def outcome(self) -> str:
        """Return the outcome, or continue with the next target."""
        outcome = self._progress.outcome
        return self.proceed() if outcome == SUCCEEDED else outcome

    def see(self, event: Event) -> None:
        """Follow the events of the person."""
        self._progress.see(event)

    def stop(self) -> None:
        """Stop the person."""
        self._route.stop()
