"""Client of the bridge: its subscriptions and its queue of outgoing messages."""

from __future__ import annotations

import asyncio
import itertools
import sys
from collections import deque
from collections.abc import AsyncIterable, Awaitable, Callable
from contextlib import suppress
from typing import Any

from websockets.exceptions import ConnectionClosed

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
    """Waiting messages of one topic for one client, at most the last `limit`.

    The last `held` ones are sent after `Outbox.release`.
    """

    def __init__(self, limit: int) -> None:
        self.limit = limit
        self.held = 0
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
        """Contains a queue once for each of its messages that is not held."""
        self._filled = asyncio.Event()
        self._under_way: Item | None = None

    def __len__(self) -> int:
        return len(self._order)

    def reply(self, text: str, fragment_size: int | None = None) -> None:
        """Add an answer, or disconnect a client for which too many wait."""
        if len(self._replies.waiting) >= MOST_REPLIES:
            self._account.refuse(f"{MOST_REPLIES} answers wait to be read")
        self.put(self._replies, text, fragment_size)

    def put(
        self, queue: TopicQueue, text: str, fragment_size: int | None = None, *, held: bool = False
    ) -> None:
        """Add a message of a topic, and drop its oldest ones if too many wait."""
        while len(queue.waiting) >= queue.limit:
            self._count(queue.waiting.popleft(), -1)
            if len(queue.waiting) < queue.held:
                queue.held -= 1
            else:
                self._order.remove(queue)
        item = (text, fragment_size)
        self._count(item, 1)
        if not self._account.is_closed:
            queue.waiting.append(item)
            queue.held += 1
            if not held:
                self.release(queue)

    def release(self, queue: TopicQueue) -> None:
        """Send the oldest message that is held."""
        queue.held -= 1
        self._order.append(queue)
        self._filled.set()
        self.idle.clear()

    def drop(self, queue: TopicQueue) -> None:
        """Drop the messages of a topic."""
        for item in queue.waiting:
            self._count(item, -1)
        queue.waiting.clear()
        queue.held = 0
        self._order = deque(one for one in self._order if one is not queue)

    def clear(self) -> None:
        """Drop all messages that are not held."""
        for queue in set(self._order):
            self.drop(queue)

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
        self._queue = TopicQueue(USUAL_QUEUE)
        self._queue_length = 0
        self._free_at = 0.0
        self._timer: asyncio.TimerHandle | None = None
        """Runs while messages are held."""
        client.account.add(_SUBSCRIPTION)

    def add(self, request: Subscribe) -> None:
        """Add a request, which replaces the one with the same id."""
        if request.id not in self.requests:
            self._client.account.add(_cost(request.id))
        self.requests[request.id] = request
        longest = max(one.queue_length or 0 for one in self.requests.values())
        self._queue_length = min(longest, LONGEST_QUEUE)
        self._queue.limit = self._queue_length or USUAL_QUEUE

    def remove(self, id: str | int | None) -> bool:
        """Remove a request, or all requests for None. Return whether there was one."""
        gone = [one for one in self.requests if id is None or one == id]
        for one in gone:
            del self.requests[one]
            self._client.account.add(-_cost(one))
        if not self.requests:
            self._client.account.add(-_SUBSCRIPTION)
            self._client.outbox.drop(self._queue)
            if self._timer is not None:
                self._timer.cancel()
        return bool(gone)

    def offer(self, text: str) -> None:
        """Send a message of the topic now, send it after the interval, or drop it."""
        requests, loop = self.requests.values(), asyncio.get_running_loop()
        size = min((one.fragment_size for one in requests if one.fragment_size), default=None)
        if not self._interval or (loop.time() >= self._free_at and self._timer is None):
            self._free_at = loop.time() + self._interval
            self._client.outbox.put(self._queue, text, size)
        # Within the interval, messages wait if the client requested a queue. Otherwise only the
        # next one after it is sent.
        elif self._queue_length:
            self._client.outbox.put(self._queue, text, size, held=True)
            if self._timer is None:
                self._timer = loop.call_at(self._free_at, self._release)

    @property
    def _interval(self) -> float:
        """Interval between messages in seconds."""
        return min(one.throttle_rate or 0.0 for one in self.requests.values()) / 1000

    def _release(self) -> None:
        loop, self._timer = asyncio.get_running_loop(), None
        if self._queue.held:
            self._client.outbox.release(self._queue)
            self._free_at = loop.time() + self._interval
        if self._queue.held:
            self._timer = loop.call_at(self._free_at, self._release)


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

    async def attend(
        self, texts: AsyncIterable[str | bytes], handle: Callable[[str | bytes], None]
    ) -> None:
        """Handle the messages of the client until its connection ends, and send the outbox."""
        sending = asyncio.create_task(self.send_forever())
        try:
            async for text in texts:
                handle(text)
                # Serve other clients, however much this one sends.
                await asyncio.sleep(0)
        except ConnectionClosed:
            pass
        finally:
            sending.cancel()
            with suppress(asyncio.CancelledError, ConnectionClosed):
                await sending

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
