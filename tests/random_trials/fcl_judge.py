"""FCL as the judge of what people did: no kernel of the library, and no shapely distance, decides.

The motion of each person is cut into chords. What their body sweeps along a chord is a capsule, and
whatever is in the way a convex prism: FCL says whether the two share a point. Chords are so short
that a motion is within `DEVIATION` of them, and bodies are narrower by `CLEARANCE`: whatever FCL
lets pass is clear but for the sum of the two.
"""

import itertools
import math
from typing import NamedTuple

import fcl
import numpy as np
import shapely

CLEARANCE = 1e-4
"""Metres. So much closer than their radius people may be to anything, from rounding."""

DEVIATION = 1e-5
"""Metres. How far a motion may be from its chords."""

AROUND = 5.0
"""Metres. The floor ends in a wall so thick."""

LEAVES = 15.0
"""Seconds within which somebody leaves a door that closed on them."""

SLOW = 1e-9
"""m/s. A motion that turns back no faster than this does not turn back."""


def judge_faults(run):
    """Return what FCL rejects: people in walls, in what is closed, and in each other."""
    bodies = {
        entry.name: _radius(run, entry) - CLEARANCE
        for entry in run.trial.people
        if entry.recorded is None
    }
    swept = {name: _chords(_pieces(run, name)) for name in bodies}
    touch = _Touch()
    for barrier in _barriers(run):
        for entry in run.trial.people:
            if entry.name in bodies:
                chords, radius = swept[entry.name], bodies[entry.name]
                for t in barrier.rejected(touch, chords, radius, _braking(run, entry)):
                    yield f"FCL rejects {entry.name} at t = {t:.4f} s: {barrier.name} is there"
                    break
    for one, other in itertools.combinations(bodies, 2):
        t = _meeting(run, touch, (one, bodies[one]), (other, bodies[other]))
        if t is not None:
            yield f"FCL rejects {one} at t = {t:.4f} s: {other} is there"


def _radius(run, entry):
    return run.trial.floorplan.human.radius if entry.radius is None else entry.radius


def _braking(run, entry):
    """The deceleration with which somebody stops (m/s²)."""
    most = run.scene.person(entry.name).max_acceleration
    return run.trial.floorplan.human.max_acceleration if most is None else most


# ---- motions as chords


class _Chords(NamedTuple):
    """Chords of a motion: instants (N,) in seconds, ends (N, 2) in metres, speeds at the begin."""

    begin: np.ndarray
    end: np.ndarray
    a: np.ndarray
    b: np.ndarray

    def within(self, begin, end):
        """Return those that are not over at `begin` and begin before `end` (seconds)."""
        kept = (self.end > begin) & (self.begin < end)
        return _Chords(*(values[kept] for values in self))


def _pieces(run, name):
    """Return the pieces of somebody while they are on the floor: begins, ends, cubics of x, y."""
    since, until = run.presence[name]
    rows = [p for p in run.motions[name].pieces if p.end > since and p.begin < until]
    begin, end = (np.array([p[k] for p in rows]) for k in (0, 1))
    return begin, end, np.array([(p.x, p.y) for p in rows]).reshape(-1, 2, 4)


def _at(cubics, u):
    """Return places (N, 2) on cubics (N, 2, 4), `u` (N,) seconds after each began."""
    u = u[:, None]
    c = cubics
    return c[..., 0] + u * (c[..., 1] + u * (c[..., 2] + u * c[..., 3]))


def _chords(pieces):
    """Return chords from which no place of the pieces is farther than `DEVIATION`."""
    begin, end, c = pieces
    h = end - begin
    way = _at(c, h) - c[..., 0]
    length = np.hypot(*way.T)
    along = np.divide(way, length[:, None], out=np.zeros_like(way), where=length[:, None] > 0)
    # Half the acceleration is linear in time, so greatest at an end; that across the chord counts
    # alone, unless the piece turns back: its velocity is within its control points.
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
    """Asks FCL whether a capsule along a chord touches a shape."""

    def __init__(self):
        self._capsule, self._ball = fcl.Capsule(1.0, 1.0), fcl.Sphere(1.0)
        self._long = fcl.CollisionObject(self._capsule)
        self._round = fcl.CollisionObject(self._ball)
        self._asked = fcl.CollisionRequest()

    def __call__(self, a, b, radius, shape):
        """Return whether what a disc sweeps from `a` to `b` shares a point with a shape."""
        (x, y), length = b - a, math.dist(a, b)
        body = self._round
        if length < 1e-9:
            self._ball.radius = radius
        else:
            self._capsule.radius, self._capsule.lz = radius, length
            c, s = x / length, y / length
            # A capsule lies along its z axis: its axes are z, then what completes the frame.
            self._long.setRotation(np.array([[0.0, -s, c], [0.0, c, s], [-1.0, 0.0, 0.0]]))
            body = self._long
        body.setTranslation(np.array([*(a + b) / 2, 0.0]))
        return fcl.collide(body, shape, self._asked, fcl.CollisionResult()) > 0


