"""The bytes that are held for clients: counted, and limited for each and for all together.

A count is close to the memory that Python uses: texts by their size in memory, and a flat figure
for every object around them, so that many small things cost as much as they do.
"""

from __future__ import annotations

import sys
from collections.abc import Callable

_PLACE = 100
"""Bytes. The memory that a text takes in a queue, beside its own."""


def size_of(text: str) -> int:
    """Return the bytes that a text takes where it waits."""
    return sys.getsizeof(text) + _PLACE


class Ledger:
    """The accounts of all clients.

    A client for which more than `most_for_one` bytes are held is disconnected. So is the one for
    which the most are held, where they are more than `most_for_all` for all clients.
    """

    def __init__(self, *, most_for_one: int = 8_000_000, most_for_all: int = 128_000_000) -> None:
        self.most_for_one = most_for_one
        self.most_for_all = most_for_all
        self.held = 0
        self.accounts: dict[Account, None] = {}


class Account:
    """The bytes that are held for one client.

    `let_go(why)` is called, once, when there are too many. From then on nothing is counted, and
    nothing must be kept for the client any more.
    """

    def __init__(self, ledger: Ledger, let_go: Callable[[str], None]) -> None:
        self.held = 0
        self.let_go = let_go
        self._ledger = ledger
        ledger.accounts[self] = None

    @property
    def is_closed(self) -> bool:
        """Whether the client has gone or is being disconnected."""
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
        """Disconnect the client, unless that is under way."""
        if not self.is_closed:
            self.close()
            self.let_go(why)

    def close(self) -> None:
        """Count nothing any more, since the client has gone."""
        if not self.is_closed:
            del self._ledger.accounts[self]
            self._ledger.held -= self.held
            self.held = 0
