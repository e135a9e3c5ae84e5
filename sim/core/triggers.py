"""Conditions that things wait for: a time, or something that happens."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from .clock import Clock
from .recorder import Event
from .start import Start

Action = Callable[[], None]


@dataclass
class _Waiting:
    """Somebody waits for `start`, and has seen it `seen` times."""

    start: Start
    who: str | None
    action: Action
    seen: int = 0


class Triggers:
    """Calls each action once, when its condition is met."""

    def __init__(self, clock: Clock) -> None:
        self._clock = clock
        self._waiting: list[_Waiting] = []
        self._each: dict[str, list[Callable[[Event], None]]] = {}

    def add(self, start: Start, action: Action, who: str | None = None) -> None:
        """Call `action` at the time of `start`, or as soon as what it names has happened.

        `who` is the person who waits.
        """
        if start.time is not None:
            self._clock.call_at(start.time, action)
        else:
            self._waiting.append(_Waiting(start, who, action))

    def each(self, kind: str, action: Callable[[Event], None]) -> None:
        """Call `action` with every event of this kind from now on."""
        self._each.setdefault(kind, []).append(action)

    def notify(self, event: Event) -> None:
        """Call the actions that have waited for the event, in the order of their waiting."""
        for told in self._each.get(event["kind"], ()):
            told(event)
        due = []
        for waiting in self._waiting:
            if _is(event, waiting.start, waiting.who):
                waiting.seen += 1
                if waiting.seen == waiting.start.count:
                    due.append(waiting)
        if due:
            # Off the list before any action, which may wait for something, or cause events, itself.
            self._waiting = [waiting for waiting in self._waiting if waiting not in due]
        for waiting in due:
            waiting.action()


def _is(event: Event, start: Start, who: str | None) -> bool:
    kind: str = event["kind"]
    if start.event is not None:
        person = start.person or who
        return kind == start.event and event.get("person", person) == person
    if start.order_submitted is not None:
        return kind == "order_submitted" and start.order_submitted == str(event["order"])
    if start.part_placed is None or kind != "job_done" or event["job"] != "pick_place":
        return False
    return start.part_placed.items() <= {"part": event["part"], "agv": event["to"]}.items()
