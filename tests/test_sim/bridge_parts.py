"""Parts of tests of the bridge: a session in a thread, and a plain client over a socket."""

import asyncio
import json
import signal
import threading
import time
from collections import deque
from contextlib import contextmanager, suppress

from processes import started
from waiting import HANG, HandLoop, until
from websockets.sync.client import connect

import sim
from sim.bridge import (
    AddressError as AddressError,
    BridgeError as BridgeError,
    ConnectError as ConnectError,
    Exchange,
    OriginError as OriginError,
    Origins as Origins,
    RemoteAgent as RemoteAgent,
    RosbridgeServer,
    Session,
    Workcell,
    listen_at,
)
from sim.bridge.client import LONGEST_QUEUE as LONGEST_QUEUE
from sim.bridge.protocol import Ledger as Ledger
from sim.people.minds import make_agent as make_agent

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


STEP = 1 / 16
"""Real time (s) of one step of a session by hand, exact in sums."""


class InThread:
    """Event loop in its own thread that runs `main(opened)`, which calls `opened()`."""

    def __init__(self, main, loop=None):
        self.failure = None
        self._loop = loop or asyncio.new_event_loop()
        self._opened = threading.Event()
        self._task = self._loop.create_task(main(self._opened.set))
        self._thread = threading.Thread(target=self._run, daemon=True)
        self._thread.start()
        assert self._opened.wait(HANG)

    def _run(self):
        try:
            self._loop.run_until_complete(self._task)
        except asyncio.CancelledError:
            pass
        except Exception as why:
            self.failure = why
        finally:
            self._loop.close()

    def do(self, action):
        """Run `action` in that thread and return its result."""

        async def run():
            return action()

        return asyncio.run_coroutine_threadsafe(run(), self._loop).result(HANG)

    def join(self, timeout):
        """Wait for the end of `main`. Return whether it has ended."""
        self._thread.join(timeout)
        return not self._thread.is_alive()

    def stop(self):
        if self._thread.is_alive():
            self._loop.call_soon_threadsafe(self._task.cancel)
            assert self.join(HANG), f"{self._thread} goes on after its task was cancelled"


class Served:
    """Session under way, with its address, its notices, and its run.

    If `by_hand`, time advances only in `move`, otherwise with the wall clock.
    """

    def __init__(self, a_trial, listeners, speed, hold, grace, viewer, by_hand):
        self._loop = HandLoop() if by_hand else None
        self.exchange = Exchange()
        self.workcell = Workcell(a_trial, self.exchange, *listeners)
        self.notices = []

        async def main(opened):
            self.session = Session(
                self.workcell,
                self.exchange,
                speed=speed,
                hold=hold,
                grace=grace,
                notice=self.notices.append,
                viewer=viewer,
            )
            self.url = f"ws://127.0.0.1:{await self.session.open(port=0)}"
            opened()
            await self.session.run()

        self._thread = InThread(main, self._loop)
        self.do, self.stop = self._thread.do, self._thread.stop

    @property
    def now(self):
        return self.workcell.now

    @property
    def time(self):
        """Real time (s) of a session by hand."""
        return self._loop.time()

    def move(self, seconds):
        """Advance the real time of a session by hand in short steps."""
        while seconds > 0 and not self._thread.join(0):
            with suppress(RuntimeError):  # it is over
                self._loop.move(min(seconds, STEP))
            seconds -= STEP

    def accompany(self, seconds):
        """Advance a session by hand, and wait until all clients have acted."""
        self.move(seconds)

        async def reached():
            for client in (*self.session.server.clients,) * 2:
                await self.session.server.reached(client, HANG)

        if not self._thread.join(0):
            reaching = reached()
            try:
                future = asyncio.run_coroutine_threadsafe(reaching, self._loop)
                until(lambda: future.done() or self._thread.join(0))
            except RuntimeError:
                reaching.close()  # it is over

    def join(self):
        """Wait for the end of the trial and return the run."""
        while self._loop is not None and not self._thread.join(0):
            self.move(STEP)
        assert self._thread.join(HANG), f"still at t = {self.now} s: {self.notices}"
        if self._thread.failure is not None:
            raise self._thread.failure
        return self.workcell.simulation.finish()


@contextmanager
def served(a_trial=None, *listeners, speed=0.0, hold=False, grace=0.0, viewer=None, by_hand=False):
    """Session of the bridge for `a_trial`, on a free port of this machine."""
    session = Served(a_trial or trial(), listeners, speed, hold, grace, viewer, by_hand)
    try:
        yield session
    finally:
        session.stop()


