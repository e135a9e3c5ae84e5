"""Topics of people, and HuNavSim's services, by which they walk in other simulators."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from typing import Any

from ..cell import Cell, Pose, Velocity
from ..core.recorder import Figure
from .messages import seconds, set_header, set_pose, set_twist
from .node import CellNode

Here = tuple[Figure, int, Pose, Velocity]
"""Figure, number, pose and velocity of a person on the floor."""


class People:
    """Publisher of all people on the floor, in each type that is installed.

    `advance(seconds)` advances the simulation for HuNavSim's service `compute_agents`. It
    returns False if time is not stepped. `reset()` begins the run again. It is None if that is not
    possible.
    """

    def __init__(
        self,
        ros: CellNode,
        cell: Cell,
        advance: Callable[[float], bool],
        reset: Callable[[], None] | None,
    ) -> None:
        self._ros = ros
        self._cell = cell
        self._advance = advance
        self._begin_again = reset
        self._last_request: float | None = None
        self._people = ros.publish_on("people", "people_msgs/msg/People")
        self._person = ros.find("people_msgs/msg/Person", "people")
        self._agents = ros.publish_on("human_states", "hunav_msgs/msg/Agents")
        self._agent = ros.find("hunav_msgs/msg/Agent", "human_states")
        self._poses = ros.publish_on("people_poses", "geometry_msgs/msg/PoseArray")
        self._pose = ros.find("geometry_msgs/msg/Pose", "people_poses")
        for name, interface, answer in (
            ("compute_agents", "ComputeAgents", self._compute),
            ("get_agents", "GetAgents", self._get),
            ("reset_agents", "ResetAgents", self._reset),
        ):
            ros.provide(name, f"hunav_msgs/srv/{interface}", answer)

    def publish(self) -> None:
        """Publish the people who are on the floor."""
        for topic, fill in (
            (self._people, self._fill_people),
            (self._agents, self._fill_agents),
            (self._poses, self._fill_poses),
        ):
            if topic.is_needed:
                message = topic.new()
                fill(message)
                set_header(message.header, self._cell.now)
                topic.publish(message)

    def _here(self) -> Iterator[Here]:
        for number, person in enumerate(self._cell.simulation.scene.people):
            pose, velocity = (
                self._cell.signals[f"people/{person.name}/{name}"].read()
                for name in ("pose", "velocity")
            )
            if pose is not None:
                yield person, number, pose, velocity

    def _fill_people(self, message: Any) -> None:
        for figure, _, pose, velocity in self._here():
            person = self._person(name=figure.name, reliability=1.0)
            person.position.x, person.position.y = pose.x, pose.y
            person.velocity.x, person.velocity.y = velocity.x, velocity.y
            message.people.append(person)

    def _fill_poses(self, message: Any) -> None:
        for _, _, pose, _ in self._here():
            message.poses.append(self._pose())
            set_pose(message.poses[-1], pose)

    def _fill_agents(self, message: Any) -> None:
        for figure, number, pose, velocity in self._here():
            agent = self._agent(id=number, name=figure.name, radius=figure.radius)
            agent.type = agent.PERSON
            set_pose(agent.position, pose)
            set_twist(agent.velocity, velocity)
            agent.yaw, agent.angular_vel = pose.heading, velocity.turn
            agent.linear_vel = math.hypot(velocity.x, velocity.y)
            message.agents.append(agent)

    def _compute(self, request: Any, response: Any) -> Any:
        """Advance by the time between two requests, and return the people."""
        now = seconds(request.current_agents.header.stamp)
        last, self._last_request = self._last_request, now
        if last is not None and now > last:
            self._advance(now - last)
        elif last is not None and now < last:
            line = f"the clock went back from {last:g} to {now:g} s"
            self._ros.warn("compute_agents", line, "clock")
        self._fill_agents(response.updated_agents)
        response.updated_agents.header = request.current_agents.header
        return response

    def _get(self, _: Any, response: Any) -> Any:
        self._fill_agents(response.agents)
        set_header(response.agents.header, self._cell.now)
        return response

    def _reset(self, _: Any, response: Any) -> Any:
        """Begin the run again, with people at their first places."""
        response.ok = self._begin_again is not None
        if self._begin_again is not None:
            self._begin_again()
            self._last_request = None
        return response
