"""Cancelled sessions end, also if something happens at the moment of the cancellation."""

import asyncio
import gc

import pytest
from bridge_parts import Exchange, Session, Workcell, trial

from sim.bridge.client import done_within


async def cancelled_as_it_happens(waiting, happens):
    """Cancel a waiting task in the same turn of the loop in which its event happens."""
    task = asyncio.create_task(waiting)
    for _ in range(3):
        await asyncio.sleep(0)
    happens()
    task.cancel()
    await asyncio.wait({task}, timeout=10.0)
    assert task.done(), "it goes on"
    with pytest.raises(asyncio.CancelledError):
        await task


def test_a_wait_is_cancelled_though_its_event_is_set():
    async def main():
        event = asyncio.Event()
        await cancelled_as_it_happens(done_within(event.wait(), 60.0), event.set)

    asyncio.run(main())


def test_a_session_is_cancelled_though_it_has_changed():
    async def main():
        exchange = Exchange()
        session = Session(Workcell(trial(), exchange), exchange, hold=True)
        await session.open(port=0)
        await cancelled_as_it_happens(session.run(), exchange.changed)

    asyncio.run(main())


def test_a_wait_ends_with_its_time_and_leaves_no_task():
    async def main():
        event = asyncio.Event()
        assert not await done_within(event.wait(), 0.001)
        await asyncio.sleep(0)
        assert asyncio.all_tasks() == {asyncio.current_task()}
        event.set()
        assert await done_within(event.wait(), 60.0)

    asyncio.run(main())
    gc.collect()


def test_an_error_of_the_awaited_event_is_raised():
    async def fail():
        raise OSError("gone")

    with pytest.raises(OSError, match="gone"):
        asyncio.run(done_within(fail(), 60.0))
