"""Path planning for people and for the gantry, with explanations when there is no path."""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Hashable, Mapping, Sequence
from functools import partial
from typing import Any

import numpy as np
import shapely
from numpy.typing import ArrayLike

from floorplan import Floorplan, Point, UserError
from floorplan.files.problems import metres
from floorplan.files.values import require

from .bodies import Disc
from .catalog import ROADMAP, Path, PlannerChoice, PlanningError, Reason, Setting, Watch
from .freespace import STEP, FreeSpace, Gates
from .kernels.walks import distinct, is_place
from .roadmap import HAIR, Roadmap
from .roadmap_planner import SLACK, RoadmapQuestions
from .sampling import OmplQuery, sample_path
from .world import CollisionWorld

_HALVINGS = 8
"""Number of bisections of the radius at which a path opens, to 0.4 % of the radius."""

_WIDER = 1.01
"""Factor to the next radius if rounding admits one that does not fit."""

_QUARTER = 8
"""Sides of a quarter circle in computations for messages."""


def blocked_place(world: CollisionWorld, place: Point, end: str, radius: float) -> str:
    """Return why a disc of `radius` metres cannot be at `place`, the `end` of a path."""
    name, gap = world.nearest(place)
    at = f"the {end} ({place[0]:g}, {place[1]:g})"
    if name == "boundary" and gap == 0:
        return f"{at} is outside the boundary"
    if gap == 0:
        return f"{at} is inside {name}"
    what = "the boundary" if name == "boundary" else name
    return f"{at} is {metres(gap, radius)} m from {what}; a radius of {radius:g} m does not fit"


def explain_cut_off(
    world: CollisionWorld, start: Point, goal: Point, radius: float
) -> Callable[[], str]:
    """Return a function that explains why there is no path from `start` to `goal` at present.

    The explanation takes longer than the proof, so it is computed when it is read.
    """
    now = world.as_if()
    return lambda: _cut_off(now, start, goal, radius)


def _cut_off(world: CollisionWorld, start: Point, goal: Point, radius: float) -> str:
    """Find the radius at which `start` and `goal` become connected, by bisection."""
    between = f"from ({start[0]:g}, {start[1]:g}) to ({goal[0]:g}, {goal[1]:g})"
    walkable = world.walkable
    space = world.free_space(radius + HAIR)
    if space.together(start, goal):
        gates = " or ".join(world.gates.closing(space, start))
        return f"no way leads {between} but through {gates}, against the direction"
    fits, apart = 0.0, FreeSpace(walkable)
    if not apart.together(start, goal):
        link = _link(apart, start, goal)
        crossed = [name for name, shape in world.things() if link.intersects(shape)]
        walls = " with ".join(crossed) or "the boundary"
        return f"no way, however narrow, leads {between}: {walls} cuts it off"
    too_wide = radius
    # Finer corners than those of the planner may open a gap, so try a larger radius.
    while (apart := _space(walkable, too_wide)).together(start, goal):
        too_wide *= _WIDER
    # Bisect between a disc that passes and one that does not.
    for _ in range(_HALVINGS):
        middle = (fits + too_wide) / 2
        narrower = _space(walkable, middle)
        if narrower.together(start, goal):
            fits = middle
        else:
            too_wide, apart = middle, narrower
    fits = min(fits, radius)
    place = shapely.line_interpolate_point(_link(apart, start, goal), 0.5, normalized=True)
    one, other = _nearest_two(world, place)
    n = _digits(fits, radius)
    return (
        f"no way leads {between} for a radius of {radius:.{n + 1}g} m: the widest one is"
        f" {2 * fits:.{n}f} m wide between {one} and {other} at ({place.x:.2f}, {place.y:.2f}),"
        f" and {2 * radius:.{n}f} m are needed; a radius up to {fits:.{n}f} m would pass"
    )


def _space(walkable: shapely.Geometry, radius: float) -> FreeSpace:
    """Return the free space of a disc of `radius` metres with coarse corners."""
    return FreeSpace(walkable.buffer(-radius, quad_segs=_QUARTER))


