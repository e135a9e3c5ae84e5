"""Limits of motions: clear of walls, without jumps, within limits."""

import math
from itertools import pairwise

import numpy as np
import shapely

CLEARANCE = 1e-4
"""Distance by which people may be closer than their radius to fixed obstacles (m)."""

JUMP = 1e-6
"""m. Positions no farther apart are one place."""

ROUNDING = 1e-6
"""Maximum error of values (m or m/s)."""

STANDS = 5e-3
"""m/s. A slower person may turn freely."""

STRAIGHT = 1e-4
"""rad. A smaller turn is none."""

SHARE = 1e-4
"""Share of a limit by which speeds and accelerations may exceed it."""

STEP = 0.02
"""Time between samples, in addition to the ends of pieces (s)."""


def movement_faults(run):
    """Return faults in the motions of bodies."""
    trial, plan = run.trial, run.trial.floorplan
    for entry in trial.people:
        yield from _named(entry.name, _person_faults(run, entry))
    for lane in plan.lanes:
        yield from _named(lane.name, _agv_faults(run.motions[lane.name], lane))
    if plan.gantry is not None:
        touched = [one for one in run.events if one["kind"] == "contact"]
        impacts = [one["t"] for one in touched if one["machine"] == "gantry"]
        yield from _named("gantry", _gantry_faults(run.motions["gantry"], plan.gantry, impacts))
    for name, motion in run.motions.items():
        if motion.start != 0.0 or not math.isclose(motion.end, run.duration, abs_tol=1e-9):
            yield f"{name}: moves from {motion.start} to {motion.end} s of {run.duration} s"


def _named(name, faults):
    return (f"{name}: {fault}" for fault in faults)


# ---- each kind of body


def _person_faults(run, entry):
    plan, motion = run.trial.floorplan, run.motions[entry.name]
    human = plan.human
    radius = human.radius if entry.radius is None else entry.radius
    top = human.max_speed if entry.max_speed is None else entry.max_speed
    most = human.max_acceleration if entry.max_acceleration is None else entry.max_acceleration
    yield from _clearance_faults(plan, motion, radius)
    for lane in plan.lanes:
        yield from _bumping_faults(run, motion, lane, radius, top / most)
    for piece in motion.pieces:
        states = [state_of(piece, u) for u in instants(piece)]
        speed = max(math.hypot(*v[:2]) for _, v, _ in states)
        acceleration = max(math.hypot(*a[:2]) for _, _, a in states)
        yield from _over("speed", speed, top, piece.begin)
        yield from _over("acceleration", acceleration, most, piece.begin)
    puts = [
        (e["t"], e["to"])
        for e in run.events
        if e["kind"] == "teleport" and e["person"] == entry.name
    ]
    for t, at, to, before, after in _seams(motion):
        put = any(abs(t - when) < 1e-8 and math.dist(to, place) < JUMP for when, place in puts)
        if math.dist(at, to) > JUMP and not put:
            yield f"jumps by {math.dist(at, to):.4f} m at t = {t:.6f} s"
        if not put and abs(math.hypot(*before[:2]) - math.hypot(*after[:2])) > 1e-5:
            yield f"changes speed at once at t = {t:.6f} s: {before[:2]} to {after[:2]}"
    yield from _corner_faults(motion, most)


def _corner_faults(motion, most):
    """Yield corners that a person takes faster than an arc beside them allows, leg by leg.

    The arc leaves the corner by 0.05 m at most, and takes up to half of the straight leg before it.
    A person may stop on that leg, and a standing person may turn freely.
    """
    leg = 0.0
    pieces = zip(pairwise(motion.pieces), _seams(motion), strict=True)
    for (piece, following), (t, at, to, before, after) in pieces:
        chord, onward = _chord(piece), _chord(following)
        leg += math.hypot(*chord)
        speed = math.hypot(*before[:2])
        stands = min(speed, math.hypot(*after[:2])) < STANDS
        turn = _angle(chord, onward) if stands else _angle(before, after)
        if math.dist(at, to) > JUMP or (stands and turn > STRAIGHT):
            leg = 0.0
            continue
        if turn < STRAIGHT:
            continue
        half = turn / 2
        radius = min(0.05 / (1 / math.cos(half) - 1), leg / 2 / math.tan(half))
        limit = math.sqrt(most * max(radius, 0.0))
        if speed > limit * (1 + SHARE) + STANDS:
            angle = math.degrees(turn)
            yield (
                f"turns by {angle:.1f}° at {speed:.4f} m/s, {leg:.4f} m after the last turn, at"
                f" t = {t:.6f} s: {limit:.4f} m/s at most"
            )
        leg = 0.0


