"""What a policy sees of a machine, what it does, and the controller that asks it at each tick."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Sequence
from dataclasses import KW_ONLY, dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray
from simpy.events import Event

from floorplan import UserError

from ..core.entries import Pose
from .amr.amr import Amr
from .commanded import CommandedMachine, Sighting
from .commanding import Steps
from .gantry.robot import GantryRobot

SLOWEST = 0.05
"""Lowest share of the speed of a gantry."""

ROUNDING = 1e-6
"""By how much an action may exceed its bounds."""

Array = NDArray[np.float32]
Observation = dict[str, Array]

FARTHEST = 1000.0
"""Metres. Bound of positions and distances."""


@dataclass(frozen=True)
class Interface:
    """Interface between a policy and a machine: ticks, sensors and actions.

    Parameters
    ----------
    rate : float, optional
        Ticks per second. At each, the policy chooses an action.
    people : int, optional
        Number of people that are observed, the nearest first.
    rays : int, optional
        Number of laser rays.
    reach : float, optional
        Range of the rays, and bound of the margin, in metres.
    goal_radius : float, optional
        Distance in metres within which a goal is reached.

    Raises
    ------
    ValueError
        If a value is not positive.
    """

    rate: float = 5.0
    _: KW_ONLY
    people: int = 5
    rays: int = 36
    reach: float = 10.0
    goal_radius: float = 0.3

    def __post_init__(self) -> None:
        for name, value in vars(self).items():
            number = isinstance(value, int | float) and math.isfinite(value)
            if not number or value < 0 or (value == 0 and name not in ("people", "rays")):
                raise UserError(f"{name} must be a number above 0, not {value!r}")

    @property
    def sizes(self) -> dict[str, tuple[int, ...]]:
        """Shape of each part of an observation."""
        parts = {"self": (7,), "goal": (3,), "people": (self.people, 5), "margin": (1,)}
        return {**parts, "scan": (self.rays,)} if self.rays else parts

    @property
    def size(self) -> int:
        """Number of values of a flat observation."""
        return sum(math.prod(shape) for shape in self.sizes.values())

    def bounds(self, machine: CommandedMachine) -> dict[str, tuple[Array, Array]]:
        """Return the lowest and highest value of each part of an observation."""
        fastest = 1.01 * max(machine.human_speed, machine.drive.top_speed, 10.0)
        own = [FARTHEST, FARTHEST, 1.0, 1.0, fastest, fastest, fastest]
        high = {
            "self": own,
            "goal": [FARTHEST, FARTHEST, 1.0],
            "people": [[FARTHEST, FARTHEST, 2 * fastest, 2 * fastest, 1.0]] * self.people,
            "margin": [FARTHEST],
            "scan": [self.reach] * self.rays,
        }
        found = {}
        for name, shape in self.sizes.items():
            highest = np.array(high[name], np.float32).reshape(shape)
            found[name] = (-highest, highest) if name != "scan" else (0 * highest, highest)
        return found

    def observe(self, machine: CommandedMachine) -> Observation:
        """Return what a machine observes now.

        Returns
        -------
        dict
            Arrays in the frame of the machine, in metres and m/s. `self`: x and y on the floor,
            cosine and sine of the rotation, and the velocity (forwards, left, rad/s). `goal`: x, y
            and 1, or zeros without a goal. `people`: x, y, velocity (x, y) and 1 for each person,
            or zeros. `margin`: least distance minus required distance to a person. `scan`: lengths
            of the rays, as of `scan`.
        """
        (x, y, rotation), (vx, vy, turning), _ = machine.state
        c, s = math.cos(rotation), math.sin(rotation)
        goal = goal_of(machine)
        people = np.zeros((self.people, 5), np.float32)
        for row, person in zip(people, self._nearest(machine, x, y), strict=False):
            dx, dy = person.at[0] - x, person.at[1] - y
            u, v = person.velocity
            row[:] = dx * c + dy * s, dy * c - dx * s, u * c + v * s, v * c - u * s, 1.0
        towards = (0.0, 0.0, 0.0)
        if goal is not None:
            dx, dy = goal[0] - x, goal[1] - y
            towards = (dx * c + dy * s, dy * c - dx * s, 1.0)
        own = (x, y, c, s, vx * c + vy * s, vy * c - vx * s, turning)
        seen: Observation = {
            "self": np.array(own, np.float32),
            "goal": np.array(towards, np.float32),
            "people": people,
            "margin": np.array([self.margin(machine)], np.float32),
        }
        if self.rays:
            seen["scan"] = machine.scan(self.rays, self.reach).astype(np.float32)
        return seen

    def margin(self, machine: CommandedMachine) -> float:
        """Return the margin of a machine now in metres, at most `reach`."""
        return max(-FARTHEST, min(self.reach, machine.margin))

    def _nearest(self, machine: CommandedMachine, x: float, y: float) -> list[Sighting]:
        return sorted(machine.people, key=lambda person: math.dist(person.at, (x, y)))[
            : self.people
        ]


def flat(observation: Observation) -> Array:
    """Return an observation as one array, in the order of its keys."""
    return np.concatenate([part.ravel() for part in observation.values()])


def goal_of(machine: CommandedMachine) -> Pose | None:
    """Return the goal of the current mission or step: x, y (m) and rotation (nan for any)."""
    if isinstance(machine, Amr):
        goals = [one.go for one in machine.missions if isinstance(one.go, tuple)]
        return (goals[0][0], goals[0][1], math.nan) if goals else None
    if not isinstance(machine, GantryRobot) or not machine.open_tasks:
        return None
    return machine.where(machine.open_tasks[0])


class ActionBounds:
    """Actions of a machine as numbers from -1 to 1, and the commands that they stand for.

    Those of a vehicle stand for its twist: m/s forwards, m/s to the left (of a holonomic drive
    only) and rad/s. Those of a gantry stand for its target (x, y in metres) and the share of its
    speed.
    """

    def __init__(self, machine: CommandedMachine) -> None:
        if isinstance(machine, GantryRobot):
            axes = (machine.gantry.x, machine.gantry.y)
            low = [*(axis.low for axis in axes), SLOWEST]
            high = [*(axis.high for axis in axes), 1.0]
        else:
            assert isinstance(machine, Amr)
            limits = machine.limits
            high = [limits.speed, *filter(None, [limits.side_speed]), limits.turn_speed]
            low = [-value for value in high]
        self._middle = (np.array(low) + high) / 2
        self._half = (np.array(high) - low) / 2
        self.count = len(high)

    def command(self, action: ArrayLike) -> list[float]:
        """Return the command of an action. `ValueError` says what is wrong with an action."""
        try:
            values = np.asarray(action, np.float64)
        except (TypeError, ValueError):
            raise UserError(f"action must be {self.count} numbers, not {action!r}") from None
        if values.shape != (self.count,):
            raise UserError(f"action must have the shape ({self.count},), not {values.shape}")
        bad = ~(np.abs(values) <= 1 + ROUNDING)  # also nan
        if bad.any():
            k = int(bad.argmax())
            raise UserError(f"action[{k}] must be -1 to 1, not {values[k]:g}")
        command: list[float] = (self._middle + np.clip(values, -1, 1) * self._half).tolist()
        return command


Choose = Callable[[Any], Any]
"""Chooses the action of a machine, as numbers or as an event whose value they are."""


def driven(choose: Choose, interface: Interface, machine: CommandedMachine) -> Steps:
    """Carry out the actions that are chosen at each tick, and count goals that are reached."""
    for k in itertools.count(1):
        if k / interface.rate <= machine.now:  # a step of a task took longer than a tick
            continue
        if isinstance(machine, Amr):
            _complete(machine, interface.goal_radius)
        action = choose(machine)
        if isinstance(action, Event):
            action = yield action
        until = k / interface.rate
        if isinstance(machine, Amr):
            _steer(machine, action, until)
        else:
            yield from _aim(machine, action, interface.goal_radius)
        yield machine.until(max(until, machine.now))


def _complete(vehicle: Amr, radius: float) -> None:
    vehicle.begin_mission()
    while vehicle.missions:
        x, y, _ = vehicle.position
        goal = vehicle.missions[0].go
        if isinstance(goal, tuple) and math.dist(goal[:2], (x, y)) > radius:
            return
        vehicle.complete()


def _steer(vehicle: Amr, twist: Sequence[float], until: float) -> None:
    may_move = vehicle.only_waits or not vehicle.disabled
    if may_move and (vehicle.body.motion.end > vehicle.now or any(twist)):
        vehicle.twist(twist, until - vehicle.now)


def _aim(gantry: CommandedMachine, action: Sequence[float], radius: float) -> Steps:
    """Move towards a target; carry out the step of a task if the gantry stands at its place."""
    x, y, share = action
    goal = goal_of(gantry)
    if goal is None or math.dist(goal[:2], (x, y)) > radius:
        gantry.move_to(x, y, speed_share=share)
    elif gantry.body.motion.end <= gantry.now and gantry.position == goal:
        yield gantry.handle(gantry.open_tasks[0])
    else:
        gantry.move_to(*goal, speed_share=share)
