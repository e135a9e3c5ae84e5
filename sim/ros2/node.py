"""The node: topics, services and actions of the message types that the user's ROS has."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from importlib import import_module
from typing import Any

from rclpy.action import ActionServer
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile
from rclpy.task import Future

from ..cell import Rejected
from ..cell.admission import Notices
from ..competition import RefusedError

LATCHED = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
"""Later subscribers get the last message too."""

DEPTH = 10
"""Number of messages in the queue of a topic."""

RESULTS_LAST = 900
"""Seconds of simulated time in which a client can get a result. 10, the default, pass fast."""


class RosTopic:
    """Topic on which the cell publishes. It is never needed if its type is not installed."""

    def __init__(self, publisher: Any, new: Callable[..., Any]) -> None:
        self.new = new
        self._publisher = publisher

    @property
    def exists(self) -> bool:
        """Whether the type is installed."""
        return self._publisher is not None

    @property
    def is_needed(self) -> bool:
        """Whether there is a subscriber."""
        return self.exists and self._publisher.get_subscription_count() > 0

    def publish(self, message: Any) -> None:
        """Publish a message."""
        if self.exists:
            self._publisher.publish(message)


class CellNode:
    """Node whose topics, services and actions exist if their types are installed.

    `notice(line)` informs the user.
    """

    def __init__(self, node: Node, notice: Callable[[str], None]) -> None:
        self.node = node
        self.notice = notice
        self._omitted: dict[str, set[str]] = {}
        self._notices = Notices(notice)
        self._turns: list[Future] = []

    def find(self, interface: str, use: str) -> Any:
        """Return a class such as "nav_msgs/msg/Odometry". Without it, omit its use: None."""
        package, kind, name = interface.split("/")
        try:
            return getattr(import_module(f"{package}.{kind}"), name)
        except (ImportError, AttributeError):
            self._omitted.setdefault(package, set()).add(use)
            return None

    def report_omitted(self) -> None:
        """Name the packages that are not installed, and what is missing without them."""
        for package, uses in self._omitted.items():
            self.notice(f"without the ROS package {package}: no {', '.join(sorted(uses))}")

    def publish_on(self, topic: str, interface: str, qos: Any = DEPTH) -> RosTopic:
        """Return a topic to publish on."""
        message = self.find(interface, topic)
        if message is None:
            return RosTopic(None, dict)
        return RosTopic(self.node.create_publisher(message, topic, qos), message)

    def subscribe(self, topic: str, interface: str, take: Callable[[Any], None]) -> Any:
        """Pass the messages of a topic on, and return the subscription, or None.

        The user is informed of messages that are rejected.
        """

        def received(message: Any) -> None:
            with self.rejecting(topic):
                take(message)

        if (message := self.find(interface, topic)) is None:
            return None
        return self.node.create_subscription(message, topic, received, DEPTH)

    def provide(self, name: str, interface: str, answer: Callable[[Any, Any], Any]) -> None:
        """Provide a service: `answer(request, response)` returns the response."""
        if (service := self.find(interface, name)) is not None:
            self.node.create_service(service, name, answer)

    def provide_action(self, name: str, interface: str, **callbacks: Any) -> Any:
        """Provide an action with callbacks of rclpy, and return its type, or None."""
        if (action := self.find(interface, name)) is not None:
            ActionServer(self.node, action, name, result_timeout=RESULTS_LAST, **callbacks)
        return action

    def next_turn(self) -> Future:
        """Return a future that is done after the executor has served other requests."""
        self._turns.append(turn := Future())
        return turn

    def end_turn(self) -> bool:
        """End a turn of the executor. Return whether a coroutine waited for it."""
        turns, self._turns = self._turns, []
        for turn in turns:
            turn.set_result(None)
        return bool(turns)

    @contextmanager
    def rejecting(self, name: str) -> Iterator[None]:
        """Inform the user if a command is rejected."""
        try:
            yield
        except Rejected as why:
            self.warn(name, str(why).removeprefix(f"{why.name} "), why.reason)
        except RefusedError as why:
            self.warn(name, str(why))

    def warn(self, about: str, line: str, reason: str = "") -> None:
        """Inform the user once for each topic and reason."""
        kind = (about, (reason or line).partition(" at t = ")[0])
        self._notices.add(f"{about}: {line}", kind)
