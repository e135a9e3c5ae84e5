"""A client of the bridge: what it wants to hear, and what is on its way to it."""

from __future__ import annotations

import asyncio
import sys
from collections import deque
from collections.abc import Awaitable, Callable
from contextlib import suppress
from dataclasses import dataclass

from .ledger import Account, size_of
from .outbox import LONGEST_QUEUE, USUAL_QUEUE, Item, Outbox, Stream
from .protocol import LEVELS, Level, Reassembly, Subscribe, fragments, status

_WISH, _SUBSCRIPTION, _ADVERTISED, _CALL = 500, 3000, 200, 4000
"""Bytes. The place that a client's wish takes, and so on."""


@dataclass(frozen=True)
class Wish:
    """How a client wants to hear of a topic: seconds between messages, messages kept, size."""

    interval: float
    queue: int
    fragment_size: int | None

    @classmethod
    def of(cls, request: Subscribe) -> Wish:
        """The wish of a subscription."""
        interval = (request.throttle_rate or 0.0) / 1000
        return cls(interval, request.queue_length or 0, request.fragment_size)


class Subscription:
    """A client's subscriptions to one topic, which it may have several of, as one stream.

    The most demanding of its wishes count: the shortest interval, the longest queue, the smallest
    fragments.
    """

    def __init__(self, topic: str, client: Client) -> None:
        self.topic = topic
        self._client = client
        self._wishes: dict[str | int | None, Wish] = {}
        self._stream = Stream(USUAL_QUEUE)
        self._held_back: deque[str] = deque()
        self._most_held_back = 0
        self._free_at = 0.0
        self._timer: asyncio.TimerHandle | None = None
        client.account.add(_SUBSCRIPTION)

    @property
    def wishes(self) -> int:
        """How many subscriptions it stands for."""
        return len(self._wishes)

    def add(self, id: str | int | None, wish: Wish) -> None:
        """One subscription more."""
        if id not in self._wishes:
            self._client.account.add(_cost(id))
        self._wishes[id] = wish
        asked = max(one.queue for one in self._wishes.values())
        self._stream.limit = min(asked, LONGEST_QUEUE) if asked else USUAL_QUEUE
        self._most_held_back = min(asked, LONGEST_QUEUE)
        while len(self._held_back) > self._most_held_back:
            self._release()

    def remove(self, id: str | int | None) -> bool:
        """One subscription less, or with None all of them; whether there was one."""
        gone = list(self._wishes) if id is None else [id] if id in self._wishes else []
        for one in gone:
            del self._wishes[one]
            self._client.account.add(-_cost(one))
        if not self._wishes:
            self._client.account.add(-_SUBSCRIPTION)
            self._client.outbox.drop(self._stream)
            while self._held_back:
                self._release()
            if self._timer is not None:
                self._timer.cancel()
        return bool(gone)

    def offer(self, text: str) -> None:
        """A message of the topic: sent now, or when the interval is over, or not at all."""
        if self._client.account.is_closed:
            return
        interval = min(wish.interval for wish in self._wishes.values())
        if not interval:
            self._send(text)
            return
        now = asyncio.get_running_loop().time()
        if now >= self._free_at and not self._held_back:
            self._free_at = now + interval
            self._send(text)
        elif self._most_held_back:
            if len(self._held_back) >= self._most_held_back:
                self._release()
            self._held_back.append(text)
            self._client.account.add(size_of(text))
            if self._timer is None:
                self._timer = asyncio.get_running_loop().call_at(self._free_at, self._catch_up)

    def _catch_up(self) -> None:
        self._timer = None
        if not self._held_back:
            return
        self._send(self._release())
        loop = asyncio.get_running_loop()
        self._free_at = loop.time() + min(wish.interval for wish in self._wishes.values())
        if self._held_back:
            self._timer = loop.call_at(self._free_at, self._catch_up)

    def _release(self) -> str:
        text = self._held_back.popleft()
        self._client.account.add(-size_of(text))
        return text

    def _send(self, text: str) -> None:
        sizes = [wish.fragment_size for wish in self._wishes.values() if wish.fragment_size]
        self._client.post(self._stream, text, min(sizes, default=None))


class Client:
    """One connected client: `send(text)` sends, `account` counts what is held for it."""

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
        self._idle = asyncio.Event()
        self._idle.set()
        self._fragmented = 0

    def __repr__(self) -> str:
        return f"<client {self.name}>"

    def advertise(self, topic: str) -> None:
        """The client publishes on a topic."""
        if topic not in self.advertised:
            self.advertised.add(topic)
            self.account.add(_ADVERTISED)

    def withdraw(self, topic: str) -> None:
        """The client doesn't publish on a topic any more."""
        if topic in self.advertised:
            self.advertised.remove(topic)
            self.account.add(-_ADVERTISED)

    def begin_call(self, call: asyncio.Future[None]) -> None:
        """A service call is under way, until it is done."""
        self.calls.add(call)
        self.account.add(_CALL)
        call.add_done_callback(self._end_call)

    def _end_call(self, call: asyncio.Future[None]) -> None:
        self.calls.discard(call)
        self.account.add(-_CALL)

    def clear(self) -> None:
        """Keep nothing of what was to be sent, or is not complete."""
        self.outbox.clear()
        self.reassembly.clear()

    def tell(self, level: Level, message: str, id: str | int | None = None) -> None:
        """Send a status message, if the client wants those of that level."""
        if LEVELS.index(level) <= LEVELS.index(self.level):
            self.answer(status(level, message, id))

    def answer(self, text: str, fragment_size: int | None = None) -> None:
        """Send something that isn't thrown away."""
        self._idle.clear()
        self.outbox.reply(self._cut(text, fragment_size))

    def post(self, stream: Stream, text: str, fragment_size: int | None) -> None:
        """Send a topic's message, or instead of it a newer one when this one is late."""
        self._idle.clear()
        self.outbox.put(stream, self._cut(text, fragment_size))

    async def send_forever(self) -> None:
        """Send what is to be sent, one after the other."""
        while True:
            if not self.outbox:
                self._idle.set()
            for piece in await self.outbox.get():
                await self._send(piece)

    @property
    def is_idle(self) -> bool:
        """Whether everything is sent."""
        return self._idle.is_set()

    async def idle(self, patience: float) -> bool:
        """Wait until everything is sent, `patience` seconds at most; whether it is."""
        with suppress(asyncio.TimeoutError):
            await asyncio.wait_for(self._idle.wait(), patience)
        return self._idle.is_set()

    def _cut(self, text: str, size: int | None) -> Item:
        if size is None or len(text) <= size:
            return (text,)
        self._fragmented += 1
        return tuple(fragments(text, size, f"{self.name}-{self._fragmented}"))


def _cost(id: str | int | None) -> int:
    """The bytes that a wish with that id takes."""
    return _WISH + sys.getsizeof(id)
