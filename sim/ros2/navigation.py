"""Nav2's actions, by which people and vehicles are sent to places."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import Any, NamedTuple

from floorplan import Lane

from ..cell import Cell, Pose, Rejected, Running
from ..machines.agv.agv import Agv
from .actions import Action
from .messages import pose_of, set_header, set_pose, set_time
from .node import CellNode

ACTIVE = 3
"""Id of the state "active" of a lifecycle node."""

ASIDE = 0.5
"""Distance of a goal from the lane of an AGV, m."""


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


class Navigator:
    """What Nav2's BasicNavigator expects, for a body ("people/NAME" or "machines/NAME").

    The names begin with the name of the body, so that Nav2's own navigation has its names.
    """

    def __init__(self, ros: CellNode, cell: Cell, body: str, namespace: str) -> None:
        self._cell = cell
        machine = cell.simulation.machines.get(body.removeprefix("machines/"))
        self._lane = machine.lane if isinstance(machine, Agv) else None
        self._read_velocity = cell.signals[f"{body}/velocity"].read
        self.actions = [
            Action(
                ros,
                f"{namespace}/{kind.name}",
                f"nav2_msgs/action/{kind.interface}",
                start=self._starting(f"{body}/{task}", kind),
                fill=self._fill,
                finish=self._finishing(kind),
            )
            for task, kind in KINDS.items()
            if f"{body}/{task}" in cell.tasks
        ]
        if self.actions:
            name = f"{namespace}/bt_navigator/get_state"
            ros.provide(name, "lifecycle_msgs/srv/GetState", _answer_active)

    def _starting(self, task: str, kind: _Kind) -> Callable[[Any], Running]:
        def start(goal: Any) -> Running:
            target = kind.goal(goal)
            return self._cell.tasks[task].start(
                target if self._lane is None else _on_lane(self._lane, target)
            )

        return start

    def _fill(self, feedback: Any, running: Running) -> None:
        progress = running.feedback()
        if hasattr(feedback, "distance_to_goal"):  # of FollowPath
            velocity = self._read_velocity()
            feedback.distance_to_goal = float(progress.remaining)
            feedback.speed = math.hypot(velocity.x, velocity.y)
            return
        set_header(feedback.current_pose.header, self._cell.now)
        set_pose(feedback.current_pose.pose, progress.pose)
        set_time(feedback.navigation_time, progress.elapsed)
        feedback.distance_remaining = float(progress.remaining)
        if hasattr(feedback, "number_of_poses_remaining"):  # of NavigateThroughPoses
            feedback.number_of_poses_remaining = progress.waypoints

    def _finishing(self, kind: _Kind) -> Callable[[Any, str], None]:
        def finish(result: Any, failure: str) -> None:
            if failure:
                result.error_code = kind.unknown
                if hasattr(result, "error_msg"):  # since Kilted
                    result.error_msg = failure

        return finish


def _answer_active(_: Any, response: Any) -> Any:
    response.current_state.id, response.current_state.label = ACTIVE, "active"
    return response


def _on_lane(lane: Lane, pose: Pose) -> float:
    """Return the position on a lane (m) of a pose, which may be `ASIDE` of it."""
    (ax, ay), (bx, by) = lane.position(0.0), lane.position(1.0)
    along = (pose.x - ax) * (bx - ax) + (pose.y - ay) * (by - ay)
    if math.dist(lane.position(along), (pose.x, pose.y)) > ASIDE:
        raise Rejected("goal", pose, f"must be on the lane of {lane.name}")
    return along
