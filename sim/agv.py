"""AGVs: they drive along their lanes when the trial says so."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

from floorplan import Lane
from navigation import AxisState, agv_run, lane_state

from .body import Body
from .clock import Alarm, Clock, Turn
from .recorder import Record
from .trial import AgvMove


class Agv:
    """One AGV on its lane. `stopped(agv)` is called whenever it has come to rest."""

    def __init__(
        self,
        clock: Clock,
        lane: Lane,
        moves: tuple[AgvMove, ...],
        *,
        record: Record,
        stopped: Callable[[Agv], None],
    ) -> None:
        at = AxisState(lane.locations[lane.start])
        self.lane = lane
        self.body = Body(clock, lane.name, "agv", agv_run(lane, at, at.position, clock.now))
        self._clock = clock
        self._record = record
        self._stopped = stopped
        self._arrival = Alarm(clock, self._arrive, Turn.MOTION_ENDS)
        for move in moves:
            clock.call_at(move.time, partial(self.drive, move.to))

    @property
    def lane_position(self) -> float:
        """Where it is on its lane now, metres."""
        return lane_state(self.lane, self.body.state).position

    @property
    def stands(self) -> bool:
        """Whether it is at rest, and nothing makes it set out."""
        return self.body.motion.end <= self._clock.now

    def drive(self, to: str | float) -> None:
        """Set out for a location or a lane position, from whatever it is doing now."""
        now = self._clock.now
        motion = agv_run(self.lane, lane_state(self.lane, self.body.state), to, now)
        self._record("agv_moved", agv=self.lane.name, to=to, arrives=motion.end)
        self.body.follow(motion)
        self._arrival.set(motion.end)

    def _arrive(self) -> None:
        self._stopped(self)
