"""Guard of one machine: the safety function that its protective fields trip."""

from __future__ import annotations

import math
from collections.abc import Iterable

from floorplan import UserError

from ...core.body import Machine
from ...core.clock import Alarm, Turn
from ...core.events import (
    FieldFree,
    FieldOccupied,
    FieldSlowdown,
    FieldSlowdownEnded,
    FieldsMuted,
    FieldStop,
    FieldStopEnded,
    FieldsUnmuted,
)
from ...core.fields import MachineFields
from ...core.stage import Bystander, Stage
from ..monitors import Pair, PersonWatches
from .muting import MutingWatch
from .reaction import Reaction
from .watch import MOMENT, FieldWatch

PROTECTIVE, WARNING = "protective", "warning"
"""The fields of a set."""

INTRUSION, BLIND, NO_SET = "intrusion", "blackout", "no field set"
"""Causes of a stop: a person, a blackout, and a velocity without field set."""

LATER = 1e-6
"""Seconds. A machine that moves for longer than its stop takes has not obeyed."""

STOPPED = "protective field"
"""Reason for which a machine is held while its protective field is occupied."""

TOO_FAST = "warning field"
"""Reason for which a machine that cannot slow down is held while its warning field is occupied."""


class FieldGuard:
    """Stops and slows a machine while people are in its fields, whatever its controller commands.

    After an intrusion into the protective field, the machine continues for the response time, then
    brakes and stands until the field has been free for the restart delay. The field set depends on
    the velocity, so a stationary machine has the set for standstill. A blackout and a velocity
    without field set trip the guard like an intrusion. An intrusion into the warning field limits
    the speed, after the same response time and with the same restart delay.
    """

    def __init__(
        self,
        stage: Stage,
        machine: Machine,
        fields: MachineFields,
        people: Iterable[tuple[Bystander, float, PersonWatches]],
    ) -> None:
        self.machine = machine
        self._stage = stage
        self._clock = stage.clock
        self._fields = fields
        self._watches: list[FieldWatch] = []
        for person, radius, watches in people:
            watch = FieldWatch(Pair(stage, person, machine), fields, radius, self._changed)
            watches.add(watch.row, watch.alarm, watch.reconsider)
            self._watches.append(watch)
        zones = (zone for zone in stage.floorplan.zones if zone.name in fields.muting.zones)
        self._muting = MutingWatch(machine.body, zones, fields.muting.times, self._mute)
        self._unprotected = False
        """Whether no field set applies to the velocity."""
        self._stop = Reaction(stage.clock, fields, self._begin_stop, self._end_stop)
        self._slowdown = Reaction(stage.clock, fields, self._begin_slowdown, self._end_slowdown)
        self._stop_ends = math.inf
        """End of the braking of a stopped machine, seconds."""
        self._gap = Alarm(stage.clock, self._find_gaps, Turn.VIOLATION)
        machine.body.on_change.append(self._machine_changed)

    def begin(self) -> None:
        """Begin to watch. People who are in a field already trip it at once."""
        self._machine_changed()
        for reaction in (self._stop, self._slowdown):
            reaction.trip()

    def sight_changed(self) -> None:
        """Handle the begin or end of a blackout."""
        self._decide()

    @property
    def figures(self) -> dict[str, float]:
        """Number of stops until now, and the seconds in which it was stopped, or only slow."""
        stops = self._stop.intervals
        slow = 0.0
        for begin, end in self._slowdown.intervals:
            stopped = sum(max(0.0, min(end, t) - max(begin, since)) for since, t in stops)
            slow += end - begin - stopped
        return {
            "field_stops": len(stops),
            "field_stop_time": sum((end - begin for begin, end in stops), 0.0),
            "field_slow_time": slow,
        }

    def _machine_changed(self) -> None:
        self._muting.reconsider()
        self._find_gaps()
        for watch in self._watches:
            watch.reconsider()
        self._stop.rests_from(self.machine.body.motion.end)
        if self._stop.active:
            self._require_stop()

    def _require_stop(self) -> None:
        """Raise `UserError` if the machine moves on beyond its stop."""
        now, motion = self._clock.now, self.machine.body.motion
        moves = any(not piece.stands for piece in motion.pieces_from(now))
        if moves and motion.end > self._stop_ends + LATER:
            raise UserError(
                f"the machine {self.machine.name!r} drives on at t = {now:g} s although its"
                " protective fields stop it, which no controller can switch off"
            )

    def _find_gaps(self) -> None:
        """Compute whether a field set applies to the velocity, and when that changes."""
        now, machine = self._clock.now, self.machine
        end = max(now, machine.body.motion.end) + 1.0
        spans = self._fields.protective.applying(machine.body.motion, now, end, machine.loaded)
        unprotected, change = False, None
        for span in spans:
            if span.begin <= now + MOMENT < span.end:
                unprotected = span.set is None
            elif span.begin > now and (span.set is None) != unprotected:
                change = span.begin
                break
        self._gap.set(change)
        if unprotected != self._unprotected:
            self._unprotected = unprotected
            self._decide()

    def _mute(self) -> None:
        muted = self._muting.active
        name = self.machine.name
        self._stage.record(FieldsMuted(machine=name) if muted else FieldsUnmuted(machine=name))
        for watch in self._watches:
            watch.mute(muted)
        self._decide()

    def _changed(self, watch: FieldWatch, before: dict[str, str]) -> None:
        """Record that a person entered or left fields, and react."""
        names = {"machine": self.machine.name, "person": watch.person}
        for field in (PROTECTIVE, WARNING):
            if field in watch.occupied and field not in before:
                self._stage.record(FieldOccupied(**names, field=field, set_=watch.occupied[field]))
            elif field in before and field not in watch.occupied:
                self._stage.record(FieldFree(**names, field=field, set_=before[field]))
        self._decide(watch.person)

    def _decide(self, person: str = "") -> None:
        """Update the triggers of both reactions. `person` has caused a new one, if any."""
        if self._stage.blind[self.machine.name] > 0:
            self._stop.become(BLIND, "")
        elif self._unprotected and not self._muting.active:
            self._stop.become(NO_SET, "")
        else:
            self._stop.become(INTRUSION if self._is_occupied(PROTECTIVE) else "", person)
        self._slowdown.become(INTRUSION if self._is_occupied(WARNING) else "", person)

    def _is_occupied(self, field: str) -> bool:
        return any(field in watch.occupied for watch in self._watches)

    def _begin_stop(self, cause: str, person: str) -> None:
        name = self.machine.name
        self._stage.record(FieldStop(machine=name, cause=cause, person=person or None))
        self._stop_ends = math.inf
        self.machine.stand_for(STOPPED, True)
        self._stop_ends = self.machine.body.motion.end

    def _end_stop(self) -> None:
        self._stage.record(FieldStopEnded(machine=self.machine.name))
        self.machine.stand_for(STOPPED, False)

    def _begin_slowdown(self, _: str, person: str) -> None:
        self._stage.record(FieldSlowdown(machine=self.machine.name, person=person))
        if not self.machine.limit_speed(self._fields.warning_speed):
            self.machine.stand_for(TOO_FAST, True)

    def _end_slowdown(self) -> None:
        self._stage.record(FieldSlowdownEnded(machine=self.machine.name))
        if not self.machine.limit_speed(None):
            self.machine.stand_for(TOO_FAST, False)
