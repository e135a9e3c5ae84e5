"""A rosbridge server over websockets: connections become clients of an exchange."""

from __future__ import annotations

import asyncio
import logging
import socket
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

_TURNS = 5
"""Turns of the event loop in which a message that has come in is taken for sure."""


class AddressError(OSError):
    """An address that can't be served at."""


def listen_at(host: str, port: int) -> socket.socket:
    """A listening socket at an address (port 0: any that is free); `AddressError` says why not."""
    try:
        (family, _, _, _, address), *_ = socket.getaddrinfo(host, port, type=socket.SOCK_STREAM)
        return socket.create_server(address[:2], family=family)
    except (OSError, UnicodeError) as why:
        reason = getattr(why, "strerror", None) or why
        raise AddressError(
            f"can't serve at {host}:{port}: {reason}; choose another with --host and --port"
        ) from None


class RosbridgeServer:
    """Serves an exchange to any number of clients.

    `left(client)` is called when one has gone, `failed(why)` when what a client asked for goes
    wrong through no fault of the client's.
    """

    def __init__(
        self,
        exchange: Exchange,
        *,
        left: Callable[[Client], None],
        failed: Callable[[Exception], None],
    ) -> None:
        self.clients: dict[Client, ServerConnection] = {}
        self._exchange = exchange
        self._left = left
        self._failed = failed
        self._slow: set[Client] = set()
        self._names = 0
        self._server: Server | None = None

    async def open(self, at: socket.socket) -> None:
        """Take clients at a listening socket from now on."""
        logger = logging.getLogger(f"{__name__}.websockets")
        logger.addHandler(logging.NullHandler())
        logger.propagate = False
        self._server = await serve(
            self._attend,
            sock=at,
            compression=None,
            max_size=_LONGEST_FRAME,
            max_queue=4,
            ping_interval=_PING_EVERY,
            ping_timeout=_PING_EVERY,
            close_timeout=1.0,
            logger=logger,
        )

    async def close(self) -> None:
        """Send what is still to be sent, and let everybody go."""
        await self.flush(1.0)
        if self._server is not None:
            self._server.close()
            await self._server.wait_closed()

    async def flush(self, patience: float) -> None:
        """Wait until what is published is on its way, for nobody longer than `patience` (s).

        Who wasn't ready in that time is not waited for again before they are.
        """
        busy = [client for client in self.clients if not client.is_idle]
        self._slow.intersection_update(busy)
        waiting = [client for client in busy if client not in self._slow]
        if waiting:
            ready = await asyncio.gather(*(client.idle(patience) for client in waiting))
            self._slow |= {
                one for one, is_ready in zip(waiting, ready, strict=True) if not is_ready
            }

    async def reached(self, client: Client, patience: float) -> None:
        """Wait until a client has read everything that was sent to it, and has said its say.

        That is when it answers a ping. Not longer than `patience` (seconds), nor when it goes.
        """
        connection = self.clients.get(client)
        if connection is None or client in self._slow:
            return
        try:
            await asyncio.wait_for(await connection.ping(), patience)
        except asyncio.TimeoutError:
            self._slow.add(client)
        except ConnectionClosed:
            return
        heard = None
        while heard != client.heard:
            heard = client.heard
            for _ in range(_TURNS):
                await asyncio.sleep(0)

    async def _attend(self, connection: ServerConnection) -> None:
        if len(self.clients) >= MOST_CLIENTS:
            await connection.close(1013, f"{MOST_CLIENTS} clients are here already")
            return
        # asyncio does so itself only where it opened the listening socket.
        connection.transport.get_extra_info("socket").setsockopt(
            socket.IPPROTO_TCP, socket.TCP_NODELAY, 1
        )
        self._names += 1
        client = Client(
            f"client{self._names}", connection.send, lambda _: connection.transport.abort()
        )
        self.clients[client] = connection
        sending = asyncio.create_task(client.send_forever())
        try:
            async for text in connection:
                client.heard += 1
                self._exchange.take(client, text)
                # Others have their turn, however much this one has to say.
                await asyncio.sleep(0)
        except ConnectionClosed:
            pass
        except Exception as why:
            self._failed(why)
        finally:
            sending.cancel()
            with suppress(asyncio.CancelledError, ConnectionClosed):
                await sending
            del self.clients[client]
            self._slow.discard(client)
            self._exchange.forget(client)
            self._left(client)
