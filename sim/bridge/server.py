"""Rosbridge server over websockets, with limits per connection."""

from __future__ import annotations

import asyncio
import errno
import itertools
import logging
import socket
from collections import deque
from collections.abc import Callable
from contextlib import suppress
from typing import Any

from websockets.asyncio.server import Server, ServerConnection, serve
from websockets.exceptions import ConnectionClosed
from websockets.frames import DATA_OPCODES, Frame
from websockets.http11 import Request, Response
from websockets.protocol import State

from ..live.page_server import Origins
from .client import Client
from .exchange import Exchange
from .protocol import LONGEST_MESSAGE, Account, Ledger
from .waiting import done_within

_FRAME = 300
"""Bytes. The memory that a frame takes while it waits, beside its data."""

_GOODBYE = 1.0
"""Seconds. How long a client that is disconnected may take to read the reason."""

_LONGEST_FAREWELL = 10_000
"""Bytes that are still taken of a client that is disconnected."""

_POLICY = 1008
"""The close code for a client that violates a policy (RFC 6455, 7.4.1)."""


class Incoming(ServerConnection):
    """A client's connection, with the account of what is held for it.

    Counted are the bytes of an incomplete frame, frames that wait or belong to an incomplete
    message, and bytes that wait to be written: answers to pings, which websockets sends unasked.
    """

    ledger: Ledger
    most: int
    """How many connections there may be at once."""

    def connection_made(self, transport: asyncio.BaseTransport) -> None:
        """Open the account."""
        self.account = Account(self.ledger, self.dismiss)
        self._farewell = _LONGEST_FAREWELL
        self._buffered = 0
        self._unwritten = 0
        self._message = 0
        self._messages: deque[int] = deque()
        self._goodbye: asyncio.Task[None] | None = None
        super().connection_made(transport)
        if len(self.ledger.accounts) > self.most:
            self.account.close()
            self.transport.abort()

    def data_received(self, data: bytes) -> None:
        """Count what comes in; of a client that is disconnected only a farewell is taken."""
        self._buffer(len(data))
        if self.account.is_closed:
            self._farewell -= len(data)
            if self._farewell < 0:
                return
        super().data_received(data)
        unwritten = self.transport.get_write_buffer_size()
        self.account.add(unwritten - self._unwritten)
        self._unwritten = unwritten

    def process_event(self, event: object) -> None:
        """Count a frame that is complete."""
        if isinstance(event, Frame):
            self._buffer(-_length_on_the_wire(event))
            if event.opcode in DATA_OPCODES:
                size = len(event.data) + _FRAME
                self.account.add(size)
                self._message += size
                if event.fin:
                    self._messages.append(self._message)
                    self._message = 0
        else:
            self._buffer(-self._buffered)
        super().process_event(event)  # type: ignore[arg-type]

    def connection_lost(self, exc: Exception | None) -> None:
        """Close the account."""
        self.account.close()
        super().connection_lost(exc)

    def taken(self) -> None:
        """Count the oldest of the complete messages no longer: it is taken."""
        self.account.add(-self._messages.popleft())

    def dismiss(self, why: str) -> None:
        """Close the connection; a client that doesn't read won't get the reason."""
        self._goodbye = asyncio.ensure_future(self._dismiss(why))

    async def _dismiss(self, why: str) -> None:
        if self.state is State.OPEN:
            await done_within(self.close(_POLICY, why), _GOODBYE)
        self.transport.abort()

    def _buffer(self, size: int) -> None:
        self._buffered += size
        self.account.add(size)


def _length_on_the_wire(frame: Frame) -> int:
    """Return the size in bytes of a client's frame: header, mask, data (RFC 6455, 5.2)."""
    length = len(frame.data)
    return length + (6 if length < 126 else 8 if length < 65536 else 14)


MOST_CLIENTS = 1000
"""How many clients may be connected at once."""

_MOST_CONNECTIONS = 2 * MOST_CLIENTS
"""How many connections there may be, those included that have not sent a request yet."""

_LONGEST_FRAME = 4 * LONGEST_MESSAGE
"""Bytes: the longest message in UTF-8. A longer one ends the connection."""

_BACKLOG = 128
"""Connections that the system keeps until they are taken."""

_EXHAUSTED = (errno.EMFILE, errno.ENFILE, errno.ENOBUFS, errno.ENOMEM)

_LONGEST_SHOWN = 100
"""Characters of an origin in a notice."""

