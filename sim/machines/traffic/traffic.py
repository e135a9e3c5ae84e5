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
        for one, other in itertools.combinations(claimants, 2):
            if may_meet(one.machine.shape, other.machine.shape):
                one.peers.append(other)
                other.peers.append(one)
        self._changes.clear()
        self._claimants = [one for one in claimants if one.peers]
        for one in self._claimants:
            one.begin()

    @property
    def waiting_times(self) -> dict[str, float]:
        """Time for which each machine that may meet others has waited for them (s), by name.

        Machines whose stop is unknown have their own figures only.
        """
        return {one.name: one.waiting_time for one in self._claimants if one.stops}

    def close(self) -> None:
        """Finish at the end of the trial."""
        for one in self._claimants:
            one.close()

    def changed(self, claimant: Claimant) -> None:
        """Check whether the machines that wait for this one can continue."""
        if any(one.waiting is not None for one in self._claimants):
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
        waits_for = {one: one.waiting.blockers for one in self._claimants if one.waiting}
        circle = circle_of(among, waits_for)
        if not circle or not all(one.rests for one in circle):
            return False
        behind = [
            one for one in waits_for if one not in circle and leads_to(one, circle, waits_for)
        ]
        *lower, first = sorted(circle, key=_rank)
        if any(one.evade(circle) for one in (*lower, *sorted(behind, key=_rank), first)):
            return True
        peers = {peer for one in circle for peer in one.peers}
        if any(not one.rests and one.is_near(circle) for one in peers):
            return False  # that machine leaves, or makes room
        assert among.waiting is not None
        if among.waiting.looks > 1 and frozenset(circle) not in self._stuck:
            self._stuck.add(frozenset(circle))
            self.deadlocks += 1
            self.stage.record(TrafficDeadlock(machines=[one.name for one in circle]))
        return False

    def gave_way(self, claimant: Claimant) -> None:
        """End all waits for a machine that has given up its right of way."""
        for one in self._claimants:
            one.lets_pass.pop(claimant, None)

    def proceeded(self, claimant: Claimant) -> None:
        """Count a deadlock of this machine again, because its wait has ended."""
        self._stuck = {circle for circle in self._stuck if claimant not in circle}

    def _reconsider(self) -> None:
        changes, self._changes = self._changes, set()
        waiting = [one for one in self._claimants if one.waiting is not None]
        for one in sorted(waiting, key=_rank, reverse=True):
            if one.waiting is not None and not changes.isdisjoint((one, *one.waiting.blockers)):
                one.reconsider()


def _rank(claimant: Claimant) -> tuple[int, float, int]:
    return claimant.rank
