"""Nav2's actions, by which people and vehicles are sent to places."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from functools import partial
from typing import Any, NamedTuple

from ..cell import Cell, Pose, Rejected, Running
from ..cell.tasks import CANCELLED, SUCCEEDED
from ..competition import Values
from ..competition.messages import header, pose_message, seconds, stamped_pose_of
from ..exports.scene import ROOT_FRAME
from .actions import Action
from .messages import values_of
from .node import CellNode

ACTIVE = {"current_state": {"id": 3, "label": "active"}}
"""State of a lifecycle node."""

SLOWEST = 0.01
"""Speed in m/s above which the remaining time is estimated, as in Nav2."""

PENDING, COMPLETED, _, FAILED = range(4)
"""States of a nav2_msgs/WaypointStatus."""


class _Kind(NamedTuple):
    """Name, task, type, code of an unknown error, and goal of an action of Nav2."""

    name: str
    task: str
    interface: str
    unknown: int
    goal: Callable[[Any], Any]


def _pose(goal: Any) -> Pose:
    return stamped_pose_of(values_of(goal.pose))


def _poses(goal: Any) -> list[Pose]:
    # nav_msgs/Goals since Kilted, a plain list before.
    return [stamped_pose_of(values_of(one)) for one in getattr(goal.poses, "goals", goal.poses)]


def _waypoints(goal: Any) -> list[Pose]:
    if goal.number_of_loops or goal.goal_index:
        value = goal.number_of_loops, goal.goal_index
        raise Rejected("number_of_loops and goal_index", value, "must be 0")
    return _poses(goal)


def _path(goal: Any) -> list[Pose]:
    frame = goal.path.header.frame_id
    return [stamped_pose_of(values_of(one), frame) for one in goal.path.poses]


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
    velocity = cell.signals[f"{body}/velocity"]

    def start(kind: _Kind, goal: Any) -> Running:
        return cell.tasks[f"{body}/{kind.task}"].start(kind.goal(goal))

    def feedback(running: Running) -> Values:
        """Return the fields of all actions."""
        progress, now = running.feedback(), velocity.read()
        speed, left = math.hypot(now.x, now.y), float(progress.remaining)
        values = {
            "current_pose": _stamped(cell.now, progress.pose),
            "navigation_time": seconds(progress.elapsed),
            "distance_remaining": left,
            "distance_to_goal": left,
            "speed": speed,
        }
        if speed > SLOWEST:
            values["estimated_time_remaining"] = seconds(left / speed)
        if isinstance(running.goal, list):
            values["number_of_poses_remaining"] = progress.waypoints
            values["current_waypoint"] = len(running.goal) - progress.waypoints
            values["waypoint_statuses"] = _statuses(running)
        return values

    state = f"{namespace}/bt_navigator/get_state"
    ros.provide(state, "lifecycle_msgs/GetState", lambda *_: ACTIVE)
    for kind in KINDS:
        if f"{body}/{kind.task}" in cell.tasks:
            yield Action(
                ros=ros,
                name=f"{namespace}/{kind.name}",
                type_=f"nav2_msgs/{kind.interface}",
                start=partial(start, kind),
                feedback=feedback,
                result=partial(_result, kind),
                failed=kind.unknown,
            )


def _stamped(t: float, pose: Pose) -> Values:
    return {"header": header(t, ROOT_FRAME), "pose": pose_message(pose)}


def _result(kind: _Kind, running: Running) -> Values:
    """Return the states of waypoints, and those that were missed."""
    if kind.task != "go_through":
        return {}
    statuses = _statuses(running, kind.unknown)
    missed = [one for one in statuses if one["waypoint_status"] == FAILED]
    return {"waypoint_statuses": statuses, "missed_waypoints": missed}


def _statuses(running: Running, unknown: int = 0) -> list[Values]:
    """Return a nav2_msgs/WaypointStatus of each waypoint."""
    reached = len(running.goal) - running.feedback().waypoints
    outcome = str(running.result) if running.ended else ""
    has_failed = outcome not in ("", SUCCEEDED, CANCELLED)
    statuses = [
        {
            "waypoint_status": COMPLETED if k < reached else PENDING,
            "waypoint_index": k,
            "waypoint_pose": _stamped(0.0, pose),
            "index": k,  # of MissedWaypoint, before Kilted
            "goal": _stamped(0.0, pose),
        }
        for k, pose in enumerate(running.goal)
    ]
    if has_failed:
        failure = {"waypoint_status": FAILED, "error_code": unknown, "error_msg": outcome}
        statuses[reached] |= failure
    return statuses
