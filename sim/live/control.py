"""Control of a run from its page: pause, speed, and commands.

Requests come in the threads of the page's server and are answered in the thread of the run, between
two of its steps: what is done in a run has one order, and an instant of simulated time.
"""

from __future__ import annotations

import threading
from collections.abc import Callable
from dataclasses import dataclass, field
from queue import Empty, SimpleQueue
from typing import Any

from ..core.tempo import checked_speed

Answer = dict[str, Any]
"""Answer to a request: `problem`, where it can't be done, in words."""

PATIENCE = 10.0
"""Seconds that a request waits for the run to come to it."""

OVER = "the run is over"


class Pace:
    """The tempo of a run that goes by the wall's clock.

    `now()` is real time in seconds. Simulated time begins at 0 when it is first looked at.
    """

    def __init__(self, speed: float, now: Callable[[], float]) -> None:
        self.paused = False
        self._speed = checked_speed(speed)
        self._now = now
        self._at = 0.0
        self._since: float | None = None

    @property
    def speed(self) -> float:
        """Seconds of the run in a second of real time."""
        return self._speed

    def target(self) -> float:
        """Return how far the run should be now (seconds of simulated time)."""
        now = self._now()
        if self._since is not None and not self.paused:
            self._at += (now - self._since) * self._speed
        self._since = now
        return self._at

    def change(self, *, speed: float | None = None, paused: bool | None = None) -> None:
        """Go on with another speed, pause, or go on after a pause; None leaves it as it is."""
        wanted = self._speed if speed is None else checked_speed(speed)
        self.target()
        self._speed = wanted
        self.paused = self.paused if paused is None else paused


@dataclass
class _Request:
    wish: Any
    answered: threading.Event = field(default_factory=threading.Event)
    answer: Answer = field(default_factory=dict)


class Requests:
    """Requests that wait for the run to come to them."""

    def __init__(self) -> None:
        self._waiting: SimpleQueue[_Request] = SimpleQueue()
        self._closed = False

    def ask(self, wish: Any) -> Answer:
        """Return the answer to a wish; called in any thread, it waits for the run."""
        request = _Request(wish)
        self._waiting.put(request)
        if self._closed:
            return {"problem": OVER}
        if not request.answered.wait(PATIENCE):
            return {"problem": "the run does not answer"}
        return request.answer

    def answer(self, carry_out: Callable[[Any], Answer]) -> None:
        """Answer all that wait, in their order."""
        while True:
            try:
                request = self._waiting.get_nowait()
            except Empty:
                return
            request.answer = carry_out(request.wish)
            request.answered.set()

    def close(self) -> None:
        """Answer no more: the run is over."""
        self._closed = True
        self.answer(lambda _: {"problem": OVER})
