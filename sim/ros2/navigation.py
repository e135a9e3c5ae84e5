"""Nav2's actions, by which people and vehicles are sent to places."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping
from functools import partial
from typing import Any, NamedTuple

from ..cell import Cell, Pose, Running
from .actions import Action
from .messages import pose_of, set_header, set_pose, set_time
from .node import CellNode

ACTIVE = 3
"""Id of the state "active" of a lifecycle node."""


SLOWEST = 0.01
"""Speed in m/s above which the remaining time is estimated, as in Nav2."""


class _Kind(NamedTuple):
    """Name, type, code of an unknown error, and goal of an action of Nav2."""

    name: str
    interface: str
    unknown: int
    goal: Callable[[Any], Any]


def _pose(goal: Any) -> Pose:
    return pose_of(goal.pose.pose, goal.pose.header.frame_id)


def _poses(goal: Any) -> list[Pose]:
    # nav_msgs/Goals since Kilted, a plain list before.
    poses = getattr(goal.poses, "goals", goal.poses)
    return [pose_of(one.pose, one.header.frame_id) for one in poses]


def _path(goal: Any) -> list[Pose]:
    frame = goal.path.header.frame_id
    return [pose_of(one.pose, one.header.frame_id or frame) for one in goal.path.poses]


KINDS: Mapping[str, _Kind] = {
    "go_to": _Kind("navigate_to_pose", "NavigateToPose", 9000, _pose),
    "go_through": _Kind("navigate_through_poses", "NavigateThroughPoses", 9100, _poses),
    "follow": _Kind("follow_path", "FollowPath", 100, _path),
}
"""Action of each task."""


def navigation_of(ros: CellNode, cell: Cell, body: str, namespace: str) -> Iterator[Action]:
    """Provide what Nav2's BasicNavigator expects of "people/NAME" or "machines/NAME".

    The names begin with the name of the body, so that the names of Nav2 remain free.
    """
    read_velocity = cell.signals[f"{body}/velocity"].read

    def start(task: str, goal: Any) -> Running:
        return cell.tasks[f"{body}/{task}"].start(KINDS[task].goal(goal))

    def fill(feedback: Any, running: Running) -> None:
        progress, velocity = running.feedback(), read_velocity()
        speed = math.hypot(velocity.x, velocity.y)
        if hasattr(feedback, "distance_to_goal"):  # of FollowPath
            feedback.distance_to_goal = float(progress.remaining)
            feedback.speed = speed
            return
        set_header(feedback.current_pose.header, cell.now)
        set_pose(feedback.current_pose.pose, progress.pose)
        set_time(feedback.navigation_time, progress.elapsed)
        feedback.distance_remaining = float(progress.remaining)
        if speed > SLOWEST:
            set_time(feedback.estimated_time_remaining, progress.remaining / speed)
        if hasattr(feedback, "number_of_poses_remaining"):  # of NavigateThroughPoses
            feedback.number_of_poses_remaining = progress.waypoints

    ros.provide(
        f"{namespace}/bt_navigator/get_state", "lifecycle_msgs/srv/GetState", _answer_active
    )
    for task, kind in KINDS.items():
        if f"{body}/{task}" in cell.tasks:
            name, interface = f"{namespace}/{kind.name}", f"nav2_msgs/action/{kind.interface}"
            starting = partial(start, task)
            yield Action(ros, name, interface, start=starting, fill=fill, failed=kind.unknown)


def _answer_active(_: Any, response: Any) -> Any:
    response.current_state.id, response.current_state.label = ACTIVE, "active"
    return response
