"""A client of the bridge: what it wants to hear, and what is on its way to it."""

from __future__ import annotations

import asyncio
from collections import deque
from collections.abc import Awaitable, Callable
from contextlib import suppress
from dataclasses import dataclass

from .outbox import LONGEST_QUEUE, USUAL_QUEUE, Item, NotReadingError, Outbox, Stream
from .protocol import LEVELS, Level, Reassembly, Subscribe, fragments, status


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
        self._free_at = 0.0
        self._timer: asyncio.TimerHandle | None = None

    @property
    def wishes(self) -> int:
        """How many subscriptions it stands for."""
        return len(self._wishes)

    def add(self, id: str | int | None, wish: Wish) -> None:
        """One subscription more."""
        self._wishes[id] = wish
        asked = max(one.queue for one in self._wishes.values())
        self._stream.limit = min(asked, LONGEST_QUEUE) if asked else USUAL_QUEUE
        self._held_back = deque(self._held_back, maxlen=min(asked, LONGEST_QUEUE))

    def remove(self, id: str | int | None) -> bool:
        """One subscription less, or with None all of them; whether there was one."""
        if id is None:
            found = bool(self._wishes)
            self._wishes.clear()
        else:
            found = self._wishes.pop(id, None) is not None
        if not self._wishes:
            self._client.outbox.drop(self._stream)
            self._held_back.clear()
            if self._timer is not None:
                self._timer.cancel()
        return found

    def offer(self, text: str) -> None:
        """A message of the topic: sent now, or when the interval is over, or not at all."""
        interval = min(wish.interval for wish in self._wishes.values())
        if not interval:
            self._send(text)
            return
        now = asyncio.get_running_loop().time()
        if now >= self._free_at and not self._held_back:
            self._free_at = now + interval
            self._send(text)
        elif self._held_back.maxlen:
            self._held_back.append(text)
            if self._timer is None:
                self._timer = asyncio.get_running_loop().call_at(self._free_at, self._catch_up)

    def _catch_up(self) -> None:
        self._timer = None
        if not self._held_back:
            return
        self._send(self._held_back.popleft())
        loop = asyncio.get_running_loop()
        self._free_at = loop.time() + min(wish.interval for wish in self._wishes.values())
        if self._held_back:
            self._timer = loop.call_at(self._free_at, self._catch_up)

    def _send(self, text: str) -> None:
        sizes = [wish.fragment_size for wish in self._wishes.values() if wish.fragment_size]
        self._client.post(self._stream, text, min(sizes, default=None))


class Client:
    """One connected client.

    `send(text)` sends; `let_go(why)` is called when it lets too much pile up.
    """

    def __init__(
        self, name: str, send: Callable[[str], Awaitable[None]], let_go: Callable[[str], None]
    ) -> None:
        self.name = name
        self.outbox = Outbox()
        self.subscriptions: dict[str, Subscription] = {}
        self.advertised: set[str] = set()
        self.level: Level = "error"
        self.reassembly = Reassembly()
        self.calls: set[asyncio.Future[None]] = set()
        self.heard = 0
        self._send = send
        self._let_go = let_go
        self._idle = asyncio.Event()
        self._idle.set()
        self._fragmented = 0

    def __repr__(self) -> str:
        return f"<client {self.name}>"

    def tell(self, level: Level, message: str, id: str | int | None = None) -> None:
        """Send a status message, if the client wants those of that level."""
        if LEVELS.index(level) <= LEVELS.index(self.level):
            self.answer(status(level, message, id))

    def answer(self, text: str, fragment_size: int | None = None) -> None:
        """Send something that isn't thrown away."""
        self._idle.clear()
        try:
            self.outbox.reply(self._cut(text, fragment_size))
        except NotReadingError as why:
            self._let_go(str(why))

    def post(self, stream: Stream, text: str, fragment_size: int | None) -> None:
        """Send a topic's message, or instead of it a newer one when this one is late."""
        self._idle.clear()
        try:
            self.outbox.put(stream, self._cut(text, fragment_size))
        except NotReadingError as why:
            self._let_go(str(why))

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
