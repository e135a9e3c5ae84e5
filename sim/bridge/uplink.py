"""Connection to another rosbridge server, through which the topics of an exchange are served.

Both ends of a connection send the same operations: what a client of this server would publish
comes from the other server instead.
"""

from __future__ import annotations

import asyncio
import itertools
import json
import logging
from collections.abc import AsyncIterator, Callable, Collection
from contextlib import suppress
from typing import Any

from websockets.asyncio.client import ClientConnection, connect
from websockets.exceptions import InvalidHandshake, InvalidURI

from floorplan import UserError

from ..competition.transport import Values
from .client import Client
from .exchange import Exchange
from .protocol import Account, Ledger, Level, encode

ANSWER_WITHIN = 5.0
"""Seconds within which most services answer."""

_OPEN_WITHIN = 10.0
_LONGEST_FRAME = 16 * 1024 * 1024

PATIENCE = 1.0
"""Seconds in which the last messages are sent."""

_FIRST_RETRY, _LAST_RETRY = 0.5, 5.0
"""Seconds of real time before a lost connection is tried again: at first, and at most."""


class ConnectError(OSError):
    """Address without a rosbridge server."""


class LostError(ConnectError):
    """Connection that broke off."""


class ServiceError(UserError):
    """Service that does not exist, or has failed."""


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


async def connections(
    first: ClientConnection, url: str, notice: Callable[[str], None]
) -> AsyncIterator[ClientConnection]:
    """Yield a websocket to a server, and another one whenever it has broken off.

    `notice(text)` informs the user about each.
    """
    socket, delay = first, _FIRST_RETRY
    while True:
        notice(f"connected to {url}")
        yield socket
        notice(f"the connection to {url} broke off; trying again")
        while True:
            await asyncio.sleep(delay)
            try:
                socket = await connected_to(url)
                break
            except ConnectError:
                delay = min(2 * delay, _LAST_RETRY)
        delay = _FIRST_RETRY


class ServerLink(Client):
    """Client of another server, which serves the exchange there. Use it with `async with`.

    `complain(level, text, id)` is called with each status message of the server, and with faults of
    its messages. `handled()` is called after each message.
    """

    def __init__(
        self,
        socket: ClientConnection,
        exchange: Exchange,
        complain: Callable[[object, str, object], None],
        handled: Callable[[], None] = lambda: None,
    ) -> None:
        super().__init__("rosbridge", socket.send, Account(Ledger(), self._let_go))
        self._socket = socket
        self._exchange = exchange
        self._complain = complain
        self._handled = handled
        self._answers: dict[str, asyncio.Future[Values]] = {}
        self._numbers = itertools.count(1)

    async def __aenter__(self) -> ServerLink:
        """Start to handle messages of the server, and to send messages."""
        self._reading = asyncio.create_task(self._read())
        return self

    async def __aexit__(self, kind: type[BaseException] | None, *_: object) -> None:
        """Send everything that is waiting, and disconnect."""
        if kind is None:
            await self.idle(PATIENCE)
        self._reading.cancel()
        await asyncio.gather(self._reading, return_exceptions=True)
        self._exchange.forget(self)
        await self._socket.close()

    def offer(self, omitted: Collection[str] = ()) -> None:
        """Advertise and subscribe to all topics, and advertise all services, but those omitted."""
        for name, topic in tuple(self._exchange.topics.items()):
            if name in omitted:
                continue
            fields = {"id": name, "topic": name, "type": topic.type.name}
            if topic.ours:
                self._post(op="advertise", **fields, latch=bool(topic.kept.maxlen))
                self._exchange.take(self, encode({"op": "subscribe", "topic": name}))
            else:
                self._post(op="subscribe", **fields)
        for name, service in self._exchange.services.items():
            if name not in omitted and not name.startswith("/rosapi/"):
                self._post(op="advertise_service", id=name, service=name, type=service.type.name)

    async def call(
        self, service: str, arguments: Values, within: float | None = ANSWER_WITHIN
    ) -> Values:
        """Return the answer of a service.

        `ServiceError` if it fails or does not answer `within` a time (s, None for no limit).
        `LostError` if the connection breaks off.
        """
        id = f"call-{next(self._numbers)}"
        answer: asyncio.Future[Values] = asyncio.get_running_loop().create_future()
        self._answers[id] = answer
        self._post(op="call_service", id=id, service=service, args=arguments)
        try:
            await asyncio.wait(
                (answer, self._reading), timeout=within, return_when=asyncio.FIRST_COMPLETED
            )
            if not answer.done():
                await self.wait(0.0)
                raise ServiceError(f"{service} did not answer")
            return answer.result()
        finally:
            del self._answers[id]

    async def wait(self, seconds: float | None = None) -> None:
        """Wait for `seconds`, or forever. `LostError` if the connection breaks off."""
        await asyncio.wait((self._reading,), timeout=seconds)
        if self._reading.done():
            self._reading.result()

    def report(self, level: Level, message: str, id: str | int | None = None) -> None:
        """Report the fault of a message of the server."""
        self._complain(level, message, None)

    def _post(self, **operation: Any) -> None:
        self.outbox.reply(encode(operation))

    def _let_go(self, why: str) -> None:
        self._closing = asyncio.ensure_future(self._socket.close())

    async def _read(self) -> None:
        """Handle messages. Errors of the exchange are raised in `call` and `wait`."""
        await self.attend(self._socket, self.take)
        raise LostError("the connection broke off")

    def take(self, text: str | bytes) -> None:
        """Handle a message of the server."""
        try:
            operation = json.loads(text)
        except (ValueError, RecursionError):
            self.report("error", "the server sent something that is not JSON")
            return
        kind = operation.get("op") if isinstance(operation, dict) else None
        if kind == "status":
            self._complain(operation.get("level"), str(operation.get("msg")), operation.get("id"))
        elif kind == "service_response":
            self._answer(operation)
        else:
            self._exchange.take(self, text)
        self._handled()

    def _answer(self, response: Values) -> None:
        call, values = self._answers.get(str(response.get("id"))), response.get("values")
        if call is None or call.done():
            return
        if response.get("result", True) and isinstance(values, dict):
            call.set_result(values)
        else:
            call.set_exception(ServiceError(str(values)))


