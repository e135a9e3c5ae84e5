"""Rosbridge server over websockets, with limits per connection."""

from __future__ import annotations

import asyncio
import errno
import itertools
import logging
import socket
from collections import deque
from collections.abc import Callable
from functools import partial
from typing import Any

from websockets.asyncio.server import Server, ServerConnection, serve
from websockets.exceptions import ConnectionClosed
from websockets.frames import DATA_OPCODES, Frame
from websockets.http11 import Request, Response
from websockets.protocol import State

from ..cell.admission import Notices
from ..live.page_server import Origins
from .client import Client, done_within
from .exchange import Exchange
from .protocol import LONGEST_MESSAGE, Account, Ledger

_FRAME = 300
"""Bytes. Memory of a waiting frame without its data."""

_HEADER = 6
"""Bytes. Header and mask of a control frame of a client (RFC 6455, 5.2)."""

_GOODBYE = 1.0
"""Seconds in which a client that is being disconnected may read the reason."""

_LONGEST_FAREWELL = 10_000
"""Bytes that are accepted from a client that is being disconnected."""

_POLICY = 1008
"""Close code for a client that violates a policy (RFC 6455, 7.4.1)."""


class Incoming(ServerConnection):
    """Connection of a client, with an account of the bytes held for it.

    It counts the bytes and frames of messages that are incomplete or wait, and bytes that wait to
    be written. The latter are answers to pings, which websockets sends.
    """

    ledger: Ledger
    most: int
    """Maximum number of connections."""

    def connection_made(self, transport: asyncio.BaseTransport) -> None:
        """Open the account."""
        self.account = Account(self.ledger, self.dismiss)
        self._farewell = _LONGEST_FAREWELL
        self._unwritten = 0
        self._incomplete = 0
        self._complete: deque[int] = deque()
        self._goodbye: asyncio.Task[None] | None = None
        super().connection_made(transport)
        if len(self.ledger.accounts) > self.most:
            self.account.close()
            self.transport.abort()

    def data_received(self, data: bytes) -> None:
        """Count data. From a client that is being disconnected, only a farewell is accepted."""
        self._count(len(data))
        if self.account.is_closed:
            self._farewell -= len(data)
            if self._farewell < 0:
                return
        super().data_received(data)
        unwritten = self.transport.get_write_buffer_size()
        self.account.add(unwritten - self._unwritten)
        self._unwritten = unwritten

    def process_event(self, event: object) -> None:
        """Count a complete frame. Bytes received with the end of a message belong to it."""
        if not isinstance(event, Frame):  # the request of the handshake
            self._count(-self._incomplete)
        elif event.opcode not in DATA_OPCODES:
            self._count(-_HEADER - len(event.data))
        else:
            self._count(_FRAME)
            if event.fin:
                self._complete.append(self._incomplete)
                self._incomplete = 0
        super().process_event(event)  # type: ignore[arg-type]

    def connection_lost(self, exc: Exception | None) -> None:
        """Close the account."""
        self.account.close()
        super().connection_lost(exc)

    def taken(self) -> None:
        """Stop counting the oldest complete message, because it is handled."""
        self.account.add(-self._complete.popleft())

    def dismiss(self, why: str) -> None:
        """Close the connection. A client that does not read does not get the reason."""
        self._goodbye = asyncio.ensure_future(self._dismiss(why))

    async def _dismiss(self, why: str) -> None:
        if self.state is State.OPEN:
            await done_within(self.close(_POLICY, why), _GOODBYE)
        self.transport.abort()

    def _count(self, size: int) -> None:
        self._incomplete += size
        self.account.add(size)


MOST_CLIENTS = 1000
"""Maximum number of clients."""

_MOST_CONNECTIONS = 2 * MOST_CLIENTS
"""Maximum number of connections, including those without a request yet."""

_LONGEST_FRAME = 4 * LONGEST_MESSAGE
"""Bytes of the longest message in UTF-8. A longer one ends the connection."""

_BACKLOG = 128
"""Connections that the system queues until they are accepted."""

_EXHAUSTED = (errno.EMFILE, errno.ENFILE, errno.ENOBUFS, errno.ENOMEM)

_LONGEST_SHOWN = 100
"""Characters of an origin in a notice."""

_PING_EVERY = 20.0
"""Seconds between pings, and until a client without an answer counts as gone."""

_TURNS = 5
"""Turns of the event loop after which a received message is certainly handled."""


class AddressError(OSError):
    """Address that is not available."""


def listen_at(host: str, port: int) -> socket.socket:
    """Return a listening socket at an address. Port 0 is any free one.

    `AddressError` says why that fails.
    """
    try:
        (family, _, _, _, address), *_ = socket.getaddrinfo(host, port, type=socket.SOCK_STREAM)
        return socket.create_server(address[:2], family=family)
    except (OSError, UnicodeError) as why:
        reason = getattr(why, "strerror", None) or why
        raise AddressError(
            f"can't serve at {host}:{port}: {reason}; choose another with --host and --port"
        ) from None


