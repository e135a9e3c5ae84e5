"""AGVs: drive on a lane, yield to people, and slow down or stop before obstacles."""

from __future__ import annotations

import math
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import replace
from functools import partial

import shapely

from floorplan import Gate, Lane, Point, rectangle
from navigation import CollisionWorld, Motion, agv_run, agv_stop, join, walk
from navigation.machines import AxisState, agv_stops, lane_state
from navigation.motion import State
from navigation.separation import required_at_speeds

from ...core.body import CONTACT, Body, Machine, MachineShape, commands
from ...core.clock import Alarm, Turn
from ...core.events import AgvBlocked, AgvMoved, AgvYielded
from ...core.scenario import AgvMove
from ...core.speed_zones import SLIGHT, Stretch, extent, parts_between, slow_areas
from ...core.stage import Stage
from ...safety.stopping_check import Pedestrian, Stoppable, StoppingCheck

MARGIN = 0.1
"""Metres. An AGV stops so far from what is in its way."""

Span = tuple[float, float]
"""Lane positions from the least to the greatest, metres."""


def part_within(lane: Lane, area: shapely.Geometry) -> Span | None:
    """Return the lane positions at which the AGV covers some of `area`, if there are any."""
    low, high = lane.limits
    middle = lane.position((low + high) / 2)
    # All that the AGV ever covers on its lane: from half a length before its first place to half a
    # length behind its last.
    swept = rectangle(middle, lane.direction, high - low + lane.length, lane.width)
    span = extent(area, swept, lane.origin, lane.direction)
    return None if span is None else (span[0] - lane.length / 2, span[1] + lane.length / 2)


def part_behind(lane: Lane, gate: Gate, at: float, to: float) -> Span | None:
    """Return the lane positions that `gate` closes to a run from `at` to `to`, if there are any.

    Those with the centre on its far side at which the AGV stands on its line: none to a run in its
    direction.
    """
    (nx, ny), (c, s) = gate.normal, lane.direction
    ahead = nx * c + ny * s
    if ahead * (to - at) >= 0:
        return None
    course = shapely.linestrings([lane.position(q) for q in lane.limits])
    crossing = shapely.intersection(course, shapely.linestrings(gate.ends))
    if crossing.is_empty:
        return None
    (x, y), (ox, oy) = shapely.get_coordinates(crossing)[0], lane.origin
    q = float((x - ox) * c + (y - oy) * s)
    # As a box at an angle to the line: half its length, and half its width times the tangent of the
    # angle between lane and gate's direction.
    reach = (lane.length + abs(ny * c - nx * s) / abs(ahead) * lane.width) / 2
    return (q, q + reach) if ahead > 0 else (q - reach, q)


def last_before(part: Span, at: float, to: float) -> float | None:
    """Return the last lane position before `part` on a run from `at` to `to`; None if it is clear.

    Who is in the part already stays.
    """
    low, high = part
    if to >= at:
        return None if high <= at or to <= low else max(at, low - MARGIN)
    return None if low >= at or to >= high else min(at, high + MARGIN)


def run_slowly(
    lane: Lane, state: AxisState, to: float, start: float, slow: Sequence[Stretch]
) -> Motion:
    """Return a run on `lane` to the position `to`, begun at `start` (seconds).

    It is no faster than the speed (m/s) of each of the parts that are driven `slow`ly. One that
    has to turn back, or is too fast for a part, brakes first.
    """
    at, speed = state.position, state.velocity
    way = 1.0 if to >= at else -1.0
    low, high = sorted((at, to))
    parts = parts_between(low, high, lane.max_speed, slow)
    if all(part.top_speed == lane.max_speed for part in parts):
        return agv_run(lane, state, to, start)
    if way < 0:
        parts.reverse()
    if speed * way >= 0.0 and low < high:
        ends = [part.end if way > 0 else part.begin for part in parts]
        with suppress(ValueError):  # too fast for a part
            motion = walk(
                [lane.position(q) for q in (at, *ends)],
                start,
                initial_speed=abs(speed),
                top_speed=[part.top_speed for part in parts],
                max_speed=lane.max_speed,
                max_acceleration=lane.max_acceleration,
            )
            return _looking_along(lane, motion)
    if abs(speed) < SLIGHT:
        return agv_run(lane, state, to, start)
    stop = agv_stop(lane, state, start)
    rested = lane_state(lane, stop.state(stop.end))
    # From rest there is nothing to brake for, so this calls itself once at most.
    onwards = run_slowly(lane, AxisState(rested.position), to, stop.end, slow)
    return Motion((*stop.pieces, *onwards.pieces))


def _looking_along(lane: Lane, motion: Motion) -> Motion:
    """Return `motion` with the rotation that an AGV has on its lane at all times."""
    rotation = (lane.heading, 0.0, 0.0, 0.0)
    return Motion(tuple(piece._replace(rotation=rotation) for piece in motion.pieces))