class Uplink:
    """Serves an exchange through another server, with a new connection whenever one breaks off.

    Parameters
    ----------
    exchange : Exchange
        Topics and services.
    url : str
        Address of the server.
    notice : callable
        Function for lines that the user should read.
    changed : callable
        Function that is called when a connection is made or breaks off.
    failed : callable
        Function that is called with errors of custom programs.
    """

    def __init__(
        self,
        exchange: Exchange,
        url: str,
        *,
        notice: Callable[[str], None],
        changed: Callable[[], None],
        failed: Callable[[Exception], None],
    ) -> None:
        self.url = url
        self.clients: dict[Client, ServerLink] = {}
        self._exchange = exchange
        self._notice = notice
        self._changed = changed
        self._failed = failed
        self._omitted: set[str] = set()
        self._serving: asyncio.Task[None] | None = None

    async def open(self) -> None:
        """Connect, and serve from now on. `ConnectError` if nobody answers."""
        first = await connected_to(self.url)
        self._serving = asyncio.create_task(self._serve(first))
        await asyncio.sleep(0)  # in which it begins to attend

    async def close(self) -> None:
        """Send everything that is waiting, and disconnect."""
        await self.flush(PATIENCE)
        if self._serving is not None:
            self._serving.cancel()
            with suppress(asyncio.CancelledError):
                await self._serving

    async def flush(self, patience: float) -> None:
        """Wait until everything that is published is on its way, for at most `patience` s."""
        for client in tuple(self.clients):
            await client.idle(patience)

    async def reached(self, client: Client, patience: float) -> None:
        """Return at once, because the server does not report what its clients have read."""

    async def _serve(self, first: ClientConnection) -> None:
        async for socket in connections(first, self.url, self._notice):
            async with ServerLink(socket, self._exchange, self._omit) as link:
                link.offer(self._omitted)
                self.clients[link] = link
                self._changed()
                try:
                    await link.wait()
                except LostError:
                    pass
                except Exception as why:
                    self._failed(why)
                finally:
                    self.clients.clear()
            self._changed()

    def _omit(self, level: object, why: str, name: object) -> None:
        """Omit the topic or service of an error from now on."""
        topic, services = self._exchange.topics.get(str(name)), self._exchange.services
        if level != "error" or name in self._omitted or not (topic or name in services):
            return
        self._omitted.add(str(name))
        self._notice(f"{name} is omitted: {why}")
        if topic is not None and topic.ours:
            for link in self.clients:
                self._exchange.take(link, encode({"op": "unsubscribe", "topic": name}))
