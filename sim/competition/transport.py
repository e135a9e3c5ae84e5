"""Transport of ROS messages: what the topics of the competition need of it."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any, Protocol

from floorplan import UserError

from ..cell import CellCommand, CellTask, Rejected


class RefusedError(UserError):
    """Rejected request of a client, which gets the reason.

    `name` is that of a topic with which the text begins.
    """

    def __init__(self, text: str, name: str = "", reason: str = "") -> None:
        super().__init__(text)
        self.name = name
        self.reason = reason or text


Values = dict[str, Any]
"""Fields of a message, a request or an answer by name."""

Heard = Callable[[Values, str], None]
"""Takes a message and the name of the client that published it. It may raise `RefusedError`."""


class Caller(Protocol):
    """Client that calls a service."""

    @property
    def name(self) -> str:
        """Name of the client, or an empty text."""


class Port(Protocol):
    """Topic on which the simulation publishes."""

    @property
    def is_needed(self) -> bool:
        """Whether a message that is published now reaches a client, now or later."""


class Transport(Protocol):
    """Topics and services whose messages are values by field, with the types of ROS 2."""

    def advertise(
        self, name: str, type_: str, *, heard: Heard | None = None, latched: int = 0
    ) -> Port:
        """Return a new topic of the simulation. With `heard`, clients may publish on it, too.

        The last `latched` messages are sent to each client that subscribes later.
        """

    def listen(self, name: str, type_: str, heard: Heard) -> None:
        """Add a topic on which clients publish."""

    def provide(
        self,
        name: str,
        type_: str,
        answer: Callable[[Any, Values], Values],
        request: Mapping[str, str] | None = None,
    ) -> None:
        """Add a service. `answer` gets the caller and the request.

        `request` contains the types of its arguments by name.
        """

    def publish(self, topic: Any, message: Values) -> None:
        """Send a message of the simulation to every subscriber of its topic."""


def take(topic: str, port: CellCommand | CellTask, value: Any, source: str) -> Any:
    """Pass a value from a topic to a command or task of the cell, and return the running task.

    `RefusedError` names the topic and the value if it is rejected.
    """
    try:
        if isinstance(port, CellTask):
            return port.start(value, source)
        port.take(value, source)
    except Rejected as why:
        raise RefusedError(str(why.named(topic)), topic, why.reason) from None
