"""What happened inside an agent, to look at afterwards."""

from __future__ import annotations

from collections import deque
from collections.abc import Iterator
from dataclasses import dataclass


@dataclass(frozen=True)
class Entry:
    """One thing that happened at `time` (s).

    `kind` is one of percept, plan, action, print, ended, warning; `intention`
    is its number, 0 when there is none; file and line say where in the program.
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
    """Keeps the last entries: `Agent(…, on_event=history.add)`."""

    def __init__(self, limit: int = 10_000) -> None:
        self._entries: deque[Entry] = deque(maxlen=limit)

    def add(self, entry: Entry) -> None:
        """Keeps one entry more, and lets go of the oldest if there are too many."""
        self._entries.append(entry)

    def __iter__(self) -> Iterator[Entry]:
        return iter(self._entries)

    def __len__(self) -> int:
        return len(self._entries)
