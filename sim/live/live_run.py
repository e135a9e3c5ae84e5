"""Live run in a browser: pause, speed and commands from its page.

Requests arrive in the threads of the page server and are answered in the thread of the run between
two steps, so that each has a place in the order of events and a simulated time.

The page gets current motions in closed form. It draws them as smoothly as a recording, and the
simulation has nothing to send until a motion changes. Its viewers can pause the run, change its
speed, and send commands.
"""

from __future__ import annotations

import json
import math
import threading
import time
from collections.abc import Callable, Mapping
from dataclasses import field
from functools import partial
from queue import Empty, SimpleQueue
from typing import Any

from pydantic import ValidationError
from typing_extensions import override

from floorplan import UserError
from floorplan.files.dataclass import dataclass
from navigation import Motion, standing

from ..cell.pace import Pace, checked_speed
from ..core.body import Body
from ..core.clock import InProgress
from ..core.entries import COMMANDS
from ..core.recorder import Event, Listener, Scene, Thought, rounded
from ..core.scenario import TrialError
from ..runs.run import Recorded, Run
from ..simulation import Simulation
from ..trials.keys import read_command
from ..views.replay import render
from ..views.replay_data import piece_data, replay_data
from .page_server import MessageStream, PageServer

Answer = dict[str, Any]
"""Answer to a request. `problem` is the reason of a rejection."""

REQUEST_PATIENCE = 10.0
"""Seconds in which the run answers a request."""

OVER = "the run is over"


@dataclass
class _Request:
    wish: Any
    answered: threading.Event = field(default_factory=threading.Event)
    answer: Answer = field(default_factory=dict)


class Requests:
    """Requests that wait for an answer of the run."""

    def __init__(self) -> None:
        self._waiting: SimpleQueue[_Request] = SimpleQueue()
        self._closed = False

    def ask(self, wish: Any) -> Answer:
        """Return the answer to a request of the page. Any thread may call this and wait for it."""
        request = _Request(wish)
        self._waiting.put(request)
        if self._closed:
            return {"problem": OVER}
        if not request.answered.wait(REQUEST_PATIENCE):
            return {"problem": "the run does not answer"}
        return request.answer

    def answer(self, carry_out: Callable[[Any], Answer]) -> None:
        """Answer all waiting requests in order."""
        while True:
            try:
                request = self._waiting.get_nowait()
            except Empty:
                return
            request.answer = carry_out(request.wish)
            request.answered.set()

    def close(self) -> None:
        """Stop answering, because the run is over."""
        self._closed = True
        self.answer(lambda _: {"problem": OVER})


PERIOD = 0.1
"""Seconds of real time between two steps of a run that is watched."""

BROWSER_PATIENCE = 10.0
"""Seconds to wait for a browser that was opened, and for the last message to get there."""

MILLISECONDS = 1000.0
"""Commands take effect at the next whole millisecond, so that files have short numbers."""


