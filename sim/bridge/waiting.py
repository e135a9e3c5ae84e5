"""Waiting for a limited time in an event loop."""

from __future__ import annotations

import asyncio
from collections.abc import Awaitable
from typing import Any


async def done_within(awaitable: Awaitable[Any], seconds: float) -> bool:
    """Wait for at most `seconds`, then cancel `awaitable`. Return whether it was done before.

    Raises what it raises. In Python before 3.12, `asyncio.wait_for` swallows a cancellation of the
    caller at the moment at which the awaitable is done, so that the caller never ends.
    """
    task = asyncio.ensure_future(awaitable)
    try:
        await asyncio.wait({task}, timeout=seconds)
        if task.done():
            task.result()
            return True
        return False
    finally:
        task.cancel()