def _digits(fits: float, radius: float) -> int:
    """Return the number of decimals that distinguish both radii."""
    return next(n for n in range(2, 9) if n == 8 or f"{fits:.{n}f}" != f"{radius:.{n}f}")


def _link(space: FreeSpace, start: Point, goal: Point) -> shapely.Geometry:
    """Return the shortest line between the pieces of `space` that contain start and goal."""
    ends = [
        shapely.Point(place) if (piece := space.piece_of(place)) is None else space.pieces[piece]
        for place in (start, goal)
    ]
    return shapely.shortest_line(*ends)


def _nearest_two(world: CollisionWorld, place: shapely.Point) -> tuple[str, str]:
    gaps = [("the boundary", float(world.plan.boundary.exterior.distance(place)))]
    gaps += [(name, float(shape.distance(place))) for name, shape in world.things()]
    (one, _), (other, _) = sorted(gaps, key=lambda named: named[1])[:2]
    return one, other


COARSE = math.radians(15.0)
"""Default turn of a path per waypoint in radians."""

TOO_CLOSE = 1e-3
"""Metres. Tolerance for a start that is too close to something."""

_STEP = HAIR / 100
"""Metres. Shorter segments are left out, because their direction is mostly rounding."""


class PathPlanner:
    """Planner of paths through a `CollisionWorld` for a disc.

    It reads the world when a path is requested.

    Parameters
    ----------
    world : CollisionWorld
        World.
    radius : float, optional
        Radius in metres, by default the radius of the floor's people.
    ignore : collection of str, optional
        Names of bodies that are no obstacles, such as the person who plans.
    step : float, optional
        Maximum turn per waypoint around a corner in radians. Smaller turns follow corners more
        closely and give more waypoints.
    planner : str, mapping, type or PlannerChoice, optional
        Planner by name, with its parameters, or the class of a custom planner.
    seed : int, optional
        Seed of planners that draw samples.
    keep : int, optional
        Maximum number of paths to cache until a body moves.

    Raises
    ------
    floorplan.UserError
        If a value is out of range, or if the planner or a parameter is unknown.

    Examples
    --------
    >>> import floorplan
    >>> from navigation import CollisionWorld, PathPlanner
    >>> world = CollisionWorld(floorplan.load("ariac2023"))
    >>> path = PathPlanner(world, radius=0.3).plan((-15.0, -10.0), (-5.0, 3.75))
    >>> round(path.length, 2)
    17.0
    """

    def __init__(
        self,
        world: CollisionWorld,
        radius: float | None = None,
        ignore: Collection[str] = (),
        *,
        step: float = COARSE,
        planner: PlannerChoice | str | Mapping[str, Any] | type = ROADMAP,
        seed: int = 0,
        keep: int = 0,
    ) -> None:
        require(world, CollisionWorld)
        self.world = world
        self.radius = world.plan.human.radius if radius is None else float(radius)
        if not 0 < self.radius < math.inf:
            raise UserError(f"a radius must be positive and finite, found {self.radius:g}")
        if not STEP <= step <= math.pi / 2:
            raise UserError(f"bends must be from {STEP:.3g} to 1.57 radians, found {step:g}")
        self.ignore = frozenset(ignore)
        self.step = step
        self.choice = PlannerChoice.of(planner)
        """Default planner of queries."""
        self.choice.check()
        self.seed = seed
        self._queries: RoadmapQuestions | None = None
        self._keep = keep
        self._cached: dict[Hashable, Path] = {}
        self._footings: dict[tuple[Point, float], Point] = {}
        """First position from a place that is too close to something, by place and tolerance."""
        self._cached_at = world.changes

    def __repr__(self) -> str:
        return f"<PathPlanner for a radius of {self.radius:g} m in {self.world!r}>"

    def plan(
        self,
        start: ArrayLike,
        goal: ArrayLike,
        *,
        planner: PlannerChoice | str | Mapping[str, Any] | type | None = None,
        parameters: Mapping[str, Setting] | None = None,
        seed: int | None = None,
        watch: Watch | None = None,
    ) -> Path:
        """Return a path from `start` to `goal`.

        Paths of the default planner are the shortest, except for at most 0.6 % of their arcs around
        corners. Other planners are those of OMPL.

        Parameters
        ----------
        start, goal : array_like
            Positions (x, y) in metres.
        planner : str, mapping, type or PlannerChoice, optional
            Planner for this query, by default the planner of the constructor.
        parameters : mapping of str to bool, int, float or str, optional
            Parameters of the planner by name.
        seed : int, optional
            Seed for this query. The same seed gives the same path.
        watch : Watch, optional
            Observer of a search of an OMPL planner.

        Returns
        -------
        Path
            Path along which the disc touches nothing.

        Raises
        ------
        PlanningError
            If there is no path, with the reason.
        floorplan.UserError
            If a position is not finite, or if the planner or a parameter is unknown.
        """
        choice = self._choice(planner, parameters)
        seed = self.seed if seed is None else seed
        a, b = _place(start, "start"), _place(goal, "goal")
        if not self._keep:
            return self._find(a, b, choice, seed, watch)
        if self._cached_at != self.world.changes:
            self._cached_at = self.world.changes
            self._cached.clear()
            self._footings.clear()
        query = (a, b, choice, seed)
        path = self._cached.get(query)
        if path is None:
            path = self._cached[query] = self._find(a, b, choice, seed, watch)
            if len(self._cached) > self._keep:
                del self._cached[next(iter(self._cached))]
        return path

    def _find(
        self, a: Point, b: Point, choice: PlannerChoice, seed: int, watch: Watch | None
    ) -> Path:
        """Return the path from `a` to `b` without a cache."""
        if self.ignore and (away := self.ignore & {body.name for body in self.world.bodies}):
            without = PathPlanner(self.world.as_if(away=away), self.radius, step=self.step)
            return without.plan(a, b, planner=choice, seed=seed, watch=watch)
        if choice.name == ROADMAP:
            path = self._shortest(a, b)
        else:
            path = self._sampled(*self._ends_of(a, b), choice, seed, watch)
        points = np.array(distinct([a, *path, b], _STEP))
        clear = partial(self.world.clearance, points, self.world.bodies)
        return Path(points=points, clear=clear, planner=choice.name)

    def roadmap(self, step: float | None = None) -> Roadmap:
        """Return the visibility graph of the floor, with turns of at most `step` radians."""
        return self.world.roadmap(self.radius, self.step if step is None else step)

    def prepare(self) -> None:
        """Compute in advance what the first query needs."""
        roadmap = self.roadmap()
        _ = roadmap.passages
        for body in self.world.bodies:
            roadmap.around(body)

    def _choice(
        self,
        planner: PlannerChoice | str | Mapping[str, Any] | type | None,
        parameters: Mapping[str, Setting] | None,
    ) -> PlannerChoice:
        """Return the checked planner of one query."""
        if planner is None and not parameters:
            return self.choice
        choice = self.choice if planner is None else PlannerChoice.of(planner)
        if parameters:
            choice = choice.with_parameters(parameters)
        choice.check()
        return choice

    def _sampled(
        self, start: Point, goal: Point, choice: PlannerChoice, seed: int, watch: Watch | None
    ) -> list[Point]:
        keep = self.radius + SLACK
        low_x, low_y, high_x, high_y = self.world.plan.boundary.bounds

        closed = Gates()

        def free(a: Point, b: Point) -> bool:
            return self.world.segment_free(a, b, keep) and not (closed and closed.apart(a, b))

        query = OmplQuery(start, goal, (low_x, low_y), (high_x, high_y), free)
        # Each round closes another gate, so the number of rounds is limited.
        while (points := sample_path(query, choice, seed, watch)) is not None:
            # Most OMPL planners assume that a free motion is free in both directions. Repeat the
            # search with a wall for each gate that the path crosses backwards.
            broken = self.world.gates.broken(points)
            if not broken:
                return points
            closed = Gates((*closed.all, *broken))
        if not self._connected(start, goal):
            raise self._unreachable(start, goal)
        message = f"{choice.name} found no path within its budget; give it more iterations"
        raise PlanningError("not_found", message)

    def _shortest(self, start: Point, goal: Point) -> list[Point]:
        """Return the shortest path between the positions next to start and goal.

        Sweeps from the start and to the goal include the discs there. If both are free in the
        plane, FCL tests only the sweeps.
        """
        if self._queries is None:
            self._queries = RoadmapQuestions(self.world, self.radius)
        links = self._queries.links
        hopeful = links.holds(start) and links.holds(goal)
        points = self._queries.path(start, goal, self.step) if hopeful else None
        if points is not None:
            return points
        leave, arrive = self._ends_of(start, goal)
        if not hopeful or (leave, arrive) != (start, goal):
            points = self._queries.path(leave, arrive, self.step)
        if points is not None:
            return points
        if not self._connected(leave, arrive):
            raise self._unreachable(leave, arrive)
        raise PlanningError("not_found", "no path was found, though there should be one")

    def _ends_of(self, start: Point, goal: Point) -> tuple[Point, Point]:
        """Return the first position after the start, and the last before the goal."""
        leave = self._cached_footing(start, "start", TOO_CLOSE)
        return leave, self._cached_footing(goal, "goal", 0.0)

    def _connected(self, start: Point, goal: Point) -> bool:
        if self.roadmap().apart(start, goal):
            return False
        return self.world.reaches(start, goal, self.radius + HAIR)

    def _unreachable(self, start: Point, goal: Point) -> PlanningError:
        explain = explain_cut_off(self.world, start, goal, self.radius)
        return PlanningError("unreachable", explain)

    def _blocked(self, place: Point, end: str) -> Callable[[], str]:
        """Return a function that explains why `place` is not free at present."""
        return partial(blocked_place, self.world.as_if(), place, end, self.radius)

    def _cached_footing(self, place: Point, end: str, tolerance: float) -> Point:
        """Return `_footing` with a cache, because most goals are stations."""
        if not self._keep:
            return self._footing(place, end, tolerance)
        footing = self._footings.get((place, tolerance))
        if footing is None:
            footing = self._footing(place, end, tolerance)
            if len(self._footings) >= self._keep:
                self._footings.clear()
            self._footings[place, tolerance] = footing
        return footing

    def _footing(self, place: Point, end: str, tolerance: float) -> Point:
        """Return `place`, or the nearest free position if it is slightly too close to something.

        `PlanningError` if it is more than `tolerance` metres too close.
        """
        world = self.world
        if world.free(place, self.radius + SLACK):
            return place
        reason: Reason = "start_blocked" if end == "start" else "goal_blocked"
        gap = world.distance(place)
        if gap < self.radius - max(tolerance, 1e-9):
            raise PlanningError(reason, self._blocked(place, end))
        footing = world.nearest_free(place, self.radius + HAIR)
        # From a place within the tolerance, the nearest free position is not far.
        if footing is None or math.dist(place, footing) > 10 * TOO_CLOSE:
            raise PlanningError(reason, self._blocked(place, end))
        return footing


