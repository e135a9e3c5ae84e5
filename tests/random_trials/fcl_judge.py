"""FCL as the judge of people's motions. No kernel of the library and no shapely distance decides.

The motion of each person is cut into chords. A body sweeps a capsule along a chord, and each
obstacle is a convex prism. FCL decides whether the two share a point. Chords are so short that a
motion is within `DEVIATION` of them, and bodies are narrower by `CLEARANCE`. Motions that FCL
accepts are therefore clear to within the sum of the two.
"""

import itertools
import math
from typing import NamedTuple

import fcl
import numpy as np
import shapely

CLEARANCE = 1e-4
"""Distance by which people may be closer than their radius, from rounding (m)."""

DEVIATION = 1e-5
"""Maximum distance of a motion from its chords (m)."""

LEAVES = 5.0
"""Maximum time until a person is out of a door that closed on them (s)."""

NEARLY = 0.01
"""m. A person who could stop by less before a closing obstacle need not stop."""

SLOW = 1e-9
"""m/s. A motion that turns back more slowly does not turn back."""


def judge_faults(run):
    """Return what FCL rejects: people in walls, in closed areas, and in each other."""
    bodies = {
        entry.name: _radius(run, entry) - CLEARANCE
        for entry in run.trial.people
        if entry.recorded is None
    }
    touch, barriers = _Touch(), list(_barriers(run))
    changes = sorted({t for one in barriers for t in (one.begin, one.end) if 0.0 < t < math.inf})
    for entry in run.trial.people:
        if entry.name not in bodies:
            continue
        pieces = _cut(_pieces(run, entry.name), changes)
        chords, radius = _chords(pieces), bodies[entry.name]
        for barrier in barriers:
            begin = barrier.begin
            if begin > 0.0:
                speed = _speed_before(pieces, begin)
                reach = speed**2 / (2 * _deceleration(run, entry)) + NEARLY
                begin = barrier.left(touch, chords, radius, reach)
            if (t := barrier.rejected(touch, chords, radius, begin)) is not None:
                yield f"FCL rejects {entry.name} at t = {t:.4f} s: {barrier.name} is there"
    for one, other in itertools.combinations(bodies, 2):
        t = _meeting(run, touch, (one, bodies[one]), (other, bodies[other]))
        if t is not None:
            yield f"FCL rejects {one} at t = {t:.4f} s: {other} is there"


def _radius(run, entry):
    return run.trial.floorplan.human.radius if entry.radius is None else entry.radius


def _deceleration(run, entry):
    """Return the deceleration of a person (m/s²)."""
    most = entry.max_acceleration
    return run.trial.floorplan.human.max_acceleration if most is None else most


# ---- motions as chords


class _Chords(NamedTuple):
    """Chords of a motion: begins and ends (N,) in seconds, and their positions (N, 2) in metres."""

    begin: np.ndarray
    end: np.ndarray
    a: np.ndarray
    b: np.ndarray

    def within(self, begin, end):
        """Return the chords that end after `begin` and begin before `end` (s)."""
        overlaps = (self.end > begin) & (self.begin < end)
        return _Chords(*(values[overlaps] for values in self))


def _pieces(run, name):
    """Return the pieces of a person while on the floor: begins, ends, cubics of x and y."""
    since, until = run.presence[name]
    rows = [p for p in run.motions[name].pieces if p.end > since and p.begin < until]
    begin, end = (np.array([p[k] for p in rows]) for k in (0, 1))
    return begin, end, np.array([(p.x, p.y) for p in rows]).reshape(-1, 2, 4)


def _cut(pieces, instants):
    """Return pieces that are also cut at some times (s)."""
    begin, end, _ = pieces
    within = [t for t in instants if len(begin) and begin[0] < t < end[-1]]
    if not within:
        return pieces
    begins = np.unique(np.concatenate([begin, within]))
    return begins, np.append(begins[1:], end[-1]), _later(pieces, begins)


def _speed_before(pieces, t):
    """Return the final speed (m/s) of the piece that ends at `t` (s), or 0 if there is none."""
    begin, end, c = pieces
    if not (row := np.flatnonzero(end == t)).size:
        return 0.0
    u = t - begin[row[-1]]
    return math.hypot(*(c[row[-1], :, 1] + u * (2 * c[row[-1], :, 2] + u * 3 * c[row[-1], :, 3])))


def _at(cubics, u):
    """Return positions (N, 2) on cubics (N, 2, 4), `u` (N,) seconds after each began."""
    u = u[:, None]
    c = cubics
    return c[..., 0] + u * (c[..., 1] + u * (c[..., 2] + u * c[..., 3]))