def _chord(piece):
    """Return the displacement over a piece (m)."""
    start, end = (state_of(piece, u)[0] for u in (0.0, piece.end - piece.begin))
    return end[0] - start[0], end[1] - start[1]


def _angle(before, after):
    """Return the angle between two displacements or velocities (rad), or a half turn if one is
    zero.
    """
    (vx, vy), (wx, wy) = before[:2], after[:2]
    if math.hypot(vx, vy) < ROUNDING or math.hypot(wx, wy) < ROUNDING:
        return math.pi
    return abs(math.atan2(vx * wy - vy * wx, vx * wx + vy * wy))


def _agv_faults(motion, lane):
    c, s = math.cos(lane.heading), math.sin(lane.heading)
    low, high = lane.limits
    for piece in motion.pieces:
        for u in instants(piece):
            (x, y, _), (vx, vy, _), (ax, ay, _) = state_of(piece, u)
            x, y = x - lane.origin[0], y - lane.origin[1]
            along, across = x * c + y * s, y * c - x * s
            if abs(across) > ROUNDING or not low - ROUNDING <= along <= high + ROUNDING:
                yield f"is off its lane at t = {piece.begin + u:.6f} s: {along}, {across}"
            yield from _over("speed", math.hypot(vx, vy), lane.max_speed, piece.begin + u)
            acceleration = math.hypot(ax, ay)
            yield from _over("acceleration", acceleration, lane.max_acceleration, piece.begin + u)
    yield from _smoothness_faults(motion)


def _gantry_faults(motion, gantry, impacts):
    for piece in motion.pieces:
        for axis, cubic in zip(gantry.axes, (piece.x, piece.y, piece.rotation), strict=True):
            yield from _over("jerk", abs(6 * cubic[3]), axis.max_jerk, piece.begin)
        for u in instants(piece):
            for name, axis, q, v, a in zip("xyr", gantry.axes, *state_of(piece, u), strict=True):
                t = piece.begin + u
                if not axis.low - ROUNDING <= q <= axis.high + ROUNDING:
                    yield f"{name} = {q} is out of range at t = {t:.6f} s"
                yield from _over(f"speed of {name}", abs(v), axis.max_speed, t)
                yield from _over(f"acceleration of {name}", abs(a), axis.max_acceleration, t)
    yield from _smoothness_faults(motion, impacts)


# ---- faults


def _clearance_faults(plan, motion, radius):
    """Check the segments between samples, dense and at the ends of pieces, against the floor's
    shapes.
    """
    there = [o.footprint for o in plan.obstacles if o.bottom < plan.human.height and o.top > 0]
    solid = shapely.union_all([*there, plan.boundary.exterior])
    shapely.prepare(solid)
    counts = [max(2, math.ceil((piece.end - piece.begin) / STEP) + 1) for piece in motion.pieces]
    piece = np.repeat(np.arange(len(counts)), counts)
    share = np.concatenate([np.linspace(0.0, 1.0, count) for count in counts])
    begin, end = (np.array([p[k] for p in motion.pieces])[piece] for k in (0, 1))
    times = begin + share * (end - begin)
    places = np.stack(sampled(motion, times, piece)[:2], axis=1)
    same = piece[1:] == piece[:-1]
    segments = np.stack([places[:-1], places[1:]], axis=1)[same]
    distinct, first = np.unique(np.round(segments, 9), axis=0, return_index=True)
    lines, times = shapely.linestrings(distinct), times[:-1][same]
    inside = shapely.contains_xy(plan.boundary, distinct[:, 0, 0], distinct[:, 0, 1])
    for index in np.flatnonzero(shapely.dwithin(solid, lines, radius - CLEARANCE) | ~inside)[:3]:
        gap = shapely.distance(solid, lines[index])
        t = times[first[index]]
        yield f"is {gap:.6f} m from what never moves at t = {t:.4f} s, with radius {radius}"