def _place(at: ArrayLike, end: str) -> Point:
    if is_place(at):
        return at
    position = np.asarray(at, dtype=float)
    if position.shape != (2,) or not np.isfinite(position).all():
        raise UserError(f"the {end} must be a finite x and y, found {at!r}")
    return (float(position[0]), float(position[1]))


Pose = tuple[float, float, float]
"""x, y in metres, rotation in radians."""

BEND = math.radians(30.0)
"""Maximum turn per waypoint of a gantry's path in radians. The gantry stops at each waypoint."""

_LEAST = 1e-3
"""Minimum radius of a disc to keep out of, in metres."""


class GantryPath(Path):
    """Path of the gantry's axis with its rotation.

    `points` have the shape (N, 3): x and y in metres, and the rotation in radians.
    """


class GantryPlanner:
    """Planner of paths for the gantry of a floorplan, with its arm folded.

    Torso and folded arm count as a disc around the axis, so the rotation is free everywhere. Lower
    obstacles are crossed.

    Parameters
    ----------
    plan : Floorplan
        Floorplan with a gantry.
    agvs : mapping of str to float or str, optional
        AGVs that are obstacles, with lane positions in metres or locations. By default none,
        because the gantry works above them.

    Raises
    ------
    floorplan.UserError
        If the floorplan has no gantry.
    """

    def __init__(self, plan: Floorplan, *, agvs: Mapping[str, float | str] | None = None) -> None:
        if plan.gantry is None:
            raise UserError(f"{plan.name} has no gantry")
        self.gantry = plan.gantry
        length, width = plan.gantry.torso[:2]
        self.radius = max(plan.gantry.arm_reach, math.hypot(length, width) / 2)
        counted = dict(agvs or {})
        self._world = CollisionWorld(
            Floorplan(
                name=plan.name,
                boundary=self._range(),
                obstacles=plan.obstacles,
                lanes=tuple(lane for lane in plan.lanes if lane.name in counted),
            ),
            bottom=min(plan.gantry.torso[2], plan.gantry.arm_bottom),
            top=plan.gantry.torso[3],
        )
        for name, at in counted.items():
            self._world.move_agv(name, at)
        self._paths = PathPlanner(self._world, self.radius, step=BEND)

    def plan(
        self,
        start: Pose,
        goal: Pose,
        *,
        keep_out: Sequence[tuple[float, float, float]] = (),
        planner: PlannerChoice | str = ROADMAP,
        parameters: Mapping[str, Setting] | None = None,
        seed: int = 0,
    ) -> GantryPath:
        """Return a path of the axis from `start` to `goal`.

        Parameters
        ----------
        start, goal : tuple of float
            x and y in metres, and the rotation in radians.
        keep_out : sequence of tuple of float, optional
            Discs (x, y, radius) in metres that the axis stays out of. It also keeps the arm's reach
            from their centres. From inside a disc, it comes no closer to the centre.
        planner, parameters, seed
            See `PathPlanner.plan`.

        Returns
        -------
        GantryPath
            Path with the rotation in proportion to the length.

        Raises
        ------
        PlanningError
            If there is no path, with the reason.
        floorplan.UserError
            If a pose is outside the range of an axis.
        """
        for pose, end in ((start, "start"), (goal, "goal")):
            self._check_range(pose, end)
        discs = {}
        for k, (x, y, radius) in enumerate(keep_out):
            # From inside a disc, plan with a smaller one that ends just before the start.
            away = math.dist((x, y), start[:2]) - 2 * HAIR
            # The planner adds its own radius to all obstacles.
            solid = max(min(radius, away) - self.radius, _LEAST)
            discs[f"keep out {k}"] = Disc((x, y), solid)
        try:
            for name, disc in discs.items():
                self._world.place(name, disc)
            path = self._paths.plan(
                start[:2], goal[:2], planner=planner, parameters=parameters, seed=seed
            )
        finally:
            for body in self._world.bodies:
                if body.name in discs:
                    self._world.remove(body.name)
        so_far = np.append(0.0, np.cumsum(np.hypot(*np.diff(path.points, axis=0).T)))
        share = so_far / so_far[-1] if so_far[-1] > 0 else np.array([0.0, 1.0])
        turned = start[2] + share * (goal[2] - start[2])
        return GantryPath(
            points=np.column_stack([path.points, turned]),
            clear=lambda: path.clearance,
            planner=path.planner,
        )

    def _range(self) -> shapely.Polygon:
        """Return the area that the envelope can cover: the axes' ranges with a margin."""
        x, y = self.gantry.x, self.gantry.y
        room = self.radius + 2 * HAIR
        return shapely.box(x.low - room, y.low - room, x.high + room, y.high + room)

    def _check_range(self, pose: Pose, end: str) -> None:
        if len(pose) != 3:
            raise UserError(f"the {end} must be x, y and a rotation, found {pose!r}")
        for name, axis, at in zip(("x", "y", "rotation"), self.gantry.axes, pose, strict=True):
            if not axis.low - HAIR <= at <= axis.high + HAIR:
                raise UserError(
                    f"the {end}'s {name} = {at:g} is outside the gantry's range"
                    f" {axis.low:g} … {axis.high:g}"
                )
