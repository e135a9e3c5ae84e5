"""The referee: watches every person beside every machine, and applies the rule set."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable
from functools import partial

from floorplan import Lane
from navigation import AnyLaw

from ..core import events
from ..core.body import Body
from ..core.clock import Alarm, Clock, Turn
from ..core.recorder import Record
from ..core.rules import RuleSet
from .watches import Cause, NoticeWatch, Pair, ProtectiveStop, SeparationWatch


class Referee:
    """Applies a rule set: counts penalties, disables and stops machines, warns people.

    `warn(person, percept, machine)` lets a person perceive the gantry ("gantry_detected"), a
    violation with it ("gantry_disabled") or with an AGV ("agv_danger"), and sends them home for
    the latter two. `disable_gantry(seconds)` stops the gantry for that long; `hold(machine, on)`
    stops a machine and lets it go on.
    """

    def __init__(
        self,
        clock: Clock,
        rules: RuleSet,
        end: float,
        *,
        record: Record,
        warn: Callable[[Body, str, Body], None],
        disable_gantry: Callable[[float], None],
        hold: Callable[[Body, bool], None],
    ) -> None:
        self.rules = rules
        self.penalties = 0
        self.violations: Counter[tuple[str, Cause]] = Counter()
        """How many there were, by the person's name and the cause."""
        self.agv_teleports = 0
        self.protective_stops = 0
        self.protective_stop_time = 0.0
        """Seconds, of all machines together; those that still last count from `close` on."""
        self.watches: list[SeparationWatch] = []
        self._clock = clock
        self._end = end
        self._record = record
        self._warn = warn
        self._disable_gantry = disable_gantry
        self._hold = hold
        self._stops: dict[SeparationWatch, ProtectiveStop] = {}
        self._notices: dict[Body, list[NoticeWatch]] = {}
        self._stopped: dict[Body, tuple[float, set[Body]]] = {}
        self._silent_until: dict[Body, float] = {}
        self._disabled_until = -math.inf
        self._grace_until = -math.inf
        self._rechecks = Alarm(clock, self._recheck_gantry, Turn.NOTICE)

    def watch_gantry(self, person: Body, gantry: Body, top_speed: float) -> None:
        """From now on, watch `person` and the gantry, which moves at `top_speed` (m/s) at most."""
        pair = Pair(self._clock, person, gantry, self._end)
        self._watch(pair, self.rules.gantry_law, top_speed)
        notice = NoticeWatch(pair, self.rules.notice, self._notice)
        self._notices.setdefault(person, []).append(notice)
        person.on_jump.append(notice.start_over)
        person.on_change.append(notice.reconsider)
        gantry.on_change.append(notice.reconsider)

    def watch_agv(self, person: Body, agv: Body, lane: Lane) -> None:
        """From now on, watch `person` and the AGV on `lane`."""
        pair = Pair(self._clock, person, agv, self._end, self.rules.measured_at(lane))
        self._watch(pair, self.rules.agv_law, lane.max_speed)

    def started(self, person: Body) -> None:
        """A person starts."""
        for notice in self._notices.get(person, ()):
            notice.start_over()
            notice.reconsider()

    def close(self) -> None:
        """The trial is over: so are violations and protective stops that still last."""
        for watch in self.watches:
            watch.close()
        for since, _ in self._stopped.values():
            self.protective_stop_time += self._clock.now - since
        self._stopped.clear()

    def penalise(self, person: Body) -> bool:
        """Count a penalty that somebody else asks for, unless the violation has been counted.

        It has been while the gantry is disabled, and in the grace after that. Return whether it
        was counted.
        """
        pairs = (watch.pair for watch in self.watches if watch.pair.machine.kind == "gantry")
        pair = next((pair for pair in pairs if pair.person is person), None)
        if pair is None or self._clock.now < self._grace_until:
            return False
        self._record(events.Penalty(person=person.name, cause=pair.cause()))
        self._penalise()
        return True

    def _watch(self, pair: Pair, law: AnyLaw, top_speed: float) -> None:
        watch = SeparationWatch(pair, law, self._violated)
        self.watches.append(watch)
        if self.rules.machine == "stop":
            self._stops[watch] = ProtectiveStop(pair, law, top_speed, self._stop_for)
        for body in (pair.person, pair.machine):
            body.on_change.append(watch.reconsider)
            if watch in self._stops:
                body.on_change.append(self._stops[watch].reconsider)

    def _notice(self, pair: Pair, law: AnyLaw) -> None:
        self._record(
            events.GantryDetected(
                person=pair.person.name,
                noticing_distance=pair.required(law),
                **_figures(pair, self.rules.gantry_law),
            )
        )
        self._warn(pair.person, "gantry_detected", pair.machine)

    def _violated(self, watch: SeparationWatch) -> None:
        """Record a violation, and see to what follows from it."""
        pair, rules = watch.pair, self.rules
        person, machine = pair.person, pair.machine
        with_gantry = machine.kind == "gantry"
        is_reported = self._is_reported(person)
        is_penalty = (
            with_gantry and rules.machine == "disable" and is_reported and not self._in_grace()
        )
        cause = pair.cause()
        self.violations[person.name, cause] += 1
        self._record(
            events.Violation(
                person=person.name,
                with_=machine.name,
                penalty=is_penalty,
                cause=cause,
                **_figures(pair, watch.law),
            )
        )
        if watch in self._stops:
            self._stops[watch].begin()
        if is_penalty:
            self._penalise()
        if is_reported and rules.person == "teleport":
            self.agv_teleports += not with_gantry
            self._report(person)
            self._warn(person, "gantry_disabled" if with_gantry else "agv_danger", machine)

    def _in_grace(self) -> bool:
        return self._disabled_until <= self._clock.now < self._grace_until

    def _penalise(self) -> None:
        seconds = self.rules.gantry_disabled
        self.penalties += 1
        self._disable_gantry(seconds)
        self._disabled_until = self._clock.now + seconds
        self._grace_until = self._disabled_until + self.rules.grace
        self._rechecks.set(self._grace_until)

    def _recheck_gantry(self) -> None:
        """Violations are penalties again: so are those that go on."""
        for watch in self.watches:
            if watch.pair.machine.kind == "gantry":
                watch.recheck()

    def _stop_for(self, pair: Pair, stands: bool) -> None:
        """Stop a machine for a person, or let it go on once nobody needs it to stand."""
        machine, now = pair.machine, self._clock.now
        if stands and machine not in self._stopped:
            self._stopped[machine] = (now, {pair.person})
            self.protective_stops += 1
            self._record(events.ProtectiveStop(machine=machine.name, person=pair.person.name))
            self._hold(machine, True)
        elif stands:
            self._stopped[machine][1].add(pair.person)
        else:
            since, people = self._stopped[machine]
            people.remove(pair.person)
            if not people:
                for watch, stop in self._stops.items():
                    if watch.pair.machine is machine and watch.pair is not pair:
                        stop.begin_if_needed()
            if not people:
                del self._stopped[machine]
                self.protective_stop_time += now - since
                self._record(events.ProtectiveStopEnded(machine=machine.name))
                self._hold(machine, False)

    # How often a person hears of violations.

    def _is_reported(self, person: Body) -> bool:
        return self._clock.now >= self._silent_until.get(person, -math.inf)

    def _report(self, person: Body) -> None:
        if self.rules.report_every is not None:
            again = self._silent_until[person] = self._clock.now + self.rules.report_every
            self._clock.call_at(again, partial(self._recheck_person, person), Turn.NOTICE)

    def _recheck_person(self, person: Body) -> None:
        for watch in self.watches:
            if watch.pair.person is person and self._is_reported(person):
                watch.recheck()


def _figures(pair: Pair, law: AnyLaw) -> dict[str, float]:
    """What a decision rests on: distance, required distance (m) and speeds (m/s)."""
    return {
        "distance": pair.distance(),
        "required": pair.required(law),
        "human_speed": pair.person.state.speed,
        "robot_speed": pair.machine.state.speed,
    }
