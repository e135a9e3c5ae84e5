"""A run in the browser while it goes on.

The page gets the plans of the moment, in closed form: it draws them as smoothly as a recording,
and the simulation has nothing to do until a plan changes.
"""

from __future__ import annotations

import json
import time
from functools import partial
from typing import Any

from navigation import Motion, standing

from ..core.body import Body
from ..core.recorder import Event, Listener, Thought, rounded
from ..core.scene import Scene
from ..runs.run import Recorded, Run
from ..simulation import Simulation
from ..views.replay import render
from ..views.replay_data import piece_data, replay_data
from .page_server import PageServer, Stream

PERIOD = 0.1
"""Seconds of real time between two steps of a run that is watched."""

PATIENCE = 10.0
"""Seconds to wait for a browser that was opened, and for the last message to get there."""


class LiveRun(Listener):
    """Serves a page that shows a run of `duration` (seconds) while it is advanced.

    It is a listener of the `Simulation`; there is a page once that has started. Browsers may come
    and go.
    """

    wants_thoughts = True

    def __init__(self, duration: float, *, speed: float = 1.0) -> None:
        if not 0 < speed < float("inf"):
            raise ValueError(f"speed must be more than 0, not {speed:g}")
        self.speed = speed
        self._duration = duration
        self._stream = Stream()
        self._page = ""
        self._violations: list[list[tuple[float, float]]] = []
        self.server = PageServer(lambda: self._page, stream=self._stream)

    def begin(self, scene: Scene) -> None:
        """Make the page, in which nothing has happened yet."""
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

    def event(self, event: Event) -> None:
        """Send an event to the page."""
        self._send(event=event)

    def thought(self, thought: Thought) -> None:
        """Send a person's thought to the page."""
        self._send(thought=thought)

    def advance(self, simulation: Simulation) -> None:
        """Run to the end at `speed`, or until it is stopped."""
        simulation.start()
        for body in simulation.bodies:
            self._plan(body, simulation)
            body.on_change.append(partial(self._plan, body, simulation))
        begun = time.monotonic()
        while not (simulation.over or simulation.stopped):
            time.sleep(PERIOD)
            simulation.advance((time.monotonic() - begun) * self.speed)
            self._send_changes(simulation)

    def wait_for_viewer(self) -> None:
        """Wait until a browser that was just opened reads the stream."""
        self._stream.wait_for_reader(PATIENCE)

    def finish(self, run: Run) -> None:
        """Send the whole recording to all viewers, and wait until they have it."""
        self._stream.send(json.dumps(replay_data(run)), event="finished")
        self._stream.close()
        self._stream.wait_until_read(PATIENCE)

    def _plan(self, body: Body, simulation: Simulation) -> None:
        now = simulation.clock.now
        plan: Motion = body.motion.cut(now, max(now, body.motion.end))
        pieces = [piece_data(piece) for piece in plan.pieces]
        self._send(motion={"body": body.name, "pieces": pieces})

    def _send_changes(self, simulation: Simulation) -> None:
        known = [watch.known for watch in simulation.referee.watches]
        for number, intervals in enumerate(known):
            if number >= len(self._violations) or intervals != self._violations[number]:
                self._send(violations={"watch": number, "intervals": intervals})
        self._violations = known
        self._send(now=simulation.clock.now)

    def _send(self, **message: Any) -> None:
        self._stream.send(json.dumps(rounded(message)))
