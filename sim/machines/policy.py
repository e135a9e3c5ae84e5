"""Policies: their observations and actions, and the controller that calls them at each tick."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable
from dataclasses import KW_ONLY
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray
from simpy.events import Event

from floorplan import UserError
from floorplan.files.dataclass import dataclass

from .commanded import CommandedMachine, Sighting
from .commanding import Steps
from .policy_driven import PolicyDriven

ROUNDING = 1e-6
"""Largest excess of an action over its bounds that counts as rounding."""

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
        fastest = 1.01 * max(machine.human_speed, machine.shape.top_speed, 10.0)
        own = [FARTHEST, FARTHEST, 1.0, 1.0, fastest, fastest, fastest]
        high = {
            "self": own,
            "goal": [FARTHEST, FARTHEST, 1.0],
            "people": [[FARTHEST, FARTHEST, 2 * fastest, 2 * fastest, 1.0]] * self.people,
            "margin": [FARTHEST],
            "scan": [self.reach] * self.rays,
        }
        bounds = {}
        for name, shape in self.sizes.items():
            highest = np.array(high[name], np.float32).reshape(shape)
            bounds[name] = (-highest, highest) if name != "scan" else (0 * highest, highest)
        return bounds

    def observe(self, machine: PolicyDriven) -> Observation:
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
        x, y, rotation = machine.position
        c, s = math.cos(rotation), math.sin(rotation)

        def turned(u: float, v: float) -> tuple[float, float]:
            return u * c + v * s, v * c - u * s

        people = np.zeros((self.people, 5), np.float32)
        for row, person in zip(people, self._nearest(machine, x, y), strict=False):
            ahead = turned(person.at[0] - x, person.at[1] - y)
            row[:] = *ahead, *turned(*person.velocity), 1.0
        goal = machine.goal_pose
        towards = (0.0, 0.0, 0.0) if goal is None else (*turned(goal[0] - x, goal[1] - y), 1.0)
        observation: Observation = {
            "self": np.array((x, y, c, s, *machine.twist_now), np.float32),
            "goal": np.array(towards, np.float32),
            "people": people,
            "margin": np.array([self.margin(machine)], np.float32),
        }
        if self.rays:
            observation["scan"] = machine.scan(self.rays, self.reach).astype(np.float32)
        return observation

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


class ActionBounds:
    """Actions of a machine as numbers from -1 to 1, and the commands that they mean.

    See `PolicyDriven.act` for the commands of each kind of machine.
    """

    def __init__(self, machine: PolicyDriven) -> None:
        low, high = map(np.array, machine.action_bounds)
        self._middle = (low + high) / 2
        self._half = (high - low) / 2
        self.count = len(high)

    def command(self, action: ArrayLike) -> list[float]:
        """Return the command of an action. `ValueError` if the action is invalid."""
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
        return self._scaled(values)

    @cached_property
    def choices(self) -> list[tuple[float, ...]]:
        """Discrete actions: all combinations of -1, 0 and 1."""
        return [*itertools.product((-1.0, 0.0, 1.0), repeat=self.count)]

    def choice(self, number: Any) -> list[float]:
        """Return the command of a discrete action. `ValueError` if there is none."""
        try:
            return self._scaled(np.array(self.choices[range(len(self.choices)).index(number)]))
        except ValueError:
            last = len(self.choices) - 1
            raise UserError(f"action must be 0 to {last}, not {number!r}") from None

    def _scaled(self, values: NDArray[np.float64]) -> list[float]:
        command: list[float] = (self._middle + np.clip(values, -1, 1) * self._half).tolist()
        return command


Choose = Callable[[Any], Any]
"""Returns the action of a machine as numbers, or as an event with these numbers as its value."""


def driven(choose: Choose, interface: Interface, machine: PolicyDriven) -> Steps:
    """Carry out the action that `choose` returns at each tick."""

    def chosen() -> Steps:
        machine.count_goals(interface.goal_radius)
        action = choose(machine)
        return (yield action) if isinstance(action, Event) else action

    yield from machine.act_at_ticks(interface.rate, chosen, interface.goal_radius)
