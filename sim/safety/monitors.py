"""Monitors of one person and one machine: violations, noticing, and protective stops."""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import cached_property
from typing import Literal

from floorplan.files.dataclass import dataclass
from navigation import (
    Apart,
    Approaching,
    Condition,
    Motion,
    Shapes,
    TooClose,
    minimum_separation,
)
from navigation.kernels.watch import KernelCondition, in_kernel
from navigation.kernels.watched import WatchRow, changed_rows, horizon
from navigation.monitor import RESOLUTION, search
from navigation.separation import AnyLaw, required_at, required_at_speeds

from ..core.body import PERSON, Body, Machine, Plans
from ..core.clock import Alarm, Turn
from ..core.rules import Notice
from ..core.stage import Bystander, Stage
from .laws import Curve, is_of_speeds_alone, requirement_curve

Cause = str
"""Cause of a violation: the kind of the machine if it moves at that time, otherwise "person"."""

CLEARANCE = 0.05
"""Distance beyond the required one at which a protective stop ends, m."""

GLANCE = 0.1
"""Time after which a person who cannot see a machine nearby looks again, s."""

MOVES = 1e-6
"""Speed above which a machine is the cause of a violation, m/s."""


class Pair:
    """A person and a machine of a stage, from now to the end of the trial.

    Distances are measured to the point `offset` (x, y in metres) from the machine's centre, or
    between the surfaces of `shapes`.
    """

    def __init__(
        self,
        stage: Stage,
        person: Bystander,
        machine: Machine,
        offset: tuple[float, float] = (0.0, 0.0),
        shapes: Shapes | None = None,
    ) -> None:
        self.clock = stage.clock
        self.person = person
        self.machine = machine
        self.end = stage.end
        self.shapes = shapes
        self._one, self._other = person.body, machine.body
        self._offset = offset
        self._translated = machine.body.motion
        self._measured = self._translated.translated(*offset)

    @property
    def motions(self) -> tuple[Motion, Motion]:
        """Motions of the person and of the measured point of the machine from now on."""
        motion = self._other.motion
        if self._translated is not motion:
            self._translated, self._measured = motion, motion.translated(*self._offset)
        return self._one.motion, self._measured

    def first_time(self, condition: Condition, since: float = 0.0) -> float | None:
        """Return the first time after now and `since` (s) at which `condition` holds, or None.

        Present motions are assumed.
        """
        begin, last = self.clock.now, self.horizon()
        if since > begin:
            begin = since
        end = last if last > begin else begin
        return search(condition, *self.motions, begin, end, self.shapes).change()

    def distance(self) -> float:
        """Return the distance between the two now (metres)."""
        now = self.clock.now
        person, machine = self.motions
        if self.shapes is not None:
            return minimum_separation(person, machine, now, now, shapes=self.shapes)[1]
        return math.dist(person.state(now).at, machine.state(now).at)

    def required(self, law: AnyLaw) -> float:
        """Return the distance that `law` requires now (metres)."""
        motions = self.person.body.motion, self.machine.body.motion
        return required_at(law, *motions, self.clock.now, self.shapes)

    def remember_plans(self) -> tuple[Plans, Plans]:
        """Return the plans of both, which are recorded from now on."""
        return self.person.body.remember_plans(), self.machine.body.remember_plans()

    def cause(self) -> Cause:
        """Return the cause of a violation at the current time."""
        state = self.machine.body.state
        speed = state.speed
        if self.shapes is not None:
            speed = max(speed, abs(state.velocity[2]) * self.shapes.reach)
        return self.machine.shape.kind if speed > MOVES else PERSON

    def horizon(self) -> float:
        """Return a time (s) after which nothing changes, or the end of the trial."""
        return horizon(self.clock.now, self._one.motion.end, self._other.motion.end, self.end)

    def row(
        self, condition: Condition, *, beyond: float = -math.inf, driven: bool = False
    ) -> WatchRow:
        """Return a row that searches for the first time at which `condition` holds."""
        gauges = () if self.shapes is None else self.shapes.gauges
        return WatchRow(self.end, RESOLUTION, gauges, in_kernel(condition), beyond, driven)


