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
from ..monitors import Pair
from .muting import MutingWatch
from .reaction import Reaction
from .watch import MOMENT, FieldWatch

PROTECTIVE, WARNING = "protective", "warning"
"""The fields of a set."""

INTRUSION, BLIND, NO_SET = "intrusion", "blackout", "no field set"
"""Causes of a stop: a person, sensors that see nothing, and a velocity without field set."""

LATER = 1e-6
"""Seconds. A machine that moves for longer than its stop takes drives on."""

STOPPED = "protective field"
"""The reason for which a machine is held while its protective field is occupied."""

TOO_FAST = "warning field"
"""The reason for which a machine is held that can't slow down for its warning field."""


class FieldGuard:
    """Stops and slows a machine while people are in its fields, whatever its controller commands.

    From an intrusion into the protective field, the machine goes on for the response time, then
    brakes and stands until all has been free for the restart delay. The field set that applies
    depends on how the machine moves, so a standing machine has that for standstill. A blackout, and
    a velocity to which no set applies, trip as an intrusion does. An intrusion into the warning
    field limits the speed after the same time, and until the same delay is over.
    """

    def __init__(
        self,
        stage: Stage,
        machine: Machine,
        fields: MachineFields,
        people: Iterable[tuple[Bystander, float]],
    ) -> None:
        self.machine = machine
        self.stops = 0
        """Number of stops by the protective field."""
        self._stage = stage
        self._clock = stage.clock
        self._fields = fields
        self._watches = [
            FieldWatch(Pair(stage, person, machine), fields, radius, self._changed)
            for person, radius in people
        ]
        zones = (zone for zone in stage.floorplan.zones if zone.name in fields.muting.zones)
        self._muting = MutingWatch(machine.body, zones, fields.muting.times, self._mute)
        self._unprotected = False
        """Whether no field set applies to how the machine moves."""
        self._stop = Reaction(stage.clock, fields, self._begin_stop, self._end_stop)
        self._slowdown = Reaction(stage.clock, fields, self._begin_slowdown, self._end_slowdown)
        self._counted_until = stage.clock.now
        self._stop_time = self._slow_time = 0.0
        self._stopped = self._slow = False
        self._stands_at = math.inf
        """When the machine stands that is stopped, seconds."""
        self._gap = Alarm(stage.clock, self._find_gaps, Turn.VIOLATION)
        machine.body.on_change.append(self._machine_changed)
        for watch in self._watches:
            watch.pair.person.body.on_change.append(watch.reconsider)

    def begin(self) -> None:
        """Begin to watch. Who is in a field now was there before: the machine does not set out."""
        self._machine_changed()
        for reaction in (self._stop, self._slowdown):
            reaction.trip()

    def sight_changed(self) -> None:
        """Handle the begin or end of a blackout."""
        self._decide()

    @property
    def figures(self) -> dict[str, float]:
        """Figures until now: stops, and the seconds in which it was stopped, or slow for people."""
        self._count_time()
        return {
            "field_stops": self.stops,
            "field_stop_time": self._stop_time,
            "field_slow_time": self._slow_time,
        }

    def _machine_changed(self) -> None:
        self._muting.reconsider()
        self._find_gaps()
        for watch in self._watches:
            watch.reconsider()
        self._stop.stands_from(self.machine.body.motion.end)
        if self._stopped:
            self._require_stop()

    def _require_stop(self) -> None:
        """Raise `UserError` if the machine moves on beyond its stop."""
        now, motion = self._clock.now, self.machine.body.motion
        moves = any(not piece.stands for piece in motion.pieces_from(now))
        if moves and motion.end > self._stands_at + LATER:
            raise UserError(
                f"the machine {self.machine.name!r} drives on at t = {now:g} s although its"
                " protective fields stop it, which no controller can switch off"
            )

    def _find_gaps(self) -> None:
        """Find out when the machine moves so that no field set applies."""
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
        """Let the reactions follow what is wrong now, which may be new because of a person."""
        cause = ""
        if self._stage.blind[self.machine.name] > 0:
            cause, person = BLIND, ""
        elif self._unprotected and not self._muting.active:
            cause, person = NO_SET, ""
        elif self._is_occupied(PROTECTIVE):
            cause = INTRUSION
        self._stop.become(cause, person)
        self._slowdown.become(INTRUSION if self._is_occupied(WARNING) else "", person)

    def _is_occupied(self, field: str) -> bool:
        return any(field in watch.occupied for watch in self._watches)

    def _begin_stop(self, cause: str, person: str) -> None:
        self._count_time()
        self._stopped = True
        self.stops += 1
        name = self.machine.name
        self._stage.record(FieldStop(machine=name, cause=cause, person=person or None))
        self._stands_at = math.inf
        self.machine.stand_for(STOPPED, True)
        self._stands_at = self.machine.body.motion.end

    def _end_stop(self) -> None:
        self._count_time()
        self._stopped = False
        self._stage.record(FieldStopEnded(machine=self.machine.name))
        self.machine.stand_for(STOPPED, False)

    def _begin_slowdown(self, _: str, person: str) -> None:
        self._count_time()
        self._slow = True
        self._stage.record(FieldSlowdown(machine=self.machine.name, person=person))
        if not self.machine.limit_speed(self._fields.warning_speed):
            self.machine.stand_for(TOO_FAST, True)

    def _end_slowdown(self) -> None:
        self._count_time()
        self._slow = False
        self._stage.record(FieldSlowdownEnded(machine=self.machine.name))
        if not self.machine.limit_speed(None):
            self.machine.stand_for(TOO_FAST, False)

    def _count_time(self) -> None:
        """Count the time since the last count, before something begins or ends."""
        now = self._clock.now
        if self._stopped:
            self._stop_time += now - self._counted_until
        elif self._slow:
            self._slow_time += now - self._counted_until
        self._counted_until = now
