"""Seeds of random draws: each thing in a trial has its own."""

from __future__ import annotations

import zlib


def seed_of(seed: int, what: str) -> int:
    """Return the seed for `what` in a trial with this `seed`: the same whatever else is there."""
    # Not `hash`, which is salted anew in every process.
    return zlib.crc32(f"{seed} {what}".encode())