class PersonWatches:
    """Monitors of one person beside machines.

    A new motion of the person updates their rows in one call. A monitor acts only if its next
    event has another time, or is not found by the kernel.
    """

    def __init__(self, person: Body) -> None:
        self._person = person
        self._rows: list[WatchRow] = []
        self._monitors: list[tuple[Alarm, Callable[[], None]]] = []
        person.on_change.append(self._changed)

    def add(
        self,
        row: WatchRow,
        alarm: Alarm,
        reconsider: Callable[[], None],
        machine: Body | None = None,
    ) -> None:
        """Add the row of a monitor with its `alarm`.

        `reconsider` is called if the row is open, and after new motions of `machine`, if given.
        """
        self._rows.append(row)
        self._monitors.append((alarm, reconsider))
        if machine is not None:
            machine.on_change.append(reconsider)

    def _changed(self) -> None:
        person = self._person
        for k in changed_rows(self._rows, person.motion, person.clock.now):
            row, (alarm, reconsider) = self._rows[k], self._monitors[k]
            if row.open:
                reconsider()
            else:
                alarm.set(row.time)


class SeparationMonitor:
    """Monitor of the violations of a law by a person and a machine.

    A violation lasts while `condition` holds, which follows from the law. `violated` is called at
    its begin, and `intervals` contains all that have ended.
    """

    def __init__(
        self,
        pair: Pair,
        law: AnyLaw,
        condition: Condition,
        violated: Callable[[SeparationMonitor], None],
    ) -> None:
        self.pair = pair
        self.law = law
        self.intervals: list[tuple[float, float]] = []
        self.plans = None if is_of_speeds_alone(law) else pair.remember_plans()
        """Plans of both, if `law` depends on more than their speeds."""
        self._violated = violated
        self._since: float | None = None
        self._notified_at = -math.inf
        # Stationary vehicles never violate.
        self.row = pair.row(condition, driven=pair.machine.shape.category == "vehicle")
        self.alarm = Alarm(pair.clock, self._ring, Turn.VIOLATION)
        self.reconsider()

    def reconsider(self) -> None:
        """Recompute the next begin or end of a violation after a change of motion."""
        self.row.search(*self.pair.motions, self.pair.clock.now)
        self.alarm.set(self.row.time)

    def required_before(self, t: float, person: Motion, machine: Motion) -> float:
        """Return the distance (m) that the law required of these tracks just before `t` (s)."""
        if self.plans is None:
            return required_at_speeds(
                self.law, person.state_before(t).speed, machine.state_before(t).speed
            )
        of_person, of_machine = self.plans
        plans = of_person.before(t), of_machine.before(t)
        return required_at(self.law, *plans, t, self.pair.shapes)

    @cached_property
    def requirement(self) -> Curve:
        """Distance that `law` required until now, if it depends on more than speeds.

        It is computed once, after the trial. Empty for other laws.
        """
        if self.plans is None:
            return ()
        return requirement_curve(self.law, *self.plans, self.pair.clock.now, self.pair.shapes)

    @property
    def known(self) -> list[tuple[float, float]]:
        """Intervals so far. One in progress lasts to the end of the trial."""
        lasting = [] if self._since is None else [(self._since, self.pair.end)]
        return [*self.intervals, *lasting]

    def recheck(self) -> None:
        """Call `violated` again if the violation is in progress, at most once at each time."""
        if self._since is not None and self._notified_at < self.pair.clock.now:
            self._notify()

    def close(self) -> None:
        """End the interval in progress now."""
        if self._since is not None:
            self.intervals.append((self._since, self.pair.clock.now))
            self._since = None
            self.row.holds = False

    def _ring(self) -> None:
        if self._since is None:
            self._since = self.pair.clock.now
            self.row.holds = True
            self._notify()
        else:
            self.close()
        self.reconsider()

    def _notify(self) -> None:
        self._notified_at = self.pair.clock.now
        self._violated(self)


class Noticing:
    """A rule of noticing and its conditions, which all people share."""

    def __init__(self, rule: Notice) -> None:
        self.rule = rule
        self.near = TooClose(rule.law)
        self.closing_in = self.near & Approaching()
        self.parting = ~Approaching()


