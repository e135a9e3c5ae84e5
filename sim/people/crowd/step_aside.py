"""Steps aside: people leave the course of a vehicle before it comes."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence

from navigation import Motion
from navigation.kernels.discs import Swath
from navigation.walking import motion_along, swath

from ...core.clock import Alarm, Clock, Turn
from .commitments import Commitments
from .ground import Ground
from .interrupt import Commit, Interruptions, course_of, meeting
from .make_room import Request, Retreating
from .parameters import PARAMETERS
from .traveller import Traveller


class StepsAside:
    """Reactions of people to vehicles whose announced motions meet theirs.

    A walking person decides again at once. `PARAMETERS.alarm` seconds before the vehicle comes, a
    person in the way walks to the nearest free place off its course, and tries again every
    `PARAMETERS.early` seconds if there is none.

    `people` are all people of the crowd, `decide(me)` makes a person decide again, and
    `struck(me, motion)` returns whether a vehicle strikes a person who follows `motion`.
    """

    def __init__(
        self,
        clock: Clock,
        commitments: Commitments,
        people: Mapping[Traveller, None],
        ground_of: Callable[[Traveller], Ground],
        decide: Callable[[Traveller], None],
        commit: Commit,
        interruptions: Interruptions,
        struck: Callable[[Traveller, Motion], bool],
    ) -> None:
        self._clock = clock
        self._commitments = commitments
        self._people = people
        self._ground_of = ground_of
        self._decide = decide
        self._commit = commit
        self._interruptions = interruptions
        self._struck = struck
        self._discs: dict[Traveller, None] = {}
        """Discs of all vehicles that have moved."""
        self._coming: dict[Traveller, None] = {}
        """Discs of vehicles that have just changed their motion."""
        self._reacting = Alarm(clock, self._react, Turn.MOTION_ENDS)

    def notice(self, discs: Sequence[Traveller]) -> None:
        """Schedule the reaction to a vehicle that has changed its motion."""
        self._discs.update(dict.fromkeys(discs))
        if self._people:
            if len(self._people) == 1:
                for me in self._people:
                    self._commitments.put(me)
            self._coming.update(dict.fromkeys(discs))
            self._reacting.set(self._clock.now)

    def _react(self) -> None:
        """Make people who walk into the way of a vehicle decide again, and set all alarms."""
        now, coming = self._clock.now, self._coming
        self._coming = {}
        for me in self._people:
            if me.recorded:
                continue
            others = self._commitments.others(me, me.swath.box, now)
            if me.goal is not None and not others.of(coming).free(me.swath):
                self._decide(me)
            self.watch(me)

    def watch(self, me: Traveller) -> None:
        """Set the alarm of a person before a vehicle comes."""
        if not self._discs or me.recorded:
            return
        t = self._met(me, me.swath)
        due = max(t - PARAMETERS.alarm, me.stepped + PARAMETERS.early, self._clock.now)
        if me.arriving.time is not None:  # a person who is about to arrive goes on from there
            due = max(due, min(me.arriving.time + PARAMETERS.early, t - PARAMETERS.hurry))
        me.stepping.set(None if t == math.inf else due)

    def _met(self, me: Traveller, ahead: Swath) -> float:
        """Return the time at which a vehicle meets a person with this swath (s), or infinity."""
        table, now = self._commitments, self._clock.now
        near = table.near(ahead.box, me.radius, table.indices[me])
        discs = (table.people[k] for k in near if table.people[k].is_vehicle)
        times = (meeting(me, ahead, disc, disc.swath, now) for disc in discs)
        return min((t for t in times if t is not None), default=math.inf)

    def step_aside(self, me: Traveller) -> None:
        """Walk off the course of a vehicle that still meets the person."""
        me.stepped = self._clock.now
        met = self._met(me, me.swath)
        if met < math.inf:
            for drafts in self._ways_out(me, met):
                for who, (motion, ahead) in drafts.items():
                    self._commit(who, motion, ahead)
                break
        self.watch(me)

    def _ways_out(
        self, me: Traveller, met: float
    ) -> Iterator[dict[Traveller, tuple[Motion, Swath]]]:
        """Yield motions with which no vehicle meets a person, or one later than `met` (s).

        The most comfortable are first.
        """
        now = self._clock.now
        stops = [*self._stops(me)]
        for stop, ahead in stops:
            others = self._commitments.others(me, ahead.box, now)
            if others.free(ahead) and self._met(me, ahead) == math.inf:
                yield {me: (stop, ahead)}
        discs = [disc for disc in self._discs if self._commitments.is_there(disc)]
        course = course_of(discs[0], now)

        def struck(walk: Swath) -> bool:
            return self._struck(me, motion_along(walk, me.body.state.position[2]))

        leads: list[Swath | None] = [ahead for _, ahead in stops] or [None]
        yielding = [
            Retreating(alone=True, margin=PARAMETERS.berth),
            Retreating(alone=True),
            Retreating(),
        ]
        if self._struck(me, me.body.motion):
            # The discs are larger than a vehicle, and their centres are inside.
            size = max(disc.radius for disc in discs)
            yielding.append(Retreating(alone=True, margin=-size, struck=struck))
        for manner in yielding:
            for lead in leads:
                request = Request(discs[0], now, self._commitments, self._ground_of)
                if request.step_aside(me, lead, discs, course, manner):
                    yield {
                        who: (motion_along(draft, who.body.state.position[2]), draft)
                        for who, draft in request.drafts.items()
                        if not who.is_vehicle
                    }
        for stop, ahead in stops[:1]:
            everybody = self._interruptions.all_stop(me, stop, among_vehicles=True)
            if everybody is not None and self._met(me, ahead) > met:
                yield everybody

    def _stops(self, me: Traveller) -> Iterator[tuple[Motion, Swath]]:
        """Yield the stops of a walking person from which they can step aside."""
        now = self._clock.now
        for delay in PARAMETERS.stops_after:
            if now + delay < me.body.motion.end:
                stop = self._interruptions.stop(me, now + delay)
                yield stop, swath(stop, now)
