"""The referee: monitors each person beside each machine, and applies the rule set."""

from __future__ import annotations

import math
from collections import Counter
from functools import cache, partial

from navigation.separation import AnyLaw

from ..core.body import Machine
from ..core.clock import Alarm, Turn
from ..core.events import GantryDetected, Penalty, ProtectiveStop, ProtectiveStopEnded, Violation
from ..core.stage import Bystander, Stage
from .contacts import PersonContacts
from .monitors import (
    Cause,
    Hold,
    Noticing,
    NoticingMonitor,
    Pair,
    PersonWatches,
    SeparationMonitor,
)

PEOPLE = "people"
"""Reason of protective stops for people."""


class Referee:
    """Applies the rule set of a stage: counts penalties, disables and stops machines, warns people.

    The percepts are "gantry_detected" for robots, and "gantry_disabled" and "agv_danger" for
    violations with robots and vehicles. After a violation, people go home.
    """

    def __init__(self, stage: Stage) -> None:
        self.rules = stage.rules
        self.penalties = 0
        self.violations: Counter[tuple[str, Cause]] = Counter()
        """Number of violations, by name of the person and cause."""
        self.agv_teleports = 0
        self.protective_stops = 0
        self.protective_stop_time = 0.0
        """Total time of all machines, s. Stops in progress are added by `close`."""
        self.watches: list[SeparationMonitor] = []
        self.contacts = PersonContacts(stage)
        self._condition_of = cache(lambda machine: stage.rules.condition_of(machine.shape))
        """Condition of a violation by a machine, which all people share."""
        self._noticing = Noticing(stage.rules.notice)
        self._stage = stage
        self._clock = stage.clock
        self._record = stage.record
        self._watches: dict[Bystander, PersonWatches] = {}
        self._stops: dict[SeparationMonitor, Hold] = {}
        self._notices: dict[Bystander, list[NoticingMonitor]] = {}
        self._stopped: dict[Machine, tuple[float, set[Bystander]]] = {}
        self._silent_until: dict[Bystander, float] = {}
        self._sanctions: dict[Machine, _Sanction] = {}

    def watch(self, person: Bystander, machine: Machine) -> None:
        """Start to monitor a person beside a machine."""
        offset = self.rules.measured_at(machine.shape)
        shapes = self.rules.shapes_of(machine.shape, person.radius)
        pair = Pair(self._stage, person, machine, offset, shapes)
        law = self.rules.law_of(machine.shape)
        watch = SeparationMonitor(pair, law, self._condition_of(machine), self._violated)
        self.watches.append(watch)
        if self.rules.machine == "stop":
            stop = Hold(pair, watch.law, machine.shape.top_speed, self._stop_for)
            self._stops[watch] = stop
        watches = self.watches_of(person)
        self.contacts.watch(person, machine, watches)
        watches.add(watch.row, watch.alarm, watch.reconsider, machine.body)
        if watch in self._stops:
            for body in (person.body, machine.body):
                body.on_change.append(self._stops[watch].reconsider)
        if machine.shape.category == "robot":
            self._sanctions.setdefault(machine, _Sanction(self, machine))
            notice = NoticingMonitor(pair, self._noticing, self._notice)
            self._notices.setdefault(person, []).append(notice)
            person.body.on_jump.append(notice.start_over)
            watches.add(notice.row, notice.alarm, notice.reconsider, machine.body)

    def watches_of(self, person: Bystander) -> PersonWatches:
        """Return the monitors of a person, which are updated together."""
        if person not in self._watches:
            self._watches[person] = PersonWatches(person.body)
        return self._watches[person]

    def started(self, person: Bystander) -> None:
        """Restart the interval without noticing, because the person starts."""
        for notice in self._notices.get(person, ()):
            notice.start_over()
            notice.reconsider()
        self.contacts.started(person)

    def close(self) -> None:
        """End the violations and protective stops in progress at the end of the trial."""
        for watch in self.watches:
            watch.close()
        for since, _ in self._stopped.values():
            self.protective_stop_time += self._clock.now - since
        self._stopped.clear()

    def penalise(self, person: Bystander) -> bool:
        """Count a penalty on request. Return whether it was counted.

        While the robot is disabled, and during the grace period, the violation has been counted
        already.
        """
        for watch in self.watches:
            pair = watch.pair
            sanction = self._sanctions.get(pair.machine)
            if pair.person is person and sanction is not None:
                if self._clock.now < sanction.grace_until:
                    return False
                self._record(Penalty(person=person.name, cause=pair.cause()))
                self._penalise(sanction)
                return True
        return False

    def recheck(self, machine: Machine) -> None:
        """Report the violations in progress with a machine again."""
        for watch in self.watches:
            if watch.pair.machine is machine:
                watch.recheck()

    def _notice(self, pair: Pair, law: AnyLaw) -> None:
        self._record(
            GantryDetected(
                person=pair.person.name,
                noticing_distance=pair.required(law),
                **_figures(pair, self.rules.law_of(pair.machine.shape)),
            )
        )
        pair.person.warn("gantry_detected", pair.machine)

    def _violated(self, watch: SeparationMonitor) -> None:
        """Record a violation, and apply its consequences."""
        pair, rules = watch.pair, self.rules
        person, machine = pair.person, pair.machine
        sanction = self._sanctions.get(machine)
        is_reported = self._is_reported(person)
        is_penalty = (
            sanction is not None
            and rules.machine == "disable"
            and is_reported
            and not sanction.in_grace
        )
        cause = pair.cause()
        self.violations[person.name, cause] += 1
        self._record(
            Violation(
                person=person.name,
                with_=machine.name,
                penalty=is_penalty,
                cause=cause,
                **_figures(pair, watch.law),
            )
        )
        if watch in self._stops:
            self._stops[watch].begin()
        if is_penalty and sanction is not None:
            self._penalise(sanction)
        if is_reported and rules.person == "teleport":
            self.agv_teleports += sanction is None and not person.is_recorded
            self._report(person)
            person.warn("agv_danger" if sanction is None else "gantry_disabled", machine)

    def _penalise(self, sanction: _Sanction) -> None:
        self.penalties += 1
        sanction.begin()

    def _stop_for(self, pair: Pair, stands: bool) -> None:
        """Stop the machine for a person, or resume it when no person requires the stop."""
        machine, now = pair.machine, self._clock.now
        if stands and machine not in self._stopped:
            self._stopped[machine] = (now, {pair.person})
            self.protective_stops += 1
            self._record(ProtectiveStop(machine=machine.name, person=pair.person.name))
            machine.stand_for(PEOPLE, True)
        elif stands:
            self._stopped[machine][1].add(pair.person)
        else:
            since, people = self._stopped[machine]
            people.remove(pair.person)
            if not people:
                # Other people may be too close for the top speed, although they had no violation.
                # They continue the stop, and are added to `people`.
                for watch, stop in self._stops.items():
                    if watch.pair.machine is machine and watch.pair is not pair:
                        stop.begin_if_needed()
            if not people:
                del self._stopped[machine]
                self.protective_stop_time += now - since
                self._record(ProtectiveStopEnded(machine=machine.name))
                machine.stand_for(PEOPLE, False)

    # Repeated reports of violations to a person

    def _is_reported(self, person: Bystander) -> bool:
        return self._clock.now >= self._silent_until.get(person, -math.inf)

    def _report(self, person: Bystander) -> None:
        if self.rules.report_every is not None:
            again = self._silent_until[person] = self._clock.now + self.rules.report_every
            self._clock.call_at(again, partial(self._recheck_person, person), Turn.NOTICE)

    def _recheck_person(self, person: Bystander) -> None:
        for watch in self.watches:
            if watch.pair.person is person and self._is_reported(person):
                watch.recheck()


class _Sanction:
    """Consequence of penalties for one robot: a disabled time, and a grace period after it."""

    def __init__(self, referee: Referee, machine: Machine) -> None:
        self.grace_until = -math.inf
        self._rules = referee.rules
        self._machine = machine
        self._clock = machine.body.clock
        self._disabled_until = -math.inf
        # After the grace period, violations in progress are penalties again.
        self._over = Alarm(self._clock, partial(referee.recheck, machine), Turn.NOTICE)

    @property
    def in_grace(self) -> bool:
        """Whether violations are no penalties now."""
        return self._disabled_until <= self._clock.now < self.grace_until

    def begin(self) -> None:
        """Disable the robot from now on."""
        seconds = self._rules.gantry_disabled
        self._machine.disable(seconds)
        self._disabled_until = self._clock.now + seconds
        self.grace_until = self._disabled_until + self._rules.grace
        self._over.set(self.grace_until)


def _figures(pair: Pair, law: AnyLaw) -> dict[str, float]:
    """Return the values of a decision: distance, required distance (m) and speeds (m/s)."""
    return {
        "distance": pair.distance(),
        "required": pair.required(law),
        "human_speed": pair.person.body.state.speed,
        "robot_speed": pair.machine.body.state.speed,
    }