class NoticingMonitor:
    """Noticing of a gantry by a person, once per approach within the noticing distance.

    The monitor follows the approach to its nearest point. It is alert again after both have parted
    by `rule.parting` metres from there, or after `rule.every` seconds. People who do not see the
    gantry look again after `GLANCE`. People who see it perceive it after their reaction time.
    """

    # Three stages, of which each waits for the one instant that ends it:
    # - alert: the noticing distance is reached while closing in.
    # - closing: the distance no longer falls, which makes it the nearest of the approach so far.
    # - parting: either the distance has grown by `parting`, which ends the approach, or it has
    #   fallen below the nearest again, which goes on with the same approach.
    # A person who lingers at the noticing distance, or whom a machine passes to and fro, is
    # therefore notified once: the distance has to grow by `parting` in between, which no
    # rounding at the threshold brings about. `rule.every` replaces the last two stages by a time.

    def __init__(
        self, pair: Pair, noticing: Noticing, noticed: Callable[[Pair, AnyLaw], None]
    ) -> None:
        self.pair = pair
        self.rule = noticing.rule
        self._conditions = noticing
        self._noticed = noticed
        self._hidden = False
        self._stage: Literal["alert", "closing", "parting"] = "alert"
        self._nearest = 0.0
        self.row = pair.row(noticing.closing_in)
        self.alarm = Alarm(pair.clock, self._ring, Turn.NOTICE)
        self._perceiving = Alarm(pair.clock, self._perceive, Turn.NOTICE)
        self.reconsider()

    def reconsider(self) -> None:
        """Recompute the next change of stage after a change of motion."""
        self.row.search(*self.pair.motions, self.pair.clock.now)
        self.alarm.set(self.row.time)

    def start_over(self) -> None:
        """Restart after `rule.silent` seconds, because the person starts or was moved."""
        self._perceiving.set(None)
        self._hidden = False
        self._be_alert(self.pair.clock.now + self.rule.silent)

    def _be_alert(self, silent_until: float = 0.0) -> None:
        """Wait for the next approach, after `silent_until` (s)."""
        of = self._conditions
        # People who first see a machine nearby notice it, regardless of their direction.
        self._wait("alert", of.near if self._hidden else of.closing_in)
        self.row.since = max(self.row.since, silent_until)

    def _wait(
        self, stage: Literal["alert", "closing", "parting"], condition: KernelCondition
    ) -> None:
        self._stage = stage
        self.row.condition = condition

    def _ring(self) -> None:
        if self._stage == "alert":
            person, now = self.pair.person, self.pair.clock.now
            self._hidden = not person.sees(self.pair.machine)
            if self._hidden:
                self._be_alert(now + GLANCE)
                self.reconsider()
                return
            if self.rule.every is None:
                self._wait("closing", self._conditions.parting)
            else:
                self._be_alert(now + self.rule.every)
            if person.reaction_time > 0.0:
                self._perceiving.set(now + person.reaction_time)
            else:
                self._perceive()
        elif self._stage == "closing":
            self._nearest = self.pair.distance()
            self._wait("parting", self._off_nearest())
        elif self.pair.distance() > self._nearest:
            self._be_alert()
        else:
            self._wait("closing", self._conditions.parting)
        self.reconsider()

    def _off_nearest(self) -> KernelCondition:
        """Return the condition that the two have parted, or are nearer than at their nearest."""
        # One millimetre less, so that rounding at the nearest point does not count as nearer.
        nearer, parted = max(self._nearest - 1e-3, 0.0), self._nearest + self.rule.parting
        return ~(Apart(nearer) & ~Apart(parted))

    def _perceive(self) -> None:
        self._noticed(self.pair, self.rule.law)


class Hold:
    """Protective stop for one person, from a violation until the machine may start again.

    The machine must be stationary, and the distance must be enough for its top speed (m/s) and the
    present speed of the person, plus `CLEARANCE`. Otherwise its own speed would stop it again.
    `hold(pair, True)` stops the machine, and `hold(pair, False)` resumes it.
    """

    def __init__(
        self, pair: Pair, law: AnyLaw, top_speed: float, hold: Callable[[Pair, bool], None]
    ) -> None:
        self._pair = pair
        self._law = _AtSpeed(law, top_speed)
        self._clear = ~TooClose(self._law)
        self._hold = hold
        self._holds = False
        self._alarm = Alarm(pair.clock, self._end, Turn.MOTION_ENDS)

    def begin(self) -> None:
        """Stop the machine, unless this stop is active."""
        if not self._holds:
            self._holds = True
            self._hold(self._pair, True)
            self.reconsider()

    def begin_if_needed(self) -> None:
        """Continue the stop of another person if the distance is too small for the top speed."""
        if self._pair.distance() < self._pair.required(self._law):
            self.begin()

    def reconsider(self) -> None:
        """Recompute the end of the stop after a change of motion."""
        if self._holds:
            stands = self._pair.machine.body.motion.end
            # A machine that brakes may come nearer, so the stop ends when it is stationary.
            self._alarm.set(self._pair.first_time(self._clear, since=stands))

    def _end(self) -> None:
        self._holds = False
        self._hold(self._pair, False)


@dataclass(frozen=True)
class _AtSpeed:
    """Distance of `law` for a machine at `speed` (m/s), plus `CLEARANCE`."""

    law: AnyLaw
    speed: float

    def distance(self, human_speed: float, robot_speed: float) -> float:
        """Return the required distance (m), regardless of the robot's speed."""
        return required_at_speeds(self.law, human_speed, self.speed) + CLEARANCE