class LiveRun(InProgress, Listener):
    """Server of a page that shows a run while it is simulated.

    It is a listener of a `Simulation`, and the page exists once that has started. Browsers may
    connect and disconnect at any time. Viewers can pause the run, change its speed, and send
    commands (`Simulation.command`).

    Parameters
    ----------
    duration : float
        Duration of the trial in seconds.
    speed : float, optional
        Simulated seconds per second of real time.
    now : callable, optional
        Function that returns real time in seconds. Pass your own clock to control the progress of
        the run. The default is `time.monotonic`.

    Raises
    ------
    ValueError
        If `speed` is not a finite number above 0.
    """

    wants_thoughts = True

    def __init__(
        self, duration: float, *, speed: float = 1.0, now: Callable[[], float] = time.monotonic
    ) -> None:
        self._speed = checked_speed(speed)
        self._now = now
        self._pace: Pace | None = None
        self._duration = duration
        self._stream = MessageStream()
        self._page = ""
        self._violations: list[list[tuple[float, float]]] = []
        self._requests = Requests()
        self.server = PageServer(
            lambda: self._page, stream=self._stream, control=self._requests.ask
        )

    @property
    def speed(self) -> float:
        """Simulated seconds per second of real time, unless the run is paused."""
        return self._speed if self._pace is None else self._pace.speed

    @override
    def begin(self, scene: Scene) -> None:
        people = [person.name for person in scene.people]
        machines = [name for name in scene.starts if name not in people]
        nothing = Recorded(
            scene=scene,
            duration=self._duration,
            summary={},
            events=(),
            motions={
                name: standing((x, y), heading=rotation)
                for name, (x, y, rotation) in scene.starts.items()
            },
            violations={(person, machine): () for person in people for machine in machines},
        )
        self._page = render(replay_data(nothing), stream="stream", speed=self.speed)

    @override
    def event(self, event: Event) -> None:
        self._send(event=event)

    @override
    def thought(self, thought: Thought) -> None:
        self._send(thought=thought)

    def advance(self, simulation: Simulation) -> None:
        """Run to the end at the speed set by the page, or until the simulation is stopped.

        Parameters
        ----------
        simulation : Simulation
            Simulation of which this is a listener.
        """
        simulation.start()
        pace = Pace(simulation, speed=self._speed, now=self._now)
        self.follow(simulation, pace)
        try:
            while not pace.over:
                time.sleep(PERIOD)
                self._answer(simulation)
                pace.catch_up()
                self._send_changes(simulation)
            pace.check()
        finally:
            self.leave()

    def follow(self, simulation: Simulation, pace: Pace) -> None:
        """Show a started run that the caller advances.

        The caller calls `attend` regularly between two steps, and `leave` at the end.

        Parameters
        ----------
        simulation : Simulation
            Simulation of which this is a listener.
        pace : Pace
            Pace of the run. The page can change it.
        """
        self._pace = pace
        for body in simulation.bodies:
            self._plan(body, simulation)
            body.on_change.append(partial(self._plan, body, simulation))

    def attend(self, simulation: Simulation) -> None:
        """Carry out commands of viewers and send changes to the page.

        Parameters
        ----------
        simulation : Simulation
            Simulation of which this is a listener.
        """
        self._answer(simulation)
        self._send_changes(simulation)

    def leave(self) -> None:
        """Stop carrying out commands of viewers."""
        self._requests.close()

    def _answer(self, simulation: Simulation) -> None:
        self._requests.answer(partial(self._carry_out, simulation))

    def wait_for_viewer(self) -> None:
        """Wait until a browser that was just opened has connected."""
        self._stream.wait_for_reader(BROWSER_PATIENCE)

    def finish(self, run: Run) -> None:
        """Send the whole recording to all viewers and wait until they have received it.

        Parameters
        ----------
        run : Run
            Finished run.
        """
        self._stream.send(json.dumps(replay_data(run)), event="finished")
        self._stream.close()
        self._stream.wait_until_read(BROWSER_PATIENCE)

    def _carry_out(self, simulation: Simulation, wish: Any) -> Answer:
        """Carry out a request: {"pace": {…}}, or {"command": {…}} without the time."""
        try:
            match wish:
                case {"pace": {**changes}} if self._pace is not None and changes.keys() <= {
                    "speed",
                    "paused",
                }:
                    self._pace.change(**_checked(changes))
                    self._send(pace={"speed": self.speed, "paused": self._pace.paused})
                    return {}
                case {"command": {**keys}}:
                    now = simulation.clock.now
                    at = (math.floor(now * MILLISECONDS) + 1) / MILLISECONDS
                    simulation.command(read_command({**keys, "time": at}))
                    return {"t": at}
        except TrialError as why:
            return {"problem": "; ".join(problem.message for problem in why.problems)}
        except ValidationError as why:
            return {"problem": why.errors()[0]["msg"].removeprefix("Value error, ")}
        except UserError as why:
            return {"problem": str(why)}
        return {"problem": f"expected a pace or a command: {', '.join(COMMANDS)}"}

    def _plan(self, body: Body, simulation: Simulation) -> None:
        now = simulation.clock.now
        plan: Motion = body.motion.cut(now, max(now, body.motion.end))
        pieces = [piece_data(piece) for piece in plan.pieces]
        self._send(motion={"body": body.name, "pieces": pieces})

    def _send_changes(self, simulation: Simulation) -> None:
        violations = [watch.known for watch in simulation.referee.watches]
        for number, intervals in enumerate(violations):
            if number >= len(self._violations) or intervals != self._violations[number]:
                self._send(violations={"watch": number, "intervals": intervals})
        self._violations = violations
        self._send(now=simulation.clock.now)

    def _send(self, **message: Any) -> None:
        self._stream.send(json.dumps(rounded(message)))


def _checked(changes: Mapping[Any, Any]) -> dict[str, Any]:
    """Return changes of the pace. `ValueError` for values of other types."""
    speed, paused = changes.get("speed"), changes.get("paused")
    if not (speed is None or (isinstance(speed, int | float) and not isinstance(speed, bool))):
        raise UserError(f"speed must be a number, not {speed!r}")
    if not (paused is None or isinstance(paused, bool)):
        raise UserError(f"paused must be true or false, not {paused!r}")
    return {"speed": speed, "paused": paused}
