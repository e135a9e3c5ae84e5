"""The referee: watches every person beside every machine, and applies the rule set."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import Literal

from floorplan import Lane
from navigation import (
    RESOLUTION,
    AnyLaw,
    Apart,
    Approaching,
    Both,
    Condition,
    FixedDistance,
    Motion,
    Moving,
    Not,
    TooClose,
    first_time,
    required_at,
    required_at_speeds,
    when,
)

from .body import Body
from .clock import Alarm, Clock, Turn
from .plans import Plans
from .recordings.recorder import Record
from .recordings.requirement_curve import is_plain
from .rules import Notice, RuleSet

Cause = Literal["gantry", "agv", "person"]
"""The cause of a violation: the machine if it moves at that instant, else the person."""

CLEARANCE = 0.05
"""Metres. What a machine in a protective stop waits for beyond the required distance."""

MOVES = 1e-6
"""m/s. A machine that is faster than this at the instant of a violation is its cause."""


class Pair:
    """A person beside a machine, from now until the trial ends.

    Distances are measured to the point `offset` (x, y in metres) from the machine's centre.
    """

    def __init__(
        self,
        clock: Clock,
        person: Body,
        machine: Body,
        end: float,
        offset: tuple[float, float] = (0.0, 0.0),
    ) -> None:
        self.clock = clock
        self.person = person
        self.machine = machine
        self.end = end
        self._offset = offset
        self._translated = (machine.motion, self._measured(machine.motion))

    @property
    def motions(self) -> tuple[Motion, Motion]:
        """What the person and the measured point of the machine do from now on."""
        if self._translated[0] is not self.machine.motion:
            self._translated = (self.machine.motion, self._measured(self.machine.motion))
        return self.person.motion, self._translated[1]

    def first_time(self, condition: Condition, since: float = 0.0) -> float | None:
        """The first instant from now and `since` on at which `condition` holds.

        If nobody changes course: None means that it never does.
        """
        begin = max(self.clock.now, since)
        end = max(begin, self.horizon())
        return first_time(condition, *self.motions, begin, end)

    def next_interval(self, condition: Condition) -> tuple[float, float] | None:
        """The first interval from now on in which `condition` holds."""
        return next(when(condition, *self.motions, self.clock.now, self.horizon()), None)

    def distance(self) -> float:
        """The distance between the two now, metres."""
        now = self.clock.now
        person, machine = self.motions
        return math.dist(person.state(now).at, machine.state(now).at)

    def required(self, law: AnyLaw) -> float:
        """The distance that `law` requires now, metres."""
        return required_at(law, self.person.motion, self.machine.motion, self.clock.now)

    def remember_plans(self) -> tuple[Plans, Plans]:
        """From now on, what the two were about to do at every instant."""
        return self.person.remember_plans(), self.machine.remember_plans()

    def cause(self) -> Cause:
        """Return the cause of a violation at this instant."""
        return self.machine.kind if self.machine.state.speed > MOVES else "person"

    def horizon(self) -> float:
        """The instant from which on both stand, or the trial's end."""
        last = max(self.clock.now, self.person.motion.end, self.machine.motion.end)
        return min(last, self.end)

    def _measured(self, motion: Motion) -> Motion:
        return motion if self._offset == (0.0, 0.0) else motion.translated(*self._offset)


class SeparationWatch:
    """Notifies when a person and a machine get closer than a law requires, and when it is over.

    `violated` is called as they get too close; each interval in which they are stays in
    `intervals`.
    """

    def __init__(
        self, pair: Pair, law: AnyLaw, violated: Callable[[SeparationWatch], None]
    ) -> None:
        self.pair = pair
        self.law = law
        self.intervals: list[tuple[float, float]] = []
        self.plans = None if is_plain(law) else pair.remember_plans()
        """What the two were about to do, where `law` asks for more than their speeds."""
        self._violated = violated
        self._since: float | None = None
        self._notified_at = -math.inf
        is_agv = pair.machine.kind == "agv"
        self._condition = Both(Moving(), TooClose(law)) if is_agv else TooClose(law)
        self._alarm = Alarm(pair.clock, self._ring, Turn.VIOLATION)
        self.reconsider()

    def reconsider(self) -> None:
        """Work out anew when something happens next; called whenever a motion changes."""
        now, machine = self.pair.clock.now, self.pair.machine
        # An AGV that stands never counts, and most stand most of the time.
        idle = machine.kind == "agv" and machine.motion.end <= now
        coming = None if idle else self.pair.next_interval(self._condition)
        if self._since is None:
            self._alarm.set(coming[0] if coming else None)
        elif coming is None or coming[0] > now + 10 * RESOLUTION:
            self._alarm.set(now)
        else:
            self._alarm.set(coming[1] if coming[1] < self.pair.horizon() else None)

    def required_before(self, t: float, person: Motion, machine: Motion) -> float:
        """The distance (m) that the law required just before `t` (seconds) of these tracks."""
        if self.plans is None:
            return required_at_speeds(
                self.law, person.state_before(t).speed, machine.state_before(t).speed
            )
        of_person, of_machine = self.plans
        return required_at(self.law, of_person.before(t), of_machine.before(t), t)

    @property
    def known(self) -> list[tuple[float, float]]:
        """The intervals so far; one that still goes on lasts to the end, for all that is known."""
        lasting = [] if self._since is None else [(self._since, self.pair.end)]
        return [*self.intervals, *lasting]

    def recheck(self) -> None:
        """Call `violated` again if they are still too close now."""
        if self._since is not None and self._notified_at < self.pair.clock.now:
            self._notify()

    def close(self) -> None:
        """The trial is over: so is an interval that is still open."""
        if self._since is not None:
            self.intervals.append((self._since, self.pair.clock.now))
            self._since = None

    def _ring(self) -> None:
        if self._since is None:
            self._since = self.pair.clock.now
            self._notify()
        else:
            self.close()
        self.reconsider()

    def _notify(self) -> None:
        self._notified_at = self.pair.clock.now
        self._violated(self)


