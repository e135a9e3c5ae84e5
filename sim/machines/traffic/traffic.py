"""Traffic: machines claim the area ahead of them, and wait where another machine has claimed it.

No machine commits to a motion that conflicts with the claims of others. A claim is the area that a
machine sweeps on the next part of its motion and on every stop from there. At the end of the part,
the machine claims the next one and releases the area behind it. If the next one is not free, the
machine brakes within its claim. Claims have no time, because people and protective stops delay
machines.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterable

from ...core.body import Machine
from ...core.clock import Turn
from ...core.events import TrafficDeadlock
from ...core.stage import Stage
from .areas import may_meet
from .claimant import Claimant
from .waiting import circle_of, leads_to


class Traffic:
    """Claims of the machines of a trial that may meet each other."""

    def __init__(self, stage: Stage, machines: Iterable[Machine]) -> None:
        self.stage = stage
        self.deadlocks = 0
        """Number of times that machines waited for each other, and none could evade."""
        self._changes: set[Claimant] = set()
        self._stuck: set[frozenset[Claimant]] = set()
        self._claimants: list[Claimant] = []
        claimants = [Claimant(self, machine, k) for k, machine in enumerate(machines)]
        for member, other in itertools.combinations(claimants, 2):
            if may_meet(member.machine.shape, other.machine.shape):
                member.peers.append(other)
                other.peers.append(member)
        self._changes.clear()
        self._claimants = [member for member in claimants if member.peers]
        for member in self._claimants:
            member.begin()

    @property
    def waiting_times(self) -> dict[str, float]:
        """Time for which each machine that may meet others has waited for them (s), by name.

        Machines whose stop is unknown have their own figures only.
        """
        return {member.name: member.waiting_time for member in self._claimants if member.stops}

    def close(self) -> None:
        """Finish at the end of the trial."""
        for member in self._claimants:
            member.close()

    def changed(self, claimant: Claimant) -> None:
        """Check whether the machines that wait for this one can continue."""
        if any(member.waiting is not None for member in self._claimants):
            if not self._changes:
                clock = self.stage.clock
                clock.call_at(clock.now, self._reconsider, Turn.MOTION_ENDS)
            self._changes.add(claimant)

    def untangle(self, among: Claimant) -> bool:
        """Resolve the cycle of machines that wait for each other with one, if there is one.

        Return whether a machine evades. The machines that wait for the cycle try after the others
        of it, and the one of the highest rank tries last.
        """
        self._reconsider()  # a machine that can continue is in no cycle
        waits_for = {
            member: member.waiting.blockers for member in self._claimants if member.waiting
        }
        circle = circle_of(among, waits_for)
        if not circle or not all(member.rests for member in circle):
            return False
        behind = [
            member
            for member in waits_for
            if member not in circle and leads_to(member, circle, waits_for)
        ]
        *lower, first = sorted(circle, key=_rank)
        if any(member.evade(circle) for member in (*lower, *sorted(behind, key=_rank), first)):
            return True
        peers = {peer for member in circle for peer in member.peers}
        if any(not member.rests and member.is_near(circle) for member in peers):
            return False  # that machine leaves, or makes room
        assert among.waiting is not None
        if among.waiting.looks > 1 and frozenset(circle) not in self._stuck:
            self._stuck.add(frozenset(circle))
            self.deadlocks += 1
            self.stage.record(TrafficDeadlock(machines=[member.name for member in circle]))
        return False

    def gave_way(self, claimant: Claimant) -> None:
        """End all waits for a machine that has given up its right of way."""
        for member in self._claimants:
            member.lets_pass.pop(claimant, None)

    def proceeded(self, claimant: Claimant) -> None:
        """Count a deadlock of this machine again, because its wait has ended."""
        self._stuck = {circle for circle in self._stuck if claimant not in circle}

    def _reconsider(self) -> None:
        changes, self._changes = self._changes, set()
        waiting = [member for member in self._claimants if member.waiting is not None]
        for member in sorted(waiting, key=_rank, reverse=True):
            if member.waiting is not None and not changes.isdisjoint(
                (member, *member.waiting.blockers)
            ):
                member.reconsider()


def _rank(claimant: Claimant) -> tuple[int, float, int]:
    return claimant.rank