_MOST_NOTICES = 20
"""How many clients are reported that are refused or disconnected; there may be no end of them."""

_PING_EVERY = 20.0
"""Seconds between pings, and until a client that doesn't answer one counts as gone."""

_TURNS = 5
"""Turns of the event loop after which a message that has come in is certainly taken."""


class AddressError(OSError):
    """An address that the bridge can't serve at."""


def listen_at(host: str, port: int) -> socket.socket:
    """Return a listening socket at an address (port 0: any that is free).

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
    """Serves an exchange to any number of clients.

    `left(client)` is called when one has gone, `failed(why)` when a request fails through no fault
    of the client's. Web pages of `origins` may take part, `ledger` limits what is held for
    clients, and `notice(text)` notifies the user of clients that are refused or disconnected.
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
        self._said: set[str] = set()
        self._is_closed = False
        self._slow: set[Client] = set()
        self._numbers = itertools.count(1)
        self._server: Server | None = None

    async def open(self, at: socket.socket) -> None:
        """Take clients at a listening socket from now on."""
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
            # asyncio tries to take as many connections at once as this, and complains of each.
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
        """Send what is still to be sent, and disconnect all clients."""
        await self.flush(1.0)
        self._is_closed = True
        if self._server is not None:
            self._server.close()
            await self._server.wait_closed()

    async def flush(self, patience: float) -> None:
        """Wait until all that is published is on its way, `patience` seconds at most.

        A client that is not ready in that time is not waited for again before it is.
        """
        busy = {client for client in self.clients if not client.outbox.idle.is_set()}
        self._slow &= busy
        waiting = busy - self._slow
        if waiting:
            await asyncio.gather(*(client.idle(patience) for client in waiting))
            self._slow |= {client for client in waiting if not client.outbox.idle.is_set()}

    async def reached(self, client: Client, patience: float) -> None:
        """Wait until a client has read all that was sent to it, and its messages are taken.

        That is when it answers a ping: `patience` seconds at most, and not once it has gone.
        """
        connection = self.clients.get(client)
        if connection is None or client in self._slow:
            return
        try:
            if not await done_within(await connection.ping(), patience):
                self._slow.add(client)
        except ConnectionClosed:
            return
        # A ping is answered out of turn: what came before it may still wait to be taken, and cause
        # more.
        heard = -1
        while heard != client.heard:
            heard = client.heard
            for _ in range(_TURNS):
                await asyncio.sleep(0)

    def _admit(self, connection: ServerConnection, request: Request) -> Response | None:
        """Refuse a web page that is not trusted; a client that sends no origin is let in."""
        host = ",".join(request.headers.get_all("Host"))
        for origin in request.headers.get_all("Origin"):
            if not self._origins.trust(origin, host):
                page = f"web page of {origin[:_LONGEST_SHOWN]!a}"
                self._notice_once(f"a {page} was rejected; allow it with --origin")
                return connection.respond(403, f"a {page} is not allowed here\n")
        return None

    def _complain(self, loop: asyncio.AbstractEventLoop, context: dict[str, Any]) -> None:
        """Report in a sentence that there is no room for another client; asyncio repeats it."""
        why = context.get("exception")
        if "socket" in context and isinstance(why, OSError) and why.errno in _EXHAUSTED:
            self._notice_once(f"no more clients are accepted for now: {why.strerror}")
        elif self._is_closed and "_start_serving" in context.get("message", ""):
            pass  # asyncio tries again to take clients, at a socket that is closed
        elif self._pass_on is not None:
            self._pass_on(loop, context)
        else:
            loop.default_exception_handler(context)

    def _notice_once(self, text: str) -> None:
        if text not in self._said and len(self._said) < _MOST_NOTICES:
            self._said.add(text)
            self._notice(text)

    async def _attend(self, connection: ServerConnection) -> None:
        assert isinstance(connection, Incoming)  # as `open` has it
        if len(self.clients) >= MOST_CLIENTS:
            await connection.close(1013, f"{MOST_CLIENTS} clients are connected already")
            return
        # asyncio does so itself only where it opened the listening socket.
        connection.transport.get_extra_info("socket").setsockopt(
            socket.IPPROTO_TCP, socket.TCP_NODELAY, 1
        )
        client = Client(f"client{next(self._numbers)}", connection.send, connection.account)

        def let_go(why: str) -> None:
            client.clear()
            self._exchange.forget(client)
            self._notice_once(f"a client was disconnected: {why}")
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
                # Other clients have their turn, however much this one sends.
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
