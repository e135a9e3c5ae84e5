"""Client of a rosbridge server that serves the topics and services of an exchange through it.

Both ends of a connection send the same operations: what a client of this server would publish
comes from the other server instead.
"""

from __future__ import annotations

import asyncio
import json
from collections.abc import Callable
from contextlib import suppress

from websockets.asyncio.client import ClientConnection
from websockets.exceptions import ConnectionClosed

from .client import Client
from .connection import FIRST_RETRY, LAST_RETRY, ConnectError, connected_to
from .exchange import Exchange, Topic
from .protocol import Account, Ledger, encode

PATIENCE = 1.0
"""Seconds in which the last messages are sent."""


class Uplink:
    """Connection to a rosbridge server, which is renewed whenever it breaks off.

    Parameters
    ----------
    exchange : Exchange
        Topics and services.
    url : str
        Address of the server.
    notice : callable
        Function for lines that the user should read.
    changed : callable
        Function that is called when the connection is made or breaks off.
    """

    def __init__(
        self,
        exchange: Exchange,
        url: str,
        *,
        notice: Callable[[str], None],
        changed: Callable[[], None],
    ) -> None:
        self.url = url
        self.clients: dict[Client, ClientConnection] = {}
        self._exchange = exchange
        self._notice = notice
        self._changed = changed
        self._omitted: set[str] = set()
        self._serving: asyncio.Task[None] | None = None

    async def open(self) -> None:
        """Connect, and serve from now on. `ConnectError` if nobody answers."""
        socket = await connected_to(self.url)
        self._serving = asyncio.create_task(self._serve(socket))
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

    async def _serve(self, socket: ClientConnection) -> None:
        delay = FIRST_RETRY
        while True:
            await self._attend(socket)
            self._notice(f"the connection to {self.url} broke off; trying again")
            while True:
                await asyncio.sleep(delay)
                try:
                    socket = await connected_to(self.url)
                    break
                except ConnectError:
                    delay = min(2 * delay, LAST_RETRY)
            delay = FIRST_RETRY

    async def _attend(self, socket: ClientConnection) -> None:
        """Serve through a connection until it breaks off."""
        closing: list[asyncio.Future[None]] = []
        client = Client(
            "rosbridge",
            socket.send,
            Account(Ledger(), lambda why: closing.append(asyncio.ensure_future(socket.close()))),
        )
        client.level = "none"
        sending = asyncio.create_task(client.send_forever())
        self._offer(client)
        self.clients[client] = socket
        self._notice(f"connected to {self.url}")
        self._changed()
        try:
            async for text in socket:
                if not self._is_status(client, text):
                    self._exchange.take(client, text)
        except ConnectionClosed:
            pass
        finally:
            sending.cancel()
            with suppress(asyncio.CancelledError, ConnectionClosed):
                await sending
            self.clients.pop(client, None)
            self._exchange.forget(client)
            self._changed()
            await socket.close()

    def _offer(self, client: Client) -> None:
        """Advertise and subscribe to all topics, and advertise all services."""
        send = client.outbox.reply
        for name, topic in tuple(self._exchange.topics.items()):
            if name in self._omitted:
                continue
            operation = {"id": name, "topic": name, "type": topic.type.name}
            if topic.ours:
                send(encode({"op": "advertise", **operation, "latch": bool(topic.kept.maxlen)}))
                self._exchange.take(client, encode({"op": "subscribe", "topic": name}))
            else:
                send(encode({"op": "subscribe", **operation}))
        for name, service in self._exchange.services.items():
            if name not in self._omitted and not name.startswith("/rosapi/"):
                type_ = service.type.name
                send(
                    encode({"op": "advertise_service", "id": name, "service": name, "type": type_})
                )

    def _is_status(self, client: Client, text: str | bytes) -> bool:
        """Return whether a message is a status. Omit the topic or service of an error."""
        with suppress(ValueError):
            said = json.loads(text)
            if isinstance(said, dict) and said.get("op") == "status":
                name, why = said.get("id"), said.get("msg")
                if said.get("level") == "error" and isinstance(name, str):
                    self._omit(client, name, str(why))
                return True
        return False

    def _omit(self, client: Client, name: str, why: str) -> None:
        topic: Topic | None = self._exchange.topics.get(name)
        if name in self._omitted or not (topic or name in self._exchange.services):
            return
        self._omitted.add(name)
        self._notice(f"{name} is omitted: {why}")
        if topic is not None and topic.ours:
            self._exchange.take(client, encode({"op": "unsubscribe", "topic": name}))
