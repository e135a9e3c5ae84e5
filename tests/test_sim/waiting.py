"""Waiting for conditions, and clocks that only a test moves."""

import asyncio
import selectors
import threading
import time

HANG = 300.0
"""s. A longer wait is a hang, even on a busy machine."""


def until(holds, process=None, message=lambda: ""):
    """Wait until `holds` returns a true value, and return it.

    A `process` must run meanwhile. `message()` is the message of a failure.
    """
    hangs_at = time.monotonic() + HANG
    while not (result := holds()):
        assert time.monotonic() < hangs_at, message()
        assert process is None or process.poll() is None, message()
        time.sleep(0.01)
    return result


class Hand:
    """Real time (s) of a run that a test paces. Only `move` advances it."""

    def __init__(self):
        self._time = 0.0
        self._is_looked_at = threading.Event()

    def __call__(self):
        self._is_looked_at.set()
        return self._time

    def move(self, seconds):
        """Advance the time once the run has read it."""
        assert self._is_looked_at.wait(HANG)
        self._time += seconds


class HandLoop(asyncio.SelectorEventLoop):
    """Event loop whose time (s) only `move` advances, so that its timers wait for the test.

    Each reading also adds a nanosecond, because a constant time would keep a rounding error
    forever.
    """

    def __init__(self):
        self._hand = 0.0
        self._when_idle = []
        self._moves = []
        super().__init__(_Selector(self._when_idle))

    def time(self):
        self._hand += 1e-9
        return self._hand

    def move(self, seconds):
        """Advance the time, and wait until everything due by then is done."""
        done = threading.Event()
        self._moves[:] = [done]
        self.call_soon_threadsafe(self._move, seconds, done)
        assert done.wait(HANG)

    def _move(self, seconds, done):
        self._hand += seconds
        self._when_idle.append(done)

    def close(self):
        super().close()
        for done in self._moves:
            done.set()


class _Selector(selectors.DefaultSelector):
    """Selector that reports an idle loop, and then waits only for messages."""

    def __init__(self, when_idle):
        super().__init__()
        self._when_idle = when_idle

    def select(self, timeout=None):
        ready = super().select(0)
        if ready or timeout == 0:
            return ready
        while self._when_idle:
            self._when_idle.pop().set()
        return super().select()