def _chords(pieces):
    """Return chords that deviate from the pieces by at most `DEVIATION`."""
    begin, end, c = pieces
    h = end - begin
    way = _at(c, h) - c[..., 0]
    length = np.hypot(*way.T)
    along = np.divide(way, length[:, None], out=np.zeros_like(way), where=length[:, None] > 0)
    # The acceleration is linear in time, so it is greatest at an end. Unless the piece turns back,
    # only the part across the chord counts. Its velocity is within that of its control points.
    bends = np.stack([2 * c[..., 2], 2 * c[..., 2] + 6 * c[..., 3] * h[:, None]])
    across = np.abs(bends[..., 0] * along[:, 1] - bends[..., 1] * along[:, 0]).max(axis=0)
    whole = np.hypot(bends[..., 0], bends[..., 1]).max(axis=0)
    middle = c[..., 1] + c[..., 2] * h[:, None]
    last = c[..., 1] + (2 * c[..., 2] + 3 * c[..., 3] * h[:, None]) * h[:, None]
    rates = np.stack([(v * along).sum(axis=1) for v in (c[..., 1], middle, last)])
    bend = np.where((rates.min(axis=0) >= -SLOW) & (length > 0), across, whole)
    counts = np.maximum(1, np.ceil(h * np.sqrt(bend / (8 * DEVIATION)))).astype(int)
    row = np.repeat(np.arange(len(h)), counts)
    part = np.arange(len(row)) - np.repeat(np.cumsum(counts) - counts, counts)
    u, v = (h[row] * (part + k) / counts[row] for k in (0, 1))
    return _Chords(begin[row] + u, begin[row] + v, _at(c[row], u), _at(c[row], v))


# ---- FCL's shapes


class _Touch:
    """Query to FCL: does a capsule along a chord touch a shape?"""

    def __init__(self):
        self._capsule, self._ball = fcl.Capsule(1.0, 1.0), fcl.Sphere(1.0)
        self._long = fcl.CollisionObject(self._capsule)
        self._round = fcl.CollisionObject(self._ball)
        self._asked = fcl.CollisionRequest()

    def __call__(self, a, b, radius, shape):
        """Return whether a disc that moves from `a` to `b` shares a point with a shape."""
        (x, y), length = b - a, math.dist(a, b)
        body = self._round
        if length < 1e-9:
            self._ball.radius = radius
        else:
            self._capsule.radius, self._capsule.lz = radius, length
            c, s = x / length, y / length
            # A capsule lies along its z axis. The axes of its frame are z and two axes that
            # complete it.
            self._long.setRotation(np.array([[0.0, -s, c], [0.0, c, s], [-1.0, 0.0, 0.0]]))
            body = self._long
        body.setTranslation(np.array([*(a + b) / 2, 0.0]))
        return fcl.collide(body, shape, self._asked, fcl.CollisionResult()) > 0


def _prisms(area):
    """Return FCL's objects for an area (shapely), 2 m high: convex parts, or its triangles."""
    parts = []
    for polygon in shapely.get_parts(area):
        if not isinstance(polygon, shapely.Polygon) or polygon.is_empty:
            continue
        whole = not polygon.interiors and polygon.convex_hull.area - polygon.area < 1e-9
        cut = [polygon] if whole else shapely.get_parts(_triangles(polygon))
        parts += [shapely.get_coordinates(part.normalize().exterior)[:-1] for part in cut]
    return [(corners.min(axis=0), corners.max(axis=0), _prism(corners)) for corners in parts]


def _triangles(polygon):
    return shapely.constrained_delaunay_triangles(polygon)


def _prism(corners):
    """Return the convex prism over corners (N, 2), from 1 m below the plane to 1 m above it."""
    n = len(corners)
    points = np.vstack([np.column_stack([corners, np.full(n, z)]) for z in (-1.0, 1.0)])
    sides = [(4, k, (k + 1) % n, (k + 1) % n + n, k + n) for k in range(n)]
    lids = [(n, *reversed(range(n))), (n, *range(n, 2 * n))]
    faces = np.array([*itertools.chain(*sides, *lids)])
    return fcl.CollisionObject(fcl.Convex(points, n + 2, faces))


def _sides(area):
    """Return FCL's objects for the outside of the bounds of an area: four half spaces."""
    west, south, east, north = area.bounds
    anywhere = np.full(2, math.inf)
    sides = ((1.0, 0.0, west), (0.0, 1.0, south), (-1.0, 0.0, -east), (0.0, -1.0, -north))
    return [
        (-anywhere, anywhere, fcl.CollisionObject(fcl.Halfspace(np.array([x, y, 0.0]), d)))
        for x, y, d in sides
    ]


# ---- obstacles


