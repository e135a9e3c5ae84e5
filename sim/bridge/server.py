"""A rosbridge server over websockets: connections become clients of an exchange."""

from __future__ import annotations

import asyncio
import logging
from collections.abc import Callable
from contextlib import suppress

from websockets.asyncio.server import Server, ServerConnection, serve
from websockets.exceptions import ConnectionClosed

from .client import Client
from .exchange import Exchange

MOST_CLIENTS = 1000
"""How many clients may be connected at once."""

_LONGEST_FRAME = 16 * 1024 * 1024
"""Bytes. A message up to this length is read and refused; a longer one ends the connection."""

_PING_EVERY = 20.0
"""Seconds between pings, and until a client that doesn't answer one counts as gone."""


class RosbridgeServer:
    """Serves an exchange to any number of clients.

    `left(client)` is called when one has gone.
    """

    def __init__(self, exchange: Exchange, *, left: Callable[[Client], None]) -> None:
        self.clients: dict[Client, ServerConnection] = {}
        self._exchange = exchange
        self._left = left
        self._names = 0
        self._server: Server | None = None

    async def open(self, host: str, port: int) -> int:
        """Take clients from now on; the port (that given, or with 0 a free one)."""
        logger = logging.getLogger(f"{__name__}.websockets")
        logger.addHandler(logging.NullHandler())
        logger.propagate = False
        self._server = await serve(
            self._attend,
            host,
            port,
            compression=None,
            max_size=_LONGEST_FRAME,
            max_queue=4,
            ping_interval=_PING_EVERY,
            ping_timeout=_PING_EVERY,
            close_timeout=1.0,
            logger=logger,
        )
        return int(next(iter(self._server.sockets)).getsockname()[1])

    async def close(self) -> None:
        """Send what is still to be sent, and let everybody go."""
        await self.flush(1.0)
        if self._server is not None:
            self._server.close()
            await self._server.wait_closed()

    async def flush(self, patience: float) -> None:
        """Wait until what is published is on its way, for nobody longer than `patience` (s)."""
        waiting = [client.idle(patience) for client in self.clients if client.outbox]
        if waiting:
            await asyncio.gather(*waiting)

    async def reached(self, client: Client, patience: float) -> None:
        """Wait until a client has read everything that was sent to it: until it answers a ping.

        Not longer than `patience` (seconds), nor when it goes.
        """
        connection = self.clients.get(client)
        if connection is None:
            return
        with suppress(ConnectionClosed, asyncio.TimeoutError):
            await asyncio.wait_for(await connection.ping(), patience)

    async def _attend(self, connection: ServerConnection) -> None:
        if len(self.clients) >= MOST_CLIENTS:
            await connection.close(1013, f"{MOST_CLIENTS} clients are here already")
            return
        self._names += 1
        client = Client(
            f"client{self._names}", connection.send, lambda _: connection.transport.abort()
        )
        self.clients[client] = connection
        sending = asyncio.create_task(client.send_forever())
        try:
            async for text in connection:
                self._exchange.take(client, text)
                # Others have their turn, however much this one has to say.
                await asyncio.sleep(0)
        except ConnectionClosed:
            pass
        finally:
            sending.cancel()
            with suppress(asyncio.CancelledError, ConnectionClosed):
                await sending
            del self.clients[client]
            self._exchange.forget(client)
            self._left(client)
