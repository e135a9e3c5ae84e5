"""A rosbridge server over websockets: connections become clients of an exchange."""

from __future__ import annotations

import asyncio
import errno
import logging
import socket
from collections.abc import Callable
from contextlib import suppress
from typing import Any

from websockets.asyncio.server import Server, ServerConnection, serve
from websockets.exceptions import ConnectionClosed
from websockets.http11 import Request, Response

from .client import Client
from .exchange import Exchange
from .incoming import Incoming
from .ledger import Ledger
from .origins import Origins
from .protocol import LONGEST_MESSAGE

MOST_CLIENTS = 1000
"""How many clients may be connected at once."""

_MOST_CONNECTIONS = 2 * MOST_CLIENTS
"""How many connections there may be, those included that have yet to say what they want."""

_LONGEST_FRAME = 4 * LONGEST_MESSAGE
"""Bytes: the longest message in UTF-8. One that is longer ends the connection."""

_BACKLOG = 128
"""Connections that the system keeps until they are taken."""

_EXHAUSTED = (errno.EMFILE, errno.ENFILE, errno.ENOBUFS, errno.ENOMEM)

_LONGEST_TOLD = 100
"""Characters of an origin that are told."""

_MOST_NOTICES = 20
"""How much is told of clients that are not let in or let go; they could go on for ever."""

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
    wrong through no fault of the client's. `origins` says which web pages may take part, `ledger`
    how much is held for clients. `notice(text)` tells the user who is not let in, or let go.
    """

    def __init__(
        self,
        exchange: Exchange,
        *,
        left: Callable[[Client], None],
        failed: Callable[[Exception], None],
        origins: Origins | None = None,
        ledger: Ledger | None = None,
        notice: Callable[[str], None] = lambda _: None,
    ) -> None:
        self.clients: dict[Client, Incoming] = {}
        self._exchange = exchange
        self._left = left
        self._failed = failed
        self._origins = origins or Origins()
        self._ledger = ledger or Ledger()
        self._notice = notice
        self._told: set[str] = set()
        self._is_closed = False
        self._slow: set[Client] = set()
        self._names = 0
        self._server: Server | None = None

    async def open(self, at: socket.socket) -> None:
        """Take clients at a listening socket from now on."""
        logger = logging.getLogger(f"{__name__}.websockets")
        logger.addHandler(logging.NullHandler())
        logger.propagate = False

        class Connection(Incoming):
            ledger = self._ledger
            most = _MOST_CONNECTIONS

        loop = asyncio.get_running_loop()
        self._pass_on = loop.get_exception_handler()
        loop.set_exception_handler(self._complain)
        self._server = await serve(
            self._attend,
            sock=at,
            # asyncio tries to take as many connections at once as this, and complains of each.
            backlog=1,
            create_connection=Connection,
            process_request=self._admit,
            compression=None,
            max_size=_LONGEST_FRAME,
            max_queue=4,
            ping_interval=_PING_EVERY,
            ping_timeout=_PING_EVERY,
            close_timeout=1.0,
            logger=logger,
        )
        at.listen(_BACKLOG)

    async def close(self) -> None:
        """Send what is still to be sent, and let everybody go."""
        await self.flush(1.0)
        self._is_closed = True
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

    def _admit(self, connection: ServerConnection, request: Request) -> Response | None:
        """Refuse a web page that has no business here; let in what is no web page."""
        host = ",".join(request.headers.get_all("Host"))
        for origin in request.headers.get_all("Origin"):
            if not self._origins.trust(origin, host):
                page = f"web page of {origin[:_LONGEST_TOLD]!a}"
                self._tell(f"a {page} was not let in; --origin would let it in")
                return connection.respond(403, f"a {page} is not let in here\n")
        return None

    def _complain(self, loop: asyncio.AbstractEventLoop, context: dict[str, Any]) -> None:
        """Tell in a sentence that there is no room for another client, which comes up often."""
        why = context.get("exception")
        if "socket" in context and isinstance(why, OSError) and why.errno in _EXHAUSTED:
            self._tell(f"no more clients can be taken for now: {why.strerror}")
        elif self._is_closed and "_start_serving" in context.get("message", ""):
            pass  # asyncio tries again to take clients, at a socket that is closed
        elif self._pass_on is not None:
            self._pass_on(loop, context)
        else:
            loop.default_exception_handler(context)

    def _tell(self, text: str) -> None:
        """Tell the user, once."""
        if text not in self._told and len(self._told) < _MOST_NOTICES:
            self._told.add(text)
            self._notice(text)

    async def _attend(self, connection: ServerConnection) -> None:
        assert isinstance(connection, Incoming)  # as `open` has it
        if len(self.clients) >= MOST_CLIENTS:
            await connection.close(1013, f"{MOST_CLIENTS} clients are here already")
            return
        # asyncio does so itself only where it opened the listening socket.
        connection.transport.get_extra_info("socket").setsockopt(
            socket.IPPROTO_TCP, socket.TCP_NODELAY, 1
        )
        self._names += 1
        client = Client(f"client{self._names}", connection.send, connection.account)

        def let_go(why: str) -> None:
            client.clear()
            self._exchange.forget(client)
            self._tell(f"a client was let go: {why}")
            connection.dismiss(why)

        connection.account.let_go = let_go
        self.clients[client] = connection
        sending = asyncio.create_task(client.send_forever())
        try:
            async for text in connection:
                connection.taken()
                if connection.account.is_closed:
                    break
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
