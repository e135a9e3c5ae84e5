"""The messages that wait to be sent to one client, bounded however slowly the client reads."""

from __future__ import annotations

import asyncio
from collections import deque

from .ledger import Account, size_of

LONGEST_QUEUE = 1000
"""Messages. The most that wait of one topic, however many a client asks for."""

USUAL_QUEUE = 100
"""Messages. The most that wait of one topic unless a client asks for more (10 s at 10 Hz)."""

MOST_REPLIES = 1000
"""Answers and status messages that may wait; a client that reads none of them is disconnected."""

Item = tuple[str, int | None]
"""A message, and the size of the fragments that it is to be sent in, if any (characters)."""


class Stream:
    """The messages of one topic that wait for one client: the latest `limit` of them."""

    def __init__(self, limit: int) -> None:
        self.limit = limit
        self.waiting: deque[Item] = deque()


class Outbox:
    """Hands messages out in the order in which they came, without those dropped meanwhile.

    `account` counts the messages that wait, and the one handed out last until the next is asked
    for; nothing is kept where it is closed. `idle` is set while all messages are sent.
    """

    def __init__(self, account: Account) -> None:
        self.idle = asyncio.Event()
        self.idle.set()
        self._account = account
        self._replies = Stream(MOST_REPLIES)
        self._order: deque[Stream] = deque()
        self._filled = asyncio.Event()
        self._under_way: Item | None = None

    def __len__(self) -> int:
        return len(self._order)

    def reply(self, text: str, fragment_size: int | None = None) -> None:
        """Add an answer; a client for which too many wait is disconnected."""
        if len(self._replies.waiting) >= MOST_REPLIES:
            self._account.refuse(f"{MOST_REPLIES} answers wait to be read")
        self._put(self._replies, (text, fragment_size))

    def put(self, stream: Stream, text: str, fragment_size: int | None = None) -> None:
        """Add a topic's message, and drop the oldest ones of the topic where too many wait."""
        while len(stream.waiting) >= stream.limit:
            self._count(stream.waiting.popleft(), -1)
            # A stream stands in the order once for each message: its first place is that of its
            # oldest.
            self._order.remove(stream)
        self._put(stream, (text, fragment_size))

    def drop(self, stream: Stream) -> None:
        """Drop the messages of a topic."""
        while stream.waiting:
            self._count(stream.waiting.popleft(), -1)
        self._order = deque(one for one in self._order if one is not stream)

    def clear(self) -> None:
        """Drop all messages."""
        for stream in set(self._order):
            self.drop(stream)

    async def get(self) -> Item:
        """Return the next message, as soon as there is one."""
        if self._under_way is not None:
            self._count(self._under_way, -1)
            self._under_way = None
        while not self._order:
            self.idle.set()
            self._filled.clear()
            await self._filled.wait()
        self._under_way = self._order.popleft().waiting.popleft()
        return self._under_way

    def _put(self, stream: Stream, item: Item) -> None:
        self._count(item, 1)
        if not self._account.is_closed:
            stream.waiting.append(item)
            self._order.append(stream)
            self._filled.set()
            self.idle.clear()

    def _count(self, item: Item, sign: int) -> None:
        self._account.add(sign * size_of(item[0]))
