"""Why there is no way, in words: what stands on a place, and what cuts two places off."""

from __future__ import annotations

from collections.abc import Collection

import shapely

from floorplan import Point

from .freespace import FreeSpace
from .world import CollisionWorld

_HALVINGS = 8
"""How often the radius at which a way opens is narrowed down: to 0.4 % of the radius."""

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


def cut_off(
    world: CollisionWorld, start: Point, goal: Point, radius: float, ignore: Collection[str]
) -> str:
    """What cuts `goal` off from `start` for a disc of `radius` metres; empty if nothing does."""
    space = world.free_space(radius, ignore)
    if _together(space, start, goal):
        return ""
    between = f"from ({start[0]:g}, {start[1]:g}) to ({goal[0]:g}, {goal[1]:g})"
    walkable = world.walkable_but(ignore)
    fits, apart = 0.0, FreeSpace(walkable)
    if not _together(apart, start, goal):
        walls = _walls_between(world, apart, start, goal, ignore)
        return f"no way, however narrow, leads {between}: {walls} cuts it off"
    too_wide = radius
    for _ in range(_HALVINGS):
        middle = (fits + too_wide) / 2
        narrower = FreeSpace(walkable.buffer(-middle, quad_segs=_QUARTER))
        if _together(narrower, start, goal):
            fits = middle
        else:
            too_wide, apart = middle, narrower
    x, y = _gap(apart, start, goal)
    (one, _), (other, _) = world.neighbours((x, y), ignore)[:2]
    return (
        f"no way leads {between} for a radius of {radius:.3g} m: the widest one is"
        f" {2 * fits:.2f} m wide between {one} and {other} at ({x:.2f}, {y:.2f}),"
        f" and {2 * radius:.2f} m are needed; a radius up to {fits:.2f} m would pass"
    )


def _together(space: FreeSpace, start: Point, goal: Point) -> bool:
    one, other = space.piece_of(start), space.piece_of(goal)
    return one is not None and one == other


def _gap(space: FreeSpace, start: Point, goal: Point) -> Point:
    """The middle between the pieces of `space` that start and goal are in."""
    link = _link(space, start, goal)
    middle = shapely.get_coordinates(link).mean(axis=0)
    return (float(middle[0]), float(middle[1]))


def _link(space: FreeSpace, start: Point, goal: Point) -> shapely.Geometry:
    ends = [
        shapely.Point(place) if (piece := space.piece_of(place)) is None else space.pieces[piece]
        for place in (start, goal)
    ]
    return shapely.shortest_line(*ends)


def _walls_between(
    world: CollisionWorld,
    space: FreeSpace,
    start: Point,
    goal: Point,
    ignore: Collection[str],
) -> str:
    link = _link(space, start, goal)
    crossed = [name for name, shape in world.things(ignore) if link.intersects(shape)]
    return " with ".join(crossed) or "the boundary"
