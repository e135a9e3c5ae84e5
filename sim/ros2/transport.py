"""Topics and services of the competition in ROS 2: values by field as messages, and back."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from importlib import import_module
from types import SimpleNamespace
from typing import Any

from rclpy.qos import DurabilityPolicy, QoSProfile

from ..cell import Rejected
from ..competition import RefusedError, Values
from ..competition.transport import Heard, Read
from .node import DEPTH, CellNode, RosTopic

CALLER = SimpleNamespace(name="")
"""Client of every service, because ROS does not name it."""


class RosTransport:
    """`Transport` of the competition's topics by a node."""

    def __init__(self, ros: CellNode) -> None:
        self._ros = ros
        self._read: list[tuple[RosTopic, Read]] = []

    def advertise(
        self,
        name: str,
        type_: str,
        read: Read | None = None,
        *,
        heard: Heard | None = None,
        latched: int = 0,
    ) -> RosTopic:
        """Return a new topic. See `Transport`."""
        if heard is not None:
            self.listen(name, type_, heard)
        qos = QoSProfile(depth=latched or DEPTH)
        if latched:
            qos.durability = DurabilityPolicy.TRANSIENT_LOCAL
        topic = self._ros.publish_on(name, _in_full(type_, "msg"), qos)
        if read is not None:
            self._read.append((topic, read))
        return topic

    def publish_state(self) -> None:
        """Publish the present message of each topic that has one."""
        for topic, read in self._read:
            if topic.is_needed and (message := read()) is not None:
                self.publish(topic, message)

    def listen(self, name: str, type_: str, heard: Heard) -> None:
        """Add a topic on which clients publish."""
        take = lambda message: heard(values_of(message), "")  # noqa: E731
        self._ros.subscribe(name, _in_full(type_, "msg"), take)

    def provide(
        self,
        name: str,
        type_: str,
        answer: Callable[[Any, Values], Values],
        request: Mapping[str, str] | None = None,
    ) -> None:
        """Add a service, whose response has the fields `success` and `message`."""

        def respond(request: Any, response: Any) -> Any:
            try:
                return filled(response, answer(CALLER, values_of(request)))
            except (RefusedError, Rejected) as why:
                text = str(why.named(name) if isinstance(why, Rejected) else why)
                return filled(response, {"success": False, "message": text})

        self._ros.provide(name, _in_full(type_, "srv"), respond)

    def publish(self, topic: RosTopic, message: Values) -> None:
        """Publish a message, if its type is installed."""
        if topic.exists:
            topic.publish(filled(topic.new(), message))


def _in_full(type_: str, kind: str) -> str:
    package, _, name = type_.rpartition("/")
    return f"{package}/{kind}/{name}"


def values_of(message: Any) -> Any:
    """Return the values of a message by field. Nested messages are values by field, too."""
    if hasattr(message, "get_fields_and_field_types"):
        names = message.get_fields_and_field_types()
        return {name: values_of(getattr(message, name)) for name in names}
    if isinstance(message, str | bytes | bool | int | float):
        return message
    return [values_of(one) for one in message]


def filled(message: Any, values: Values) -> Any:
    """Set fields of a message, and return it."""
    for name, value in values.items():
        if isinstance(value, dict):
            filled(getattr(message, name), value)
        elif isinstance(value, list) and value and isinstance(value[0], dict):
            element = element_of(message, name)
            setattr(message, name, [filled(element(), one) for one in value])
        else:
            setattr(message, name, value)
    return message


def element_of(message: Any, field: str) -> Any:
    """Return the class of the messages in a list."""
    type_ = message.get_fields_and_field_types()[field]
    package, _, name = type_.removeprefix("sequence<").rstrip(">").partition("/")
    return getattr(import_module(f"{package}.msg"), name)
