"""AGVs: they drive along their lanes when the trial says so, and may yield to people."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

from floorplan import Lane
from navigation import (
    AxisState,
    agv_run,
    agv_stop,
    lane_state,
    required_at_speeds,
)

from ...core.body import Body
from ...core.clock import Alarm, Clock, Turn
from ...core.events import AgvMoved, AgvYielded
from ...core.recorder import Record
from ...core.rules import RuleSet
from ...core.scenario import AgvMove
from .yielding import LOOK, Foresight, Sighting

RESUME = 1.0
"""Seconds. An AGV that yields sets out if it may drive for so long; else it would creep."""


class Agv:
    """One AGV on its lane. `stopped(agv)` is called whenever it has come to rest.

    With `foresight` it yields: it looks where people are ten times a second, and stops on its
    lane while it still can before anybody comes too close, whatever they do. It drives on when
    the way is clear.
    """

    def __init__(
        self,
        clock: Clock,
        lane: Lane,
        moves: tuple[AgvMove, ...],
        *,
        record: Record,
        stopped: Callable[[Agv], None],
        foresight: Foresight | None = None,
    ) -> None:
        at = AxisState(lane.locations[lane.start])
        self.lane = lane
        self.body = Body(clock, lane.name, "agv", agv_run(lane, at, at.position, clock.now))
        self._clock = clock
        self._record = record
        self._stopped = stopped
        self._foresight = foresight
        self._target: str | float | None = None
        self._under_way_to: str | float | None = None
        self._has_said = False
        self._held = False
        self._arrival = Alarm(clock, self._arrive, Turn.MOTION_ENDS)
        self._looking = Alarm(clock, self._look, Turn.MOTION_ENDS)
        for move in moves:
            clock.call_at(move.time, partial(self.drive, move.to))

    @property
    def lane_position(self) -> float:
        """Where it is on its lane now, metres."""
        return lane_state(self.lane, self.body.state).position

    @property
    def stands(self) -> bool:
        """Whether it is at rest, and nothing makes it set out."""
        return self.body.motion.end <= self._clock.now and self._target is None

    def look_out_for(self, person: Body, top_speed: float) -> None:
        """If it yields, it does so to this person, who walks at `top_speed` (m/s) at most."""
        if self._foresight is not None:
            self._foresight.watch(person, top_speed)
            person.on_jump.append(self._look)

    def zone(self, rules: RuleSet, top_speed: float) -> float:
        """How far (metres) from its centre somebody must stand so that it can set out.

        Under `rules`, for somebody who may walk at `top_speed` (m/s).
        """
        fastest = self.lane.max_speed
        if self._foresight is None:
            return required_at_speeds(rules.agv_law, 0.0, fastest) + abs(rules.agv_offset)
        stopping = fastest / self.lane.max_acceleration
        kept = required_at_speeds(rules.agv_law, top_speed, fastest) + abs(rules.agv_offset)
        return kept + top_speed * (RESUME + stopping)

    def drive(self, to: str | float) -> None:
        """Set out for a location or a lane position, from whatever it is doing now."""
        self._target = to
        if self._held:
            return
        hindered = self._try()
        if hindered is not None and self._under_way_to is None:
            self._wait(hindered)
        # While it still drives elsewhere, it goes on till it looks: until then stopping is safe.

    def hold(self, stands: bool) -> None:
        """Brake and stand until `hold(False)`, then go on: a protective stop."""
        self._held = stands
        if stands:
            self._looking.set(None)
            self._stop()
        elif self._target is not None:
            self.drive(self._target)

    def _try(self) -> Sighting | None:
        """Set out for the target, or tell who is in the way."""
        target, now = self._target, self._clock.now
        assert target is not None
        motion = agv_run(self.lane, lane_state(self.lane, self.body.state), target, now)
        if self._foresight is not None:
            drives = self._under_way_to is not None
            hindered = self._foresight.in_the_way(motion, now, LOOK if drives else RESUME)
            if hindered is not None:
                return hindered
            self._looking.set(now + LOOK)
        self._record(AgvMoved(agv=self.lane.name, to=target, arrives=motion.end))
        self._under_way_to, self._has_said = target, False
        self.body.follow(motion)
        self._arrival.set(motion.end)
        return None

    def _look(self) -> None:
        """Go on, stop, or set out again, as people allow."""
        now, motion = self._clock.now, self.body.motion
        if self._foresight is None or self._target is None or self._held:
            return
        if self._under_way_to == self._target:
            hindered = self._foresight.in_the_way(motion, now, LOOK)
        else:
            hindered = self._try()
        if hindered is None:
            self._looking.set(now + LOOK)
        else:
            self._wait(hindered)

    def _wait(self, hindered: Sighting) -> None:
        """Stop, or go on standing, until the way is clear."""
        self._stop()
        if not self._has_said:
            self._has_said = True
            self._record(
                AgvYielded(
                    agv=self.lane.name,
                    person=hindered.name,
                    distance=hindered.distance,
                    required=hindered.required,
                )
            )
        self._looking.set(self._clock.now + LOOK)

    def _stop(self) -> None:
        """Brake, if it drives."""
        if self._under_way_to is not None:
            self._under_way_to = None
            state = lane_state(self.lane, self.body.state)
            stop = agv_stop(self.lane, state, self._clock.now)
            self.body.follow(stop)
            self._arrival.set(stop.end)

    def _arrive(self) -> None:
        if self._under_way_to == self._target:
            self._target = None
            self._looking.set(None)
        self._under_way_to = None
        self._stopped(self)
