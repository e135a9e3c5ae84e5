"""A client's connection to a rosbridge server."""

from __future__ import annotations

import asyncio
import itertools
import json
import logging
from collections.abc import Callable
from contextlib import suppress
from types import TracebackType
from typing import Any

from websockets.asyncio.client import ClientConnection, connect
from websockets.exceptions import ConnectionClosed, InvalidHandshake, InvalidURI

from .conformance import MessageError, conform
from .message_types import MessageType, message_type
from .protocol import encode

ANSWER_WITHIN = 5.0
"""Seconds. How long a service may take that answers at once."""

_OPEN_WITHIN = 10.0
_LONGEST_FRAME = 16 * 1024 * 1024


class ConnectError(OSError):
    """Nobody at an address, or nobody who speaks rosbridge."""


class LostError(ConnectError):
    """The connection broke off."""


class ServiceError(ValueError):
    """A service that could not do what it was asked for, or is not there."""


Heard = Callable[[dict[str, Any]], None]


class Connection:
    """Subscribes, publishes and calls services; for use with `async with`.

    `told(text)` takes what the server has to complain about. Messages are handed to whoever
    subscribed in the order in which they come, before the answer to a call that comes after them.
    """

    def __init__(self, url: str, *, told: Callable[[str], None] = lambda _: None) -> None:
        self.url = url
        self._told = told
        self._socket: ClientConnection | None = None
        self._heard: dict[str, tuple[MessageType, Heard]] = {}
        self._advertised: set[str] = set()
        self._calls: dict[str, asyncio.Future[dict[str, Any]]] = {}
        self._numbers = itertools.count(1)
        self._outgoing: asyncio.Queue[str] = asyncio.Queue()
        self._tasks: list[asyncio.Task[None]] = []
        self._lost: asyncio.Future[None] | None = None

    async def __aenter__(self) -> Connection:
        """Connect; `ConnectError` says why it doesn't work."""
        logger = logging.getLogger(f"{__name__}.websockets")
        logger.addHandler(logging.NullHandler())
        logger.propagate = False
        try:
            self._socket = await connect(
                self.url,
                open_timeout=_OPEN_WITHIN,
                max_size=_LONGEST_FRAME,
                compression=None,
                logger=logger,
            )
        except InvalidURI:
            raise ConnectError(f"{self.url} is no address; one looks like ws://host:9090") from None
        except (OSError, InvalidHandshake, EOFError) as why:
            reason = getattr(why, "strerror", None) or str(why) or "no answer"
            raise ConnectError(f"can't connect to {self.url}: {reason}") from None
        self._lost = asyncio.get_running_loop().create_future()
        self._tasks = [
            asyncio.create_task(self._read(self._socket)),
            asyncio.create_task(self._write(self._socket)),
        ]
        return self

    async def __aexit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        """Send what is still to be sent, and disconnect."""
        if kind is None:
            with suppress(asyncio.TimeoutError):
                await asyncio.wait_for(self._outgoing.join(), 1.0)
        for task in self._tasks:
            task.cancel()
        await asyncio.gather(*self._tasks, return_exceptions=True)
        if self._socket is not None:
            await self._socket.close()
        if self._lost is not None and not self._lost.done():
            self._lost.cancel()

    def subscribe(self, topic: str, type_: str, heard: Heard) -> None:
        """Have `heard` called with every message of a topic."""
        self._heard[topic] = (message_type(type_), heard)
        self._send({"op": "subscribe", "topic": topic, "type": type_, "queue_length": 100})

    def publish(self, topic: str, type_: str, message: dict[str, Any]) -> None:
        """Publish a message; the topic is advertised before the first one."""
        if topic not in self._advertised:
            self._advertised.add(topic)
            self._send({"op": "advertise", "topic": topic, "type": type_})
        self._send({"op": "publish", "topic": topic, "msg": message})

    async def call(
        self, service: str, arguments: dict[str, Any], within: float | None = ANSWER_WITHIN
    ) -> dict[str, Any]:
        """The answer of a service.

        `ServiceError` where it has none, or none `within` that time (seconds; None: no limit);
        `LostError` where the connection breaks off.
        """
        id = f"call-{next(self._numbers)}"
        answer = self._calls[id] = asyncio.get_running_loop().create_future()
        self._send({"op": "call_service", "id": id, "service": service, "args": arguments})
        try:
            return await asyncio.wait_for(answer, within)
        except asyncio.TimeoutError:
            raise ServiceError(f"{service} did not answer") from None
        finally:
            del self._calls[id]

    async def wait(self, seconds: float | None) -> None:
        """Let `seconds` of the wall clock go by (None: for ever); `LostError` as `call`."""
        assert self._lost is not None  # within `async with`
        with suppress(asyncio.TimeoutError):
            await asyncio.wait_for(asyncio.shield(self._lost), seconds)

    def _send(self, operation: dict[str, Any]) -> None:
        self._outgoing.put_nowait(encode(operation))

    async def _write(self, socket: ClientConnection) -> None:
        with suppress(ConnectionClosed):
            while True:
                text = await self._outgoing.get()
                await socket.send(text)
                self._outgoing.task_done()

    async def _read(self, socket: ClientConnection) -> None:
        failure: Exception = LostError(f"the connection to {self.url} broke off")
        try:
            async for text in socket:
                self._take(text)
        except ConnectionClosed:
            pass
        except Exception as why:  # of whoever listens: told where they wait
            failure = why
        for waiting in (*self._calls.values(), self._lost):
            if waiting is not None and not waiting.done():
                waiting.set_exception(failure)
                waiting.exception()

    def _take(self, text: str | bytes) -> None:
        try:
            operation = json.loads(text)
        except (ValueError, RecursionError):
            self._told("the server sent something that is not JSON")
            return
        if not isinstance(operation, dict):
            return
        kind = operation.get("op")
        if kind == "publish":
            self._hear(operation.get("topic"), operation.get("msg"))
        elif kind == "service_response":
            call = self._calls.get(str(operation.get("id")))
            if call is not None and not call.done():
                self._answer(call, operation)
        elif kind == "status":
            self._told(str(operation.get("msg")))

    def _hear(self, topic: Any, message: Any) -> None:
        if not isinstance(topic, str) or topic not in self._heard:
            return
        type_, heard = self._heard[topic]
        try:
            complete = conform(type_, message)
        except MessageError as why:
            self._told(f"{topic}: {why}")
            return
        heard(complete)

    def _answer(self, call: asyncio.Future[dict[str, Any]], response: dict[str, Any]) -> None:
        values = response.get("values")
        if response.get("result", True) and isinstance(values, dict):
            call.set_result(values)
        else:
            call.set_exception(ServiceError(str(values)))
