"""Geometry without the library's own code and without FCL, for comparison."""

import itertools
import math
from functools import lru_cache

import numpy as np
import shapely
from shapely.geometry import Polygon, box

from floorplan import Floorplan, Obstacle


def floor(*obstacles, boundary=None):
    """Return a floor of 10 m × 10 m, or within `boundary`, with obstacles 1 m high."""
    things = [
        Obstacle(name=f"thing{k}", footprint=shape, bottom=0.0, top=1.0)
        for k, shape in enumerate(obstacles)
    ]
    return Floorplan(name="test", boundary=boundary or box(0, 0, 10, 10), obstacles=things)


def solid(world):
    """Everything that is no room to walk, in a wide frame around the floor.

    Discs are drawn from inside, with 32 corners.
    """
    fixed = (o.footprint for o in world.plan.obstacles if o.overlaps(world.bottom, world.top))
    bodies = (_shape(body.shape) for body in world.bodies)
    return _solid(world.plan.boundary, (*fixed, *bodies))


@lru_cache(maxsize=4)
def _solid(boundary, shapes):
    frame = shapely.box(*boundary.bounds).buffer(5.0, join_style="mitre")
    return frame.difference(boundary).union(shapely.union_all(shapes))


def _shape(shape):
    if isinstance(shape, Polygon):
        return shape
    return shapely.Point(shape.centre).buffer(shape.radius, quad_segs=8)


def gap(world, points):
    """Return the distance of a polyline (or point) from all obstacles."""
    points = np.asarray(points, dtype=float)
    still = (points == points[0]).all()
    line = shapely.Point(points[0]) if still else shapely.linestrings(points)
    discs = [body.shape for body in world.bodies if not isinstance(body.shape, Polygon)]
    gaps = [line.distance(shapely.Point(disc.centre)) - disc.radius for disc in discs]
    return max(0.0, min([float(shapely.distance(solid(world), line)), *gaps]))


def length(points):
    return sum(math.dist(a, b) for a, b in itertools.pairwise(np.asarray(points).tolist()))


def room(world, radius, sides=32):
    """Return slightly more than the free space, without grown edges and inscribed corners."""
    blocked = solid(world)
    parts = [blocked]
    for polygon in shapely.get_parts(blocked):
        for ring in (polygon.exterior, *polygon.interiors):
            points = np.array(ring.coords)
            for (ax, ay), (bx, by) in itertools.pairwise(points.tolist()):
                far = math.dist((ax, ay), (bx, by))
                nx, ny = -(by - ay) / far * radius, (bx - ax) / far * radius
                parts.append(
                    Polygon(
                        [
                            (ax + nx, ay + ny),
                            (bx + nx, by + ny),
                            (bx - nx, by - ny),
                            (ax - nx, ay - ny),
                        ]
                    )
                )
                angles = np.linspace(0, 2 * math.pi, sides, endpoint=False)
                parts.append(
                    Polygon(
                        np.column_stack(
                            [ax + radius * np.cos(angles), ay + radius * np.sin(angles)]
                        )
                    )
                )
    return world.plan.boundary.difference(shapely.union_all(parts))


def goes_back(gate, a, b):
    """Return whether segments from a to b (N, 2) cross a gate against its direction."""
    (x, y), towards = gate.ends[0], np.subtract(gate.towards, gate.ends[0])
    dx, dy = np.subtract(gate.ends[1], gate.ends[0])
    way = math.copysign(1.0, dx * towards[1] - dy * towards[0])
    here, there = (way * (dx * (at[:, 1] - y) - dy * (at[:, 0] - x)) for at in (a, b))
    back = (here >= 0) & (there < 0)
    lines = shapely.linestrings(np.stack([a, b], axis=1))
    return back & shapely.intersects(lines, shapely.linestrings(gate.ends))


def shortest(free, places, gates=()):
    """The shortest ways in polygon(s) `free` between `places`: a matrix of lengths.

    Every corner is linked with every other that it sees, but not back through one of the `gates`.
    """
    corners = []
    for polygon in shapely.get_parts(shapely.orient_polygons(free)):
        for ring in (polygon.exterior, *polygon.interiors):
            points = np.array(ring.coords)[:-1]
            before, after = points - np.roll(points, 1, 0), np.roll(points, -1, 0) - points
            turn = before[:, 0] * after[:, 1] - before[:, 1] * after[:, 0]
            corners.append(points[turn < 0])
    nodes = np.concatenate([places, *corners])
    wide = free.buffer(1e-7)
    shapely.prepare(wide)
    one, other = np.triu_indices(len(nodes), 1)
    seen = shapely.covers(wide, shapely.linestrings(np.stack([nodes[one], nodes[other]], axis=1)))
    far = np.full((len(nodes), len(nodes)), math.inf)
    apart = np.hypot(*(nodes[one] - nodes[other]).T)
    far[one[seen], other[seen]] = far[other[seen], one[seen]] = apart[seen]
    for gate, (a, b) in itertools.product(gates, ((one, other), (other, one))):
        back = goes_back(gate, nodes[a], nodes[b])
        far[a[back], b[back]] = math.inf
    np.fill_diagonal(far, 0.0)
    for k in range(len(nodes)):
        np.minimum(far, far[:, k, None] + far[k], out=far)
    return far[: len(places), : len(places)]
