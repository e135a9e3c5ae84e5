"""Client of the bridge: its subscriptions and its queue of outgoing messages."""

from __future__ import annotations

import asyncio
import itertools
import sys
from collections import deque
from collections.abc import Awaitable, Callable
from typing import Any

from .protocol import LEVELS, Account, Level, Reassembly, Subscribe, fragments, size_of, status

LONGEST_QUEUE = 1000
"""Maximum number of waiting messages of one topic, whatever a client requests."""

USUAL_QUEUE = 100
"""Number of waiting messages of one topic, unless a client requests more (10 s at 10 Hz)."""

MOST_REPLIES = 1000
"""Number of waiting answers and status messages at which a client is disconnected."""

Item = tuple[str, int | None]
"""Message, and the size of its fragments in characters, if it is sent in fragments."""


class TopicQueue:
    """Waiting messages of one topic for one client, at most the last `limit`."""

    def __init__(self, limit: int) -> None:
        self.limit = limit
        self.waiting: deque[Item] = deque()


class Outbox:
    """Waiting messages of a client in their order, without dropped ones.

    `account` counts the waiting messages and the last one that was returned. If it is closed,
    nothing is added. `idle` is set while all messages are sent.
    """

    def __init__(self, account: Account) -> None:
        self.idle = asyncio.Event()
        self.idle.set()
        self._account = account
        self._replies = TopicQueue(MOST_REPLIES)
        self._order: deque[TopicQueue] = deque()
        self._filled = asyncio.Event()
        self._under_way: Item | None = None

    def __len__(self) -> int:
        return len(self._order)

    def reply(self, text: str, fragment_size: int | None = None) -> None:
        """Add an answer, or disconnect a client for which too many wait."""
        if len(self._replies.waiting) >= MOST_REPLIES:
            self._account.refuse(f"{MOST_REPLIES} answers wait to be read")
        self._put(self._replies, (text, fragment_size))

    def put(self, stream: TopicQueue, text: str, fragment_size: int | None = None) -> None:
        """Add a message of a topic, and drop its oldest ones if too many wait."""
        while len(stream.waiting) >= stream.limit:
            self._count(stream.waiting.popleft(), -1)
            # The order contains a stream once per message, so the first place is the oldest one's.
            self._order.remove(stream)
        self._put(stream, (text, fragment_size))

    def drop(self, stream: TopicQueue) -> None:
        """Drop the messages of a topic."""
        while stream.waiting:
            self._count(stream.waiting.popleft(), -1)
        self._order = deque(one for one in self._order if one is not stream)

    def clear(self) -> None:
        """Drop all messages."""
        for stream in set(self._order):
            self.drop(stream)

    async def get(self) -> Item:
        """Wait for the next message and return it."""
        if self._under_way is not None:
            self._count(self._under_way, -1)
            self._under_way = None
        while not self._order:
            self.idle.set()
            self._filled.clear()
            await self._filled.wait()
        self._under_way = self._order.popleft().waiting.popleft()
        return self._under_way

    def _put(self, stream: TopicQueue, item: Item) -> None:
        self._count(item, 1)
        if not self._account.is_closed:
            stream.waiting.append(item)
            self._order.append(stream)
            self._filled.set()
            self.idle.clear()

    def _count(self, item: Item, sign: int) -> None:
        self._account.add(sign * size_of(item[0]))


ADVERTISED = 200
"""Bytes. Memory of an advertised topic."""

_REQUEST, _SUBSCRIPTION, _CALL = 500, 3000, 4000
"""Bytes. Memory of a request to subscribe, a subscription, and a service call."""


