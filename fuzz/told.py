"""What is no crash: an error that tells the user, in a message of a fair length, what is wrong."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

OURS = ("floorplan", "navigation", "bdi", "sim")
LONGEST = 20_000
"""Characters. A longer message drowns what it says."""


@contextmanager
def told(*others: type[Exception]) -> Iterator[None]:
    """Let pass what tells the user of bad input: errors of our packages, and `others` themselves.

    `AssertionError` where the message is empty or endless.
    """
    try:
        yield
    except Exception as why:
        ours = type(why).__module__.partition(".")[0] in OURS
        if not (ours or type(why) in others):
            raise
        message = str(why)
        assert message.strip(), f"{type(why).__name__} says nothing"
        assert len(message) <= LONGEST, f"{type(why).__name__} says too much: {len(message)}"
