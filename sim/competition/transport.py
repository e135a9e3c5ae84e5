"""Transport of ROS messages: what the topics of the competition need of it."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from typing import Any, Protocol

from floorplan import UserError

from ..machines.amr.amr import Amr
from ..simulation import Simulation


class RefusedError(UserError):
    """Rejected request of a client, which gets the reason."""


Values = dict[str, Any]
"""Fields of a message, a request or an answer by name."""

Heard = Callable[[Values, str], None]
"""Takes a message and the name of the client that published it.

It may raise `Rejected` or `RefusedError`.
"""


Read = Callable[[], Values | None]
"""Returns the present message of a topic, if there is one."""


Answer = Callable[[Any, Values], Values]
"""Answers a request of a `Caller`. It may raise `Rejected` or `RefusedError`."""


class Caller(Protocol):
    """Client that calls a service."""

    @property
    def name(self) -> str:
        """Name of the client, or an empty text."""


class Transport(Protocol):
    """Topics and services whose messages are values by field, with the types of ROS 2."""

    def advertise(
        self,
        name: str,
        type_: str,
        read: Read | None = None,
        *,
        heard: Heard | None = None,
        latched: int = 0,
    ) -> Any:
        """Return a new topic of the simulation. With `heard`, clients may publish on it, too.

        The result of `read` is published with the state. The last `latched` messages are sent to
        each client that subscribes later.
        """

    def listen(self, name: str, type_: str, heard: Heard) -> None:
        """Add a topic on which clients publish."""

    def provide(
        self,
        name: str,
        type_: str,
        answer: Answer,
        request: Mapping[str, str] | None = None,
    ) -> None:
        """Add a service. `answer` gets the caller and the request.

        `request` contains the types of its arguments by name.
        """

    def publish(self, topic: Any, message: Values) -> None:
        """Send a message of the simulation to every subscriber of its topic."""


def prefix_of(simulation: Simulation, name: str) -> str:
    """Return the prefix of the topics of a body, empty for the only vehicle that drives freely."""
    free = [one for one, machine in simulation.machines.items() if isinstance(machine, Amr)]
    return "" if free == [name] else f"{plain(name)}/"


def plain(name: str) -> str:
    """Return a name as ROS allows it."""
    text = re.sub(r"\W", "_", name, flags=re.ASCII)
    return text if text[:1].isalpha() else f"body_{text}"