class _Barrier(NamedTuple):
    """Obstacle during an interval (seconds), as the prisms that it consists of."""

    name: str
    begin: float
    end: float
    prisms: list

    def rejected(self, touch, chords, radius, begin):
        """Return when chords from `begin` (s) on first lead through the obstacle, or None."""
        near = chords.within(begin, self.end)
        hits = self._hits(touch, near, radius)
        return max(float(near.begin[min(hits)]), begin) if hits else None

    def left(self, touch, chords, radius, reach):
        """Return the time (s) from which no person may touch the obstacle.

        A person who was inside when it came, or at most `reach` metres before it on the path,
        leaves it first.
        """
        after = chords.within(self.begin, min(self.end, self.begin + LEAVES))
        hits = self._hits(touch, after, radius)
        if not hits:
            return self.begin
        first = min(hits)
        way, length = after.b[first] - after.a[first], math.dist(after.a[first], after.b[first])
        gone = float(np.hypot(*(after.b[:first] - after.a[:first]).T).sum())
        if gone > reach:
            return self.begin
        last = after.a[first] + way * min(1.0, (reach - gone) / length if length else 1.0)
        if not any(touch(after.a[first], last, radius, prism) for _, _, prism in self.prisms):
            return self.begin
        out = [k for k in range(first, len(after.begin)) if k not in hits]
        return float(after.begin[out[0]]) if out else self.begin + LEAVES

    def _hits(self, touch, chords, radius):
        """Return the numbers of chords that lead through the obstacle."""
        low, high = np.minimum(chords.a, chords.b) - radius, np.maximum(chords.a, chords.b) + radius
        return {
            k
            for least, most, prism in self.prisms
            for k in np.flatnonzero(((high >= least) & (low <= most)).all(axis=1)).tolist()
            if touch(chords.a[k], chords.b[k], radius, prism)
        }


def _barriers(run):
    """Yield all obstacles where people walk, permanent and temporary, and the end of the floor."""
    trial, plan = run.trial, run.trial.floorplan
    tall = plan.human.height
    beyond = [*_prisms(plan.boundary.envelope.difference(plan.boundary)), *_sides(plan.boundary)]
    yield _Barrier("the end of the floor", -1.0, math.inf, beyond)
    for one in plan.obstacles:
        if one.bottom < tall and one.top > 0.0:
            yield _Barrier(one.name, -1.0, math.inf, _prisms(one.footprint))
    for door in plan.doors:
        times = trial.doors.get(door.name)
        prisms = _prisms(door.footprint)
        for begin, end in _closed(door, times, run.duration):
            yield _Barrier(f"the closed door {door.name}", begin, end, prisms)
    for timed in trial.obstacles:
        one = timed.obstacle
        if one.bottom < tall and one.top > 0.0:
            for begin, end in timed.there:
                yield _Barrier(one.name, begin, end, _prisms(one.footprint))


def _closed(door, times, duration):
    """Return the intervals in which a door is closed (s)."""
    if times is None:
        return [] if door.is_open else [(0.0, duration)]
    if times.open is None:
        return list(times.closed or ())
    ends = [0.0, *itertools.chain(*sorted(times.open)), duration]
    return [(a, b) for a, b in zip(ends[::2], ends[1::2], strict=True) if a < b]


# ---- people among people


def _meeting(run, touch, one, other):
    """Return when two people, as (name, radius), first share a point (s), or None."""
    (name, radius), (other_name, other_radius) = one, other
    pieces, theirs = _pieces(run, name), _pieces(run, other_name)
    if not len(pieces[0]) or not len(theirs[0]):
        return None
    since = max(pieces[0][0], theirs[0][0])
    until = min(pieces[1][-1], theirs[1][-1])
    cuts = np.unique(np.concatenate([pieces[0], theirs[0], [since, until]]))
    cuts = cuts[(cuts >= since) & (cuts <= until)]
    if len(cuts) < 2:
        return None
    begin, end = cuts[:-1], cuts[1:]
    apart = _later(pieces, begin) - _later(theirs, begin)
    chords = _chords((begin, end, apart))
    reach = radius + other_radius
    low, high = np.minimum(chords.a, chords.b) - reach, np.maximum(chords.a, chords.b) + reach
    ball = fcl.CollisionObject(fcl.Sphere(other_radius))
    for k in np.flatnonzero(((low <= 0.0) & (high >= 0.0)).all(axis=1)).tolist():
        if touch(chords.a[k], chords.b[k], radius, ball):
            return float(chords.begin[k])
    return None


def _later(pieces, t):
    """Return the cubics of pieces in force at `t` (N,), counted from `t`: (N, 2, 4)."""
    begin, _, cubics = pieces
    row = np.searchsorted(begin, t, side="right") - 1
    c, u = cubics[row], (t - begin[row])[:, None]
    at = c[..., 0] + u * (c[..., 1] + u * (c[..., 2] + u * c[..., 3]))
    rate = c[..., 1] + u * (2 * c[..., 2] + u * 3 * c[..., 3])
    return np.stack([at, rate, c[..., 2] + u * 3 * c[..., 3], c[..., 3]], axis=-1)