class Subscription:
    """Requests of a client for the messages of one topic, by id, served as one stream.

    The shortest interval, the longest queue and the smallest fragments of all requests count.
    """

    def __init__(self, client: Client) -> None:
        self.requests: dict[str | int | None, Subscribe] = {}
        self._client = client
        self._stream = TopicQueue(USUAL_QUEUE)
        self._held_back: deque[str] = deque()
        self._most_held_back = 0
        self._free_at = 0.0
        self._timer: asyncio.TimerHandle | None = None
        client.account.add(_SUBSCRIPTION)

    def add(self, request: Subscribe) -> None:
        """Add a request, which replaces the one with the same id."""
        if request.id not in self.requests:
            self._client.account.add(_cost(request.id))
        self.requests[request.id] = request
        queue = max(one.queue_length or 0 for one in self.requests.values())
        self._most_held_back = min(queue, LONGEST_QUEUE)
        self._stream.limit = self._most_held_back or USUAL_QUEUE
        while len(self._held_back) > self._most_held_back:
            self._release()

    def remove(self, id: str | int | None) -> bool:
        """Remove a request, or all requests for None. Return whether there was one."""
        gone = [one for one in self.requests if id is None or one == id]
        for one in gone:
            del self.requests[one]
            self._client.account.add(-_cost(one))
        if not self.requests:
            self._client.account.add(-_SUBSCRIPTION)
            self._client.outbox.drop(self._stream)
            while self._held_back:
                self._release()
            if self._timer is not None:
                self._timer.cancel()
        return bool(gone)

    def offer(self, text: str) -> None:
        """Send a message of the topic now, send it after the interval, or drop it."""
        if self._client.account.is_closed:
            return
        loop, interval = asyncio.get_running_loop(), self._interval
        if not interval or (loop.time() >= self._free_at and not self._held_back):
            self._free_at = loop.time() + interval
            self._send(text)
        # Within the interval, messages wait if the client requested a queue. Otherwise only the
        # next one after it is sent.
        elif self._most_held_back:
            if len(self._held_back) >= self._most_held_back:
                self._release()
            self._held_back.append(text)
            self._client.account.add(size_of(text))
            if self._timer is None:
                self._timer = loop.call_at(self._free_at, self._catch_up)

    @property
    def _interval(self) -> float:
        """Interval between messages in seconds."""
        return min(one.throttle_rate or 0.0 for one in self.requests.values()) / 1000

    def _catch_up(self) -> None:
        self._timer = None
        if not self._held_back:
            return
        self._send(self._release())
        loop = asyncio.get_running_loop()
        self._free_at = loop.time() + self._interval
        if self._held_back:
            self._timer = loop.call_at(self._free_at, self._catch_up)

    def _release(self) -> str:
        text = self._held_back.popleft()
        self._client.account.add(-size_of(text))
        return text

    def _send(self, text: str) -> None:
        sizes = [one.fragment_size for one in self.requests.values() if one.fragment_size]
        self._client.outbox.put(self._stream, text, min(sizes, default=None))


class Client:
    """Connected client. `send(text)` sends to it, and `account` counts the bytes held for it."""

    def __init__(self, name: str, send: Callable[[str], Awaitable[None]], account: Account) -> None:
        self.name = name
        self.account = account
        self.outbox = Outbox(account)
        self.subscriptions: dict[str, Subscription] = {}
        self.advertised: set[str] = set()
        self.level: Level = "error"
        self.reassembly = Reassembly(account)
        self.calls: set[asyncio.Future[None]] = set()
        self.heard = 0
        self._send = send

    def __repr__(self) -> str:
        return f"<client {self.name}>"

    def begin_call(self, call: asyncio.Future[None]) -> None:
        """Add a service call until it is done."""
        self.calls.add(call)
        self.account.add(_CALL)
        call.add_done_callback(self._end_call)

    def _end_call(self, call: asyncio.Future[None]) -> None:
        self.calls.discard(call)
        self.account.add(-_CALL)

    def clear(self) -> None:
        """Drop all messages that wait, and all incomplete ones."""
        self.outbox.clear()
        self.reassembly.clear()

    def report(self, level: Level, message: str, id: str | int | None = None) -> None:
        """Send a status message, if the client gets messages of this level."""
        if LEVELS.index(level) <= LEVELS.index(self.level):
            self.outbox.reply(status(level, message, id))

    async def send_forever(self) -> None:
        """Send the messages of the outbox until this is cancelled."""
        for number in itertools.count(1):
            text, size = await self.outbox.get()
            for piece in fragments(text, size or len(text), f"{self.name}-{number}"):
                await self._send(piece)

    async def idle(self, patience: float) -> bool:
        """Wait until everything is sent, for at most `patience` s. Return whether it is."""
        await done_within(self.outbox.idle.wait(), patience)
        return self.outbox.idle.is_set()


def _cost(id: str | int | None) -> int:
    """Return the size in bytes of a request with an id."""
    return _REQUEST + sys.getsizeof(id)


async def done_within(awaitable: Awaitable[Any], seconds: float) -> bool:
    """Wait for at most `seconds`, then cancel `awaitable`. Return whether it was done before.

    Raises what it raises. In Python before 3.12, `asyncio.wait_for` swallows a cancellation of the
    caller at the moment at which the awaitable is done, so that the caller never ends.
    """
    task = asyncio.ensure_future(awaitable)
    try:
        await asyncio.wait({task}, timeout=seconds)
        if task.done():
            task.result()
            return True
        return False
    finally:
        task.cancel()
