"""What tests of the bridge share: a session in a thread, and a plain client over a socket."""

import asyncio
import json
import threading
import time
from contextlib import contextmanager

from websockets.sync.client import connect

import sim
from sim.bridge import Exchange, RosbridgeServer, Session, Workcell, listen_at

TRIAL = """
floorplan: ariac2023
duration: {duration}
people: [{{name: operator, personality: {personality}, start: {{time: {start}}}}}]
gantry: {{controller: {controller}, at: [-2.5, 0.5, 0.0]}}
agvs: {{agv1: [{{time: 30.0, to: assembly_front}}]}}
"""


def trial(personality="external", duration=275.0, start=0.0, controller="parked"):
    text = TRIAL.format(
        personality=personality, duration=duration, start=start, controller=controller
    )
    return sim.Trial.parse(text)


class Served:
    """A session under way: where it is, what it said, and what came of it."""

    def __init__(self, a_trial, listeners, speed, hold):
        self.exchange = Exchange()
        self.workcell = Workcell(a_trial, self.exchange, *listeners)
        self.notices = []
        self.url = None
        self.failure = None
        self.cpu = 0.0
        self._opened = threading.Event()
        self._loop = asyncio.new_event_loop()
        self._task = None
        self._thread = threading.Thread(target=self._run, args=(speed, hold), daemon=True)
        self._thread.start()
        assert self._opened.wait(30)

    def _run(self, speed, hold):
        async def main():
            self.session = Session(
                self.workcell, self.exchange, speed=speed, hold=hold, notice=self._hear
            )
            self._task = asyncio.current_task()
            await self.session.open(port=0)
            await self.session.run()

        try:
            self._loop.run_until_complete(main())
        except asyncio.CancelledError:
            pass
        except Exception as why:
            self.failure = why
        finally:
            self.cpu = time.thread_time()
            self._loop.close()

    def _hear(self, text):
        self.notices.append(text)
        if text.startswith("serving "):
            self.url = text.removeprefix("serving ")
            self._opened.set()

    @property
    def now(self):
        return self.workcell.now

    def do(self, action):
        """Run `action` in the session's own thread, and hand its result over."""

        async def run():
            return action()

        return asyncio.run_coroutine_threadsafe(run(), self._loop).result(30)

    def join(self, timeout=120):
        """Wait for the end; the run."""
        self._thread.join(timeout)
        assert not self._thread.is_alive(), f"still at t = {self.now} s: {self.notices}"
        if self.failure is not None:
            raise self.failure
        return self.workcell.simulation.finish()

    def stop(self):
        if self._thread.is_alive():
            self._loop.call_soon_threadsafe(self._task.cancel)
            self._thread.join(30)


@contextmanager
def served(a_trial=None, *listeners, speed=0.0, hold=False):
    """A session of the bridge for `a_trial`, on a free port of this machine."""
    session = Served(a_trial or trial(), listeners, speed, hold)
    try:
        yield session
    finally:
        session.stop()


@contextmanager
def relay(**options):
    """A rosbridge server with no simulation behind it: clients hear each other. Its address.

    `options` are those of a server.
    """
    loop = asyncio.new_event_loop()
    opened = threading.Event()
    address = []

    async def main():
        server = RosbridgeServer(Exchange(), left=lambda _: None, failed=print, **options)
        at = listen_at("127.0.0.1", 0)
        await server.open(at)
        address.append(f"ws://127.0.0.1:{at.getsockname()[1]}")
        opened.set()
        try:
            await asyncio.Event().wait()
        finally:
            await server.close()

    task = loop.create_task(main())

    def run():
        try:
            loop.run_until_complete(task)
        except asyncio.CancelledError:
            loop.close()

    thread = threading.Thread(target=run, daemon=True)
    thread.start()
    assert opened.wait(30)
    try:
        yield address[0]
    finally:
        loop.call_soon_threadsafe(task.cancel)
        thread.join(30)


class Client:
    """A client that says and hears exactly what it is told to."""

    def __init__(self, url, **options):
        options = {"compression": None, "max_size": None, "close_timeout": 0.5, **options}
        self._connection = connect(url, **options)

    def __enter__(self):
        self.socket = self._connection.__enter__()
        return self

    def __exit__(self, *why):
        self._connection.__exit__(*why)

    def send(self, **operation):
        self.socket.send(json.dumps(operation))

    def publish(self, topic, **message):
        self.send(op="publish", topic=topic, msg=message)

    def subscribe(self, *topics, **options):
        for topic in topics:
            self.send(op="subscribe", topic=topic, **options)

    def hear(self, timeout=20.0):
        """The next thing that the server says."""
        return json.loads(self.socket.recv(timeout))

    def hear_until(self, is_it, timeout=20.0):
        """The first thing that the server says of which `is_it` holds."""
        deadline = time.monotonic() + timeout
        while True:
            said = self.hear(max(deadline - time.monotonic(), 0.0))
            if is_it(said):
                return said

    def message(self, topic, timeout=20.0):
        """The next message on `topic`."""
        said = self.hear_until(lambda said: said.get("topic") == topic, timeout)
        return said["msg"]

    def call(self, service, **arguments):
        """The answer of a service: whether it worked, and its values."""
        self.send(op="call_service", service=service, args=arguments, id="a call")
        said = self.hear_until(lambda said: said["op"] == "service_response")
        return said["result"], said["values"]

    def error(self, timeout=20.0):
        """What the server has to complain about next."""
        return self.hear_until(lambda said: said["op"] == "status", timeout)


def require_whole(folder):
    """Every file of a recording can be read, to its last line."""
    json.loads((folder / "summary.json").read_text())
    for name in ("events.jsonl", "motions.jsonl"):
        lines = (folder / name).read_text().splitlines()
        assert lines
        for line in lines:
            json.loads(line)
    assert json.loads(lines[-1])["end"] > 0
    assert (folder / "replay.html").stat().st_size > 10_000
