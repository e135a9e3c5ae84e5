"""The node: topics, services and actions of the message types that the user's ROS has."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from importlib import import_module
from types import SimpleNamespace
from typing import Any, NamedTuple

from rclpy.action import ActionServer
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile
from rclpy.task import Future

from ..cell import Rejected
from ..cell.admission import Notices
from ..competition import RefusedError, Values
from ..competition.transport import Answer, Heard, Read
from .messages import filled, values_of

DEPTH = 10
"""Number of messages in the queue of a topic."""

USUAL_RATE = 10.0
"""Hz, in simulated time, of topics without another rate."""

RESULTS_LAST = 900
"""Seconds of simulated time in which a client can get a result. 10, the default, pass fast."""

CALLER = SimpleNamespace(name="")
"""Client of every service, because ROS does not name it."""


class RosTopic(NamedTuple):
    """Publisher of a topic, and class of its messages. They are None if it is not installed."""

    publisher: Any
    message: Any


class CellNode:
    """Node whose topics, services and actions exist if their types are installed.

    It is the `Transport` of ROS 2. `notice(line)` informs the user.
    """

    def __init__(self, node: Node, notice: Callable[[str], None]) -> None:
        self.node = node
        self.notice = notice
        self._omitted: dict[str, set[str]] = {}
        self._notices = Notices(notice)
        self._read: defaultdict[float, list[tuple[RosTopic, Read]]] = defaultdict(list)
        self._turns: list[Future] = []

    def find(self, interface: str, kind: str, use: str) -> Any:
        """Return the class of "nav_msgs/Odometry", a "msg". Without it, omit its use: None."""
        package, _, name = interface.partition("/")
        try:
            return getattr(import_module(f"{package}.{kind}"), name)
        except (ImportError, AttributeError):
            self._omitted.setdefault(package, set()).add(use)
            return None

    def report_omitted(self) -> None:
        """Name the packages that are not installed, and what is missing without them."""
        for package, uses in self._omitted.items():
            self.notice(f"without the ROS package {package}: no {', '.join(sorted(uses))}")

    def advertise(
        self,
        name: str,
        type_: str,
        read: Read | None = None,
        *,
        heard: Heard | None = None,
        latched: int = 0,
        rate: float = USUAL_RATE,
        depth: int = DEPTH,
    ) -> RosTopic:
        """Return a new topic. See `Transport`."""
        qos = QoSProfile(depth=latched or depth)
        if latched:
            qos.durability = DurabilityPolicy.TRANSIENT_LOCAL
        message = self.find(type_, "msg", name)
        if message is None:
            return RosTopic(None, None)
        topic = RosTopic(self.node.create_publisher(message, name, qos), message)
        if read is not None:
            self._read[rate].append((topic, read))
        if heard is not None:
            self.listen(name, type_, heard)
        return topic

    def publish(self, topic: RosTopic, message: Values) -> None:
        """Publish a message, if its type is installed."""
        if topic.message is not None:
            topic.publisher.publish(filled(topic.message(), message))

    def publish_state(self, rate: float) -> None:
        """Publish the topics of a rate (Hz) that have subscribers."""
        for topic, read in self._read[rate]:
            is_needed = topic.publisher.get_subscription_count() > 0
            if is_needed and (message := read()) is not None:
                self.publish(topic, message)

    def listen(self, name: str, type_: str, heard: Heard) -> Any:
        """Add a topic on which clients publish, and return the subscription, or None.

        The user is informed of messages that are rejected.
        """

        def received(message: Any) -> None:
            with self.rejecting(name):
                heard(values_of(message), "")

        if (message := self.find(type_, "msg", name)) is None:
            return None
        return self.node.create_subscription(message, name, received, DEPTH)

    def provide(
        self, name: str, type_: str, answer: Answer, request: Mapping[str, str] | None = None
    ) -> None:
        """Add a service. See `Transport`."""

        def respond(values: Any, response: Any) -> Any:
            try:
                return filled(response, answer(CALLER, values_of(values)))
            except (RefusedError, Rejected) as why:
                text = str(why.named(name) if isinstance(why, Rejected) else why)
                return filled(response, {"success": False, "message": text})

        if (service := self.find(type_, "srv", name)) is not None:
            self.node.create_service(service, name, respond)

    def provide_action(self, name: str, type_: str, **callbacks: Any) -> Any:
        """Provide an action with callbacks of rclpy, and return its class, or None."""
        if (action := self.find(type_, "action", name)) is not None:
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
