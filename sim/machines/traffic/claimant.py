"""Claimants: machines that claim the area ahead of them, wait for others, and evade them."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Sequence
from typing import Protocol, TypeVar

import shapely
from shapely.geometry import Polygon

from floorplan import Point

from ...core.body import TRAFFIC, Machine, is_there
from ...core.clock import Alarm, Turn
from ...core.entries import Pose
from ...core.events import MachineEvades, MachineProceeds, MachineWaiting
from ...core.stage import Stage
from .areas import CLEAR, Area, Part, footprint_of
from .evading import Evading
from .waiting import WaitForMachines

T = TypeVar("T")

PART = 1.0
"""Seconds of motion that a machine claims at once, if it does not rest before."""

UNKNOWN_PART = 6.0
"""Seconds of motion that a machine claims whose stop is unknown."""

NEARBY = 6.0
"""Metres. Only claims that are nearer count when a machine looks for another path."""

MARGINS = (0.05, CLEAR, 0.0)
"""Metres. Distances that a machine keeps from the claims of others: usually, when it evades, and
when it is nearer already or cannot evade."""

PLANNED = 1.01e-3
"""Metres. Planned paths keep a little less than this distance from areas."""

NEARER = 1.1e-3
"""Metres. Machines nearer than `CLEAR` to each other come nearer by at most that, if they part."""

TOUCH = 1e-6
"""Metres. Machines at this distance touch."""

THERE = 1e-3
"""Metres and radians. Nearer than this is there."""

PATIENCE = 5.0
"""Seconds after which a machine looks for a way around one that stands, and again twice as long."""

LONGEST = 120.0
"""Seconds. Longest time between two looks."""

SHORT = 5.0
"""Seconds that a detour around a machine that stands may take more at once."""


class Coordinator(Protocol):
    """What a claimant tells and asks the others together."""

    stage: Stage

    def changed(self, claimant: Claimant) -> None:
        """Let the machines that wait for this one look whether they can go on."""

    def went_on(self, claimant: Claimant) -> None:
        """Take note that a machine waits no longer."""

    def gave_way(self, claimant: Claimant) -> None:
        """Let no machine wait until one has passed that has given up its right of way."""

    def untangle(self, among: Claimant) -> bool:
        """Resolve the circle of machines that wait for each other with one, if there is any."""
        ...


class Claimant:
    """A machine with its claim."""

    def __init__(self, coordinator: Coordinator, machine: Machine, order: int) -> None:
        self.machine = machine
        self.name = machine.name
        self.peers: list[Claimant] = []
        """Machines that it may meet."""
        self.claim: Area
        """The area that it covers until its next look."""
        self.waiting: WaitForMachines[Claimant] | None = None
        self.waiting_time = 0.0
        state, now = machine.body.state, coordinator.stage.clock.now
        self.stops = machine.stopping(state, now) is not None
        """Whether it is known how it stops."""
        self._seconds = PART if self.stops else UNKNOWN_PART
        self._company = coordinator
        self._clock = coordinator.stage.clock
        self._footprint = footprint_of(machine.shape, CLEAR)
        self._evading = machine if isinstance(machine, Evading) else None
        self._margins = [footprint_of(machine.shape, clear) for clear in MARGINS]
        self._bare = self._margins[-1]
        self._usual = self._margins if self._evading is not None else self._margins[-1:]
        self._kept = self._usual
        """Footprints with the margin that it keeps on its present path, and with smaller ones."""
        self._course = machine.body.motion
        """The motion on which it set out last."""
        self._left_at: float | None = None
        """When it left that motion to stop, if it did."""
        self._order = order
        self.goal = machine.goal
        """Its present goal, or the last one."""
        self._since = now
        """When it got that goal, or gave up its right of way."""
        self.lets_pass: dict[Claimant, Point | None] = {}
        """Machines that it lets pass, with their goals."""
        self._aside: Pose | None = None
        """The passing place to which it is under way."""
        self._evaded_at = -math.inf
        """When it looked for another path last. Once at each time is enough."""
        self._alarm = Alarm(self._clock, self._ring, Turn.MOTION_ENDS)
        self._retry = Alarm(self._clock, self._look_again, Turn.MOTION_ENDS)
        self._claim(self._footprint.at(machine.body.state.position))

    def begin(self) -> None:
        """Claim what it sweeps from now on."""
        self.machine.body.on_change.append(self._changed)
        self._changed()

    @property
    def rank(self) -> tuple[int, float, int]:
        """Its right of way: those of a lower rank evade those of a higher one.

        Among machines of one priority, this is who has been under way to a goal for longest.
        """
        return self.machine.priority, -self._since, -self._order

    @property
    def rests(self) -> bool:
        """Whether it does not move."""
        return self.machine.body.motion.end <= self._clock.now

    @property
    def covered(self) -> Area:
        """The area that it covers now."""
        return self._bare.at(self.machine.body.state.position)

    @property
    def course(self) -> Area:
        """The area that it covers on its way to its goal, as far as that is known."""
        begin = self._clock.now if self._left_at is None else self._left_at
        ahead = self._footprint.swept(self._course, begin, max(begin, self._course.end))
        return Area.of([self.claim, ahead])

    @property
    def wide_course(self) -> list[Polygon]:
        """The polygons of its course, with the distance that others keep from it."""
        return [*shapely.buffer(self.course.parts, 2 * MARGINS[0], join_style="mitre")]

    def blockers(self, ahead: Sequence[Sequence[Pose]]) -> list[Claimant]:
        """Return the machines that keep it from moving along poses."""
        here = [ahead[0][0]]
        found = []
        for footprint in self._kept:
            area = Area.of([footprint.along(poses) for poses in ahead])
            found = [peer for peer in self.peers if area.meets(peer.claim)]
            if footprint is self._kept[0]:
                found += [one for one in self._let_pass(area) if one not in found]
            # Beside who is nearer already, a smaller distance must do.
            if not any(footprint.along(here).meets(peer.claim) for peer in found):
                return found
        return [peer for peer in found if not self._parts_from(peer, ahead)]

    def _parts_from(self, peer: Claimant, ahead: Sequence[Sequence[Pose]]) -> bool:
        """Return whether it comes hardly nearer to a machine that stands."""
        if not peer.rests:
            return False
        gap = self.covered.distance(peer.covered)
        kept = shapely.buffer(peer.covered.parts, max(gap - NEARER, -TOUCH))
        return not any(
            shapely.intersects(self._bare.along(poses).parts[:, None], kept).any()
            for poses in ahead
        )

    def _let_pass(self, area: Area) -> list[Claimant]:
        """Return the machines that it lets pass before it moves into an area."""
        self._forget_passed()
        if self._aside is not None:
            return []
        return [one for one in self.lets_pass if area.meets(one.course)]

    def _forget_passed(self) -> None:
        """Forget those who have another goal since."""
        self.lets_pass = {one: goal for one, goal in self.lets_pass.items() if one.goal == goal}

    def reconsider(self) -> None:
        """Go on if the area for which it waits is free."""
        assert self.waiting is not None
        before, self.waiting.blockers = self.waiting.blockers, self.blockers(self.waiting.ahead)
        if not self.waiting.blockers:
            self._go_on()
        elif before != self.waiting.blockers:
            self.look_soon()

    def look_soon(self) -> None:
        """Look for another path as soon as it rests, if it waits."""
        if self.waiting is not None:
            self.waiting.looks = 0
            self._retry.set(max(self._clock.now, self.machine.body.motion.end))

    def evade(self, circle: Iterable[Claimant]) -> bool:
        """Take another path, or let others pass at a passing place; return whether it can.

        It lets those of a higher rank pass. If there are none, it gives up its right of way.
        """
        machine, now = self._evading, self._clock.now
        if machine is None or not self._may_look():
            return False
        self._forget_passed()
        others = [one for one in circle if one is not self]
        first = [one for one in others if one.rank > self.rank]
        kept_free = dict.fromkeys((*others, *self.lets_pass))
        courses = [polygon for one in kept_free for polygon in one.wide_course]
        evasion = self._with_margin(lambda taken: machine.evade(taken, courses))
        if evasion is None:
            return False
        self._company.stage.record(
            MachineEvades(
                machine=self.name,
                for_machine=max(others, key=lambda one: one.rank).name,
                to=None if evasion.aside is None else evasion.aside[:2],
            )
        )
        if not first:
            self._since = now
            self._company.gave_way(self)
        self._aside = evasion.aside
        if evasion.aside:
            self.lets_pass |= {one: one.goal for one in first or others}
        self._go_on()
        return True

    def _may_look(self) -> bool:
        """Return whether it rests, and looks for another path for the first time at this time."""
        if not self.rests or self._evaded_at == self._clock.now:
            return False
        self._evaded_at = self._clock.now
        return True

    def close(self) -> None:
        """Count the time that it waited until now: the trial is over."""
        if self.waiting is not None:
            self.waiting_time += self._clock.now - self.waiting.since

    def _with_margin(self, path: Callable[[list[Polygon]], T | None]) -> T | None:
        """Return what is found around the claims of others, with the largest margin possible."""
        for k, wider in enumerate(MARGINS, 1):
            if (found := path(self.taken(wider))) is not None:
                self._kept = self._margins[k:] or [self._bare]
                return found
        return None

    def taken(self, margin: float) -> list[Polygon]:
        """Return what other machines nearby claim, so many metres larger.

        Those farther away have moved on before this one gets there. Of a machine whose claim this
        one is in already, the area is smaller, so that a path can begin where this one stands.
        """
        here = self.covered
        areas: list[Polygon] = []
        for peer in self.peers:
            if not peer.is_near([self]):
                continue
            if here.meets(peer.claim):
                by, parts = here.distance(peer.covered) - PLANNED, peer.covered.parts
                areas += shapely.buffer(parts, by).tolist()
            else:
                areas += shapely.buffer(peer.claim.parts, margin, join_style="mitre").tolist()
        return areas

    def is_near(self, others: Iterable[Claimant]) -> bool:
        """Return whether it claims an area near that of others."""
        return any(self.claim.gap(one.claim) < NEARBY for one in others)

    def _go_on(self) -> None:
        """Let the machine move again."""
        self._end_wait()
        self.machine.stand_for(TRAFFIC, False)

    def _end_wait(self) -> None:
        assert self.waiting is not None
        waited = self._clock.now - self.waiting.since
        self.waiting_time += waited
        self.waiting = None
        self._retry.set(None)
        self._company.went_on(self)
        self._company.stage.record(MachineProceeds(machine=self.name, waited=waited))

    def _changed(self) -> None:
        """Claim what its new motion sweeps."""
        motion, now = self.machine.body.motion, self._clock.now
        if self.machine.is_held:
            self._left_at = now if self._left_at is None else self._left_at
            self._claim(self._footprint.swept(motion, now, max(now, motion.end)))
            self._alarm.set(motion.end if motion.end > now else None)
            return
        goal = self.machine.goal
        if goal is None:
            self._aside = None
        elif goal != self.goal:
            self.goal, self._since = goal, now
            self._aside, self._kept = None, self._usual
            self.lets_pass.clear()
        if goal is None or math.dist(motion.state(motion.end).at, goal) < THERE:
            self._course, self._left_at = motion, None
        if not self._extended():
            # Not at once, because the machine is about to do more at this instant.
            self._clock.call_at(now, self._halt_unless_free, Turn.VIOLATION)
        elif self.waiting is not None:  # its controller has chosen a motion that is free
            self._end_wait()

    def _ring(self) -> None:
        if self.machine.is_held:
            self._claim(self._footprint.at(self.machine.body.state.position))
        else:
            self._halt_unless_free()

    def _extended(self) -> bool:
        """Claim the next part of the motion; return whether it is free."""
        motion, now = self.machine.body.motion, self._clock.now
        here = motion.state(now)
        if self._aside is not None and is_there(here.position, self._aside, THERE):
            self._aside = None
            for one in self.lets_pass:
                one.look_soon()
        if motion.end <= now:
            self._claim(self._footprint.at(here.position))
            self._alarm.set(None)
            return True
        part = Part.of(self.machine, motion, now, self._seconds)
        if self.blockers(part.courses):
            return False
        self._claim(Area.of([self._footprint.along(poses) for poses in part.courses]))
        self._alarm.set(part.end)
        return True

    def _halt_unless_free(self) -> None:
        """Brake, and wait until the next part is free."""
        motion, now = self.machine.body.motion, self._clock.now
        if self.machine.is_held or self._extended():
            return
        ahead = Part.of(self.machine, motion, now, self._seconds).courses
        before, since = self.waiting, now if self.waiting is None else self.waiting.since
        self.waiting = WaitForMachines(ahead, self.blockers(ahead), since)
        first = self.waiting.blockers[0]
        if before is None or before.blockers[:1] != [first]:
            self._company.stage.record(MachineWaiting(machine=self.name, for_machine=first.name))
        self.machine.stand_for(TRAFFIC, True)
        self._retry.set(self.machine.body.motion.end)
        self._company.changed(self)

    def _claim(self, area: Area) -> None:
        self.claim = area
        self._company.changed(self)

    def _look_again(self) -> None:
        """Look for a path around machines that stand, or let them make way."""
        now, waiting = self._clock.now, self.waiting
        if waiting is None:
            return
        waiting.looks += 1
        if self._others_move(waiting):
            waiting.looks = 1
        if self.waiting is waiting:
            self._retry.set(now + min(LONGEST, PATIENCE * 2 ** (waiting.looks - 1)))

    def _others_move(self, waiting: WaitForMachines[Claimant]) -> bool:
        """Let machines make way or evade, or take a detour; return whether any does."""
        stand = [one for one in waiting.blockers if one.rests and one.waiting is None]
        if any(one.makes_way_for(self) for one in stand):
            return True
        if stand and self._detour_around(stand[0], waiting):
            return True
        return self._company.untangle(self)

    def makes_way_for(self, other: Claimant) -> bool:
        """Move off the course of another machine if it has nothing to do; return whether it can."""
        machine = self._evading
        return machine is not None and machine.make_way(self.taken(CLEAR), other.wide_course)

    def _detour_around(self, stands: Claimant, waiting: WaitForMachines[Claimant]) -> bool:
        """Take another path around a machine that stands; return whether there is one."""
        machine = self._evading
        if machine is None or not self._may_look():
            return False
        most = SHORT if waiting.looks == 1 else math.inf
        if not self._with_margin(lambda taken: machine.detour(taken, most) or None):
            return False
        self._company.stage.record(MachineEvades(machine=self.name, for_machine=stands.name))
        self._go_on()
        return True
