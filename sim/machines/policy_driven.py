"""Machines that policies can drive."""

from __future__ import annotations

import itertools
import math
from abc import abstractmethod
from collections.abc import Callable, Sequence

from navigation.vehicles import Twist

from ..core.entries import Pose
from .commanding import Steps
from .tasked import TaskedMachine


class PolicyDriven(TaskedMachine):
    """Machine that a policy can drive."""

    @property
    def twist_now(self) -> Twist:
        """Its velocity now: m/s forwards and to the left, rad/s."""
        (_, _, rotation), (vx, vy, turning), _ = self.state
        c, s = math.cos(rotation), math.sin(rotation)
        return Twist(vx * c + vy * s, vy * c - vx * s, turning)

    @property
    @abstractmethod
    def goal_pose(self) -> Pose | None:
        """Goal of the current mission or step: x, y (m) and rotation (nan for any)."""

    @property
    @abstractmethod
    def action_bounds(self) -> tuple[list[float], list[float]]:
        """Lowest and highest values of an action."""

    @property
    @abstractmethod
    def stop_action(self) -> list[float]:
        """Action with which the machine stops."""

    def begin_mission(self) -> None:
        """Record the start of the current mission, once. A gantry has none."""

    def count_goals(self, radius: float) -> None:
        """Complete the missions whose goals are near. A gantry has none.

        Parameters
        ----------
        radius : float
            Distance in metres.
        """

    @abstractmethod
    def act(self, action: Sequence[float], until: float, radius: float) -> Steps:
        """Carry out an action.

        Parameters
        ----------
        action : sequence of float
            Of a vehicle: its twist, which is m/s forwards, m/s to the left (of a holonomic drive
            only) and rad/s. Of a gantry: its target (x, y in metres) and the share of its speed,
            which is 1 if it is omitted.
        until : float
            Time of the next tick in seconds.
        radius : float
            Distance in metres from a goal within which a target is the goal.

        Yields
        ------
        Event
            End of the step of a task, if the action carries out one.
        """

    def act_at_ticks(self, rate: float, choose: Callable[[], Steps], radius: float) -> Steps:
        """Carry out the action that is chosen at each tick, if any.

        Parameters
        ----------
        rate : float
            Ticks per second.
        choose : callable
            Function that returns a generator, whose value is the action or None.
        radius : float
            Distance in metres, as of `act`.

        Yields
        ------
        Event
            Event to wait for: the next tick, or what `choose` and `act` wait for.
        """
        for k in itertools.count(1):
            until = k / rate
            if until <= self.now:  # a step of a task took longer than a tick
                continue
            action = yield from choose()
            if action is not None:
                yield from self.act(action, until, radius)
            yield self.until(max(until, self.now))
