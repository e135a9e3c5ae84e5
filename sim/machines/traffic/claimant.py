"""Claimants: machines that claim the area ahead of them, wait for others, and evade them."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
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
from .waiting import Driving, GivingWay, WaitingForMachines

T = TypeVar("T")

PART = 1.0
"""Seconds of motion that a machine claims at a time, if it does not come to rest before."""

UNKNOWN_PART = 6.0
"""Seconds of motion that a machine claims at a time if its stop is unknown."""

NEARBY = 6.0
"""Metres. Claims that are farther away do not count in the search for another path."""

MARGINS: tuple[float, ...] = (0.05, CLEAR, 0.0)
"""Metres. Margins that a machine keeps from the claims of others, in the order of preference."""

PLANNED = 1.01e-3
"""Metres. Planned paths keep a little less than this distance from areas."""

NEARER = 1.1e-3
"""Metres. Most by which a machine may come nearer to one within `CLEAR`, if they part then."""

TOUCH = 1e-6
"""Metres. Machines at this distance touch."""

THERE = 1e-3
"""Metres and radians. Tolerance of goals and passing places."""

PATIENCE = 5.0
"""Seconds between the first two searches for another path. The interval doubles each time."""

LONGEST = 120.0
"""Seconds. Longest time between two searches."""

SHORT = 5.0
"""Seconds. Most additional time of a detour around a stationary machine at the first search."""


class Coordinator(Protocol):
    """Interface of the traffic for its claimants."""

    stage: Stage

    def changed(self, claimant: Claimant) -> None:
        """Check whether the machines that wait for this one can continue."""

    def proceeded(self, claimant: Claimant) -> None:
        """Handle the end of a wait."""

    def gave_way(self, claimant: Claimant) -> None:
        """End all waits for a machine that has given up its right of way."""

    def untangle(self, among: Claimant) -> bool:
        """Resolve the cycle of machines that wait for each other, if there is one."""
        ...


class Claimant:
    """A machine with its claim.

    Its state is `Driving`, `GivingWay` on the way to a passing place, or `WaitingForMachines`. It
    begins to wait when the next part of its motion is not free. It returns to its former state when
    that area is free, when it finds another path, or when its controller chooses a free motion.
    """

    def __init__(self, coordinator: Coordinator, machine: Machine, order: int) -> None:
        self.machine = machine
        self.name = machine.name
        self.peers: list[Claimant] = []
        """Machines that it may meet."""
        self.claim: Area
        """Area that it covers until the claim is renewed."""
        self.state: Driving | GivingWay | WaitingForMachines[Claimant] = Driving()
        self.waiting_time = 0.0
        state, now = machine.body.state, coordinator.stage.clock.now
        self.stops = machine.stopping(state, now) is not None
        """Whether its stop is known."""
        self._seconds = PART if self.stops else UNKNOWN_PART
        self._traffic = coordinator
        self._clock = coordinator.stage.clock
        self._evading = machine if isinstance(machine, Evading) else None
        self._footprints = {margin: footprint_of(machine.shape, margin) for margin in MARGINS}
        self._usual_margins = MARGINS if self._evading is not None else MARGINS[-1:]
        self._margins = self._usual_margins
        """Margins that it keeps on its present path, in the order of preference."""
        self._course = machine.body.motion
        """Last motion that leads to its goal."""
        self._left_at: float | None = None
        """Time at which it left that motion to stop, if it did."""
        self._order = order
        self.goal = machine.goal
        """Its present goal, or the last one."""
        self._since = now
        """Time since which it has this goal, or since it gave up its right of way."""
        self.lets_pass: dict[Claimant, Point | None] = {}
        """Machines that it lets pass, with their goals."""
        self._searched_at = -math.inf
        """Time of the last search for another path. There is one at each time."""
        self._alarm = Alarm(self._clock, self._claim_ends, Turn.MOTION_ENDS)
        self._retry = Alarm(self._clock, self._search, Turn.MOTION_ENDS)
        self._claim(self._footprints[CLEAR].at(machine.body.state.position))

    def begin(self) -> None:
        """Claim the first part of the motion, and follow its changes."""
        self.machine.body.on_change.append(self._motion_changed)
        self._motion_changed()

    @property
    def waiting(self) -> WaitingForMachines[Claimant] | None:
        """Its state if it waits, otherwise None."""
        return self.state if isinstance(self.state, WaitingForMachines) else None

    @property
    def rank(self) -> tuple[int, float, int]:
        """Its right of way. Machines of a lower rank evade those of a higher one.

        Among machines of one priority, the longest one under way to its goal has the highest rank.
        """
        return self.machine.priority, -self._since, -self._order

    @property
    def rests(self) -> bool:
        """Whether it does not move."""
        return self.machine.body.motion.end <= self._clock.now

    @property
    def covered(self) -> Area:
        """The area that it covers now."""
        return self._footprints[0.0].at(self.machine.body.state.position)

    @property
    def course(self) -> Area:
        """The area that it covers on its way to its goal, as far as that is known."""
        begin = self._clock.now if self._left_at is None else self._left_at
        ahead = self._footprints[CLEAR].swept(self._course, begin, max(begin, self._course.end))
        return Area.of([self.claim, ahead])

    @property
    def wide_course(self) -> list[Polygon]:
        """The polygons of its course, enlarged by the distance that others keep from it."""
        return [*shapely.buffer(self.course.parts, 2 * MARGINS[0], join_style="mitre")]

    # Its claims.

    def _motion_changed(self) -> None:
        """Claim the first part of a new motion."""
        motion, now = self.machine.body.motion, self._clock.now
        if self.machine.is_held:
            self._left_at = now if self._left_at is None else self._left_at
            self._claim(self._footprints[CLEAR].swept(motion, now, max(now, motion.end)))
            self._alarm.set(motion.end if motion.end > now else None)
            return
        self._update_goal()
        goal = self.machine.goal
        if goal is None or math.dist(motion.state(motion.end).at, goal) < THERE:
            self._course, self._left_at = motion, None
        if not self._claim_next_part():
            # Later at this time, because the machine may change its motion again before.
            self._clock.call_at(now, self._halt_unless_free, Turn.VIOLATION)
        elif self.waiting is not None:  # its controller has chosen a motion that is free
            self._end_wait()

    def _update_goal(self) -> None:
        goal = self.machine.goal
        if goal is None:
            self._stop_giving_way()
        elif goal != self.goal:
            self.goal, self._since = goal, self._clock.now
            self._margins = self._usual_margins
            self._stop_giving_way()
            self.lets_pass.clear()

    def _stop_giving_way(self) -> None:
        if isinstance(self.state, WaitingForMachines):
            self.state.before = Driving()
        else:
            self.state = Driving()

    def _claim_ends(self) -> None:
        if self.machine.is_held:
            self._claim(self._footprints[CLEAR].at(self.machine.body.state.position))
        else:
            self._halt_unless_free()

    def _claim_next_part(self) -> bool:
        """Claim the next part of the motion. Return whether it is free."""
        motion, now = self.machine.body.motion, self._clock.now
        here = motion.state(now).position
        if (aside := self._aside) is not None and is_there(here, aside, THERE):
            self._stop_giving_way()
            for peer in self.lets_pass:
                peer.search_soon()
        if motion.end <= now:
            self._claim(self._footprints[CLEAR].at(here))
            self._alarm.set(None)
            return True
        part = Part(self.machine, motion, now, self._seconds)
        if self._blockers(part):
            return False
        self._claim(part.area(self._footprints[CLEAR]))
        self._alarm.set(part.end)
        return True

    def _claim(self, area: Area) -> None:
        self.claim = area
        self._traffic.changed(self)

    def _blockers(self, ahead: Part) -> list[Claimant]:
        """Return the machines that prevent it from moving on the next part of its motion."""
        blockers: list[Claimant] = []
        for margin in self._margins:
            footprint = self._footprints[margin]
            area = ahead.area(footprint)
            blockers = [peer for peer in self.peers if area.meets(peer.claim)]
            if margin == self._margins[0]:
                blockers += [peer for peer in self._to_let_pass(area) if peer not in blockers]
            # A machine within the margin already requires a smaller one.
            here = footprint.at(ahead.begin)
            if not any(here.meets(peer.claim) for peer in blockers):
                return blockers
        return [peer for peer in blockers if not self._parts_from(peer, ahead)]

    def _parts_from(self, peer: Claimant, ahead: Part) -> bool:
        """Return whether it hardly comes nearer to a stationary machine."""
        if not peer.rests:
            return False
        gap = self.covered.distance(peer.covered)
        forbidden = shapely.buffer(peer.covered.parts, max(gap - NEARER, -TOUCH))
        bare = ahead.area(self._footprints[0.0])
        return not shapely.intersects(bare.parts[:, None], forbidden).any()

    # Its waits.

    def _halt_unless_free(self) -> None:
        """Brake, and wait until the next part is free."""
        motion, now = self.machine.body.motion, self._clock.now
        if self.machine.is_held or self._claim_next_part():
            return
        ahead = Part(self.machine, motion, now, self._seconds)
        blockers = self._blockers(ahead)
        if isinstance(self.state, WaitingForMachines):
            announced, since, before = self.state.blockers[:1], self.state.since, self.state.before
        else:
            announced, since, before = [], now, self.state
        self.state = WaitingForMachines(ahead, blockers, since, before)
        if announced != blockers[:1]:
            name = blockers[0].name
            self._traffic.stage.record(MachineWaiting(machine=self.name, for_machine=name))
        self.machine.stand_for(TRAFFIC, True)
        self._retry.set(self.machine.body.motion.end)
        self._traffic.changed(self)

    def reconsider(self) -> None:
        """Continue if the area for which it waits is free."""
        assert isinstance(self.state, WaitingForMachines)
        before, self.state.blockers = self.state.blockers, self._blockers(self.state.ahead)
        if not self.state.blockers:
            self._proceed()
        elif before != self.state.blockers:
            self.search_soon()

    def _proceed(self) -> None:
        """Release the machine."""
        self._end_wait()
        self.machine.stand_for(TRAFFIC, False)

    def _end_wait(self) -> None:
        assert isinstance(self.state, WaitingForMachines)
        waited = self._clock.now - self.state.since
        self.waiting_time += waited
        self.state = self.state.before
        self._retry.set(None)
        self._traffic.proceeded(self)
        self._traffic.stage.record(MachineProceeds(machine=self.name, waited=waited))

    def close(self) -> None:
        """Count the time of an unfinished wait at the end of the trial."""
        if self.waiting is not None:
            self.waiting_time += self._clock.now - self.waiting.since

    # Its searches for another path.

    def search_soon(self) -> None:
        """Search for another path as soon as it rests, if it waits."""
        if self.waiting is not None:
            self.waiting.looks = 0
            self._retry.set(max(self._clock.now, self.machine.body.motion.end))

    def _search(self) -> None:
        """Search for a path around stationary machines, or request way from others."""
        now, waiting = self._clock.now, self.waiting
        if waiting is None:
            return
        waiting.looks += 1
        if self._others_move(waiting):
            waiting.looks = 1
        if self.waiting is waiting:
            self._retry.set(now + min(LONGEST, PATIENCE * 2 ** (waiting.looks - 1)))

    def _others_move(self, waiting: WaitingForMachines[Claimant]) -> bool:
        """Request way from other machines, or take a detour. Return whether any machine moves."""
        stationary = [peer for peer in waiting.blockers if peer.rests and peer.waiting is None]
        if any(peer.makes_way_for(self) for peer in stationary):
            return True
        if stationary and self._detour_around(stationary[0], waiting):
            return True
        return self._traffic.untangle(self)

    def makes_way_for(self, other: Claimant) -> bool:
        """Move off the course of another machine if idle. Return whether that is possible."""
        machine = self._evading
        return machine is not None and machine.make_way(self.taken(CLEAR), other.wide_course)

    def _detour_around(self, blocker: Claimant, waiting: WaitingForMachines[Claimant]) -> bool:
        """Take another path around a stationary machine. Return whether there is one."""
        machine = self._evading
        if machine is None or not self._may_search():
            return False
        limit = SHORT if waiting.looks == 1 else math.inf
        if not self._with_margin(lambda taken: machine.detour(taken, limit) or None):
            return False
        self._traffic.stage.record(MachineEvades(machine=self.name, for_machine=blocker.name))
        self._proceed()
        return True

    def evade(self, circle: Iterable[Claimant]) -> bool:
        """Evade by another path or at a passing place. Return whether that is possible.

        Machines of a higher rank pass first. If there are none, it gives up its right of way.
        """
        machine, now = self._evading, self._clock.now
        if machine is None or not self._may_search():
            return False
        self._forget_passed()
        others = [peer for peer in circle if peer is not self]
        higher = [peer for peer in others if peer.rank > self.rank]
        kept_free = dict.fromkeys((*others, *self.lets_pass))
        courses = [polygon for peer in kept_free for polygon in peer.wide_course]
        evasion = self._with_margin(lambda taken: machine.evade(taken, courses))
        if evasion is None:
            return False
        self._traffic.stage.record(
            MachineEvades(
                machine=self.name,
                for_machine=max(others, key=lambda peer: peer.rank).name,
                to=None if evasion.aside is None else evasion.aside[:2],
            )
        )
        if not higher:
            self._since = now
            self._traffic.gave_way(self)
        assert isinstance(self.state, WaitingForMachines)
        self.state.before = Driving() if evasion.aside is None else GivingWay(evasion.aside)
        if evasion.aside:
            self.lets_pass |= {peer: peer.goal for peer in higher or others}
        self._proceed()
        return True

    @property
    def _aside(self) -> Pose | None:
        """The passing place to which it is under way, or returns after a wait."""
        state = self.state.before if isinstance(self.state, WaitingForMachines) else self.state
        return state.aside if isinstance(state, GivingWay) else None

    def _to_let_pass(self, area: Area) -> list[Claimant]:
        """Return the machines that pass before this one moves into an area."""
        self._forget_passed()
        if self._aside is not None:
            return []
        return [peer for peer in self.lets_pass if area.meets(peer.course)]

    def _forget_passed(self) -> None:
        """Remove the machines that have another goal now."""
        self.lets_pass = {peer: goal for peer, goal in self.lets_pass.items() if peer.goal == goal}

    def _may_search(self) -> bool:
        """Return whether it rests, and has not searched for a path at this time."""
        if not self.rests or self._searched_at == self._clock.now:
            return False
        self._searched_at = self._clock.now
        return True

    def _with_margin(self, search: Callable[[list[Polygon]], T | None]) -> T | None:
        """Return the result of `search` around the claims of others, with the largest margin.

        On its path, the machine keeps the next smaller margin.
        """
        for margin in MARGINS:
            if (path := search(self.taken(margin))) is not None:
                self._margins = (
                    tuple(smaller for smaller in MARGINS if smaller < margin) or MARGINS[-1:]
                )
                return path
        return None

    def taken(self, margin: float) -> list[Polygon]:
        """Return the claims of machines nearby, enlarged by `margin` metres.

        Machines farther away have moved on before this one gets there. A claim that contains this
        machine already is reduced, so that a path can begin here.
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
        """Return whether its claim is near that of others."""
        return any(self.claim.gap(peer.claim) < NEARBY for peer in others)
