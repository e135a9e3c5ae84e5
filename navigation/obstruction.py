"""Explanations of why there is no path: the thing at a place, or the gap that is too narrow."""

from __future__ import annotations

from collections.abc import Callable

import shapely

from floorplan import Point

from .freespace import FreeSpace
from .roadmap import HAIR
from .world import CollisionWorld

_HALVINGS = 8
"""Bisections of the radius at which a path opens: it is known to 0.4 % of the radius."""

_WIDER = 1.01
"""Factor to the next radius to try where rounding lets one through that does not fit."""

_QUARTER = 8
"""Sides of a quarter circle where only the message depends on it."""


def blocked_place(world: CollisionWorld, place: Point, end: str, radius: float) -> str:
    """Return why a disc of `radius` metres can't stand at `place`, the `end` of a path."""
    name, gap = world.nearest(place)
    at = f"the {end} ({place[0]:g}, {place[1]:g})"
    if name == "boundary" and gap == 0:
        return f"{at} is outside the boundary"
    if gap == 0:
        return f"{at} is inside {name}"
    what = "the boundary" if name == "boundary" else name
    return f"{at} is {gap:.3f} m from {what}; a radius of {radius:g} m does not fit"


def explain_cut_off(
    world: CollisionWorld, start: Point, goal: Point, radius: float
) -> Callable[[], str]:
    """Return a function that explains why no path leads from `start` to `goal` as things are now.

    The explanation takes longer than the proof, so it is left for when it is read.
    """
    now = world.as_if()
    return lambda: _cut_off(now, start, goal, radius)


def _cut_off(world: CollisionWorld, start: Point, goal: Point, radius: float) -> str:
    """Find the radius at which `start` and `goal` are just connected, by bisection."""
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
    # Rounder corners than those planned with may leave a gap that they closed: a little wider,
    # then.
    while (apart := _space(walkable, too_wide)).together(start, goal):
        too_wide *= _WIDER
    # The widest disc that gets through, between one that does and one that does not.
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
    """Return where a disc of `radius` metres fits, with corners rounded a little too little."""
    return FreeSpace(walkable.buffer(-radius, quad_segs=_QUARTER))


def _digits(fits: float, radius: float) -> int:
    """Return the number of decimals that tell the two radii apart."""
    return next(n for n in range(2, 9) if n == 8 or f"{fits:.{n}f}" != f"{radius:.{n}f}")


def _link(space: FreeSpace, start: Point, goal: Point) -> shapely.Geometry:
    """Return the shortest line between the pieces of `space` that start and goal are in."""
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
