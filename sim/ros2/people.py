"""Topics of people, and HuNavSim's services, by which they walk in other simulators."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from typing import Any

from ..cell import Cell, Pose, Velocity
from ..competition import Values
from ..competition.messages import header, pose_message, seconds_of, twist_message, vector
from ..core.recorder import Figure
from ..exports.scene import ROOT_FRAME
from .node import CellNode

Here = tuple[Figure, int, Pose, Velocity]
"""Figure, number, pose and velocity of a person on the floor."""

PERSON = 1
"""Type of a hunav_msgs/Agent."""


class People:
    """Publisher of all people on the floor, in each type that is installed.

    `advance(seconds)` advances the simulation for HuNavSim's service `compute_agents`. It
    returns False if time is not stepped. `reset()` begins the run again.
    """

    def __init__(
        self,
        ros: CellNode,
        cell: Cell,
        advance: Callable[[float], bool],
        reset: Callable[[], None],
    ) -> None:
        self._ros = ros
        self._cell = cell
        self._advance = advance
        self._begin_again = reset
        self._last_request: float | None = None
        ros.advertise("people", "people_msgs/People", self._people)
        ros.advertise("human_states", "hunav_msgs/Agents", self._agents)
        ros.advertise("people_poses", "geometry_msgs/PoseArray", self._poses)
        ros.provide("compute_agents", "hunav_msgs/ComputeAgents", self._compute)
        ros.provide("get_agents", "hunav_msgs/GetAgents", lambda *_: {"agents": self._agents()})
        ros.provide("reset_agents", "hunav_msgs/ResetAgents", self._reset)

    def _here(self) -> Iterator[Here]:
        signals = self._cell.signals
        for number, person in enumerate(self._cell.simulation.scene.people):
            if (pose := signals[f"people/{person.name}/pose"].read()) is not None:
                yield person, number, pose, signals[f"people/{person.name}/velocity"].read()

    @property
    def _header(self) -> Values:
        return header(self._cell.now, ROOT_FRAME)

    def _people(self) -> Values:
        people = [
            {
                "name": person.name,
                "position": vector((pose.x, pose.y)),
                "velocity": vector((velocity.x, velocity.y)),
                "reliability": 1.0,
            }
            for person, _, pose, velocity in self._here()
        ]
        return {"header": self._header, "people": people}

    def _poses(self) -> Values:
        poses = [pose_message(pose) for _, _, pose, _ in self._here()]
        return {"header": self._header, "poses": poses}

    def _agents(self) -> Values:
        agents = [
            {
                "id": number,
                "type": PERSON,
                "name": person.name,
                "radius": person.radius,
                "position": pose_message(pose),
                "yaw": pose.heading,
                "velocity": twist_message(velocity),
                "linear_vel": math.hypot(velocity.x, velocity.y),
                "angular_vel": velocity.turn,
            }
            for person, number, pose, velocity in self._here()
        ]
        return {"header": self._header, "agents": agents}

    def _compute(self, _: Any, request: Values) -> Values:
        """Advance by the time between two requests, and return the people."""
        stamped = request["current_agents"]["header"]
        now, last = seconds_of(stamped["stamp"]), self._last_request
        self._last_request = now
        if last is not None and now > last:
            self._advance(now - last)
        elif last is not None and now < last:
            line = f"the clock went back from {last:g} to {now:g} s"
            self._ros.warn("compute_agents", line, "clock")
        return {"updated_agents": self._agents() | {"header": stamped}}

    def _reset(self, _: Any, __: Values) -> Values:
        """Begin the run again, with people at their first places."""
        self._begin_again()
        self._last_request = None
        return {"ok": True}