@contextmanager
def relay(port=0, **options):
    """Address of a rosbridge server without a simulation, on which clients hear each other.

    See `RosbridgeServer` for `options`.
    """
    at = listen_at("127.0.0.1", port)

    async def main(opened):
        server = RosbridgeServer(Exchange(), left=lambda _: None, failed=print, **options)
        await server.open(at)
        opened()
        try:
            await asyncio.Event().wait()
        finally:
            await server.close()

    thread = InThread(main)
    try:
        yield f"ws://127.0.0.1:{at.getsockname()[1]}"
    finally:
        thread.stop()


class Command:
    """`floorwalker bridge` in a separate process, with its address and its lines on stderr."""

    def __init__(self, folder, *arguments, **options):
        serve = () if "--connect" in arguments else ("--port", "0", "--out", "out")
        self.process = started("bridge", *arguments, *serve, cwd=folder, **options)
        self.notices = []
        self._listening = threading.Thread(target=self._listen, daemon=True)
        self._listening.start()

    def _listen(self):
        for line in self.process.stderr:
            self.notices.append(line.rstrip("\n"))

    def __enter__(self):
        return self

    def __exit__(self, *why):
        self.process.kill()
        self.finish()
        self.process.stdout.close()
        self.process.stderr.close()

    @property
    def url(self):
        """Address, once it is served."""
        (line,) = self.wait_for(lambda: [n for n in self.notices if n.startswith("serving")])
        return line.removeprefix("serving ")

    def wait_for(self, holds):
        """Wait until `holds` returns a true value, and return it."""
        return until(holds, self.process, lambda: self.notices)

    def interrupt(self):
        """Press Ctrl-C, and return the exit code."""
        self.process.send_signal(signal.SIGINT)
        return self.finish()[0]

    def finish(self):
        """Wait for the end, and return the exit code and the output."""
        printed = self.process.stdout.read()
        code = self.process.wait(HANG)
        self._listening.join(HANG)
        assert not self._listening.is_alive(), "stderr of the command stays open"
        return code, printed


class Client:
    """Client that sends exactly the given operations."""

    def __init__(self, url, **options):
        # Without a limit of its queue, a client also reads the end of the connection.
        limits = {"max_size": None, "max_queue": None, "close_timeout": 0.1}
        options = {"compression": None, **limits, **options}
        self._connection = connect(url, **{"open_timeout": HANG, **options})

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

    def settle(self):
        """Wait until all messages of this client are handled."""
        self.call("/nowhere")

    def hear(self, timeout=HANG):
        """Return the next operation of the server."""
        return json.loads(self.socket.recv(timeout))

    def hear_until(self, is_it):
        """Return the first operation of the server for which `is_it` holds."""
        hangs_at = time.monotonic() + HANG
        while not is_it(said := self.hear()):
            assert time.monotonic() < hangs_at, said
        return said

    def message(self, topic):
        """Return the next message on `topic`."""
        return self.hear_until(lambda said: said.get("topic") == topic)["msg"]

    def call(self, service, **arguments):
        """Return whether a service call has succeeded, and its values."""
        self.send(op="call_service", service=service, args=arguments, id="a call")
        said = self.hear_until(lambda said: said["op"] == "service_response")
        return said["result"], said["values"]

    def error(self):
        """Return the next status message of the server."""
        return self.hear_until(lambda said: said["op"] == "status")


class Pacer(Client):
    """Client of a session by hand, whose time advances while it waits for the server."""

    def __init__(self, session, step=STEP, **options):
        super().__init__(session.url, **options)
        self._session = session
        self._step = step
        self._heard = deque()

    def heard(self):
        """Return all operations that the server has sent until now."""
        self.send(op="call_service", service="/nowhere", id="settled")
        while (said := super().hear()).get("id") != "settled":
            self._heard.append(said)
        heard = [*self._heard]
        self._heard.clear()
        return heard

    def hear(self):
        if not self._heard:
            self._heard.extend(self.heard())
        while not self._heard:
            self._session.move(self._step)
            self._heard.extend(self.heard())
        return self._heard.popleft()


def require_whole(folder):
    """Require that each file of a recording can be read to its last line."""
    json.loads((folder / "summary.json").read_text())
    for name in ("events.jsonl", "motions.jsonl"):
        lines = (folder / name).read_text().splitlines()
        assert lines
        for line in lines:
            json.loads(line)
    assert json.loads(lines[-1])["end"] > 0
    assert (folder / "replay.html").stat().st_size > 10_000