class NoticeWatch:
    """Lets a person notice the gantry once per approach: inside the noticing distance and closing.

    It then follows the approach to its nearest point, and is alert anew only after the two have
    parted by `rule.parting` metres from there (or `rule.every` seconds have gone by).
    """

    def __init__(self, pair: Pair, rule: Notice, noticed: Callable[[Pair, AnyLaw], None]) -> None:
        self.pair = pair
        self.rule = rule
        self._noticed = noticed
        self._condition = Both(TooClose(rule.law), Approaching())
        self._stage: Literal["alert", "closing", "parting"] = "alert"
        self._silent_until = 0.0
        self._nearest = 0.0
        self._alarm = Alarm(pair.clock, self._ring, Turn.NOTICE)
        self.reconsider()

    def reconsider(self) -> None:
        """Work out anew when something happens next; called whenever a motion changes."""
        pair = self.pair
        if self._stage == "alert":
            self._alarm.set(pair.first_time(self._condition, self._silent_until))
        elif self._stage == "closing":
            self._alarm.set(pair.first_time(Not(Approaching())))
        else:
            parted = pair.first_time(Apart(self._nearest + self.rule.parting))
            nearer = pair.first_time(TooClose(FixedDistance(max(self._nearest - 1e-3, 0.0))))
            self._alarm.set(min((t for t in (parted, nearer) if t is not None), default=None))

    def start_over(self) -> None:
        """Begin anew, after `rule.silent` seconds: the person starts, or was put elsewhere."""
        self._stage = "alert"
        self._silent_until = max(self._silent_until, self.pair.clock.now + self.rule.silent)

    def _ring(self) -> None:
        if self._stage == "alert":
            if self.rule.every is None:
                self._stage = "closing"
            else:
                self._silent_until = self.pair.clock.now + self.rule.every
            self._noticed(self.pair, self.rule.law)
        elif self._stage == "closing":
            self._nearest = self.pair.distance()
            self._stage = "parting"
        else:
            has_parted = self.pair.distance() > self._nearest
            self._stage = "alert" if has_parted else "closing"
        self.reconsider()


class ProtectiveStop:
    """Holds a machine from a violation on until it may set out again.

    That is once it stands, and the distance is enough for its top speed (m/s) and the person's
    present one, with `CLEARANCE` to spare, so that its own speed does not stop it again.
    `hold(pair, True)` stops the machine, `hold(pair, False)` lets it go on.
    """

    def __init__(
        self, pair: Pair, law: AnyLaw, top_speed: float, hold: Callable[[Pair, bool], None]
    ) -> None:
        self._pair = pair
        self._clear = Not(TooClose(_AtSpeed(law, top_speed)))
        self._hold = hold
        self._holds = False
        self._alarm = Alarm(pair.clock, self._end, Turn.MOTION_ENDS)

    def begin(self) -> None:
        """Stop the machine, if this has not done so already."""
        if not self._holds:
            self._holds = True
            self._hold(self._pair, True)
            self.reconsider()

    def reconsider(self) -> None:
        """Work out anew when the machine may go on; called whenever a motion changes."""
        if self._holds:
            stands = self._pair.machine.motion.end
            self._alarm.set(self._pair.first_time(self._clear, since=stands))

    def _end(self) -> None:
        self._holds = False
        self._hold(self._pair, False)


@dataclass(frozen=True)
class _AtSpeed:
    """What `law` requires of a machine at `speed` (m/s), and `CLEARANCE`."""

    law: AnyLaw
    speed: float

    def distance(self, human_speed: float, robot_speed: float) -> float:
        """The required distance in metres; the robot's speed does not matter."""
        return required_at_speeds(self.law, human_speed, self.speed) + CLEARANCE


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
        self._record("penalty", person=person.name, cause=pair.cause())
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
            "gantry_detected",
            person=pair.person.name,
            noticing_distance=pair.required(law),
            **_figures(pair, self.rules.gantry_law),
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
            "violation",
            person=person.name,
            **{"with": machine.name},
            penalty=is_penalty,
            cause=cause,
            **_figures(pair, watch.law),
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
            self._record("protective_stop", machine=machine.name, person=pair.person.name)
            self._hold(machine, True)
        elif stands:
            self._stopped[machine][1].add(pair.person)
        else:
            since, people = self._stopped[machine]
            people.remove(pair.person)
            if not people:
                del self._stopped[machine]
                self.protective_stop_time += now - since
                self._record("protective_stop_ended", machine=machine.name)
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
