"""Nav2's actions, by which people and vehicles are sent to places."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from functools import partial
from typing import Any, NamedTuple

from ..cell import Cell, Pose, Rejected, Running
from ..cell.tasks import CANCELLED, SUCCEEDED
from .actions import Action
from .messages import pose_of, set_header, set_pose, set_time
from .node import CellNode
from .transport import element_of

ACTIVE = 3
"""Id of the state "active" of a lifecycle node."""


SLOWEST = 0.01
"""Speed in m/s above which the remaining time is estimated, as in Nav2."""


class _Kind(NamedTuple):
    """Name, task, type, code of an unknown error, and goal of an action of Nav2."""

    name: str
    task: str
    interface: str
    unknown: int
    goal: Callable[[Any], Any]


def _pose(goal: Any) -> Pose:
    return pose_of(goal.pose.pose, goal.pose.header.frame_id)


def _poses(goal: Any) -> list[Pose]:
    # nav_msgs/Goals since Kilted, a plain list before.
    poses = getattr(goal.poses, "goals", goal.poses)
    return [pose_of(one.pose, one.header.frame_id) for one in poses]


def _waypoints(goal: Any) -> list[Pose]:
    if goal.number_of_loops or goal.goal_index:
        value = goal.number_of_loops, goal.goal_index
        raise Rejected("number_of_loops and goal_index", value, "must be 0")
    return _poses(goal)


def _path(goal: Any) -> list[Pose]:
    frame = goal.path.header.frame_id
    return [pose_of(one.pose, one.header.frame_id or frame) for one in goal.path.poses]


KINDS = (
    _Kind("navigate_to_pose", "go_to", "NavigateToPose", 9000, _pose),
    _Kind("navigate_through_poses", "go_through", "NavigateThroughPoses", 9100, _poses),
    _Kind("follow_waypoints", "go_through", "FollowWaypoints", 600, _waypoints),
    _Kind("follow_path", "follow", "FollowPath", 100, _path),
)


def navigation_of(ros: CellNode, cell: Cell, body: str, namespace: str) -> Iterator[Action]:
    """Provide what Nav2's BasicNavigator expects of "people/NAME" or "machines/NAME".

    The names begin with the name of the body, so that the names of Nav2 remain free.
    """
    velocity_of = cell.signals[f"{body}/velocity"]

    def start(kind: _Kind, goal: Any) -> Running:
        return cell.tasks[f"{body}/{kind.task}"].start(kind.goal(goal))

    def fill(feedback: Any, running: Running) -> None:
        progress, velocity = running.feedback(), velocity_of.read()
        speed = math.hypot(velocity.x, velocity.y)
        if hasattr(feedback, "current_waypoint"):  # of FollowWaypoints
            feedback.current_waypoint = len(running.goal) - progress.waypoints
            return
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
        _set_waypoints(feedback, running)

    ros.provide(
        f"{namespace}/bt_navigator/get_state", "lifecycle_msgs/srv/GetState", _answer_active
    )
    for kind in KINDS:
        if f"{body}/{kind.task}" in cell.tasks:
            yield Action(
                ros,
                f"{namespace}/{kind.name}",
                f"nav2_msgs/action/{kind.interface}",
                start=partial(start, kind),
                fill=fill,
                failed=kind.unknown,
                conclude=partial(_set_waypoints, code=kind.unknown),
            )


def _set_waypoints(message: Any, running: Running, code: int = 0) -> None:
    """Set the states of all waypoints of a task, or those that it missed, if there is a field."""
    reached = len(running.goal) - running.feedback().waypoints if _lists(message) else 0
    outcome = str(running.result) if running.ended else ""
    for field in _lists(message):
        status = element_of(message, field)
        for k, pose in enumerate(running.goal):
            has_failed = k == reached and outcome not in ("", SUCCEEDED, CANCELLED)
            if field == "missed_waypoints" and not has_failed:
                continue
            state = "FAILED" if has_failed else "COMPLETED" if k < reached else "PENDING"
            getattr(message, field).append(one := status())
            if has_failed:
                one.error_code = code
            if hasattr(one, "waypoint_status"):
                one.waypoint_status, one.waypoint_index = getattr(one, state), k
                one.error_msg = outcome if has_failed else ""
                stamped = one.waypoint_pose
            else:  # MissedWaypoint, before Kilted
                one.index, stamped = k, one.goal
            set_header(stamped.header, 0.0)
            set_pose(stamped.pose, pose)


def _lists(message: Any) -> list[str]:
    return [name for name in ("waypoint_statuses", "missed_waypoints") if hasattr(message, name)]


def _answer_active(_: Any, response: Any) -> Any:
    response.current_state.id, response.current_state.label = ACTIVE, "active"
    return response
