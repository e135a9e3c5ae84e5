"""Drive of a vehicle: routes around obstacles and machines, and motions along them."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress

import shapely
from shapely.geometry import Polygon
from simpy.events import Event

from floorplan import Floorplan, Point
from navigation import (
    CollisionWorld,
    Disc,
    Motion,
    PlanningError,
    VehicleLimits,
    VehiclePath,
    VehiclePlanner,
    join,
    standing,
    vehicle_path,
    vehicle_stop,
)
from navigation.motion import State
from navigation.vehicle_planner import SLACK
from navigation.vehicles import Twist, stops_of

from ...core.body import Body, is_there
from ...core.clock import then
from ...core.entries import Pose
from ...core.events import MachineBlocked
from ...core.stage import Stage
from ..commanding import RETRY, Drive, Move
from ..traffic.evading import Evasion
from .passing import passing_places
from .shape import Chassis
from .slow_zones import SlowZones

LONGER = 15.0
"""Seconds. Most additional time of another route that is preferred to a passing place."""

TRIED = 6
"""Number of passing places to which paths are planned."""

ON_ROUTE = 1e-4
"""Metres and radians. Tolerance of poses on a route."""


def floor_of(vehicle: Chassis, name: str, plan: Floorplan) -> CollisionWorld:
    """Return the collision world of a vehicle of that name, with AGVs at their starts."""
    gates = [gate for gate in plan.one_ways if gate.is_about(name)]
    world = CollisionWorld(plan, top=vehicle.top, gates=gates)
    for zone in plan.zones:
        if zone.forbidden and zone.is_about(name):
            world.place(zone.name, zone.area)
    return world


class VehicleDrive(Drive):
    """Drive of a vehicle, which plans a route for each new target and follows it."""

    def __init__(
        self, stage: Stage, name: str, vehicle: Chassis, at: Pose, notify: Callable[[str], None]
    ) -> None:
        body = Body(stage.clock, name, "amr", standing(at[:2], heading=at[2]))
        super().__init__(stage.clock, body, disabled_or_enabled=notify)
        self.limits = vehicle.limits
        self.stops = stops_of(vehicle.limits)
        self.top_speed = vehicle.limits.top_speed
        self.stopping_distance = vehicle.limits.longest_stop.distance
        self.planner = VehiclePlanner(
            floor_of(vehicle, name, stage.floorplan), vehicle.footprint, limits=vehicle.limits
        )
        self._stage = stage
        self._shape = vehicle.shape(name)
        self._slow = SlowZones(stage.floorplan.zones, self._shape)
        self._people: dict[str, Disc] = {}
        """People whom routes avoid."""
        self._placed: set[str] = set()
        self._areas: list[str] = []
        """Names of areas that the planner avoids now."""
        self._route: list[Pose] = []
        self._target: tuple[float, ...] = ()
        """Target of the route: x, y, and the rotation if required."""
        self._closed: frozenset[str] = frozenset()
        """Closures around which the route leads."""
        self._blocked_from: Point | None = None
        """Goal of the last failed plan, until a plan succeeds."""
        self._waits_on: Motion | None = None
        """Stop of a move whose target other vehicles block."""
        self._floor_changed = stage.clock.event()
        self.planned_at = -math.inf
        """Time at which the present motion was planned, or the one from which it stops (s)."""
        self._last_stop = body.motion
        body.on_change.append(self._motion_changed)

    @property
    def world(self) -> CollisionWorld:
        """Collision world of the planner."""
        return self.planner.world

    def destination(self, target: Sequence[float]) -> Pose:
        """Return the pose at the end of the route to a target. `PlanningError` if there is none."""
        return self._route_to(tuple(map(float, target)))[-1]

    def _planned(self, target: tuple[float, ...], speed_share: float) -> Motion:
        """Return the motion along a route. `PlanningError` if there is none."""
        now, limits = self._clock.now, self.limits.slower(speed_share)
        route = self._route_to(target)
        try:
            return self._along(route, now, limits)
        except ValueError:  # it does not move along the route
            self.forget_route()
            self._route, self._target = self._from_rest(target), target
            return self._along(self._route, now, limits)

    def _along(self, route: list[Pose], now: float, limits: VehicleLimits) -> Motion:
        """Return the motion along a route, after a stop if the route begins elsewhere."""
        state, (first, *left) = self.body.state, route
        if first == state.position:
            return self._path(state, left, now, limits)
        stop = self.stopping(state, now)
        return join([stop, self._path(first, left, stop.end, limits)])

    def _path(
        self, current: State | Pose, poses: list[Pose], start: float, limits: VehicleLimits
    ) -> Motion:
        """Return the motion through poses, slow in zones that limit the speed."""
        if self._slow.areas and poses:
            return self._slow.path(current, poses, start, limits)
        return vehicle_path(current, poses, start, limits=limits)

    def _from_rest(self, target: tuple[float, ...]) -> list[Pose]:
        """Return the poses from the end of a stop to a target."""
        stop = self.stopping(self.body.state, self._clock.now)
        path = self.planner.plan(stop.state(stop.end).position, target)
        return [*map(_pose, path.poses.tolist())]

    def stopping(self, state: State, t: float) -> Motion:
        """Return the fastest stop from `state` at `t` (seconds), on the arc it drives on."""
        if t <= self.body.motion.start and not any(state.velocity):
            # At the begin of an arc, the acceleration of its spline does not count.
            self._last_stop = standing(state.at, heading=state.position[2], start=t)
        else:
            self._last_stop = vehicle_stop(state, t, limits=self.limits)
        return self._last_stop

    def _motion_changed(self) -> None:
        motion = self.body.motion
        if motion is not self._last_stop:
            planned = any(motion is preview for preview in self._previews.values())
            self.planned_at = self._clock.now if planned else -math.inf

    def resumed(self, target: Pose, speed_share: float) -> Motion:
        """Return the motion to `target` after a stop, or only a stop if there is no route now."""
        try:
            return self.preview(target, speed_share)
        except PlanningError as why:
            self.record_blocked(target, why)
            stop = self.stopping(self.body.state, self._clock.now)
            self._look_around(vehicles=False)
            with suppress(PlanningError):
                self.planner.plan(stop.state(stop.end).position, target)
                self._waits_on = stop
            return stop

    def pauses(self, move: Move) -> bool:
        """Return whether a move waits for other vehicles that block it."""
        if self.body.motion is not self._waits_on:
            return False
        then(self.change_of_floor(), move.proceed)
        return True

    def change_of_floor(self) -> Event:
        """Return the event after which a blocked vehicle plans again."""
        return self._floor_changed | self._clock.at(self._clock.now + RETRY)

    def floor_changed(self) -> None:
        """Notify moves that wait for a change of the floor."""
        changed, self._floor_changed = self._floor_changed, self._clock.event()
        changed.succeed()

    def record_blocked(self, target: Sequence[float], why: PlanningError) -> None:
        """Record that there is no path to `target`, once until a plan succeeds."""
        goal = (float(target[0]), float(target[1]))
        if goal != self._blocked_from:
            self._blocked_from = goal
            name, message = self.body.name, why.message
            self._stage.record(MachineBlocked(machine=name, goal=goal, message=message))

    def slowed(self, twist: Twist) -> Twist:
        """Return a twist on the same arc within the speed limit."""
        speed = math.hypot(twist.forwards, twist.sideways)
        share = min(1.0, self._limit / speed) if speed > 0.0 else 1.0
        return Twist(*(share * value for value in twist))

    def is_at(self, target: Sequence[float]) -> bool:
        """Return whether the vehicle rests at x, y, and at the rotation if there is one."""
        return is_there(self.body.state.position, target, ON_ROUTE) and (
            self.body.motion.end <= self._clock.now
        )

    def route_is_free(self) -> bool:
        """Return whether the rest of the route is free now."""
        left = self._rest_of_route()
        if left is None:
            return True
        self._look_around(leave=True)
        return self.planner.free_along(left)

    def avoid(self, people: Mapping[str, Point], aside: float) -> bool:
        """Plan around people from now on. Return whether the present route is given up.

        Routes keep `aside` metres from the bodies of people if there is room for that.
        """
        x, y, rotation = self.body.state.position
        here = self._shape.footprint((x, y), rotation)
        radius = self._stage.floorplan.human.radius + aside
        self._people = {}
        for name, at in people.items():
            # A smaller disc for people nearby, who must not block the start.
            clear = min(radius, here.distance(shapely.Point(at)) - 2 * SLACK)
            if clear > ON_ROUTE:
                self._people[f"person {name}"] = Disc(at, clear)
        if self.route_is_free():
            return False
        self.forget_route()
        return True

    @property
    def goal(self) -> Point | None:
        """End (x, y) of the route, if there is one."""
        return (self._target[0], self._target[1]) if self._route else None

    def detour(
        self, taken: Sequence[Polygon], most: float = math.inf, *, thorough: bool = True
    ) -> bool:
        """Take another route to the goal around areas. Return whether there is one.

        It takes at most `most` additional seconds. A search that is not thorough is fast.
        """
        rest = self._rest_of_route()
        if rest is None:
            return False
        route = self._path_to(rest[0], rest[-1], taken, thorough=thorough)
        if route is None or self.seconds(route) > self.seconds(rest) + most:
            return False
        self._take(route, rest[-1])
        return True

    def evade(self, taken: Sequence[Polygon], courses: Sequence[Polygon]) -> Evasion | None:
        """Take another route, directly or by a passing place off the `courses` of others."""
        rest = self._rest_of_route()
        if rest is None:
            return None
        if self.detour(taken, LONGER, thorough=False):
            return Evasion()
        paths = self._by_passing_place(rest[0], rest[-1], taken, courses)
        if paths is not None:
            there, onwards = paths
            self._take([*there, *onwards[1:]], rest[-1])
            return Evasion(aside=there[-1])
        return Evasion() if self.detour(taken) else None

    def make_way(self, taken: Sequence[Polygon], courses: Sequence[Polygon]) -> bool:
        """Go to a place off the `courses` of others. Return whether there is one."""
        paths = self._by_passing_place(self.body.state.position, None, taken, courses)
        if paths is None:
            return False
        there, _ = paths
        self._take(there, there[-1])
        self.move(there[-1], command=self.begin())
        return True

    def seconds(self, poses: Sequence[Pose]) -> float:
        """Return the approximate duration of a path (s)."""
        return self.planner.seconds(poses)

    def _take(self, route: list[Pose], target: Pose) -> None:
        """Take a route, whose end differs from the target by whole turns at most."""
        self.forget_route()
        self._route, self._target = route, target

    def _by_passing_place(
        self,
        here: Pose,
        goal: Pose | None,
        taken: Sequence[Polygon],
        courses: Sequence[Polygon],
    ) -> tuple[list[Pose], list[Pose]] | None:
        """Return the fastest path to a passing place, and the path from there to the goal."""
        self._put((*taken, *courses))
        places = [*itertools.islice(passing_places(self.planner, here), TRIED)]
        paths = []
        for place in places:
            there = self._path_to(here, place, taken)
            onwards = [place] if goal is None or there is None else self._path_to(there[-1], goal)
            if there is not None and onwards is not None:
                paths.append((there, onwards))
        return min(paths, key=lambda pair: sum(map(self.seconds, pair)), default=None)

    def _path_to(
        self,
        here: Pose,
        goal: Pose,
        taken: Sequence[Polygon] | None = None,
        *,
        thorough: bool = False,
    ) -> list[Pose] | None:
        """Return a path around areas, by default around vehicles that stay, or None."""
        if taken is None:
            self._look_around(leave=True)
        else:
            self._put(taken)
        try:
            path = self.planner.plan(here, goal, thorough=thorough)
        except PlanningError:
            return None
        finally:
            self._put(())
        return [*map(_pose, path.poses.tolist())]

    def _put(self, areas: Sequence[Polygon]) -> None:
        """Place areas in the collision world, instead of vehicles."""
        for name in self._areas:
            self.world.remove(name)
        self._areas = [f"area {k}" for k in range(len(areas))]
        if areas:
            self._look_around(leave=True, vehicles=False)
        for name, area in zip(self._areas, areas, strict=True):
            self.world.place(name, area)

    def forget_route(self) -> None:
        """Discard the route, so that the next motion is planned again."""
        self._route, self._target = [], ()
        self._previews.clear()

    def _route_to(self, target: tuple[float, ...]) -> list[Pose]:
        """Return the poses from here to a target, of the present route if it leads there.

        A vehicle on another route stops first.
        """
        closed = frozenset(self._stage.active_closures)
        if closed - self._closed and not self.route_is_free():
            self.forget_route()
        self._closed = closed
        rest = self._rest_of_route()
        if rest is not None and (target == self._target or is_there(rest[-1], target, ON_ROUTE)):
            return rest
        self._look_around()
        state = self.body.state
        stop = self.stopping(state, self._clock.now)
        start = stop.state(stop.end).position
        try:
            path = self.planner.plan(start, target)
        except PlanningError as why:
            path = self._plan_with_less(start, target, why)
        poses = [*map(_pose, path.poses.tolist())]
        self._route = [state.position, *poses] if _stops_straight(state, start) else poses
        self._target, self._blocked_from = target, None
        return self._route

    def _plan_with_less(
        self, start: Pose, target: tuple[float, ...], why: PlanningError
    ) -> VehiclePath:
        """Return a path around people, or without vehicles that may leave."""
        if self._people:
            self._people = {}
            self._look_around()
            try:
                return self.planner.plan(start, target)
            except PlanningError as again:
                why = again
        if not self._look_around(leave=True):
            raise why
        try:
            return self.planner.plan(start, target)
        except PlanningError:
            raise why from None

    def _rest_of_route(self) -> list[Pose] | None:
        """Return the present pose and the next ones of the route, or None off the route."""
        here = self.body.state.position
        if len(self._route) == 1 and _is_between(here, self._route[0], self._route[0]):
            return self._route
        for k, (one, other) in enumerate(itertools.pairwise(self._route)):
            if _is_between(here, one, other) and not _moves_back(self.body.state, one, other):
                # A turn that is almost complete ends at the begin of the next leg.
                drives = one[:2] != other[:2]
                turned = not drives or here[2] == one[2] or math.dist(here[:2], one[:2]) > ON_ROUTE
                self._route = [here, *self._route[k + 1 if turned else k :]]
                return self._route
        return None

    def _look_around(self, *, leave: bool = False, vehicles: bool = True) -> bool:
        """Update the collision world of the planner.

        It contains other vehicles at rest unless they wait in traffic, and with `leave` only those
        that stay. Return whether there are vehicles that may leave.
        """
        stage, world, now = self._stage, self.world, self._clock.now
        others = [machine for machine in stage.vehicles if machine.name != self.body.name]
        lanes = {lane.name for lane in stage.floorplan.lanes}
        stand = {
            machine.name
            for machine in others
            if machine.body.motion.end <= now and not machine.waits
        }
        may_leave = {m.name for m in others if m.name in stand and m.may_leave} - lanes
        there = stand - (may_leave if leave else set()) if vehicles else set()
        absent = {machine.name for machine in others} - there - lanes
        for name in (self._placed | absent) - stage.active_closures.keys() - self._people.keys():
            if name in {body.name for body in world.bodies}:
                world.remove(name)
        for closure in stage.active_closures.values():
            world.place(closure.name, closure.footprint, closure.bottom, closure.top)
        for name, disc in self._people.items():
            world.place(name, disc)
        self._placed = {*stage.active_closures, *self._people}
        for machine in others:
            if machine.name in there or machine.name in lanes:
                machine.stand_in(world)
        return bool(may_leave)


def _stops_straight(state: State, rest: Pose) -> bool:
    """Return whether a moving vehicle stops on the line of its motion."""
    (x, y, rotation), (vx, vy, _), _ = state
    dx, dy = rest[0] - x, rest[1] - y
    across = abs(vx * dy - vy * dx)
    return rotation == rest[2] and math.hypot(dx, dy) > 0 and across <= ON_ROUTE * state.speed


def _pose(numbers: Sequence[float]) -> Pose:
    x, y, rotation = numbers
    return (x, y, rotation)


def _moves_back(state: State, one: Pose, other: Pose) -> bool:
    """Return whether a vehicle moves from the second pose to the first."""
    (vx, vy, _) = state.velocity
    return vx * (other[0] - one[0]) + vy * (other[1] - one[1]) < 0


def _is_between(here: Pose, one: Pose, other: Pose) -> bool:
    """Return whether a pose is on the leg or turn between two poses."""
    (ax, ay), (bx, by) = one[:2], other[:2]
    length = math.dist((ax, ay), (bx, by))
    low, high = sorted((one[2], other[2]))
    if not low - ON_ROUTE <= here[2] <= high + ON_ROUTE:
        return False
    if length < ON_ROUTE:
        return math.dist(here[:2], (ax, ay)) < ON_ROUTE
    dx, dy = (bx - ax) / length, (by - ay) / length
    along = (here[0] - ax) * dx + (here[1] - ay) * dy
    across = (here[1] - ay) * dx - (here[0] - ax) * dy
    return -ON_ROUTE <= along <= length + ON_ROUTE and abs(across) < ON_ROUTE