LOOK = 0.1
"""Seconds. An AGV that yields looks where people are no sooner than that after the last time."""

RESUME = 1.0
"""Seconds. An AGV that yields sets out if it may drive for so long; else it would creep."""


class Agv(Machine):
    """One AGV on its lane.

    One that `yields` looks where people are whenever they might matter, and stops on its lane
    while it still can before anybody comes too close, whatever they do. It drives on when its path
    is clear.
    """

    def __init__(
        self,
        stage: Stage,
        lane: Lane,
        moves: tuple[AgvMove, ...] = (),
        *,
        yields: bool = False,
    ) -> None:
        at = AxisState(lane.locations[lane.start])
        self.lane = lane
        self.shape = agv_shape(lane)
        motion = agv_run(lane, at, at.position, stage.clock.now)
        self.body = Body(stage.clock, lane.name, "agv", motion)
        self._stage = stage
        self._clock = stage.clock
        self._record = stage.record
        self._law = stage.rules.law_of(self.shape)
        shapes = stage.rules.shapes_of(self.shape, stage.widest)
        check = StoppingCheck(self._law, lane.max_speed, shapes)
        # The centre is farther off than the point, or the surface, to which distances are measured.
        self._beyond = math.hypot(*stage.rules.measured_at(self.shape)) + check.around
        self._moves = moves
        self._is_on_floor = any(lane is known for known in stage.floorplan.lanes)
        self._foresight = check if yields else None
        self._stops = agv_stops(lane)
        self._people: list[tuple[Body, float]] = []
        self._target: str | float | None = None
        self._under_way_to: str | float | None = None
        self._rest: tuple[Motion | None, float] = (None, 0.0)
        """The motion on which it has come to rest, and where on the lane that is (m)."""
        self._has_recorded = False
        self._held = False
        self._driven = lane
        """Its lane, with the top speed that it may have now."""
        self._arrival = Alarm(stage.clock, self._arrive, Turn.MOTION_ENDS)
        self._looking = Alarm(stage.clock, self._look, Turn.MOTION_ENDS)
        self._awaited: tuple[Body, float, float] | None = None
        """Who stands in its way while it stands, when it would look next, and how often (s)."""
        zones = stage.floorplan.zones
        self._slow = [
            Stretch(*span, limit)
            for area, limit in slow_areas(zones, lane.name)
            for span in [part_within(lane, area)]
            if span is not None
        ]
        self._forbidden = [
            (zone.name, part)
            for zone in zones
            if zone.forbidden and zone.is_about(lane.name)
            for part in [part_within(lane, zone.area)]
            if part is not None
        ]
        self._gates = [gate for gate in stage.floorplan.one_ways if gate.is_about(lane.name)]
        self._blocked: tuple[str, float] | None = None

    def begin(self) -> None:
        """Set out at the times of its moves."""
        for move in self._moves:
            self._clock.call_at(move.time, partial(self.drive, move.to))

    def foreseen(self, until: float) -> Motion:
        """Return its motion with the moves that the trial announces to begin by `until` (s).

        One that yields, or is held, drives as people let it: then what is under way counts alone.
        """
        motion, now = self.body.motion, self._clock.now
        if self._foresight is None and not self._held:
            for move in self._moves:
                if now <= move.time <= until:
                    at = lane_state(self.lane, motion.state(move.time))
                    motion = join([motion, agv_run(self.lane, at, move.to, move.time)])
        return motion

    def sets_out(self, after: float) -> float:
        """Return when its next announced move begins, later than `after` (s); infinite if never."""
        if self._foresight is not None or self._held:
            return math.inf
        return min((move.time for move in self._moves if move.time > after), default=math.inf)

    def stand_in(self, world: CollisionWorld) -> None:
        """Put it into `world` where it is now."""
        if self._is_on_floor:
            world.move_agv(self.name, self.lane_position)
        else:
            super().stand_in(world)

    @property
    def centre(self) -> Point:
        """The middle of the AGV (x, y)."""
        return self.lane.position(self.lane_position)

    @property
    def lane_position(self) -> float:
        """Position on the lane now (m)."""
        motion = self.body.motion
        if motion is self._rest[0]:
            return self._rest[1]
        position = lane_state(self.lane, self.body.state).position
        if motion.end <= self._clock.now:
            self._rest = motion, position
        return position

    @property
    def goal(self) -> Point | None:
        """The place (x, y) to which it is under way."""
        return None if self._target is None else self.lane.position(self._lane_goal)

    @property
    def may_leave(self) -> bool:
        """Whether it is under way, or moves again in the trial."""
        return self._target is not None or any(m.time >= self._clock.now for m in self._moves)

    @property
    def _lane_goal(self) -> float:
        """The lane position (m) to which it is under way, or how far it gets on its way there."""
        return self.lane.lane_position(self._goal())

    def stopping(self, state: State, t: float) -> Motion:
        """Return the stop on its lane from `state` at `t` (seconds)."""
        return agv_stop(self.lane, lane_state(self.lane, state), t)

    @property
    def stands(self) -> bool:
        """True while it is at rest with no target to set out for."""
        return self.body.motion.end <= self._clock.now and self._target is None

    def look_out_for(self, person: Body, top_speed: float) -> None:
        """Yield to this person, who walks at `top_speed` (m/s) at most, if it yields at all."""
        if self._foresight is not None:
            self._people.append((person, top_speed))
            person.on_jump.append(self._look)
            person.on_change.append(partial(self._changed, person))

    def zone(self, top_speed: float) -> float:
        """Return how far (metres) from its centre somebody must stand so that it can set out.

        For somebody who may walk at `top_speed` (m/s).
        """
        fastest = self.lane.max_speed
        if self._foresight is None:
            return required_at_speeds(self._law, 0.0, fastest) + self._beyond
        # While it drives for `RESUME` and then brakes, somebody may walk towards it.
        stopping = fastest / self.lane.max_acceleration
        kept = required_at_speeds(self._law, top_speed, fastest) + self._beyond
        return kept + top_speed * (RESUME + stopping)

    @commands
    def drive(self, to: str | float) -> None:
        """Set out for a location or a lane position (m), in place of the move under way."""
        self._target = to
        if self._held:
            return
        hindered = self._try()
        if hindered is not None and self._under_way_to is None:
            self._wait(hindered)
        # While it still drives elsewhere, it goes on till it looks: until then stopping is safe.

    def hold(self, stands: bool) -> None:
        """Brake and stand until `hold(False)`, then go on: a protective stop."""
        self._held = stands
        if stands:
            self._look_at(None)
            self._stop()
        elif self._target is not None:
            self.drive(self._target)

    @commands
    def limit_speed(self, speed: float | None) -> bool:
        """Drive no faster than `speed` (m/s) from now on, or as fast as the lane lets it."""
        fastest = self.lane.max_speed
        allowed = fastest if speed is None else min(speed, fastest)
        self._driven = self.lane if allowed == fastest else replace(self.lane, max_speed=allowed)
        if self._under_way_to is not None and self._target is not None and not self._held:
            hindered = self._try()
            if hindered is not None:
                self._wait(hindered)
        return True

    def sight_changed(self) -> None:
        """Look again: it sees people no longer, or again."""
        self._look()

    def contact_gone(self) -> None:
        """Go on after a contact."""
        self.stand_for(CONTACT, False)

    def floor_changed(self) -> None:
        """Go on, or stop, where something has opened or closed its lane."""
        if self._target is None or self._held or _same(self._hindrance(), self._blocked):
            return
        hindered = self._try()
        if hindered is not None:
            self._wait(hindered)

    def _hindrance(self) -> tuple[str, float] | None:
        """Return what is first in the way to the target, and the last lane position before it."""
        target, there = self._target, self._stage.active_closures
        if target is None or not (there or self._forbidden or self._gates):
            return None
        at, to = self.lane_position, self.lane.lane_position(target)
        closed = [*self._forbidden]
        behind = ((gate.name, part_behind(self.lane, gate, at, to)) for gate in self._gates)
        closed += [(name, part) for name, part in behind if part is not None]
        for one in there.values():
            part = part_within(self.lane, one.footprint)
            if part is not None and one.overlaps(0.0, self.lane.height):
                closed.append((one.name, part))
        found = [(name, q) for name, part in closed for q in [last_before(part, at, to)]]
        stops = [(name, q) for name, q in found if q is not None]
        return min(stops, key=lambda stop: abs(stop[1] - at), default=None)

    def _goal(self) -> str | float:
        """Return the target, or how far the AGV gets on its way there."""
        assert self._target is not None
        return self._target if self._blocked is None else self._blocked[1]

    def _run(self, state: AxisState, goal: str | float, now: float) -> Motion:
        """Return the run to `goal` from now on; one that can't stop there any more only stops."""
        if self._slow:
            motion = run_slowly(self._driven, state, self.lane.lane_position(goal), now, self._slow)
        else:
            motion = agv_run(self._driven, state, goal, now)
        if self._blocked is not None:
            stop = agv_stop(self.lane, state, now)
            reached = lane_state(self.lane, stop.state(stop.end)).position
            # Its stop ends beyond the last place before what is closed: nothing but braking is
            # left.
            if (reached - self._blocked[1]) * state.velocity > 0:
                return stop
        return motion

    def _try(self) -> Pedestrian | None:
        """Set out for the target, or return the person who makes that unsafe."""
        now, state = self._clock.now, lane_state(self.lane, self.body.state)
        before, self._blocked = self._blocked, self._hindrance()
        if self._blocked is not None and not _same(self._blocked, before):
            name, at = self._blocked
            self._record(AgvBlocked(agv=self.lane.name, by=name, at=at))
        target = self._goal()
        if self._blocked is not None and state.velocity == 0 and self._is_at(self._blocked[1]):
            return None
        motion = self._run(state, target, now)
        if self._foresight is not None:
            drives = self._under_way_to is not None
            hindered = self._look_ahead(self._foresight, motion, LOOK if drives else RESUME)
            if hindered is not None:
                return hindered
        self._record(AgvMoved(agv=self.lane.name, to=target, arrives=motion.end))
        self._under_way_to, self._has_recorded = target, False
        self.body.follow(motion)
        self._arrival.set(motion.end)
        return None

    def _is_at(self, q: float) -> bool:
        return abs(self.lane_position - q) < SLIGHT

    def _look(self) -> None:
        """Go on, stop, or set out again, as people allow."""
        if self._foresight is None or self._target is None or self._held:
            return
        if self._under_way_to == self._goal():
            hindered = self._look_ahead(self._foresight, self.body.motion, LOOK)
        else:
            hindered = self._try()
        if hindered is not None:
            self._wait(hindered)

    def _look_ahead(
        self, foresight: StoppingCheck, motion: Motion, least: float
    ) -> Pedestrian | None:
        """Return who makes it unsafe to follow `motion` for `least` seconds from now.

        None if it is safe; it then looks again when it may be no longer.
        """
        now = self._clock.now
        plan, people = Stoppable(motion, self._stops), self._seen()
        until, who = foresight.safe_until(plan, people, now, least)
        # Not even the least time is safe.
        if until == now and who is not None:
            return who
        self._look_at(until if who is not None else None)
        return None

    def _look_at(self, t: float | None) -> None:
        self._awaited = None
        self._looking.set(t)

    def _changed(self, person: Body) -> None:
        """Take note that a person sets out: look again, if it waited for that, when it would have.

        As long as both stand, every look would have the same answer.
        """
        if self._awaited is not None and self._awaited[0] is person:
            _, t, every = self._awaited
            # At one of the instants at which it would have looked, as if it had looked all along.
            while t < self._clock.now:
                t += every
            self._look_at(t)

    def _seen(self) -> list[Pedestrian]:
        """Return the people it looks out for, from the point at which distances are measured."""
        if self._stage.blind[self.name]:
            return []
        dx, dy = self._stage.rules.measured_at(self.shape)
        return [
            Pedestrian(body.name, (x - dx, y - dy), top_speed)
            for body, top_speed in self._people
            for x, y in (body.at,)
        ]

    def _wait(self, hindered: Pedestrian) -> None:
        """Stop, or go on standing, until the path is clear."""
        now, foresight = self._clock.now, self._foresight
        assert foresight is not None
        self._stop()
        state = self.body.state
        if not self._has_recorded:
            self._has_recorded = True
            self._record(
                AgvYielded(
                    agv=self.lane.name,
                    person=hindered.name,
                    distance=foresight.distance(hindered.at, state.position),
                    required=foresight.required(hindered.top_speed, state.speed),
                )
            )
        wait = LOOK
        if state.speed == 0.0:
            motion = self._run(lane_state(self.lane, state), self._goal(), now)
            plan = Stoppable(motion, self._stops)
            wait = max(wait, foresight.hindered_for(plan, hindered, now, RESUME))
        self._look_at(now + wait)
        person = next((body for body, _ in self._people if body.name == hindered.name), None)
        if state.speed == 0.0 and person is not None and person.motion.end <= now:
            self._looking.set(None)
            self._awaited = person, now + wait, wait

    def _stop(self) -> None:
        """Brake, if it drives."""
        if self._under_way_to is not None:
            self._under_way_to = None
            state = lane_state(self.lane, self.body.state)
            stop = agv_stop(self.lane, state, self._clock.now)
            self.body.follow(stop)
            self._arrival.set(stop.end)

    def _arrive(self) -> None:
        if self._under_way_to == self._target:
            self._target = None
            self._look_at(None)
        self._under_way_to = None
        self._stage.came_to_rest(self)


def _same(one: tuple[str, float] | None, other: tuple[str, float] | None) -> bool:
    if one is None or other is None:
        return one is other
    return one[0] == other[0] and abs(one[1] - other[1]) < SLIGHT


def agv_shape(lane: Lane) -> MachineShape:
    """Return the shape of the AGV on `lane`, as others see it."""
    return MachineShape(
        name=lane.name,
        kind="agv",
        category="vehicle",
        length=lane.length,
        width=lane.width,
        top=lane.height,
        top_speed=lane.max_speed,
        course=(lane.position(lane.limits[0]), lane.position(lane.limits[1])),
        direction=lane.direction,
    )
