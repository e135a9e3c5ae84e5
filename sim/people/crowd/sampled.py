"""Crowd in which a custom steering chooses all velocities at a fixed step.

All people under way change their velocity together at each multiple of the step. Between two steps
each motion is one exact piece of constant velocity. Nobody commits to anything beyond, and no
conflict is tested, so overlaps are possible.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from contextlib import suppress

import numpy as np

from floorplan import Point
from floorplan.files.dataclass import dataclass
from navigation import CollisionWorld, Motion, PlanningError
from navigation.motion import Piece

from ...core.clock import Alarm, Turn
from ...core.events import Blocked
from ...core.stage import Stage
from .crowd import Crowd
from .parameters import PARAMETERS
from .sampled_scene import (
    TINY,
    Flags,
    Floats,
    Indices,
    SampledScene,
    SampledSteering,
    WallSides,
)
from .traveller import Traveller

STEPS_PER_SECOND = 20
"""Rate of the steps, Hz."""

IN_REACH = 0.6
"""Distance from a goal at which a person has arrived, m. Repulsive forces of two walls, for
example, keep people 0.57 m away from a goal in a corner."""

WALLS_WITHIN = 2.0
"""Distance within which walls are observed, m. Common models ignore them farther away."""

SLOW = 0.2
"""Share of the top speed below which a person counts as blocked."""


@dataclass(frozen=True)
class _Walls:
    """Sides of the walls in a world, valid until the world changes."""

    changes: int
    sides: WallSides


class SampledCrowd(Crowd):
    """The people of a stage, steered together at each step.

    Parameters
    ----------
    stage : Stage
        The stage with clock, world and vehicles.
    model : SampledSteering
        Method that chooses all velocities of a step.
    seed : int
        Seed of the trial.
    """

    def __init__(self, stage: Stage, model: SampledSteering, seed: int) -> None:
        super().__init__(stage)
        self._model = model
        self._seed = seed
        self._tick = -1
        self._stepping = Alarm(stage.clock, self._step, Turn.MOTION_ENDS)
        self._walls: dict[CollisionWorld, _Walls] = {}
        self._replans: dict[Traveller, float] = {}
        """Earliest time of the next detour of each person who was pushed off the route, s."""

    @property
    def is_shared(self) -> bool:
        """True, because a person alone is steered by the same model."""
        return True

    def decide(self, me: Traveller) -> None:
        """Schedule the next step. All people decide together."""
        now = self._clock.now
        if me.goal is not None and self._stepping.time is None:
            tick = max(math.ceil(now * STEPS_PER_SECOND - 1e-6), self._tick + 1)
            self._stepping.set(max(tick / STEPS_PER_SECOND, now))

    def braking(self, me: Traveller) -> Motion:
        """Return the motion of a person who stops: the rest of the current step."""
        return me.body.motion

    def halt(self, me: Traveller, is_clear: Callable[[Motion], bool]) -> None:
        """Do nothing, because no motion is longer than a step."""

    def make_way_for(self, me: Traveller) -> None:
        """Do nothing, because the model observes recorded people at each step."""

    def notice(self, discs: Sequence[Traveller]) -> None:
        """Do nothing, because the model observes vehicles at each step."""

    def _step(self) -> None:
        """Handle arrivals, and set the velocities of all others until the next step."""
        now = self._clock.now
        self._tick = round(now * STEPS_PER_SECOND)
        bodies = [one for one in self._commitments.people if self._commitments.is_there(one)]
        at = np.array([one.body.at for one in bodies])
        velocity = np.array([_velocity(one, now) for one in bodies])
        stands = (velocity == 0.0).all(axis=1)
        bound = [k for k, one in enumerate(bodies) if one.goal is not None and not one.recorded]
        arrived = [k for k in bound if self._has_arrived(k, bodies, at, stands)]
        under_way = [k for k in bound if k not in arrived]
        velocity[arrived] = 0.0
        if under_way:
            scene = self._scene(bodies, at, velocity, under_way)
            chosen = self._model.velocities(scene)
            for k in under_way:
                self._follow(bodies[k], chosen[k], now)
            self._stepping.set((self._tick + 1) / STEPS_PER_SECOND)
        for k in arrived:
            bodies[k].arrive()

    def _has_arrived(self, k: int, bodies: Sequence[Traveller], at: Floats, stands: Flags) -> bool:
        """Return whether a person has arrived, perhaps beside a stationary one on the goal."""
        me = bodies[k]
        assert me.goal is not None
        away = math.dist(at[k], me.goal)
        if self._clock.now - me.since < me.manners.reaction_time:
            return False
        if away <= IN_REACH or away > PARAMETERS.in_reach:
            return away <= IN_REACH
        return any(
            stands[j] and j != k and math.dist(at[j], me.goal) < me.radius + other.radius
            for j, other in enumerate(bodies)
        )

    def _scene(
        self, bodies: Sequence[Traveller], at: Floats, velocity: Floats, under_way: list[int]
    ) -> SampledScene:
        """Return what the model knows."""
        desired, steered = np.zeros_like(at), np.zeros(len(bodies), dtype=bool)
        steered[under_way] = True
        for k in under_way:
            desired[k] = self._desired(bodies[k])
        wall_of, wall_at = self._near_walls(bodies, at, under_way)
        return SampledScene(
            step=1.0 / STEPS_PER_SECOND,
            seed=self._seed,
            at=at,
            velocity=velocity,
            desired=desired,
            radius=np.array([one.radius for one in bodies]),
            max_speed=np.array([one.human.max_speed for one in bodies]),
            steered=steered,
            wall_of=wall_of,
            wall_at=wall_at,
        )

    def _desired(self, me: Traveller) -> Point:
        """Return the velocity to the farthest visible waypoint of the route, m/s."""
        x, y = me.body.at
        route = self._route(me, (x, y))
        top = me.top_speed
        if me.zones:
            speeds = me.zones.along([(x, y), *route], top)[1]
            top = speeds[0] if isinstance(speeds, list) else speeds
        dx, dy = route[0][0] - x, route[0][1] - y
        away = math.sqrt(dx * dx + dy * dy)
        return (top * dx / away, top * dy / away) if away > TINY else (0.0, 0.0)

    def _route(self, me: Traveller, at: Point) -> list[Point]:
        """Return the waypoints ahead, from the planner if none is visible."""
        now, route = self._clock.now, me.route
        visible = self._ground(me).legs.farthest(*at, route)
        if visible > 0:
            route = route[visible:]
        elif visible < 0 and now >= self._replans.get(me, now):
            self._replans[me] = now + PARAMETERS.again
            with suppress(PlanningError):
                route = me.reroute(at)
        if len(route) > 1 and math.dist(at, route[0]) < 2 * me.top_speed / STEPS_PER_SECOND:
            route = route[1:]
        if route is not me.route:
            self._commitments.set_goal(me, me.goal, route)
        return route

    def _near_walls(
        self, bodies: Sequence[Traveller], at: Floats, under_way: list[int]
    ) -> tuple[Indices, Floats]:
        """Return the points of walls near the people under way, in the order of the bodies."""
        worlds: dict[CollisionWorld, list[int]] = {}
        for k in under_way:
            worlds.setdefault(bodies[k].world, []).append(k)
        owners, points = [], []
        for world, some in worlds.items():
            walls = self._walls.get(world)
            if walls is None or walls.changes != world.changes:
                walls = self._walls[world] = _Walls(world.changes, WallSides(world.walkable))
            who, where = walls.sides.near(at[some], WALLS_WITHIN)
            owners.append(np.array(some)[who])
            points.append(where)
        wall_of = np.concatenate(owners)
        order = np.argsort(wall_of, kind="stable")
        return wall_of[order], np.concatenate(points)[order]

    def _follow(self, me: Traveller, chosen: Floats, now: float) -> None:
        """Walk at the chosen velocity (m/s) until the next step, and note whether blocked."""
        vx, vy = map(float, chosen)
        speed = math.sqrt(vx * vx + vy * vy)
        x, y = me.body.at
        if speed > TINY:
            along_x, along_y = (x, vx, 0.0, 0.0), (y, vy, 0.0, 0.0)
            turned = (math.atan2(vy, vx), 0.0, 0.0, 0.0)
            end = (self._tick + 1) / STEPS_PER_SECOND
            me.body.follow(Motion((Piece(now, end, along_x, along_y, turned),)))
        if speed >= SLOW * me.top_speed:
            me.continues(now)
        elif me.stands_since is None:
            me.stands_since = now
        elif me.time_blocked(now) >= me.manners.patience and not me.said:
            me.said = True
            others = [one for one in self._people if one is not me]
            if others:
                nearest = min(others, key=lambda one: math.dist(one.body.at, me.body.at))
                self._stage.record(Blocked(person=me.name, by=nearest.name))
            me.blocked()


def _velocity(one: Traveller, now: float) -> Point:
    """Return the velocity of the step that ends now, or of a motion with other pieces, m/s."""
    state = one.body.motion.state(now) if one.recorded else one.body.motion.state_before(now)
    vx, vy = state.velocity[:2]
    return vx, vy
