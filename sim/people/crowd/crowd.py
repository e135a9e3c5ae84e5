"""Crowd: people decide one after the other, each at their own time.

Each person has a committed motion that ends in an endless standstill. A new motion replaces it
only if it is free: if it has no conflict with any other committed motion. The old motion was free
too, so it always remains as a fallback. Therefore bodies never overlap.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from contextlib import suppress
from functools import partial

from floorplan import Point
from navigation import CollisionWorld, Motion, PlanningError, standing
from navigation.kernels.discs import Swath
from navigation.walking import motion_along, swath

from ...core.clock import Alarm, Turn
from ...core.events import GaveWay, Met
from ...core.stage import Stage
from .commitments import Commitments, Hit
from .escalate import Ladder, Stuck, is_no_nearer
from .ground import Ground
from .interrupt import Interruptions, meeting
from .observe import Outlook, whole_walk
from .parameters import PARAMETERS
from .propose import Foresighted, Steering, both_aside
from .room import Place, places_at, room_near
from .step_aside import StepsAside
from .traveller import AT_THE_DOOR, Traveller
from .vehicles import Vehicle


class Crowd:
    """The people of a stage, who avoid each other and moving vehicles.

    Parameters
    ----------
    stage : Stage
        The stage with clock, world and vehicles.
    steering : Steering, optional
        Method that chooses the motion of a person, by default `Foresighted`.
    """

    def __init__(self, stage: Stage, steering: Steering | None = None) -> None:
        self.steering: Steering = Foresighted() if steering is None else steering
        self._stage = stage
        self._clock = stage.clock
        self._people: dict[Traveller, None] = {}
        self._commitments = Commitments()
        self._grounds: dict[tuple[CollisionWorld, float], Ground] = {}
        self._met: dict[tuple[int, int], float] = {}
        self._ladder = Ladder(
            stage, self._commitments, self._ground, self.decide, self._commit_request
        )
        self._interruptions = Interruptions(
            stage, self._commitments, self._ground, self.decide, self._commit
        )
        self._steps_aside = StepsAside(
            stage.clock,
            self._commitments,
            self._people,
            self._ground,
            self.decide,
            self._commit,
            self._interruptions,
            lambda me, motion: any(one.strikes(me, motion, math.inf) for one in self._vehicles),
        )
        self._vehicles: list[Vehicle] = []
        self._vehicles = [
            Vehicle(stage, machine, self._commitments, self.notice) for machine in stage.vehicles
        ]

    # People

    def enter(
        self,
        me: Traveller,
        *,
        reroute: Callable[[Point], list[Point]],
        arrive: Callable[[], None],
        blocked: Callable[[], None],
    ) -> None:
        """Add a person to the crowd.

        Parameters
        ----------
        me : Traveller
            The person.
        reroute : callable
            Plans the route from a position to the goal.
        arrive : callable
            Called on arrival.
        blocked : callable
            Called when the person has been blocked for as long as their patience.
        """
        self._commitments.put(me)
        me.body.on_change.append(lambda: self._moved(me))
        me.reroute, me.arrive, me.blocked = reroute, arrive, blocked
        me.deciding = Alarm(self._clock, lambda: self.decide(me), Turn.MOTION_ENDS)
        me.arriving = Alarm(self._clock, arrive, Turn.MOTION_ENDS)
        me.stepping = Alarm(self._clock, lambda: self._steps_aside.step_aside(me), Turn.MOTION_ENDS)
        self._people[me] = None
        self._steps_aside.watch(me)

    def _moved(self, me: Traveller) -> None:
        """Update the table and the alarm before a vehicle after a change of motion."""
        if not self.is_empty:
            self._commitments.put(me)
            self._steps_aside.watch(me)

    @property
    def is_shared(self) -> bool:
        """Whether there are several people on the floor, now or at other times."""
        return len(self._people) > 1

    @property
    def is_empty(self) -> bool:
        """Whether a person alone can meet nothing: no vehicle drives, or will soon."""
        return not (self.is_shared or any(vehicle.is_there for vehicle in self._vehicles))

    @property
    def deadlocks(self) -> int:
        """Number of times that no person with a goal could continue."""
        return self._ladder.deadlocks

    def find(self, name: str) -> Traveller | None:
        """Return the person of this name, if any."""
        return next((one for one in self._people if one.name == name), None)

    def waits_for(self, me: Traveller) -> str | None:
        """Return the name of the person who blocks `me` now, if any."""
        other = me.waits_for
        return None if other is None or me.stands_since is None else other.name

    # Goals

    def set_out(self, me: Traveller, goal: Point, route: list[Point], top_speed: float) -> None:
        """Start to `goal` along `route` (the waypoints after the current position)."""
        self._set_goal(me, goal, route, top_speed)
        me.routed = self._clock.now
        self.decide(me)

    def rest(self, me: Traveller) -> None:
        """Clear the goal of a person. The motion continues."""
        self._commitments.set_goal(me, None, [])
        me.continues(self._clock.now)
        me.deciding.set(None)
        me.arriving.set(None)

    def _set_goal(self, me: Traveller, goal: Point, route: list[Point], top_speed: float) -> None:
        if me.goal != goal:
            me.since = me.neared = self._clock.now
            me.nearest = math.inf
            # A motion that they have to keep for now ends at the goal before this one.
            me.arriving.set(None)
        self._commitments.set_goal(me, goal, route)
        me.top_speed, me.goes_round = top_speed, False

    # Free motions

    def is_free(self, me: Traveller, motion: Motion) -> bool:
        """Return whether a motion has no conflict with any committed motion."""
        if self.is_empty:
            return True
        ahead = swath(motion, self._clock.now)
        return self._commitments.others(me, ahead.box, self._clock.now).free(ahead)

    def has_room(self, me: Traveller, place: Point) -> bool:
        """Return whether a person can stand at `place` without a conflict."""
        return self.is_free(me, standing(place, start=self._clock.now))

    def room(
        self,
        place: Point,
        radius: float,
        me: Traveller | None = None,
        taken: Sequence[Place] = (),
        within: float = math.inf,
    ) -> Point | None:
        """Return the free position nearest to `place` for a person to stand, or None.

        Parameters
        ----------
        place : Point
            Position, m. If a body stands on it, positions beside that are tried.
        radius : float
            Radius of the person, m.
        me : Traveller, optional
            The person, whom the search ignores.
        taken : sequence of (Point, float), optional
            Positions and radii that are reserved for other people.
        within : float, optional
            Maximum distance, m.
        """
        world = self._stage.world if me is None else me.world
        vehicles = {machine.name for machine in self._stage.vehicles}
        places = places_at(world, place, radius, vehicles)
        if self.is_empty and not taken:
            return next(iter(places), None)
        ground, floor = partial(self._ground_in, world, radius), self._commitments
        now = self._clock.now
        rooms = (
            room_near(at, radius, ground, floor, now, me, taken, within + math.dist(at, place))
            for at in places
        )
        return next((at for at in rooms if at is not None), None)

    # Interruptions

    def make_way_for(self, me: Traveller) -> None:
        """Make others react to the new motion of a recorded person."""
        self._interruptions.make_way_for(me)

    def notice(self, discs: Sequence[Traveller]) -> None:
        """Make people react to a new motion of a vehicle that consists of `discs`."""
        self._steps_aside.notice(discs)

    def halt(self, me: Traveller, is_clear: Callable[[Motion], bool]) -> None:
        """Stop before a place that has closed, as far as possible.

        `is_clear` returns whether a motion stays out of it. People in the way of the stop also
        stop.
        """
        self._interruptions.halt(me, is_clear)

    def braking(self, me: Traveller) -> Motion:
        """Return the earliest stop on the person's own course that is free."""
        return self._interruptions.braking(me, alone=self.is_empty)

    # Decisions

    def decide(self, me: Traveller) -> None:
        """Observe, propose, commit to the first free motion, or escalate."""
        now = self._clock.now
        if me.goal is None:
            return
        try:
            if self.is_empty:
                me.continues(now)
                self._commit(me, whole_walk(me, now), None, wished=True)
                return
            see = self._observe(me)
        except PlanningError:
            self._again(me, now + PARAMETERS.again)
            return
        if see.wished is None:
            self._arrive_or_brake(me, see)
            return
        me.looked = now
        me.note_course(see.whole, now)
        if me.strays(now):
            me.nearest, me.neared = math.inf, now
            if self._ladder.walk_around(me, see, now, PARAMETERS.strays):
                return
        hit = see.first_hit
        if hit is not None and self._may_start(hit, now):
            self.decide(hit.other)
            see.look_again()
            hit = see.first_hit
        if hit is not None:
            self._meet(me, hit, now)
        motion = self._first_free(me, see, hit)
        if motion is not None and any(
            one.surrounds(me) and one.strikes(me, motion, motion.end) for one in self._vehicles
        ):
            motion = None
        is_costly = hit is not None and self._loss(see, motion) > PARAMETERS.worth
        if hit is not None and is_costly and self._both_aside(me, see, hit, now):
            return
        if motion is not None:
            wished = see.is_wish(motion)
            self._commit(me, motion, see.ahead(motion), see, wished=wished)
        elif hit is None:
            self._again(me, now + PARAMETERS.apart)
        elif me.body.motion.end > now:
            # The old motion remains free.
            due = max(me.body.motion.end, now + PARAMETERS.early)
            self._again(me, min(now + PARAMETERS.apart, due))
        else:
            self._escalate(me, see, hit)

    def _may_start(self, hit: Hit, now: float) -> bool:
        """Return whether the person in the way may start first: they stand, but not blocked."""
        other = hit.other
        return (
            hit.at_rest
            and other.goal is not None
            and not other.recorded
            and now - max(other.decided, other.looked) >= PARAMETERS.again
            and other.arriving.time is None
        )

    def _observe(self, me: Traveller) -> Outlook:
        return Outlook(me, self._clock.now, self._commitments, self._ground(me))

    def _arrive_or_brake(self, me: Traveller, see: Outlook) -> None:
        """Handle a person who is at the goal, or can only come to rest."""
        now, goal = self._clock.now, me.goal
        self._again(me, max(me.body.motion.end, now + PARAMETERS.apart))
        stands = see.speed < 1e-6 and me.body.motion.end <= see.t
        if goal is not None and stands and math.dist(see.at, goal) < 1e-6:
            me.arriving.set(max(see.t, now + PARAMETERS.early))

    def _first_free(self, me: Traveller, see: Outlook, hit: Hit | None) -> Motion | None:
        """Return the motion that the steering proposes, if it is free and leads nearer."""
        motion = self.steering.replan(me, see.others, see)
        if motion is None or (hit is None and see.is_wish(motion)):
            return motion
        if hit is not None:
            ahead = see.ahead(motion)
            if is_no_nearer(me, hit, ahead, self._commitments, self._clock.now):
                return None
        return motion if see.free(motion) else None

    def _loss(self, see: Outlook, motion: Motion | None) -> float:
        """Return the distance by which a motion falls short of the preferred one, m."""
        if motion is None or see.wished is None:
            return math.inf
        return see.wished.gone(see.t, math.inf) - see.ahead(motion).gone(see.t, math.inf)

    def _both_aside(self, me: Traveller, see: Outlook, hit: Hit, now: float) -> bool:
        """Shift two people who meet head-on aside. Return whether that is free."""
        other = hit.other
        if other.goal is None or now - other.decided < PARAMETERS.apart:
            return False
        if self._commitments.cosine_between(me, other, now) > -0.3:
            return False
        with suppress(PlanningError):
            for one, two, theirs in both_aside(me, see, hit, lambda: self._observe(other)):
                if meeting(me, one, other, two, now) is not None:
                    continue
                self._commit(me, see.made(one), one, see)
                self._commit(other, theirs.made(two), two, theirs)
                return True
        return False

    def _escalate(self, me: Traveller, see: Outlook, hit: Hit) -> None:
        """Escalate for a blocked person."""
        now = self._clock.now
        if me.stands_since is None:
            me.stands_since = now
        # Vehicles notify people when they move.
        me.wait_for(None if hit.other.is_vehicle else hit.other)
        due = self._ladder.escalate(Stuck(me, see, hit, now), self._under_way)
        if due is not None:
            self._again(me, due)

    def _under_way(self) -> list[Traveller]:
        return [one for one in self._people if one.goal is not None]

    # Commitments

    def _commit(
        self,
        me: Traveller,
        motion: Motion,
        ahead: Swath | None,
        see: Outlook | None = None,
        *,
        wished: bool = False,
    ) -> None:
        """Commit a person to a motion that was found free, and set the next decision.

        `ahead` is its swath, None for the walk to the goal on an empty floor, and `see` the
        observation if they decided.
        """
        now = self._clock.now
        if see is not None:
            self._commitments.set_goal(me, me.goal, see.course[1:])
            me.continues(now)
        me.decided = now
        self._ladder.note_motion(now)
        me.follow(motion, ahead)
        place = me.goal if ahead is None else ahead.place
        arrival = _arrival(me, motion, place, wished)
        soonest = now if motion.end > now else now + PARAMETERS.reports
        me.arriving.set(None if arrival is None else max(arrival, soonest))
        if me.goal is None or (wished and arrival is not None):
            me.deciding.set(None)
        else:
            # A person who decides before braking begins continues at full speed.
            due = motion.last_begin - PARAMETERS.early
            if not wished:
                due = max(min(due, now + PARAMETERS.again), now + PARAMETERS.keeps)
            self._again(me, due)
        for other in me.kept:
            self._wake(other, now + PARAMETERS.early)

    def _commit_request(
        self, drafts: dict[Traveller, Swath], asker: Traveller, see: Outlook
    ) -> None:
        """Commit all people of a request together."""
        for who, draft in drafts.items():
            if who is asker:
                self._commit(who, see.made(draft), draft, see)
            else:
                self._stage.record(GaveWay(person=who.name, to=asker.name))
                self._commit(who, motion_along(draft, who.body.state.position[2]), draft)

    def _again(self, me: Traveller, t: float) -> None:
        """Set the next decision of a person, at `t` (s) at the earliest."""
        soonest = self._clock.now + PARAMETERS.early
        me.deciding.set(max(t, me.decided + PARAMETERS.apart, soonest))

    def _wake(self, me: Traveller, t: float) -> None:
        """Reschedule the decision of a waiting person to `t` (s) at the latest."""
        soonest = self._clock.now + PARAMETERS.early
        t = max(t, me.looked + PARAMETERS.apart, me.decided + PARAMETERS.apart, soonest)
        due = me.deciding.time
        me.deciding.set(t if due is None else min(t, due))

    def _meet(self, me: Traveller, hit: Hit, now: float) -> None:
        """Record an encounter of two people, once each time that they meet."""
        if hit.other.is_vehicle:
            return
        one, other = me.index, hit.other.index
        pair = (one, other) if one < other else (other, one)
        if now - self._met.get(pair, -math.inf) > 2 * me.manners.foresight:
            self._stage.record(Met(person=me.name, other=hit.other.name))
        self._met[pair] = now

    # The floor

    def _ground(self, me: Traveller) -> Ground:
        return self._ground_in(me.world, me.radius)

    def _ground_in(self, world: CollisionWorld, radius: float) -> Ground:
        if (world, radius) not in self._grounds:
            self._grounds[world, radius] = Ground(world, radius)
        return self._grounds[world, radius]


def _arrival(me: Traveller, motion: Motion, place: Point | None, wished: bool) -> float | None:
    """Return the time of arrival of a person who follows a motion to `place`, or None.

    `wished` is whether it is the preferred motion. A person who leaves the floor is removed before
    braking, so that the next ones are not kept inside, or on stopping near the exit.
    """
    if me.goal is None or place is None:
        return None
    away, leaves = math.dist(place, me.goal), me.goal == me.leaves_at
    if away >= 1e-6:
        return motion.end if leaves and not wished and away < AT_THE_DOOR else None
    if not leaves:
        return motion.end
    brakes = motion.last_begin
    return brakes if math.dist(motion.state(brakes).at, me.goal) < AT_THE_DOOR else motion.end
