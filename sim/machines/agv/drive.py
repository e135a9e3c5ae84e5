"""Drive of an AGV: runs on its lane, which end before closed parts and slow down in slow ones."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import NamedTuple

from simpy.events import Event
from typing_extensions import override

from floorplan import Lane, Point, UserError
from navigation import Motion, agv_run, agv_stop
from navigation.machines import AxisState, agv_stops, lane_state, longest_stop
from navigation.motion import State

from ...core.body import Body
from ...core.entries import Pose
from ...core.events import AgvBlocked, AgvMoved
from ...core.speed_zones import SLIGHT, Stretch, slow_areas
from ...core.stage import Stage
from ..commanding import Drive, Move
from .lanes import Span, last_before, part_behind, part_within, run_slowly

ON_LANE = 1e-3
"""Metres and radians. Tolerance of targets beside the lane."""


class ClosedPart(NamedTuple):
    """The first closed part on the path of an AGV: its name, and the last position before it."""

    name: str
    at: float


class LaneDrive(Drive):
    """Drive of an AGV, which begins and resumes its moves at once.

    `rested` is called at the end of each run and stop, and `set_out` after the begin of each move.
    `permits` returns whether the AGV may follow a motion now. If not, the move waits for the next
    `retry`.
    """

    def __init__(
        self,
        stage: Stage,
        lane: Lane,
        *,
        disabled_or_enabled: Callable[[str], None],
        rested: Callable[[], None],
    ) -> None:
        at = AxisState(lane.locations[lane.start])
        body = Body(stage.clock, lane.name, "agv", agv_run(lane, at, at.position, stage.clock.now))
        super().__init__(stage.clock, body, disabled_or_enabled=disabled_or_enabled)
        self.lane = lane
        self.stops = agv_stops(lane)
        self.top_speed = lane.max_speed
        self.stopping_distance = longest_stop(lane).distance
        self.to: str | float | None = None
        """Target of the current move: a location or a lane position (m)."""
        self.permits: Callable[[Motion], bool] = lambda _: True
        self.set_out: Callable[[], None] = lambda: None
        self._stage = stage
        self._rested = rested
        self._rest: tuple[Motion | None, float] = (None, 0.0)
        """The motion on which it has come to rest, and its lane position there (m)."""
        self._last_stop: Motion | None = None
        self._block: ClosedPart | None = None
        zones = stage.floorplan.zones
        self._slow = [
            Stretch(*span, limit)
            for area, limit in slow_areas(zones, lane.name)
            for span in [part_within(lane, area)]
            if span is not None
        ]
        self._forbidden = [
            (zone.name, part)
            for zone in zones
            if zone.forbidden and zone.is_about(lane.name)
            for part in [part_within(lane, zone.area)]
            if part is not None
        ]
        self._gates = [gate for gate in stage.floorplan.one_ways if gate.is_about(lane.name)]

    @property
    def position(self) -> float:
        """Position on the lane now (m)."""
        motion = self.body.motion
        if motion is self._rest[0]:
            return self._rest[1]
        position = lane_state(self.lane, self.body.state).position
        if motion.end <= self._clock.now:
            self._rest = motion, position
        return position

    @property
    def goal(self) -> Point | None:
        """The position (x, y) at which the current move ends, or waits before a closed part."""
        if self.to is None:
            return None
        return self.lane.position(self.lane.lane_position(self._goal))

    @property
    def _goal(self) -> str | float:
        assert self.to is not None
        return self.to if self._block is None else self._block.at

    @property
    def runs(self) -> bool:
        """Whether it follows a run, and neither brakes nor rests."""
        motion = self.body.motion
        return motion.end > self._clock.now and motion is not self._last_stop

    @property
    def is_on_move(self) -> bool:
        """Whether it follows a run of the current move."""
        return self._move is not None and self._move.moves

    @override
    def destination(self, target: Sequence[float]) -> Pose:
        x, y, *rotation = target
        q = self.lane.along((x, y))
        beside = math.dist(self.lane.position(q), (x, y))
        turn = math.remainder(rotation[0] - self.lane.heading, math.tau) if rotation else 0.0
        if beside > ON_LANE or abs(turn) > ON_LANE:
            raise UserError(f"{self.lane.name} cannot leave its lane for {(*target,)}")
        return (*self.lane.position(self.lane.lane_position(q)), self.lane.heading)

    @override
    def move(
        self,
        target: Pose,
        speed_share: float = 1.0,
        *,
        resume: bool = True,
        command: int | None = None,
    ) -> Event:
        return self.go(self.lane.along(target[:2]), speed_share, resume=resume)

    def go(self, to: str | float, speed_share: float = 1.0, *, resume: bool = True) -> Move:
        """Start to move to a location or a lane position (m). Return the end of the move."""
        goal = self.lane.position(self.lane.lane_position(to))
        self.begin()
        self.to = to
        self.last_move = (*goal, self.lane.heading), speed_share

        def run() -> Motion | None:
            return self._run(speed_share)

        motion = None if self.disabled else run()
        move = self._move = Move(self, run if resume else None, run)
        if motion is not None:
            move.follow(motion)
            move.proceed()
        self.set_out()
        return move

    @override
    def follow(self, motion: Motion, again: Callable[[], Motion] | None = None) -> Event:
        raise UserError(f"{self.lane.name} follows its lane only; use drive or move_to")

    @override
    def stopping(self, state: State, t: float) -> Motion:
        return agv_stop(self.lane, lane_state(self.lane, state), t)

    @override
    def _planned(self, target: tuple[float, ...], speed_share: float) -> Motion:
        return self.run_to(self.lane.along((target[0], target[1])), speed_share)

    def run_to(self, to: str | float, speed_share: float = 1.0) -> Motion:
        """Return the run from the present state to a location or a lane position (m)."""
        top = min(self._limit, self.lane.max_speed * speed_share)
        lane = self.lane if top >= self.lane.max_speed else replace(self.lane, max_speed=top)
        state, now = lane_state(self.lane, self.body.state), self._clock.now
        if self._slow:
            return run_slowly(lane, state, lane.lane_position(to), now, self._slow)
        return agv_run(lane, state, to, now)

    def run_to_goal(self, speed_share: float = 1.0) -> Motion:
        """Return the run of the current move, or a stop if it cannot stop before a closed part."""
        motion = self.run_to(self._goal, speed_share)
        if self._block is not None:
            state, now = lane_state(self.lane, self.body.state), self._clock.now
            stop = agv_stop(self.lane, state, now)
            rest = lane_state(self.lane, stop.state(stop.end)).position
            if (rest - self._block.at) * state.velocity > 0:
                return stop
        return motion

    def _run(self, speed_share: float) -> Motion | None:
        """Return the run of the current move, or None if it must wait."""
        before, self._block = self._block, self._next_block()
        if self._block is not None:
            if not _same(self._block, before):
                name, at = self._block
                self._stage.record(AgvBlocked(agv=self.lane.name, by=name, at=at))
            at_rest = lane_state(self.lane, self.body.state).velocity == 0
            if at_rest and abs(self.position - self._block.at) < SLIGHT:
                return None
        motion = self.run_to_goal(speed_share)
        if not self.permits(motion):
            return None
        arrives = motion.end
        self._stage.record(AgvMoved(agv=self.lane.name, to=self._goal, arrives=arrives))
        return motion

    def _next_block(self) -> ClosedPart | None:
        """Return the first closed part on the path to the target."""
        closures = self._stage.active_closures
        if self.to is None or not (closures or self._forbidden or self._gates):
            return None
        lane, at, to = self.lane, self.position, self.lane.lane_position(self.to)
        parts: list[tuple[str, Span | None]] = [*self._forbidden]
        parts += [(gate.name, part_behind(lane, gate, at, to)) for gate in self._gates]
        parts += [
            (closure.name, part_within(lane, closure.footprint))
            for closure in closures.values()
            if closure.overlaps(0.0, lane.height)
        ]
        blocks = [
            ClosedPart(name, q)
            for name, part in parts
            if part is not None and (q := last_before(part, at, to)) is not None
        ]
        return min(blocks, key=lambda block: abs(block.at - at), default=None)

    def floor_changed(self) -> None:
        """Continue or stop if a part of the lane has been opened or closed."""
        if self.to is not None and not self.disabled and not _same(self._next_block(), self._block):
            self.retry()

    def retry(self) -> None:
        """Start the run of the current move again."""
        if self._move is not None:
            self._move.pause()
            self._move.proceed()

    def brake(self) -> None:
        """Brake, and wait for the next `retry`."""
        if self.runs:
            self._follow_stop()
            if self._move is not None:
                self._move.pause()
            self._arrival.set(self.body.motion.end)

    @override
    def pauses(self, move: Move) -> bool:
        return self._block is not None

    @override
    def _brake(self) -> None:
        if self.runs:
            super()._brake()
            self._arrival.set(self.body.motion.end)
        else:
            self._interrupt_waits()

    @override
    def _follow_stop(self) -> None:
        self._last_stop = self.stopping(self.body.state, self._clock.now)
        self.body.follow(self._last_stop)

    @override
    def _release(self) -> None:
        disabled = self.disabled
        super()._release()
        if disabled and not self.disabled and self._move is not None:
            self._move.proceed()

    @override
    def when_released(self, move: Move) -> None:
        """Do nothing, because `_release` continues the move at once."""

    @override
    def await_arrival(self, t: float | None) -> None:
        if t is not None:  # the end of each motion counts, also after the end of its move
            self._arrival.set(t)

    @override
    def ended(self) -> None:
        super().ended()
        self.to = None

    @override
    def _arrived(self) -> None:
        super()._arrived()
        self._rested()


def _same(one: ClosedPart | None, other: ClosedPart | None) -> bool:
    if one is None or other is None:
        return one is other
    return one.name == other.name and abs(one.at - other.at) < SLIGHT
