"""Actions of ROS that are tasks of the cell: goal, feedback, cancellation and result."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from rclpy.action import CancelResponse, GoalResponse
from rclpy.task import Future

from ..cell import Running
from ..cell.tasks import SUCCEEDED
from ..competition import Values
from .messages import filled
from .node import CellNode


@dataclass(eq=False, kw_only=True)
class Action:
    """Action that starts a task for each goal.

    `start(goal)` returns the task, or raises `Rejected`. `feedback(task)` and `result(task)` return
    their messages. The result of a failure has the error code `failed`.
    """

    ros: CellNode
    name: str
    type_: str
    start: Callable[[Any], Running]
    feedback: Callable[[Running], Values]
    result: Callable[[Running], Values] = lambda running: {}
    failed: int

    def __post_init__(self) -> None:
        self._accepted: Running | None = None
        self._running: dict[bytes, tuple[Any, Running]] = {}
        self._type = self.ros.provide_action(
            self.name,
            self.type_,
            execute_callback=self._execute,
            goal_callback=self._take,
            handle_accepted_callback=self._begin,
            cancel_callback=self._cancel,
        )

    @property
    def is_busy(self) -> bool:
        """Whether a goal has no result yet."""
        return bool(self._running)

    def publish(self) -> None:
        """Publish feedback on all goals under way."""
        for handle, running in self._running.values():
            if not running.ended:  # otherwise its result is sent soon
                handle.publish_feedback(filled(self._type.Feedback(), self.feedback(running)))

    def _take(self, goal: Any) -> GoalResponse:
        self._accepted = None
        with self.ros.rejecting(self.name):
            self._accepted = self.start(goal)
        return GoalResponse.REJECT if self._accepted is None else GoalResponse.ACCEPT

    def _begin(self, handle: Any) -> None:
        # rclpy calls this right after it has accepted the goal, before it takes another one.
        assert self._accepted is not None
        self._running[bytes(handle.goal_id.uuid)] = (handle, self._accepted)
        handle.execute()

    def _cancel(self, handle: Any) -> CancelResponse:
        with self.ros.rejecting(self.name):
            self._running[bytes(handle.goal_id.uuid)][1].cancel()
        return CancelResponse.ACCEPT

    async def _execute(self, handle: Any) -> Any:
        running = self._running[bytes(handle.goal_id.uuid)][1]
        end: Future = Future()
        running.on_end(lambda _: end.set_result(None))
        await end
        del self._running[bytes(handle.goal_id.uuid)]
        outcome, values = str(running.result), self.result(running)
        if handle.is_cancel_requested:
            handle.canceled()
        elif outcome == SUCCEEDED:
            handle.succeed()
        else:
            handle.abort()
            self.ros.warn(self.name, outcome)
            values |= {"error_code": self.failed, "error_msg": outcome, "error_string": outcome}
        return filled(self._type.Result(), values)
