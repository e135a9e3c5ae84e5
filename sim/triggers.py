"""Conditions that things wait for: a time, or something that happens."""

from __future__ import annotations

from collections.abc import Callable

from .clock import Clock
from .recorder import Event
from .trial import Start

Action = Callable[[], None]


class Triggers:
    """Does things when what they wait for happens, each once."""

    def __init__(self, clock: Clock) -> None:
        self._clock = clock
        self._waiting: list[tuple[Start, Action]] = []

    def add(self, start: Start, action: Action) -> None:
        """Call `action` at the time of `start`, or as soon as what it names has happened."""
        if start.time is not None:
            self._clock.call_at(start.time, action)
        else:
            self._waiting.append((start, action))

    def heed(self, event: Event) -> None:
        """Something has happened: call what has waited for it, in the order of the waiting."""
        called = [waiting for waiting in self._waiting if _is(event, waiting[0])]
        self._waiting = [waiting for waiting in self._waiting if waiting not in called]
        for _, action in called:
            action()


def _is(event: Event, start: Start) -> bool:
    kind: str = event["kind"]
    if start.order_submitted is not None:
        return kind == "order_submitted" and start.order_submitted == str(event["order"])
    if start.part_placed is None or kind != "job_done" or event["job"] != "pick_place":
        return False
    return start.part_placed.items() <= {"part": event["part"], "agv": event["to"]}.items()
