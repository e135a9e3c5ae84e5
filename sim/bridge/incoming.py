"""A connection that counts what has come in of it and is not taken yet."""

from __future__ import annotations

import asyncio
from collections import deque
from contextlib import suppress

from websockets.asyncio.server import ServerConnection
from websockets.frames import DATA_OPCODES, Frame
from websockets.protocol import State

from .ledger import Account, Ledger

_FRAME = 300
"""Bytes. The place that a frame takes while it waits, beside its data."""

_GOODBYE = 1.0
"""Seconds. How long a client that is let go may take to hear why."""

_LONGEST_FAREWELL = 10_000
"""Bytes, with what was on its way."""

_POLICY = 1008
"""The code with which a connection is closed that breaks a rule (RFC 6455, 7.4.1)."""


class Incoming(ServerConnection):
    """A client's connection, with the account of what is held for it.

    Counted are the bytes of a frame that is not complete, frames that wait or belong to a message
    that is not complete, and what waits to be written: answers to pings are, unasked.
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
        """Count what comes in; of a client that is let go no more is taken than a farewell."""
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
        """The oldest of the messages that are complete is taken: it is not counted any more."""
        self.account.add(-self._messages.popleft())

    def dismiss(self, why: str) -> None:
        """Close the connection; a client that doesn't read will not hear why."""
        self._goodbye = asyncio.ensure_future(self._dismiss(why))

    async def _dismiss(self, why: str) -> None:
        if self.state is State.OPEN:
            with suppress(asyncio.TimeoutError):
                await asyncio.wait_for(self.close(_POLICY, why), _GOODBYE)
        self.transport.abort()

    def _buffer(self, size: int) -> None:
        self._buffered += size
        self.account.add(size)


def _length_on_the_wire(frame: Frame) -> int:
    """The bytes of a client's frame: header, mask, data (RFC 6455, 5.2)."""
    length = len(frame.data)
    return length + (6 if length < 126 else 8 if length < 65536 else 14)
