"""Bytes that are held for clients: counted, and limited for each of them and for all together.

A count is of what Python takes for it, near enough: texts by their size in memory, and a flat
figure for every object around them, so that many small things cost as much as they do.
"""

from __future__ import annotations

import sys
from collections.abc import Callable

MOST_FOR_ONE = 8_000_000
"""Bytes. A client for which more is held is let go."""

MOST_FOR_ALL = 128_000_000
"""Bytes. Where more is held for all clients, the one with the most is let go."""

_PLACE = 100
"""Bytes. The place that a text takes in a queue, beside its own."""


def size_of(text: str) -> int:
    """Return the bytes that a text takes where it waits."""
    return sys.getsizeof(text) + _PLACE


class Ledger:
    """The accounts of all clients, and limits in bytes for each and for all of them."""

    def __init__(
        self, *, most_for_one: int = MOST_FOR_ONE, most_for_all: int = MOST_FOR_ALL
    ) -> None:
        self.most_for_one = most_for_one
        self.most_for_all = most_for_all
        self.held = 0
        self.accounts: dict[Account, None] = {}


class Account:
    """What is held for one client, in bytes.

    `let_go(why)` is called, once, when that gets too much. From then on nothing is counted, and
    nothing must be kept for the client any more.
    """

    def __init__(self, ledger: Ledger, let_go: Callable[[str], None]) -> None:
        self.held = 0
        self.let_go = let_go
        self._ledger = ledger
        ledger.accounts[self] = None

    @property
    def is_closed(self) -> bool:
        """Whether the client has gone or is let go."""
        return self not in self._ledger.accounts

    def add(self, size: int) -> None:
        """Count `size` bytes more, or less where it is negative."""
        if self.is_closed:
            return
        ledger = self._ledger
        self.held += size
        ledger.held += size
        if self.held > ledger.most_for_one:
            self.refuse(f"more than {ledger.most_for_one} bytes are held for this client")
        elif ledger.held > ledger.most_for_all:
            greatest = max(ledger.accounts, key=lambda account: account.held)
            greatest.refuse(
                f"more than {ledger.most_for_all} bytes are held for all clients,"
                " and most of them for this one"
            )

    def refuse(self, why: str) -> None:
        """Let the client go, unless it has gone already."""
        if not self.is_closed:
            self.close()
            self.let_go(why)

    def close(self) -> None:
        """Count nothing any more: the client has gone."""
        if not self.is_closed:
            del self._ledger.accounts[self]
            self._ledger.held -= self.held
            self.held = 0
