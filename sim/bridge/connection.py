"""Connection of a client to a rosbridge server."""

from __future__ import annotations

import asyncio
import itertools
import json
import logging
from collections.abc import Callable
from contextlib import suppress
from typing import Any

from websockets.asyncio.client import ClientConnection, connect
from websockets.exceptions import ConnectionClosed, InvalidHandshake, InvalidURI

from floorplan import UserError

from .messages import MessageError, MessageType, conform, message_type
from .protocol import encode
from .waiting import done_within

ANSWER_WITHIN = 5.0
"""Seconds within which most services answer."""

_OPEN_WITHIN = 10.0
_LONGEST_FRAME = 16 * 1024 * 1024


class ConnectError(OSError):
    """Address without a rosbridge server."""


class LostError(ConnectError):
    """Connection that broke off."""


class ServiceError(UserError):
    """Service that does not exist, or has failed."""


FIRST_RETRY, LAST_RETRY = 0.5, 5.0
"""Seconds of real time before a lost connection is tried again: at first, and at most."""


async def connected_to(url: str) -> ClientConnection:
    """Return a websocket to a server. `ConnectError` says why that fails."""
    logger = logging.getLogger(f"{__name__}.websockets")
    logger.addHandler(logging.NullHandler())
    logger.propagate = False
    try:
        return await connect(
            url,
            open_timeout=_OPEN_WITHIN,
            max_size=_LONGEST_FRAME,
            compression=None,
            logger=logger,
        )
    except InvalidURI:
        raise ConnectError(f"{url} is not an address; one looks like ws://host:9090") from None
    except (OSError, InvalidHandshake, EOFError) as why:
        reason = getattr(why, "strerror", None) or str(why) or "no answer"
        raise ConnectError(f"can't connect to {url}: {reason}") from None


Heard = Callable[[dict[str, Any]], None]


class RosbridgeConnection:
    """Connection to subscribe, publish and call services. Use it with `async with`.

    `complained(text)` is called with each complaint of the server. Subscribers get messages in the
    order of arrival, and before the answer to a call that arrives later.
    """

    def __init__(self, url: str, *, complained: Callable[[str], None] = lambda _: None) -> None:
        self.url = url
        self._complained = complained
        self._heard: dict[str, tuple[MessageType, Heard]] = {}
        self._advertised: set[str] = set()
        self._calls: dict[str, asyncio.Future[dict[str, Any]]] = {}
        self._numbers = itertools.count(1)
        self._outgoing: asyncio.Queue[str] = asyncio.Queue()

    async def __aenter__(self) -> RosbridgeConnection:
        """Connect. `ConnectError` says why that fails."""
        self._socket = await connected_to(self.url)
        self._reading = asyncio.create_task(self._read(self._socket))
        self._writing = asyncio.create_task(self._write(self._socket))
        return self

    async def __aexit__(self, kind: type[BaseException] | None, *_: object) -> None:
        """Send everything that is waiting, and disconnect."""
        if kind is None:
            await done_within(self._outgoing.join(), 1.0)
        for task in (self._reading, self._writing):
            task.cancel()
        await asyncio.gather(self._reading, self._writing, return_exceptions=True)
        await self._socket.close()

    def subscribe(self, topic: str, type_: str, heard: Heard) -> None:
        """Call `heard` with each message of a topic."""
        self._heard[topic] = (message_type(type_), heard)
        self._send({"op": "subscribe", "topic": topic, "type": type_, "queue_length": 100})

    def publish(self, topic: str, type_: str, message: dict[str, Any]) -> None:
        """Publish a message, and advertise the topic before the first one."""
        if topic not in self._advertised:
            self._advertised.add(topic)
            self._send({"op": "advertise", "topic": topic, "type": type_})
        self._send({"op": "publish", "topic": topic, "msg": message})

    async def call(
        self, service: str, arguments: dict[str, Any], within: float | None = ANSWER_WITHIN
    ) -> dict[str, Any]:
        """Return the answer of a service.

        `ServiceError` if it fails or does not answer `within` a time (s, None for no limit).
        `LostError` if the connection breaks off.
        """
        id = f"call-{next(self._numbers)}"
        answer: asyncio.Future[dict[str, Any]] = asyncio.get_running_loop().create_future()
        self._calls[id] = answer
        self._send({"op": "call_service", "id": id, "service": service, "args": arguments})
        try:
            await asyncio.wait(
                (answer, self._reading), timeout=within, return_when=asyncio.FIRST_COMPLETED
            )
            if not answer.done():
                await self.wait(0.0)
                raise ServiceError(f"{service} did not answer")
            return answer.result()
        finally:
            del self._calls[id]

    async def wait(self, seconds: float) -> None:
        """Wait for `seconds`. `LostError` if the connection breaks off."""
        await asyncio.wait((self._reading,), timeout=seconds)
        if self._reading.done():
            self._reading.result()

    def _send(self, operation: dict[str, Any]) -> None:
        self._outgoing.put_nowait(encode(operation))

    async def _write(self, socket: ClientConnection) -> None:
        with suppress(ConnectionClosed):
            while True:
                text = await self._outgoing.get()
                await socket.send(text)
                self._outgoing.task_done()

    async def _read(self, socket: ClientConnection) -> None:
        """Handle messages. Errors of subscribers are raised in `call` and `wait`."""
        with suppress(ConnectionClosed):
            async for text in socket:
                self._take(text)
        raise LostError(f"the connection to {self.url} broke off")

    def _take(self, text: str | bytes) -> None:
        try:
            operation = json.loads(text)
        except (ValueError, RecursionError):
            self._complained("the server sent something that is not JSON")
            return
        if not isinstance(operation, dict):
            return
        kind = operation.get("op")
        if kind == "publish":
            self._hear(operation.get("topic"), operation.get("msg"))
        elif kind == "service_response":
            self._answer(self._calls.get(str(operation.get("id"))), operation)
        elif kind == "status":
            self._complained(str(operation.get("msg")))

    def _hear(self, topic: Any, message: Any) -> None:
        if not isinstance(topic, str) or topic not in self._heard:
            return
        type_, heard = self._heard[topic]
        try:
            complete = conform(type_, message)
        except MessageError as why:
            self._complained(f"{topic}: {why}")
            return
        heard(complete)

    def _answer(
        self, call: asyncio.Future[dict[str, Any]] | None, response: dict[str, Any]
    ) -> None:
        if call is None or call.done():
            return
        values = response.get("values")
        if response.get("result", True) and isinstance(values, dict):
            call.set_result(values)
        else:
            call.set_exception(ServiceError(str(values)))
