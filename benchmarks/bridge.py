"""How late a bridge's messages are, and how soon a goal moves the person: wall-clock times.

    python benchmarks/bridge.py [--clients N] [--seconds S]

A session at speed 1 runs in this process. N clients that subscribe to /clock and
/ariac_human/state, and one that sends a goal every 0.3 s, run in another. The delay of a state is
counted from its simulated time, relative to the earliest state. The latency of a goal is the time
from its sending to the change of the person's motion.
"""

from __future__ import annotations

import argparse
import asyncio
import json
import statistics
import subprocess
import sys
import time

from websockets.asyncio.client import connect

import sim
from sim.bridge import Exchange, Session, Workcell

GOALS_EVERY = 0.3
TRIAL = "floorplan: ariac2023\nduration: {}\npeople: [{{name: operator, personality: external}}]\n"


async def serve(clients: int, duration: float) -> dict[str, object]:
    exchange = Exchange()
    workcell = Workcell(sim.Trial.parse(TRIAL.format(duration)), exchange)
    session = Session(workcell, exchange, speed=1.0, hold=True)
    moved: list[float] = []
    workcell.simulation.people[0].walker.body.on_change.append(
        lambda: moved.append(time.monotonic())
    )
    port = await session.open(port=0)
    arguments = ["--listen", f"ws://127.0.0.1:{port}", "--clients", str(clients)]
    other = await asyncio.create_subprocess_exec(
        sys.executable, __file__, *arguments, stdout=subprocess.PIPE, limit=2**30
    )
    begin = time.process_time()
    await session.run()
    cpu = time.process_time() - begin
    output, _ = await other.communicate()
    heard = json.loads(output)
    return {"moved": moved, "cpu_share": cpu / duration, **heard}


async def listen(url: str, clients: int) -> None:
    """Run all clients. Print when each received each message, and when each goal was sent."""
    arrivals: list[list[tuple[float, float]]] = [[] for _ in range(clients)]
    sent: list[float] = []
    ready = asyncio.Semaphore(0)

    async def hear(times: list[tuple[float, float]]) -> None:
        async with connect(url, compression=None) as socket:
            for topic in ("/clock", "/ariac_human/state"):
                subscription = {"op": "subscribe", "topic": topic, "queue_length": 1000}
                await socket.send(json.dumps(subscription))
            await socket.send(json.dumps({"op": "call_service", "service": "/rosapi/nodes"}))
            await socket.recv()
            ready.release()
            now = 0.0
            while True:
                heard = json.loads(await socket.recv())
                if heard.get("topic") == "/clock":
                    clock = heard["msg"]["clock"]
                    now = clock["sec"] + clock["nanosec"] / 1e9
                else:
                    times.append((now, time.monotonic()))

    async def drive() -> None:
        async with connect(url, compression=None) as socket:
            await socket.send('{"op":"subscribe","topic":"/ariac/start_human"}')
            for _ in range(clients):
                await ready.acquire()
            await socket.send('{"op":"call_service","service":"/ariac/start_competition"}')
            async for text in socket:
                if "start_human" in text:
                    break
            goal = 0
            while True:
                await asyncio.sleep(GOALS_EVERY)
                goal += 1
                point = {"x": -10.8, "y": -3.75 if goal % 2 else 3.75}
                text = json.dumps(
                    {"op": "publish", "topic": "/ariac_human/goal_position", "msg": point}
                )
                sent.append(time.monotonic())
                await socket.send(text)

    await asyncio.gather(drive(), *map(hear, arrivals), return_exceptions=True)
    print(json.dumps({"arrivals": arrivals, "sent": sent}))


def report(result: dict[str, object]) -> None:
    arrivals: list[list[tuple[float, float]]] = result["arrivals"]  # type: ignore[assignment]
    moved: list[float] = result["moved"]  # type: ignore[assignment]
    counts = {len(times) for times in arrivals}
    delays = [wall - simulated for times in arrivals for simulated, wall in times]
    earliest = min(delays)
    late = sorted(delay - earliest for delay in delays)
    latencies = sorted(
        next(t for t in moved if t >= sent) - sent
        for sent in result["sent"]  # type: ignore[attr-defined]
        if moved[-1] >= sent
    )
    print(f"states heard by each client: {min(counts)} … {max(counts)}")
    print(
        f"lateness of {len(late)} states: median {statistics.median(late) * 1e3:.1f} ms,"
        f" 99.9 % {late[int(len(late) * 0.999)] * 1e3:.1f} ms, worst {late[-1] * 1e3:.1f} ms"
    )
    print(
        f"latency of {len(latencies)} goals: median {statistics.median(latencies) * 1e3:.1f} ms,"
        f" worst {latencies[-1] * 1e3:.1f} ms"
    )
    print(f"CPU time of the session: {result['cpu_share']:.0%} of one core")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--clients", type=int, default=200)
    parser.add_argument("--seconds", type=float, default=30.0)
    parser.add_argument("--listen", help=argparse.SUPPRESS)
    options = parser.parse_args()
    if options.listen:
        asyncio.run(listen(options.listen, options.clients))
    else:
        report(asyncio.run(serve(options.clients, options.seconds)))


if __name__ == "__main__":
    main()
