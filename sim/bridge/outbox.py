"""What waits to be sent to one client: bounded, whatever the client does or doesn't read."""

from __future__ import annotations

import asyncio
from collections import deque

LONGEST_QUEUE = 1000
"""Messages. The most that wait of one topic, whatever a client asks for."""

USUAL_QUEUE = 100
"""Messages. What waits of one topic, if a client asks for nothing (10 s at 10 Hz)."""

MOST_REPLIES = 1000
"""Answers and status messages that may wait; a client that reads none of them is let go."""

MOST_CHARACTERS = 8_000_000
"""Characters. What may wait altogether; a client for which more does is let go."""


class NotReadingError(Exception):
    """A client lets pile up what can't be thrown away."""


Item = tuple[str, ...]
"""One message in one piece, or in fragments that belong together."""


class Stream:
    """The messages of one topic that wait for one client: the latest `limit` of them."""

    def __init__(self, limit: int) -> None:
        self.limit = limit
        self.waiting: deque[Item] = deque()


class Outbox:
    """Hands messages out in the order in which they came, without those that grew too old.

    `characters` is how much waits.
    """

    def __init__(self) -> None:
        self._replies = Stream(MOST_REPLIES)
        self._order: deque[Stream] = deque()
        self._filled = asyncio.Event()
        self.characters = 0

    def __len__(self) -> int:
        return len(self._order)

    def reply(self, item: Item) -> None:
        """Put an answer in; `NotReadingError` where too many wait already."""
        if len(self._replies.waiting) >= MOST_REPLIES:
            raise NotReadingError(f"{MOST_REPLIES} answers wait to be read")
        self._put(self._replies, item)

    def put(self, stream: Stream, item: Item) -> None:
        """Put a topic's message in; the oldest one of the topic goes where too many wait."""
        while len(stream.waiting) >= stream.limit:
            self.characters -= _length(stream.waiting.popleft())
            self._order.remove(stream)
        self._put(stream, item)

    def drop(self, stream: Stream) -> None:
        """Throw away what waits of a topic."""
        self.characters -= sum(map(_length, stream.waiting))
        stream.waiting.clear()
        self._order = deque(one for one in self._order if one is not stream)

    async def get(self) -> Item:
        """The next message, as soon as there is one."""
        while not self._order:
            self._filled.clear()
            await self._filled.wait()
        item = self._order.popleft().waiting.popleft()
        self.characters -= _length(item)
        return item

    def _put(self, stream: Stream, item: Item) -> None:
        length = _length(item)
        if self.characters + length > MOST_CHARACTERS:
            raise NotReadingError(f"{MOST_CHARACTERS} characters wait to be read")
        self.characters += length
        stream.waiting.append(item)
        self._order.append(stream)
        self._filled.set()


def _length(item: Item) -> int:
    return sum(map(len, item))
