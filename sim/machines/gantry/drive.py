"""Drive of a gantry: its moves and stops, and the times in which it is disabled."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import replace

from typing_extensions import override

from floorplan import Gantry, UserError
from navigation import Motion, gantry_move, gantry_stop, join, standing
from navigation.machines import AxisLimits, gantry_limits, gantry_stops, longest_stop
from navigation.motion import State

from ...core.body import Body
from ...core.clock import Alarm, Clock, Turn
from ...core.entries import Pose
from ...core.events import GantryDisabled, GantryEnabled, RobotMalfunction
from ...core.recorder import Record
from ..commanding import Drive

THERE = 1e-6
"""Metres. Tolerance of passing places."""


class GantryDrive(Drive):
    """Drive of a gantry, which also counts the time for which it was disabled."""

    def __init__(
        self,
        clock: Clock,
        gantry: Gantry,
        at: Pose,
        *,
        name: str,
        record: Record,
        disabled_or_enabled: Callable[[str], None],
    ) -> None:
        body = Body(clock, name, "gantry", standing(at[:2], heading=at[2]))
        super().__init__(clock, body, disabled_or_enabled=disabled_or_enabled)
        self.disabled_time = 0.0
        self._gantry = gantry
        self._limits = gantry_limits(gantry)
        self._slower = {1.0: self._limits}
        """Limits by share of the top speeds."""
        self.stops = gantry_stops(self._limits)
        self.top_speed = math.hypot(gantry.x.max_speed, gantry.y.max_speed)
        self.stopping_distance = longest_stop(self._limits).distance
        self._record = record
        self._disabled_at: float | None = None
        self._passing: tuple[Pose, Pose] | None = None
        """Passing place on the way to a target, and the target."""
        self._ready = Alarm(clock, self._enable, Turn.MOTION_ENDS)

    @override
    def destination(self, target: Sequence[float]) -> Pose:
        x, y, *rotation = target
        return (x, y, rotation[0] if rotation else self.body.state.position[2])

    @override
    def _planned(self, target: tuple[float, ...], speed_share: float) -> Motion:
        pose = self.destination(target)
        if faults := self._gantry.faults(pose):
            raise UserError("; ".join(faults))
        limits = self._slower.get(speed_share)
        if limits is None:
            x, y, rotation = (
                replace(axis, max_speed=axis.max_speed * speed_share) for axis in self._limits
            )
            limits = self._slower[speed_share] = x, y, rotation
        return self._by_passing_place(pose, self._clock.now, limits)

    def let_pass_at(self, place: Pose, target: Pose) -> None:
        """Move to a target by a passing place from now on."""
        self._passing = place, target
        self._previews.clear()

    def _by_passing_place(
        self, target: Pose, now: float, limits: tuple[AxisLimits, AxisLimits, AxisLimits]
    ) -> Motion:
        """Return the motion to a target, by its passing place if there is one."""
        state = self.body.state
        if self._passing is not None and self._passing[1] == target:
            place, _ = self._passing
            if math.dist(state.at, place[:2]) > THERE:
                there = gantry_move(state, place, now, limits=limits)
                return join([there, gantry_move(place, target, there.end, limits=limits)])
        self._passing = None
        return gantry_move(state, target, now, limits=limits)

    def stopping(self, state: State, t: float) -> Motion:
        """Return the fastest stop from `state` at `t` (seconds)."""
        return gantry_stop(state, t, limits=self._limits)

    def disable(
        self, seconds: float, kind: type[GantryDisabled | RobotMalfunction] = GantryDisabled
    ) -> None:
        """Stop the gantry for `seconds`, and record an event of this `kind`."""
        self._record(kind(seconds=seconds))
        # The later end counts if there are two reasons at a time.
        self._ready.set(max(self._clock.now + seconds, self._ready.time or 0.0))
        if self._disabled_at is None:
            self._disabled_at = self._clock.now
        self._stop()

    def close(self) -> None:
        """Count the time of an unfinished stop at the end of the trial."""
        if self._disabled_at is not None:
            self.disabled_time += self._clock.now - self._disabled_at
        super().close()

    @property
    def _may_move(self) -> bool:
        return self._disabled_at is None and super()._may_move

    def _enable(self) -> None:
        assert self._disabled_at is not None
        self.disabled_time += self._clock.now - self._disabled_at
        self._disabled_at = None
        self._record(GantryEnabled())
        self._release()