def _prisms(area):
    """Return FCL's objects for an area (shapely), 2 m high: convex parts, or its triangles."""
    parts = []
    for polygon in shapely.get_parts(area):
        if not isinstance(polygon, shapely.Polygon):
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


# ---- what is in the way


class _Barrier(NamedTuple):
    """Something in the way within an interval (seconds), as the prisms that it consists of."""

    name: str
    begin: float
    end: float
    prisms: list

    def rejected(self, touch, chords, radius, braking):
        """Yield when chords lead through it (s), but those of somebody on whom it closed."""
        begin = self.begin
        if begin > 0.0:
            begin = self._left(touch, chords, radius, braking)
        near = chords.within(begin, self.end)
        for k in self._hits(touch, near, radius):
            yield max(float(near.begin[k]), begin)

    def _hits(self, touch, chords, radius):
        """Yield the numbers of chords that lead through it."""
        # Places at which somebody stands are asked about once.
        low, high = np.minimum(chords.a, chords.b) - radius, np.maximum(chords.a, chords.b) + radius
        for least, most, prism in self.prisms:
            near = np.flatnonzero(((high >= least) & (low <= most)).all(axis=1))
            for k in near.tolist():
                if touch(chords.a[k], chords.b[k], radius, prism):
                    yield k

    def _left(self, touch, chords, radius, braking):
        """Return from when on nobody may touch it who could not stop before it as it closed."""
        before = chords.within(-math.inf, self.begin)
        after = chords.within(self.begin, min(self.end, self.begin + LEAVES))
        if not len(before.begin) or not len(after.begin):
            return self.begin
        k = len(before.begin) - 1
        seconds = max(before.end[k] - before.begin[k], 1e-9)
        speed = math.dist(before.a[k], before.b[k]) / seconds
        lengths = np.hypot(*(after.b - after.a).T)
        gone = np.cumsum(lengths) - lengths
        # A chord has its mean speed: what it was at the instant may be a little more.
        reach = (speed + 0.1) ** 2 / (2 * braking)
        hits = sorted(set(self._hits(touch, after, radius)))
        if not hits or gone[hits[0]] > reach:
            return self.begin
        free = [k for k in range(hits[0], len(after.begin)) if k not in set(hits)]
        return float(after.begin[free[0]]) if free else self.begin + LEAVES


def _barriers(run):
    """Return all that stands, hangs, closes or comes where people walk, and the end of the floor."""
    trial, plan = run.trial, run.trial.floorplan
    tall = plan.human.height
    around = plan.boundary.envelope.buffer(AROUND, join_style="mitre")
    yield _Barrier("the end of the floor", -1.0, math.inf, _prisms(around.difference(plan.boundary)))
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
    """Return from when to when a door is closed (seconds)."""
    if times is None:
        return [] if door.is_open else [(0.0, duration)]
    if times.open is None:
        return list(times.closed or ())
    ends = [0.0, *itertools.chain(*sorted(times.open)), duration]
    return [(a, b) for a, b in zip(ends[::2], ends[1::2], strict=True) if a < b]


# ---- people among people


def _meeting(run, touch, one, other):
    """Return when two people first share a point (s), or None: names and radii are given."""
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
    """Return the cubics of pieces in force at `t` (N,), counted from then: (N, 2, 4)."""
    begin, _, cubics = pieces
    row = np.searchsorted(begin, t, side="right") - 1
    c, u = cubics[row], (t - begin[row])[:, None]
    at = c[..., 0] + u * (c[..., 1] + u * (c[..., 2] + u * c[..., 3]))
    rate = c[..., 1] + u * (2 * c[..., 2] + u * 3 * c[..., 3])
    return np.stack([at, rate, c[..., 2] + u * 3 * c[..., 3], c[..., 3]], axis=-1)
