"""Why there is no way, in words: what stands on a place, and what cuts two places off."""

from __future__ import annotations

from collections.abc import Callable, Collection
from dataclasses import dataclass

import shapely
from shapely.geometry import Polygon

from floorplan import Point

from .freespace import FreeSpace
from .world import CollisionWorld

_HALVINGS = 8
"""How often the radius at which a way opens is narrowed down: to 0.4 % of the radius."""

_WIDER = 1.01
"""Where roundings let through a radius that doesn't fit, the next one to try is so much wider."""

_QUARTER = 8
"""The sides of a quarter circle where only the message depends on it."""


def blocked_place(
    world: CollisionWorld, place: Point, end: str, radius: float, ignore: Collection[str]
) -> str:
    """Why a disc of `radius` metres can't stand at `place`, the `end` of a way."""
    name, gap = world.nearest(place, ignore)
    at = f"the {end} ({place[0]:g}, {place[1]:g})"
    if name == "boundary" and gap == 0:
        return f"{at} is outside the boundary"
    if gap == 0:
        return f"{at} is inside {name}"
    what = "the boundary" if name == "boundary" else name
    return f"{at} is {gap:.3f} m from {what}; a radius of {radius:g} m does not fit"


def explain_cut_off(
    world: CollisionWorld, start: Point, goal: Point, radius: float, ignore: Collection[str]
) -> Callable[[], str]:
    """What will say why no disc of `radius` metres gets from `start` to `goal` as things are now.

    To find the words takes longer than the proof, so it is left for when they are wanted.
    """
    scene = _Scene(world.walkable_but(ignore), world.things(ignore), world.plan.boundary)
    return lambda: _cut_off(scene, start, goal, radius)


@dataclass(frozen=True, eq=False)
class _Scene:
    """What there was to walk on, and what stood in the way."""

    walkable: shapely.Geometry
    things: list[tuple[str, Polygon]]
    boundary: Polygon


def _cut_off(scene: _Scene, start: Point, goal: Point, radius: float) -> str:
    between = f"from ({start[0]:g}, {start[1]:g}) to ({goal[0]:g}, {goal[1]:g})"
    fits, apart = 0.0, FreeSpace(scene.walkable)
    if not apart.together(start, goal):
        walls = _walls_between(scene, apart, start, goal)
        return f"no way, however narrow, leads {between}: {walls} cuts it off"
    too_wide = radius
    while (apart := _space(scene, too_wide)).together(start, goal):
        too_wide *= _WIDER
    for _ in range(_HALVINGS):
        middle = (fits + too_wide) / 2
        narrower = _space(scene, middle)
        if narrower.together(start, goal):
            fits = middle
        else:
            too_wide, apart = middle, narrower
    fits = min(fits, radius)
    place = shapely.line_interpolate_point(_link(apart, start, goal), 0.5, normalized=True)
    one, other = _nearest_two(scene, place)
    n = _digits(fits, radius)
    return (
        f"no way leads {between} for a radius of {radius:.{n + 1}g} m: the widest one is"
        f" {2 * fits:.{n}f} m wide between {one} and {other} at ({place.x:.2f}, {place.y:.2f}),"
        f" and {2 * radius:.{n}f} m are needed; a radius up to {fits:.{n}f} m would pass"
    )


def _space(scene: _Scene, radius: float) -> FreeSpace:
    """Where a disc of `radius` metres can be, corners rounded a little less than they should be."""
    return FreeSpace(scene.walkable.buffer(-radius, quad_segs=_QUARTER))


def _digits(fits: float, radius: float) -> int:
    """So many decimals tell the two radii apart."""
    return next(n for n in range(2, 9) if n == 8 or f"{fits:.{n}f}" != f"{radius:.{n}f}")


def _link(space: FreeSpace, start: Point, goal: Point) -> shapely.Geometry:
    """The shortest line between the pieces of `space` that start and goal are in."""
    ends = [
        shapely.Point(place) if (piece := space.piece_of(place)) is None else space.pieces[piece]
        for place in (start, goal)
    ]
    return shapely.shortest_line(*ends)


def _nearest_two(scene: _Scene, place: shapely.Point) -> tuple[str, str]:
    gaps = [("the boundary", float(scene.boundary.exterior.distance(place)))]
    gaps += [(name, float(shape.distance(place))) for name, shape in scene.things]
    (one, _), (other, _) = sorted(gaps, key=lambda named: named[1])[:2]
    return one, other


def _walls_between(scene: _Scene, space: FreeSpace, start: Point, goal: Point) -> str:
    link = _link(space, start, goal)
    crossed = [name for name, shape in scene.things if link.intersects(shape)]
    return " with ".join(crossed) or "the boundary"