def _bumping_faults(run, motion, lane, radius, braking):
    """Yield walks towards a stationary AGV within the person's radius. Walks away from it may start
    there.

    The first `braking` seconds after the AGV has come to rest do not count.
    """
    t = np.arange(0.0, run.duration, STEP)
    x, y, *velocity = sampled(motion, t)
    ax, ay, *agv_velocity = sampled(run.motions[lane.name], t)
    (c, s), (dx, dy) = lane.direction, (x - ax, y - ay)
    along = np.maximum(np.abs(dx * c + dy * s) - lane.length / 2, 0.0)
    across = np.maximum(np.abs(dy * c - dx * s) - lane.width / 2, 0.0)
    gap = np.hypot(along, across)
    drove = np.where(np.hypot(*agv_velocity) > 0.0, t, -np.inf)
    stands = t - np.maximum.accumulate(drove) > braking + STEP
    walks = stands & (np.hypot(*velocity) > 0.0)
    nearer = (gap < radius - CLEARANCE) & walks
    nearer = nearer[1:] & nearer[:-1] & (gap[1:] < gap[:-1] - ROUNDING)
    if nearer.any():
        k = int(np.argmax(nearer))
        yield f"walks into {lane.name}, {gap[k]:.4f} m away at t = {t[k]:.2f} s"


def _smoothness_faults(motion, impacts=()):
    """Yield jumps of position or velocity of machines, except stops at `impacts`."""
    for t, at, to, before, after in _seams(motion):
        if math.dist(at, to) > JUMP:
            yield f"jumps by {math.dist(at, to):.4f} m at t = {t:.6f} s"
        stopped = not any(after) and any(abs(t - impact) < 2e-6 for impact in impacts)
        if math.dist(before, after) > 1e-5 and not stopped:
            yield f"changes velocity at once at t = {t:.6f} s: {before} to {after}"


def _over(what, value, limit, t):
    if value > limit * (1 + SHARE) + ROUNDING:
        yield f"{what} {value:.6f} is over {limit:g} at t = {t:.6f} s"


# ---- motions, from their coefficients


def sampled(motion, t, piece=None):
    """Return x, y and their velocities at `t` (seconds): (4, N).

    `piece` contains the number of the piece for each time. By default it is the piece that begins
    last.
    """
    begins = np.array([piece.begin for piece in motion.pieces])
    cubics = np.array([(piece.x, piece.y) for piece in motion.pieces])
    k = np.maximum(np.searchsorted(begins, t, side="right") - 1, 0) if piece is None else piece
    u = (t - begins[k])[:, None]
    c = cubics[k]
    at = c[..., 0] + u * (c[..., 1] + u * (c[..., 2] + u * c[..., 3]))
    speed = c[..., 1] + u * (2 * c[..., 2] + u * 3 * c[..., 3])
    return np.concatenate([at, speed], axis=1).T


def instants(piece, step=None):
    """Return times since the begin of a piece (s): its ends, and samples `step` apart."""
    duration = piece.end - piece.begin
    count = 2 if step is None else max(2, math.ceil(duration / step) + 1)
    turns = [-c[2] / (3 * c[3]) for c in (piece.x, piece.y, piece.rotation) if abs(c[3]) > 1e-12]
    within = [u for u in turns if 0 < u < duration]
    return sorted({*np.linspace(0.0, duration, count).tolist(), *within})


def state_of(piece, u):
    """Return position, velocity and acceleration of x, y and rotation after `u` seconds."""
    cubics = (piece.x, piece.y, piece.rotation)
    return (
        tuple(c[0] + c[1] * u + c[2] * u**2 + c[3] * u**3 for c in cubics),
        tuple(c[1] + 2 * c[2] * u + 3 * c[3] * u**2 for c in cubics),
        tuple(2 * c[2] + 6 * c[3] * u for c in cubics),
    )


def _seams(motion):
    """Yield the joints of pieces: time, both positions, and the velocities before and after."""
    for one, other in pairwise(motion.pieces):
        if one.end != other.begin:
            raise AssertionError(f"a gap in time from {one.end} to {other.begin} s")
        at, before, _ = state_of(one, one.end - one.begin)
        to, after, _ = state_of(other, 0.0)
        yield one.end, at[:2], to[:2], before, after