class RosbridgeServer:
    """Server of an exchange for any number of clients.

    `left(client)` is called when a client has gone, and `failed(why)` when a request fails without
    a fault of the client. Web pages of `origins` are accepted. `ledger` limits the bytes held for
    clients. `notice(text)` reports rejected and disconnected clients to the user.
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
        self._notices = Notices(notice)
        self._slow: set[Client] = set()
        self._numbers = itertools.count(1)
        self._server: Server | None = None

    async def open(self, at: socket.socket) -> None:
        """Accept clients at a listening socket from now on."""
        logger = logging.getLogger(f"{__name__}.websockets")
        logger.addHandler(logging.NullHandler())
        logger.propagate = False

        class CountedConnection(Incoming):
            ledger = self._ledger
            most = _MOST_CONNECTIONS

        loop = asyncio.get_running_loop()
        self._pass_on = loop.get_exception_handler()
        loop.set_exception_handler(self._complain)
        self._server = await serve(
            self._attend,
            sock=at,
            # asyncio tries to accept this many connections at once, and reports each failure.
            backlog=1,
            create_connection=CountedConnection,
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
        """Send everything that is waiting, and disconnect all clients."""
        await self.flush(1.0)
        if self._server is not None:
            self._server.close()
            await self._server.wait_closed()

    async def flush(self, patience: float) -> None:
        """Wait until everything that is published is on its way, for at most `patience` s.

        Later calls do not wait for a client that was not ready in time, until it is.
        """
        busy = {client for client in self.clients if not client.outbox.idle.is_set()}
        self._slow &= busy
        waiting = busy - self._slow
        if waiting:
            await asyncio.gather(*(client.idle(patience) for client in waiting))
            self._slow |= {client for client in waiting if not client.outbox.idle.is_set()}

    async def reached(self, client: Client, patience: float) -> None:
        """Wait until a client has read all messages, and its own messages are handled.

        It has when it answers a ping. The wait is at most `patience` s.
        """
        connection = self.clients.get(client)
        if connection is None or client in self._slow:
            return
        try:
            if not await done_within(await connection.ping(), patience):
                self._slow.add(client)
        except ConnectionClosed:
            return
        # A ping is answered out of turn, so earlier messages may still wait, and cause others.
        heard = -1
        while heard != client.heard:
            heard = client.heard
            for _ in range(_TURNS):
                await asyncio.sleep(0)

    def _handle(self, client: Client, text: str | bytes) -> None:
        self.clients[client].taken()
        if not client.account.is_closed:
            client.heard += 1
            self._exchange.take(client, text)

    def _admit(self, connection: ServerConnection, request: Request) -> Response | None:
        """Reject web pages that are not trusted. A client without an origin is accepted."""
        host = ",".join(request.headers.get_all("Host"))
        for origin in request.headers.get_all("Origin"):
            if not self._origins.trust(origin, host):
                page = f"web page of {origin[:_LONGEST_SHOWN]!a}"
                self._notices.add(f"a {page} was rejected; allow it with --origin")
                return connection.respond(403, f"a {page} is not allowed here\n")
        return None

    def _complain(self, loop: asyncio.AbstractEventLoop, context: dict[str, Any]) -> None:
        """Report once that there is no room for another client, which asyncio repeats."""
        why = context.get("exception")
        is_serving = self._server is not None and self._server.is_serving()
        if "socket" in context and isinstance(why, OSError) and why.errno in _EXHAUSTED:
            self._notices.add(f"no more clients are accepted for now: {why.strerror}")
        elif not is_serving and "_start_serving" in context.get("message", ""):
            pass  # asyncio tries to accept clients at a closed socket
        elif self._pass_on is not None:
            self._pass_on(loop, context)
        else:
            loop.default_exception_handler(context)

    async def _attend(self, connection: ServerConnection) -> None:
        assert isinstance(connection, Incoming)  # as `open` has it
        if len(self.clients) >= MOST_CLIENTS:
            await connection.close(1013, f"{MOST_CLIENTS} clients are connected already")
            return
        # asyncio does this itself only if it has opened the listening socket.
        connection.transport.get_extra_info("socket").setsockopt(
            socket.IPPROTO_TCP, socket.TCP_NODELAY, 1
        )
        client = Client(f"client{next(self._numbers)}", connection.send, connection.account)

        def let_go(why: str) -> None:
            client.clear()
            self._exchange.forget(client)
            self._notices.add(f"a client was disconnected: {why}")
            connection.dismiss(why)

        connection.account.let_go = let_go
        self.clients[client] = connection
        try:
            await client.attend(connection, partial(self._handle, client))
        except Exception as why:
            self._failed(why)
        finally:
            del self.clients[client]
            self._slow.discard(client)
            self._exchange.forget(client)
            self._left(client)
