"""Crowd: all people on the floor, and the one rule that keeps them from ever overlapping.

Everybody is committed to a motion that ends in a standing, and the standing counts for ever. A
motion takes the place of an older one only if it keeps clear of everything that the others are
committed to. As the older one did so too, there is always one to fall back on, whatever else goes
wrong: bodies can't overlap.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from contextlib import suppress
from functools import partial

from floorplan import Point
from navigation import CollisionWorld, Motion, PlanningError, join, standing, stop_walking
from navigation.walking import Swath, first_conflict, swath

from ...core.clock import Alarm, Turn
from ...core.events import Blocked, Deadlock, GaveWay, Met
from ...core.stage import Stage
from .outlook import Ground, Outlook
from .requests import Request
from .room import Place, places_at, room_near
from .steering import Foresighted, Steering, both_aside
from .traveller import AT_THE_DOOR, Traveller
from .vehicles import Vehicle
from .waiting import APART, Party, is_beside_goal, is_no_nearer, takes_way_round
from .whereabouts import GAP, Hit, Whereabouts

EARLY = 0.25
"""Seconds before braking would begin at which people decide anew."""

KEEPS, ANEW = 1.0, 2.0
"""Seconds that somebody keeps to a course that they don't wish for, at least, and until they look
again for a better one."""

DEADLOCK = 30.0
"""Seconds without any change of motion after which people who have lost patience are deadlocked."""

WORTH = 0.6
"""Metres. Who would lose more than this on their own looks whether both could shift aside."""

LATER = 0.1
"""Seconds from one stop to the next that are looked at before a place that has closed."""

LOOK = 0.5
"""Seconds from point to point of a recorded course that others step off."""


class Crowd:
    """The people of a stage among each other. They decide one after the other, each when due."""

    def __init__(self, stage: Stage, steering: Steering | None = None) -> None:
        self.steering: Steering = Foresighted() if steering is None else steering
        self.deadlocks = 0
        """Number of times that nobody under way could go on."""
        self._stage = stage
        self._clock = stage.clock
        self._parties: dict[Traveller, Party] = {}
        self._whereabouts = Whereabouts()
        self._grounds: dict[tuple[CollisionWorld, float], Ground] = {}
        self._committed = -math.inf
        """Time of the last change of motion of any person, s."""
        self._is_deadlocked = False
        """Whether a deadlock has been recorded since then."""
        self._met: dict[tuple[int, int], float] = {}
        self._coming: dict[Traveller, None] = {}
        """Parts of vehicles that have just changed what they are about to do."""
        self._minding = Alarm(stage.clock, self._mind_vehicles, Turn.MOTION_ENDS)
        self._vehicles = [
            Vehicle(stage, machine, self._whereabouts, self._notice) for machine in stage.vehicles
        ]

    def enter(
        self,
        me: Traveller,
        *,
        reroute: Callable[[Point], list[Point]],
        arrive: Callable[[], None],
        blocked: Callable[[], None],
    ) -> None:
        """Let somebody be one of the crowd from now on.

        `reroute` plans their path from a place on, `arrive` is called when they have reached their
        goal, `blocked` when they could not go on for as long as their patience lasts.
        """
        self._whereabouts.put(me)
        me.body.on_change.append(lambda: self._moved(me))
        self._parties[me] = Party(
            me,
            reroute,
            arrive,
            blocked,
            Alarm(self._clock, lambda: self._decide(me), Turn.MOTION_ENDS),
            Alarm(self._clock, arrive, Turn.MOTION_ENDS),
        )

    def room(
        self,
        place: Point,
        radius: float,
        me: Traveller | None = None,
        taken: Sequence[Place] = (),
        within: float = math.inf,
    ) -> Point | None:
        """Return the free place nearest to `place` for somebody to stand at for good.

        None if there is none near, `within` so many metres. Besides those of the crowd but `me`,
        others are about to stand where it is `taken`. Where something stands on `place`, it is one
        beside that.
        """
        world = self._stage.world if me is None else me.world
        vehicles = {machine.name for machine in self._stage.vehicles}
        places = places_at(world, place, radius, vehicles)
        if self.is_empty and not taken:
            return next(iter(places), None)
        ground, floor = partial(self._ground_in, world, radius), self._whereabouts
        now = self._clock.now
        rooms = (
            room_near(at, radius, ground, floor, now, me, taken, within + math.dist(at, place))
            for at in places
        )
        return next((at for at in rooms if at is not None), None)

    def set_out(self, me: Traveller, goal: Point, route: list[Point], top_speed: float) -> None:
        """Let somebody walk to `goal` by `route` (the points after where they are) from now on."""
        self._take_up(me, goal, route, top_speed)
        self._decide(me)

    def _take_up(self, me: Traveller, goal: Point, route: list[Point], top_speed: float) -> None:
        """Note where somebody goes from now on."""
        if me.goal != goal:
            party = self._parties[me]
            me.since, party.least_left = self._clock.now, math.inf
            # A motion that they have to keep for now ends at the goal before this one.
            party.arriving.set(None)
        self._whereabouts.send(me, goal, route)
        me.top_speed, me.goes_round = top_speed, False

    @property
    def is_shared(self) -> bool:
        """Whether there are several people on the floor, now or at other times."""
        return len(self._parties) > 1

    @property
    def is_empty(self) -> bool:
        """Whether a person alone can meet nothing: no vehicle drives, or will soon."""
        return not (self.is_shared or any(vehicle.is_there for vehicle in self._vehicles))

    def is_free(self, me: Traveller, motion: Motion) -> bool:
        """Return whether a motion of somebody conflicts with nobody, as far as is known."""
        if self.is_empty:
            return True
        ahead = swath(motion, self._clock.now)
        return self._whereabouts.others(me, ahead.box, self._clock.now).free(ahead)

    def _moved(self, me: Traveller) -> None:
        """Take note that somebody has committed themselves to something else."""
        if not self.is_empty:
            self._whereabouts.put(me)

    def walk_alone(
        self,
        me: Traveller,
        goal: Point,
        motion: Motion,
        top_speed: float,
        arrives: float,
    ) -> None:
        """Let somebody follow a free `motion` all the way to `goal`.

        They decide anew if a vehicle gets in its way; else they arrive there at `arrives` (s).
        """
        self._take_up(me, goal, [goal], top_speed)
        party = self._parties[me]
        party.goes_on(self._clock.now)
        party.deciding.set(None)
        party.arriving.set(arrives)
        me.body.follow(motion)

    def make_way_for(self, me: Traveller) -> None:
        """Let others mind the new motion of somebody who walks as they were measured."""
        now, ahead = self._clock.now, me.swath

        def in_the_way(other: Traveller) -> bool:
            return not self._whereabouts.only(me, other, now).free(ahead)

        others = self._whereabouts.others(me, ahead.box, now)
        for other in others:
            if other.goal is not None and in_the_way(other):
                self._decide(other)
        if not any(map(in_the_way, others)):
            return
        request = Request(me, now, self._whereabouts, self._ground)
        request.make_way(_course_of(me, now))
        for who, draft in request.drafts.items():
            if who is not me:
                self._give_way(who, draft, to=me)

    def _notice(self, discs: Sequence[Traveller]) -> None:
        """Let people mind what a vehicle is about to do, as soon as all of it is known."""
        if self._parties:
            if not self.is_shared:
                for me in self._parties:
                    self._whereabouts.put(me)
            self._coming.update(dict.fromkeys(discs))
            self._minding.set(self._clock.now)

    def _mind_vehicles(self) -> None:
        """Let those decide anew, or brake, who would run into a vehicle."""
        now, coming = self._clock.now, [*self._coming]
        self._coming.clear()

        def is_in_the_way(me: Traveller) -> bool:
            near = self._whereabouts.others(me, me.swath.box, now).of(coming)
            return not near.free(me.swath)

        for me, party in self._parties.items():
            if me.recorded or me.body.motion.end <= now or not is_in_the_way(me):
                continue
            self._decide(me)
            if is_in_the_way(me):
                braking = self.braking(me)
                if braking is not me.body.motion:
                    self._commit(party, braking, swath(braking, now))
                else:
                    self._stop_in_the_way(me, coming)

    def _stop_in_the_way(self, me: Traveller, coming: Sequence[Traveller]) -> None:
        """Let somebody stop who would stand in the way of a vehicle, and step off it then."""
        now, party = self._clock.now, self._parties[me]
        stop = self._stop(me, now)
        ahead = swath(stop, now)
        if self._whereabouts.others(me, ahead.box, now).without(coming).free(ahead):
            self._commit(party, stop, ahead)
            party.deciding.set(stop.end + EARLY)
            steps = partial(self._step_off, me, coming)
            self._clock.call_at(max(stop.end, now), steps, Turn.MOTION_ENDS)

    def _step_off(self, me: Traveller, coming: Sequence[Traveller]) -> None:
        """Let somebody who stands in the way of a vehicle step off it, if they can."""
        now = self._clock.now
        if me.body.motion.end > now:
            return
        for disc in coming:
            if self._whereabouts.only(me, disc, now).free(me.swath):
                continue
            request = Request(disc, now, self._whereabouts, self._ground)
            request.make_way(_course_of(disc, now))
            if me in request.drafts:
                for who, draft in request.drafts.items():
                    if not who.is_vehicle:
                        self._commit(
                            self._parties[who], draft.motion(who.body.state.position[2]), draft
                        )
                return

    def find(self, name: str) -> Traveller | None:
        """Return the one in the crowd who is called so."""
        return next((one for one in self._parties if one.name == name), None)

    def waits_for(self, me: Traveller) -> str | None:
        """Return the name of who keeps somebody from going on now."""
        other = self._parties[me].waits_for
        return None if other is None or me.stands_since is None else other.me.name

    def rest(self, me: Traveller) -> None:
        """Let somebody have no goal any more; their motion goes on."""
        party = self._parties[me]
        self._whereabouts.send(me, None, [])
        party.goes_on(self._clock.now)
        party.deciding.set(None)
        party.arriving.set(None)

    def has_room(self, me: Traveller, place: Point) -> bool:
        """Return whether somebody who stands at `place` for good is in nobody's way."""
        return not self.is_shared or self.is_free(me, standing(place, start=self._clock.now))

    def halt(self, me: Traveller, is_clear: Callable[[Motion], bool]) -> None:
        """Let somebody stop whose course has been closed: before that place, as far as they can.

        `is_clear` returns whether a motion of theirs stays out of it. Others in the way of the stop
        stop too.
        """
        # Whatever keeps this rule may come second to the other one: bodies never overlap.
        now, motion = self._clock.now, me.body.motion
        t = now
        while t < motion.end:
            stop = self._stop(me, t)
            if t > now and not is_clear(stop):
                break
            drafts = self._all_stop(me, stop)
            if drafts is not None:
                for who, (slower, ahead) in drafts.items():
                    self._commit(self._parties[who], slower, ahead)
                return
            t += LATER
        me.body.follow(self.braking(me))

    def _stop(self, me: Traveller, t: float) -> Motion:
        """Return the motion of somebody who goes on as they do until `t` (s), and stops then."""
        now, motion = self._clock.now, me.body.motion
        stop = stop_walking(motion, t, max_acceleration=me.human.max_acceleration)
        return join([motion.cut(now, t), stop]) if t > now else stop

    def _all_stop(
        self, me: Traveller, stop: Motion
    ) -> dict[Traveller, tuple[Motion, Swath]] | None:
        """Return the motions of all who stop at once, so that `me` can; None if somebody can't."""
        now = self._clock.now
        drafts = {me: (stop, swath(stop, now))}
        left = [me]
        while left:
            one = left.pop()
            mine = drafts[one][1]
            for other in self._whereabouts.others(one, mine.box, now):
                known = drafts.get(other)
                theirs = other.swath if known is None else known[1]
                if not _conflict(one, mine, other, theirs, now):
                    continue
                if known is not None or other.recorded or other.body.motion.end <= now:
                    return None
                slower = self._stop(other, now)
                drafts[other] = (slower, swath(slower, now))
                left.append(other)
        return drafts

    def braking(self, me: Traveller) -> Motion:
        """Return the earliest stop of somebody on their own course that is free."""
        now, motion = self._clock.now, me.body.motion
        if self.is_empty:
            return stop_walking(motion, now, max_acceleration=me.human.max_acceleration)
        others = self._whereabouts.others(me, me.swath.box, now)
        t = now
        while t < motion.end:
            stop = self._stop(me, t)
            # Braking at once may end where somebody else is to pass; the motion they follow is free
            # all along, so that a later stop on it is found, or its own end.
            if others.free(swath(stop, now)):
                return stop
            t += EARLY
        return motion

    # Decisions

    def _decide(self, me: Traveller) -> None:
        """Let somebody decide on a course, and set when they decide again."""
        party, now = self._parties[me], self._clock.now
        if me.goal is None:
            return
        try:
            outlook = self._outlook(me)
        except PlanningError:
            self._again(party, now + ANEW)
            return
        wished = outlook.wished
        if wished is None:  # they are there, or can only come to rest
            self._again(party, max(me.body.motion.end, now + APART))
            stands = outlook.speed < 1e-6 and me.body.motion.end <= outlook.t
            if stands and math.dist(outlook.at, me.goal) < 1e-6:
                party.arriving.set(max(outlook.t, now + EARLY))
            return
        party.looked = now
        hit = outlook.first_hit
        motion = self.steering.replan(me, outlook.others, outlook)
        if hit is not None:
            self._meet(me, hit, now)
        wish = motion is not None and outlook.is_wish(motion)
        if (
            hit is not None
            and motion is not None
            and is_no_nearer(me, hit, outlook.ahead(motion), self._whereabouts, now)
        ):
            motion = None
        loss = math.inf
        if motion is not None and ((hit is None and wish) or outlook.free(motion)):
            loss = wished.gone(outlook.t, math.inf)
            loss -= outlook.ahead(motion).gone(outlook.t, math.inf)
        else:
            motion = None
        if hit is not None and loss > WORTH and self._both_aside(me, outlook, hit, now):
            return
        if motion is not None:
            self._commit(party, motion, outlook.ahead(motion), outlook, wished=wish)
        elif hit is not None:
            self._wait(party, outlook, hit)
        else:
            self._again(party, now + APART)

    def _both_aside(self, me: Traveller, mine: Outlook, hit: Hit, now: float) -> bool:
        """Let two who meet head-on both shift to a side, if that is free; return whether it is."""
        other = hit.other
        if other.goal is None or now - other.decided < APART:
            return False
        if self._whereabouts.cosine(me, other, now) > -0.3:
            return False
        with suppress(PlanningError):
            for one, two, outlook in both_aside(me, mine, hit, lambda: self._outlook(other)):
                if _conflict(me, one, other, two, now):
                    continue
                self._commit(self._parties[me], mine.made(one), one, mine)
                self._commit(self._parties[other], outlook.made(two), two, outlook)
                return True
        return False

    def _wait(self, party: Party, outlook: Outlook, hit: Hit) -> None:
        """Let somebody wait who can't go on; after a while they ask to be let past."""
        me, now = party.me, self._clock.now
        if me.body.motion.end > now:
            self._again(party, min(now + APART, max(me.body.motion.end, now + EARLY)))
            return
        if me.stands_since is None:
            me.stands_since = now
        stood = now - me.stands_since
        # Vehicles tell themselves when they move.
        party.wait_for(None if hit.other.is_vehicle else self._parties[hit.other])
        assert me.goal is not None
        # Not at once, or who has just arrived could arrive at the next goal too without a step.
        under_way = now - me.since >= me.manners.reaction_time
        if under_way and is_beside_goal(me, hit, self._whereabouts, now):
            party.goes_on(self._clock.now)
            party.arriving.set(now)
            return
        stands = hit.at_rest and hit.other.body.motion.end <= now
        if stands and stood >= me.manners.reaction_time:
            party.pause_longer(now)
            # Of two who wait for each other the other may ask where the one has done so in vain.
            if (me.rank < hit.other.rank or party.said) and self._ask(me, outlook, hit):
                return
            if party.rounded < now and takes_way_round(me, outlook, stood):
                party.rounded = now
                self._decide(me)
                return
        if stood >= me.manners.patience and not party.said:
            party.said = True
            self._stage.record(Blocked(person=me.name, by=hit.other.name))
            party.blocked()
        if party.said:
            self._look_for_deadlock(now)
        due = max(party.tries_again, now + APART)
        if stood < me.manners.reaction_time:
            due = me.stands_since + me.manners.reaction_time
        elif not hit.at_rest:
            due = now + APART
        if not party.said:
            due = min(due, me.stands_since + me.manners.patience)
        self._again(party, due)

    def _look_for_deadlock(self, now: float) -> None:
        """Record a deadlock if people under way have lost patience and no person has moved."""
        if self._is_deadlocked or now - self._committed < DEADLOCK:
            return
        under_way = [party for me, party in self._parties.items() if me.goal is not None]
        if len(under_way) > 1 and all(party.said for party in under_way):
            self._is_deadlocked = True
            self.deadlocks += 1
            self._stage.record(Deadlock(people=[party.me.name for party in under_way]))

    def _ask(self, me: Traveller, outlook: Outlook, hit: Hit) -> bool:
        """Ask those in the way to step aside; return whether they did."""
        party, floor = self._parties[me], self._whereabouts
        request = Request(me, self._clock.now, floor, self._ground, party.behind())
        if not request.succeeds(outlook, outlook.gone(hit.t)):
            return False
        for who, draft in request.drafts.items():
            if who is me:
                self._commit(self._parties[me], outlook.made(draft), draft, outlook)
                continue
            self._give_way(who, draft, to=me)
        return True

    def _give_way(self, who: Traveller, draft: Swath, *, to: Traveller) -> None:
        """Let somebody step aside for another."""
        self._stage.record(GaveWay(person=who.name, to=to.name))
        self._commit(self._parties[who], draft.motion(who.body.state.position[2]), draft)

    def _commit(
        self,
        party: Party,
        motion: Motion,
        ahead: Swath,
        outlook: Outlook | None = None,
        *,
        wished: bool = False,
    ) -> None:
        """Let somebody follow a motion that was found free, and decide anew when it is due."""
        me, now = party.me, self._clock.now
        if outlook is not None:
            self._whereabouts.send(me, me.goal, outlook.course[1:])
            party.goes_on(self._clock.now)
        me.decided = self._committed = now
        self._is_deadlocked = False
        me.follow(motion, ahead)
        arrival = _arrival(me, motion, ahead.place, wished)
        party.arriving.set(None if arrival is None else max(arrival, now))
        if me.goal is None or (wished and arrival is not None):
            party.deciding.set(None)
        else:
            # Before they begin to brake for the stop at the end of what they look ahead: who
            # decides by then walks on at full speed.
            due = motion.last_begin - EARLY
            self._again(party, due if wished else max(min(due, now + ANEW), now + KEEPS))
        for other in party.kept:
            self._again(other, now + EARLY, sooner=True)

    def _again(self, party: Party, t: float, *, sooner: bool = False) -> None:
        if sooner:
            t = max(t, party.looked + APART)
        t = max(t, party.me.decided + APART, self._clock.now + EARLY)
        if sooner and party.deciding.time is not None:
            t = min(t, party.deciding.time)
        party.deciding.set(t)

    def _meet(self, me: Traveller, hit: Hit, now: float) -> None:
        """Record that somebody has to mind somebody else, once for each time that they meet."""
        if hit.other.is_vehicle:
            return
        pair = (min(me.index, hit.other.index), max(me.index, hit.other.index))
        if now - self._met.get(pair, -math.inf) > 2 * me.manners.foresight:
            self._stage.record(Met(person=me.name, other=hit.other.name))
        self._met[pair] = now

    # Surroundings

    def _outlook(self, me: Traveller) -> Outlook:
        party = self._parties[me]
        return Outlook(me, self._clock.now, self._whereabouts, self._ground(me), party.reroute)

    def _ground(self, me: Traveller) -> Ground:
        return self._ground_in(me.world, me.radius)

    def _ground_in(self, world: CollisionWorld, radius: float) -> Ground:
        if (world, radius) not in self._grounds:
            self._grounds[world, radius] = Ground(world, radius)
        return self._grounds[world, radius]


