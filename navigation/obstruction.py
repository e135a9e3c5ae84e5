"""Explanations of blocked positions and of missing paths."""

from __future__ import annotations

from collections.abc import Callable

import shapely

from floorplan import Point
from floorplan.files.problems import metres

from .freespace import FreeSpace
from .roadmap import HAIR
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
