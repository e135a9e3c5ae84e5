"""Record of what happened inside an agent."""

from __future__ import annotations

from collections import deque
from collections.abc import Iterator
from dataclasses import dataclass

KINDS = ("percept", "plan", "action", "print", "log", "ended", "warning")
"""Kinds of entries."""


@dataclass(frozen=True)
class Entry:
    """One thing that happened inside an agent.

    Attributes:
        time: time at which it happened (s).
        kind: one of `KINDS`.
        text: the event, action or message.
        intention: number of the intention it belongs to, 0 for none.
        file: file of the program with the step it belongs to, if any.
        line: line in that file, from 1; 0 for none.
    """

    time: float
    kind: str
    text: str
    intention: int = 0
    file: str = ""
    line: int = 0

    def __str__(self) -> str:
        place = f"  ({self.file}:{self.line})" if self.line else ""
        number = f"#{self.intention}" if self.intention else ""
        return f"{self.time:10.3f}  {number:>4}  {self.kind:<8} {self.text}{place}"


class History:
    """Record of the last entries: `Agent(…, on_event=history.add)`.

    Args:
        limit: number of entries that are kept.
    """

    def __init__(self, limit: int = 10_000) -> None:
        self._entries: deque[Entry] = deque(maxlen=limit)

    def add(self, entry: Entry) -> None:
        """Append an entry, and drop the oldest if there are too many."""
        self._entries.append(entry)

    def __repr__(self) -> str:
        return f"<History of {len(self)} entries>"

    def __iter__(self) -> Iterator[Entry]:
        return iter(self._entries)

    def __len__(self) -> int:
        return len(self._entries)