def _course_of(who: Traveller, now: float) -> list[Point]:
    """Return the places where somebody is from `now` (s) on, so far as they are committed."""
    motion = who.body.motion
    steps = math.ceil((motion.end - now) / LOOK)
    return [motion.state(now + k * LOOK).at for k in range(steps + 1)]


def _arrival(me: Traveller, motion: Motion, place: Point, wished: bool) -> float | None:
    """Return when somebody who follows a motion has arrived (s); None if it leads elsewhere.

    It ends at `place`; `wished` says whether others have left it as it is. Who leaves the floor is
    out before they would brake, not to keep the next ones inside, or where others make them stop.
    """
    if me.goal is None:
        return None
    away, leaves = math.dist(place, me.goal), me.goal == me.leaves_at
    if away >= 1e-6:
        return motion.end if leaves and not wished and away < AT_THE_DOOR else None
    brakes = motion.last_begin
    walks_out = leaves and math.dist(motion.state(brakes).at, me.goal) < AT_THE_DOOR
    return brakes if walks_out else motion.end


def _conflict(me: Traveller, mine: Swath, other: Traveller, theirs: Swath, now: float) -> bool:
    """Return whether where two people go conflicts."""
    least = me.radius + other.radius + GAP
    apart = math.dist(me.body.motion.state(now).at, other.body.motion.state(now).at)
    return first_conflict(mine, theirs, min(least, apart - 1e-9), now) is not None
