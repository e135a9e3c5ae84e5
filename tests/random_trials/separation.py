"""The monitor's intervals, its figures and the events of violations, against sampled motions."""

import math
from bisect import bisect_right
from itertools import pairwise

import numpy as np

import sim
from navigation import Moving, TooClose, when

from .movement import sampled, state_of

STEP = 0.01
"""Time between samples (s)."""

SLACK = 1e-6
"""Maximum error of a distance compared with the required one, from rounding (m)."""

LOOSE = 0.03
"""Maximum error if the required distance comes from a curve (m)."""

RESOLUTION = 1e-6
"""s. Shorter intervals, and shorter gaps between intervals, are ignored."""

AGV_STANDS = 0.01
"""m/s. A slower AGV never counts."""


def separation_faults(run):
    """Yield differences of the recorded violations from intervals with too short a distance."""
    for (person, machine), intervals in run.violations.items():
        for fault in _pair_faults(run, person, machine, intervals):
            yield f"{person} and {machine}: {fault}"
    yield from _referee_faults(run)
    for entry in run.trial.people:
        yield from (f"{entry.name}: {fault}" for fault in _nearest_faults(run, entry.name))


def measured_point(run, machine):
    """Return the point to which distances are measured, from the centre of a machine (x, y)."""
    return run.scene.rules.measured_at(run.scene.machine(machine))


def law_of(run, machine):
    """Return the law in force beside a machine."""
    rules = run.trial.rules
    if machine in rules.laws:
        return rules.laws[machine]
    return rules.agv_law if _drives(run, machine) else rules.gantry_law


def _drives(run, machine):
    return run.scene.machine(machine).category == "vehicle"


def _referee_faults(run):
    """Compare the intervals of a run with those of the exact monitor on the finished motions.

    A predictive law refers to the plans at each time. The same trial recreates these plans.
    """
    plans = None
    for (person, machine), intervals in run.violations.items():
        law = law_of(run, machine)
        condition = TooClose(law)
        if _drives(run, machine):
            condition = Moving(AGV_STANDS) & condition
        if is_of_speeds(law):
            spans = [(0.0, run.duration, run.motions[person], run.motions[machine])]
        else:
            plans = plans or _plans_of(run.trial)
            spans = _agreed(plans[person], plans[machine], run.duration)
        to = measured_point(run, machine)
        exact = [
            interval
            for begin, end, one, other in spans
            for interval in when(condition, one, other.translated(*to), begin, end)
        ]
        expected, recorded = _lasting(exact), _lasting(intervals)
        if len(expected) != len(recorded) or not np.allclose(
            expected, recorded, rtol=0.0, atol=RESOLUTION
        ):
            yield f"{person} and {machine}: {recorded} are violations, and should be {expected}"


def _plans_of(trial):
    """Return the plans of every body in a run of a trial, by its name."""
    simulation = sim.Simulation(trial)
    plans = {body.name: body.remember_plans() for body in simulation.bodies}
    simulation.advance(trial.duration)
    return plans


def _agreed(one, other, end):
    """Yield the intervals in which two bodies kept to a plan, and the plans (motions) of both."""
    changes = sorted({t for t in (*one.changes, *other.changes) if t < end} | {end})
    for a, b in pairwise(changes):
        yield a, b, one.at(a), other.at(a)


def _lasting(intervals):
    """Return intervals joined where they touch, without those of zero duration."""
    joined = []
    for begin, end in intervals:
        if joined and begin - joined[-1][1] <= RESOLUTION:
            joined[-1] = (joined[-1][0], max(end, joined[-1][1]))
        else:
            joined.append((begin, end))
    return [(a, b) for a, b in joined if b - a > RESOLUTION]


def _pair_faults(run, person, machine, intervals):
    law = law_of(run, machine)
    t, distance, human, robot = _side_by_side(run, person, machine)
    if is_of_speeds(law):
        required, slack = np.vectorize(law.distance, otypes=[float])(human, robot), SLACK
        least = most = required
    else:
        required, slack = run.required(person, machine, t), LOOSE
        # Its curve is steep where the requirement jumps, as before a machine that stops at once.
        near = [run.required(person, machine, t + wait) for wait in (-STEP, 0.0, STEP)]
        least, most = np.min(near, axis=0), np.max(near, axis=0)
    always = np.full(len(t), not _drives(run, machine))
    counts = always | (robot > AGV_STANDS + 1e-9)
    may_count = always | (robot > AGV_STANDS - 1e-9)
    too_close = counts & (distance < least - slack)
    may_be = may_count & (distance < most + slack)
    ends = np.array(intervals).reshape(-1, 2)
    if (ends[:, 1] < ends[:, 0]).any() or (ends[1:, 0] < ends[:-1, 1]).any():
        yield f"intervals that overlap: {intervals}"
    # At its ends, an interval may be off by the resolution of the monitor.
    index = np.searchsorted(ends[:, 0] - SLACK, t, side="right") - 1
    inside = (index >= 0) & (t <= ends[index, 1] + SLACK) if len(ends) else np.zeros(len(t), bool)
    index = np.searchsorted(ends[:, 0] + SLACK, t, side="right") - 1
    within = (index >= 0) & (t <= ends[index, 1] - SLACK) if len(ends) else np.zeros(len(t), bool)
    for what, wrong in (
        ("too close, and no violation", too_close & ~inside),
        ("a violation, and not too close", within & ~may_be),
    ):
        if wrong.any():
            k = int(np.argmax(wrong))
            yield f"{what} at t = {t[k]:.6f} s: {distance[k]:.6f} m, required {required[k]:.6f}"


def _nearest_faults(run, person):
    """Compare the summary's nearest approach to the gantry with samples."""
    figures = run.summary["people"][person]
    nearest, begin = figures["minimum_separation"], figures["started"]
    if nearest is None or begin is None:
        return
    t, distance, _, _ = _side_by_side(run, person, "gantry")
    distance = distance[t >= begin]
    if not len(distance):
        return
    if nearest["distance"] > distance.min() + SLACK:
        yield f"came nearer than {nearest['distance']} m: {distance.min()} m"
    if nearest["distance"] < distance.min() - 4.0 * STEP:
        yield f"never came as near as {nearest['distance']} m: {distance.min()} m"


def _side_by_side(run, person, machine):
    """Return times (s), distances (m), and both speeds (m/s)."""
    dx, dy = measured_point(run, machine)
    one, other = run.motions[person], run.motions[machine]
    cuts = sorted({p.begin for m in (one, other) for p in m.pieces} | {run.duration})
    times = [
        # Omit the exact time of a change, because the values differ on its two sides.
        np.linspace(a + 1e-9, b - 1e-9, max(2, math.ceil((b - a) / STEP) + 1))
        for a, b in pairwise(cuts)
        if b - a > 1e-8
    ]
    t = np.concatenate(times) if times else np.empty(0)
    (x, y, vx, vy), (mx, my, wx, wy) = sampled(one, t), sampled(other, t)
    return t, np.hypot(x - mx - dx, y - my - dy), np.hypot(vx, vy), np.hypot(wx, wy)


def pose_before(run, name, t):
    """Return position and speed of a body just before `t` (s), or just after at the start."""
    pieces = run.motions[name].pieces
    k = bisect_right([piece.begin for piece in pieces], t - 2e-9) - 1
    piece = pieces[max(k, 0)]
    at, velocity, _ = state_of(piece, min(max(t, piece.begin), piece.end) - piece.begin)
    return at[:2], math.hypot(*velocity[:2])


def is_of_speeds(law):
    """Return whether `law` depends only on two speeds."""
    return hasattr(getattr(law, "law", law), "distance")
