"""The referee: watches every person beside every machine, and applies the rule set."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable
from typing import Literal

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

Cause = Literal["person", "gantry", "agv"]
"""Whose doing a violation is: the machine's if it moves at that instant, else the person's."""

MOVES = 1e-6
"""m/s. A machine that is faster than this at the instant of a violation is its cause."""


class Pair:
    """A person beside a machine, from now until the trial ends."""

    def __init__(self, clock: Clock, person: Body, machine: Body, end: float) -> None:
        self.clock = clock
        self.person = person
        self.machine = machine
        self.end = end

    def first_time(self, condition: Condition, since: float = 0.0) -> float | None:
        """The first instant from now and `since` on at which `condition` holds.

        If nobody changes course: None means that it never does.
        """
        begin = max(self.clock.now, since)
        end = max(begin, self.horizon())
        return first_time(condition, self.person.motion, self.machine.motion, begin, end)

    def next_interval(self, condition: Condition) -> tuple[float, float] | None:
        """The first interval from now on in which `condition` holds."""
        now, horizon = self.clock.now, self.horizon()
        motions: tuple[Motion, Motion] = (self.person.motion, self.machine.motion)
        return next(when(condition, *motions, now, horizon), None)

    def distance(self) -> float:
        """The distance between the centres now, metres."""
        return math.dist(self.person.at, self.machine.at)

    def required(self, law: AnyLaw) -> float:
        """The distance that `law` requires now, metres."""
        return required_at(law, self.person.motion, self.machine.motion, self.clock.now)

    def remember_plans(self) -> tuple[Plans, Plans]:
        """From now on, what the two were about to do at every instant."""
        return self.person.remember_plans(), self.machine.remember_plans()

    def cause(self) -> Cause:
        """Whose doing it is if they are too close now."""
        return self.machine.kind if self.machine.state.speed > MOVES else "person"

    def horizon(self) -> float:
        """The instant from which on both stand, or the trial's end."""
        last = max(self.clock.now, self.person.motion.end, self.machine.motion.end)
        return min(last, self.end)


class SeparationWatch:
    """Tells when a person and a machine get closer than a law requires, and when it is over.

    `violated` is called as they get too close; each interval in which they are stays in
    `intervals`.
    """

    def __init__(self, pair: Pair, law: AnyLaw, violated: Callable[[Pair, AnyLaw], None]) -> None:
        self.pair = pair
        self.law = law
        self.intervals: list[tuple[float, float]] = []
        self.plans = None if is_plain(law) else pair.remember_plans()
        """What the two were about to do, where `law` asks for more than their speeds."""
        self._violated = violated
        self._since: float | None = None
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
        """Call `violated` again if they are too close now."""
        if self._since is not None:
            self._violated(self.pair, self.law)

    def close(self) -> None:
        """The trial is over: so is an interval that is still open."""
        if self._since is not None:
            self.intervals.append((self._since, self.pair.clock.now))
            self._since = None

    def _ring(self) -> None:
        if self._since is None:
            self._since = self.pair.clock.now
            self._violated(self.pair, self.law)
        else:
            self.close()
        self.reconsider()


class NoticeWatch:
    """Tells a person of the gantry once per approach: inside the noticing distance and closing.

    It then follows the approach to its nearest point, and tells anew only after the two have
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
        """Somebody was put elsewhere: whatever approach there was, it is over."""
        self._stage = "alert"

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


class Referee:
    """Applies a rule set: counts penalties, disables the gantry, warns people.

    `warn(person, percept)` tells a person of the gantry ("gantry_detected"), of a violation
    with it ("gantry_disabled") or with an AGV ("agv_danger"); `disable_gantry(seconds)` stops
    the gantry for that long.
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
    ) -> None:
        self.rules = rules
        self.penalties: Counter[tuple[str, Cause]] = Counter()
        """How many there were, by the person's name and the cause."""
        self.agv_teleports = 0
        self.watches: list[SeparationWatch] = []
        self._clock = clock
        self._end = end
        self._record = record
        self._warn = warn
        self._disable_gantry = disable_gantry
        self._harmless_until = 0.0
        self._resume = Alarm(clock, self._recheck, Turn.NOTICE)

    def watch_gantry(self, person: Body, gantry: Body) -> None:
        """From now on, keep `person` and the gantry apart."""
        pair = Pair(self._clock, person, gantry, self._end)
        self._watch(pair, self.rules.gantry_law, self._gantry_violation)
        notice = NoticeWatch(pair, self.rules.notice, self._notice)
        person.on_jump.append(notice.start_over)
        person.on_change.append(notice.reconsider)
        gantry.on_change.append(notice.reconsider)

    def watch_agv(self, person: Body, agv: Body) -> None:
        """From now on, keep `person` and an AGV apart."""
        pair = Pair(self._clock, person, agv, self._end)
        self._watch(pair, self.rules.agv_law, self._agv_violation)

    def penalise(self, person: Body) -> bool:
        """Somebody else has seen a violation with the gantry: count it, unless it has been already.

        It has been while the gantry is disabled, and in the grace after that. Whether it counted.
        """
        pairs = (watch.pair for watch in self.watches if watch.pair.machine.kind == "gantry")
        pair = next((pair for pair in pairs if pair.person is person), None)
        if pair is None or self._clock.now < self._harmless_until:
            return False
        cause = pair.cause()
        self.penalties[person.name, cause] += 1
        self._record("penalty", person=person.name, cause=cause)
        self._punish()
        return True

    def _watch(self, pair: Pair, law: AnyLaw, violated: Callable[[Pair, AnyLaw], None]) -> None:
        watch = SeparationWatch(pair, law, violated)
        self.watches.append(watch)
        pair.person.on_change.append(watch.reconsider)
        pair.machine.on_change.append(watch.reconsider)

    def _notice(self, pair: Pair, law: AnyLaw) -> None:
        self._record(
            "gantry_detected",
            person=pair.person.name,
            noticing_distance=pair.required(law),
            **_figures(pair, self.rules.gantry_law),
        )
        self._warn(pair.person, "gantry_detected", pair.machine)

    def _gantry_violation(self, pair: Pair, law: AnyLaw) -> None:
        if self._clock.now < self._harmless_until:
            return
        self.penalties[pair.person.name, pair.cause()] += 1
        self._record_violation(pair, law, penalty=True)
        self._punish()
        self._warn(pair.person, "gantry_disabled", pair.machine)

    def _punish(self) -> None:
        seconds = self.rules.gantry_disabled
        self._disable_gantry(seconds)
        self._harmless_until = self._clock.now + seconds + self.rules.grace
        self._resume.set(self._harmless_until)

    def _recheck(self) -> None:
        """Violations count again: so do those that go on."""
        for watch in self.watches:
            if watch.pair.machine.kind == "gantry":
                watch.recheck()

    def _agv_violation(self, pair: Pair, law: AnyLaw) -> None:
        self.agv_teleports += 1
        self._record_violation(pair, law, penalty=False)
        self._warn(pair.person, "agv_danger", pair.machine)

    def _record_violation(self, pair: Pair, law: AnyLaw, *, penalty: bool) -> None:
        self._record(
            "violation",
            person=pair.person.name,
            **{"with": pair.machine.name},
            penalty=penalty,
            cause=pair.cause(),
            **_figures(pair, law),
        )


def _figures(pair: Pair, law: AnyLaw) -> dict[str, float]:
    """What a decision rests on: distance, required distance (m) and speeds (m/s)."""
    return {
        "distance": pair.distance(),
        "required": pair.required(law),
        "human_speed": pair.person.state.speed,
        "robot_speed": pair.machine.state.speed,
    }
