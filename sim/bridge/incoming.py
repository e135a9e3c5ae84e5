"""A connection that counts the bytes that have come in and are not taken yet."""

from __future__ import annotations

import asyncio
from collections import deque
from contextlib import suppress

from websockets.asyncio.server import ServerConnection
from websockets.frames import DATA_OPCODES, Frame
from websockets.protocol import State

from .ledger import Account, Ledger

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
