"""Contacts with fields by dense sampling and bisection, and random cases."""

import math
import random

import numpy as np

from navigation import (
    FieldSet,
    Motion,
    ProtectiveFields,
    VehicleLimits,
    join,
    standing,
    vehicle_path,
    vehicle_twist,
)
from navigation.fields import KINDS, SPEED_TOLERANCE

RADIUS = 0.3


def signed_distance(corners, x, y):
    """Return the distances of places from a polygon in metres, negative inside it."""
    corners = np.array(corners)
    a, b = corners, np.roll(corners, -1, axis=0)
    p = np.stack([x, y], -1)[..., None, :]
    along = np.clip(((p - a) * (b - a)).sum(-1) / ((b - a) ** 2).sum(-1), 0, 1)
    away = np.linalg.norm(p - a - along[..., None] * (b - a), axis=-1).min(-1)
    px, py = p[..., 0], p[..., 1]
    straddles = (a[:, 1] > py) != (b[:, 1] > py)
    with np.errstate(divide="ignore", invalid="ignore"):
        meets = a[:, 0] + (py - a[:, 1]) * (b[:, 0] - a[:, 0]) / (b[:, 1] - a[:, 1])
    crossings = (straddles & (px < meets)).sum(-1)
    return np.where(crossings % 2 == 1, -away, away)


def depth(case, which, field, t):
    """Return the distance of the person's disc from a field of a set at given times in metres."""
    _, machine, person, radius = case
    dx, dy = (person.position(t) - machine.position(t)).T
    turned = machine.rotation(t)
    c, s = np.cos(turned), np.sin(turned)
    return signed_distance(which.corners(field), c * dx + s * dy, c * dy - s * dx) - radius


def applies(case, which, t):
    """Return whether a set is the first that fits the machine's velocity at given times."""
    fields, machine, _, _ = case
    cubics = machine.cubics(t)
    (vx, vy, turning), turned = np.moveaxis(cubics[..., 1], -1, 0), cubics[..., 2, 0]
    ahead = vx * np.cos(turned) + vy * np.sin(turned)
    aside = vy * np.cos(turned) - vx * np.sin(turned)
    free = np.ones(np.shape(t), dtype=bool)
    for each in fields.sets:
        speed = ahead if each.direction is None else np.hypot(ahead, aside)
        fits = free.copy()
        for value, (low, high) in ((speed, each.linear), (turning, each.theta)):
            fits &= (value >= low - SPEED_TOLERANCE) & (value <= high + SPEED_TOLERANCE)
        if each.direction is not None:
            first, last = each.direction
            after = np.cos(first) * aside - np.sin(first) * ahead >= -SPEED_TOLERANCE
            before = np.sin(last) * ahead - np.cos(last) * aside >= -SPEED_TOLERANCE
            fits &= after | before if last - first > math.pi else after & before
        if each is which:
            return fits
        free &= ~fits
    raise AssertionError("no such set")


def touches(case, which, field, t):
    """Return whether the person touches a field that applies at given times."""
    t = np.asarray(t, dtype=float)
    return applies(case, which, t) & (depth(case, which, field, t) <= 0)


def changes(case, which, field, t):
    """Return the times at which a contact begins or ends, by samples and bisection."""
    state = touches(case, which, field, t)
    k = np.flatnonzero(state[1:] != state[:-1])
    low, high, before = t[k], t[k + 1], state[k]
    for _ in range(24):
        middle = (low + high) / 2
        same = touches(case, which, field, middle) == before
        low, high = np.where(same, middle, low), np.where(same, high, middle)
    return high


def polygon(rng):
    """Return a polygon around the machine, mostly ahead of it and concave."""
    count = rng.randint(3, 9)
    angles = sorted(rng.uniform(0, math.tau) for _ in range(count))
    reach = [rng.uniform(0.3, 2.5) for _ in range(count)]
    shift = rng.uniform(-0.3, 1.5)
    return [(shift + r * math.cos(a), r * math.sin(a)) for r, a in zip(reach, angles, strict=True)]


def field_sets(rng):
    """Return one to four sets for ranges of speed, turn rate, or direction."""
    cuts = sorted(rng.uniform(-0.6, 1.5) for _ in range(rng.randint(0, 3)))
    kind = rng.choice(["linear", "theta", "direction"])
    sets = []
    for k, ends in enumerate(zip([-9.0, *cuts], [*cuts, 9.0], strict=True)):
        keys = {"linear": ends}
        if kind == "theta" and rng.random() < 0.5:
            low = rng.uniform(-0.8, 0.5)
            keys["theta"] = (low, low + rng.uniform(0.1, 1.0))
        if kind == "direction":
            first = rng.uniform(-4, 4)
            keys["direction"] = (first, first + rng.uniform(0.2, 6.2))
        warning = polygon(rng) if rng.random() < 0.5 else ()
        sets.append(FieldSet(name=f"s{k}", protective=polygon(rng), warning=warning, **keys))
    return ProtectiveFields(sets=sets)


def vehicle(rng):
    """Return the motion of a vehicle: drives and turns on the spot, arcs, or samples."""
    kind = rng.choice(["path", "twist", "samples"])
    limits = VehicleLimits(side_speed=rng.choice([0.0, 0.8]))
    x, y, turned = (rng.uniform(-1, 1) for _ in range(3))
    if kind == "path":
        poses = []
        for _ in range(2):
            turned += rng.uniform(-2, 2)
            poses.append((x, y, turned))
            length = rng.uniform(0.3, 3)
            x, y = x + length * math.cos(turned), y + length * math.sin(turned)
            poses.append((x, y, turned))
        return vehicle_path(poses[0], poses[1:], 0.5, limits=limits)
    if kind == "twist":
        twist = (rng.uniform(-1, 1.4), rng.uniform(-1, 1))
        return vehicle_twist((x, y, turned), twist, 0.5, seconds=rng.uniform(1, 5), limits=limits)
    places = np.cumsum([[rng.gauss(0, 0.5), rng.gauss(0, 0.5)] for _ in range(8)], axis=0)
    turns = np.cumsum([rng.gauss(0, 0.5) for _ in range(8)])
    return Motion.from_samples(np.arange(8) * 0.8, places, turns)


def pedestrian(rng):
    """Return the motion of a person who walks, stands, or is moved to another place."""
    t, x, y = 0.0, rng.uniform(-4, 4), rng.uniform(-4, 4)
    samples = [(t, x, y)]
    for _ in range(rng.randint(1, 7)):
        t += rng.uniform(0.4, 2.0)
        x, y = x - rng.uniform(0, 0.9) * x + rng.gauss(0, 1), y * rng.random() + rng.gauss(0, 1)
        samples.append((t, x, y))
    t, x, y = np.array(samples).T
    motion = Motion.from_samples(t, np.column_stack([x, y]))
    if rng.random() < 0.1:
        return standing((rng.uniform(-2, 2), rng.uniform(-2, 2)))
    if rng.random() < 0.1:
        return join([motion, standing((rng.uniform(-2, 2), 0.0), start=motion.end)])
    return motion


def random_case(seed):
    """Return fields, a machine, a person, and the person's radius."""
    rng = random.Random(seed)
    while True:
        try:
            fields = field_sets(rng)
            break
        except ValueError:
            continue  # a polygon that crosses itself
    return fields, vehicle(rng), pedestrian(rng), rng.choice([RADIUS, 0.25, 0.0])


def all_fields(case):
    """Return each set of a case with each of its fields."""
    return [(each, field) for each in case[0].sets for field in KINDS if each.corners(field)]
