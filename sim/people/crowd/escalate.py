"""Escalation: what a blocked person does, one rung of a ladder after the other."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable

from floorplan.files.dataclass import dataclass
from navigation.kernels.discs import Swath

from ...core.events import Blocked, Deadlock
from ...core.stage import Stage
from .commitments import Commitments, Hit
from .ground import Ground, length_of
from .make_room import Request
from .observe import Outlook
from .parameters import PARAMETERS
from .traveller import AT_THE_DOOR, Traveller


@dataclass(frozen=True, eq=False)
class Stuck:
    """A stationary person `me` without a free course, as `see` has it, and the first `hit`."""

    me: Traveller
    see: Outlook
    hit: Hit
    now: float

    @property
    def stood(self) -> float:
        """Time for which the person has stood, s."""
        return self.me.time_blocked(self.now)

    @property
    def may_act(self) -> bool:
        """Whether the other person stands too, and the reaction time is over."""
        stands = self.hit.at_rest and self.hit.other.body.motion.end <= self.now
        return stands and self.stood >= self.me.manners.reaction_time


class Ladder:
    """Rungs for people who cannot continue, in the order in which they are tried.

    `decide(me)` decides again, `commit_all(drafts, asker, see)` commits the drafts of a request.
    """

    def __init__(
        self,
        stage: Stage,
        commitments: Commitments,
        ground_of: Callable[[Traveller], Ground],
        decide: Callable[[Traveller], None],
        commit_all: Callable[[dict[Traveller, Swath], Traveller, Outlook], None],
    ) -> None:
        self.deadlocks = 0
        """Number of deadlocks."""
        self._stage = stage
        self._commitments = commitments
        self._ground_of = ground_of
        self._decide = decide
        self._commit_all = commit_all
        self._moved_at = -math.inf
        self._is_deadlocked = False

    def note_motion(self, now: float) -> None:
        """Note that a person has a new motion, which ends any deadlock."""
        self._moved_at, self._is_deadlocked = now, False

    def escalate(self, stuck: Stuck, under_way: Callable[[], Iterable[Traveller]]) -> float | None:
        """Try the rungs in turn; return when the person decides again (s), None if it is set.

        `under_way` returns all people with a goal.
        """
        me, now = stuck.me, stuck.now
        if self.arrive_beside_goal(stuck) or self.ask_to_make_room(stuck):
            return None
        if self.take_detour(stuck):
            return None
        self.report_blocked(stuck)
        self.report_deadlock(stuck, under_way)
        due = max(me.tries_again, now + PARAMETERS.apart)
        assert me.stands_since is not None
        if stuck.stood < me.manners.reaction_time:
            due = me.stands_since + me.manners.reaction_time
        elif not stuck.hit.at_rest:
            due = now + PARAMETERS.apart
        else:
            # The other stops in the way, or changes motion before, which wakes the person.
            due = max(due, min(stuck.hit.other.body.motion.end, now + PARAMETERS.again))
        return due if me.said else min(due, me.stands_since + me.manners.patience)

    def arrive_beside_goal(self, stuck: Stuck) -> bool:
        """Arrive if other people occupy the goal and the person stands beside it."""
        me, now = stuck.me, stuck.now
        # Each errand takes at least the reaction time, so that two goals in reach of one position
        # are not reached at once.
        under_way = now - me.since >= me.manners.reaction_time
        if not under_way or not is_beside_goal(me, stuck.hit, self._commitments, now):
            return False
        me.continues(now)
        me.arriving.set(now)
        return True

    def ask_to_make_room(self, stuck: Stuck) -> bool:
        """Ask the people in the way to step aside.

        A person of lower rank than the other asks only once patience is lost, because the other
        may have asked without success.
        """
        me, hit, see, now = stuck.me, stuck.hit, stuck.see, stuck.now
        if not stuck.may_act:
            return False
        me.pause_longer(now)
        if not (me.rank < hit.other.rank or me.said):
            return False
        request = Request(me, now, self._commitments, self._ground_of, me.behind())
        if not request.succeeds(see, see.gone(hit.t)):
            return False
        self._commit_all(request.drafts, me, see)
        return True

    def take_detour(self, stuck: Stuck) -> bool:
        """Take a path around all stationary people, if it is worth the wait.

        The detour may be as long as the distance that the person would have walked in the time
        stood and in `PARAMETERS.detour_costs`. So longer waits accept longer detours.
        """
        if not stuck.may_act or stuck.me.rounded >= stuck.now:
            return False
        return self.walk_around(stuck.me, stuck.see, stuck.now, stuck.stood)

    def walk_around(self, me: Traveller, see: Outlook, now: float, lost: float) -> bool:
        """Take a path around all stationary people, if it is worth the time `lost`, s."""
        goal = me.goal
        assert goal is not None
        standing = see.standing(PARAMETERS.detour_around, see.at, goal)
        path = see.ground.detours.path(see.at, goal, standing, see.ground.legs)
        longest = see.whole + me.top_speed * (lost + PARAMETERS.detour_costs)
        if not path or length_of(path) > longest:
            return False
        me.goes_round = True
        see.send_by(path[1:])
        me.rounded = now
        self._decide(me)
        return True

    def report_blocked(self, stuck: Stuck) -> None:
        """Add the percept `blocked` when the patience is over."""
        me = stuck.me
        if stuck.stood >= me.manners.patience and not me.said:
            me.said = True
            self._stage.record(Blocked(person=me.name, by=stuck.hit.other.name))
            me.blocked()

    def report_deadlock(self, stuck: Stuck, under_way: Callable[[], Iterable[Traveller]]) -> None:
        """Record a deadlock if no person with a goal can continue.

        That is, at least two have a goal, people at rest block all of them, and no person has a new
        motion for some time. Vehicles and people who still move will make room.
        """
        if (
            not stuck.me.said
            or self._is_deadlocked
            or stuck.now - self._moved_at < PARAMETERS.deadlock
        ):
            return
        people = [*under_way()]
        if len(people) > 1 and all(_waits_for_rest(one, stuck.now) for one in people):
            self._is_deadlocked = True
            self.deadlocks += 1
            self._stage.record(Deadlock(people=[one.name for one in people]))


def _waits_for_rest(one: Traveller, now: float) -> bool:
    """Return whether a person has perceived `blocked`, and the one in the way has come to rest."""
    other = one.waits_for
    return one.said and other is not None and other.body.motion.end <= now


def is_beside_goal(me: Traveller, hit: Hit, table: Commitments, now: float) -> bool:
    """Return whether the person who blocks `me` is one of those around the goal.

    These are people on the goal or about to reach it, people as near to it as `me` within reach of
    it, and people farther away without a gap to one of them. So a closed ring grows from neighbor
    to neighbor around the goal.
    """
    here, goal, other = me.swath.place, me.goal, hit.other
    assert goal is not None
    if other.is_vehicle:
        return False
    leaves = goal == me.leaves_at
    if math.dist(here, goal) < (AT_THE_DOOR if leaves else PARAMETERS.in_reach):
        return math.dist(other.body.at, goal) < PARAMETERS.in_reach + me.radius
    far = math.dist(here, goal) >= PARAMETERS.beside
    if leaves or far or not hit.at_rest or other.body.motion.end > now:
        return False
    indices = table.indices
    return table.encloses(indices[me], indices[other], *goal, PARAMETERS.beside, now)


def is_no_nearer(me: Traveller, hit: Hit, ahead: Swath, table: Commitments, now: float) -> bool:
    """Return whether a person beside an occupied goal would end no nearer to it.

    Such a person would come back and start again, and never arrive.
    """
    goal = me.goal
    assert goal is not None
    return (
        hit.at_rest
        and me.body.motion.end <= now
        and math.dist(ahead.place, goal) >= math.dist(me.body.at, goal)
        and is_beside_goal(me, hit, table, now)
    )
