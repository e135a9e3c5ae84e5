"""Scripted recording for tests of the replay page: the ARIAC floor, 275 s, and one violation.

It is not simulated and shares no code with the simulation, so everything on the page can be
compared with the values computed here.
"""

from __future__ import annotations

import functools
import itertools
import math
from bisect import bisect_right

import floorplan
from sim.core.recorder import rounded as rounded
from sim.core.wording import distinguished as distinguished
from sim.views import replay as replay
from sim.views.replay import recordings_in as recordings_in, render as render
from sim.views.replay_data import replay_data as replay_data

DURATION = 275.0
DISABLED = 8.0
LAW = {"t1": 1.0, "t2": 1.5, "stopping": 0.0, "intrusion": 1.0}
SAFE_ZONE = (-15.0, -10.0)
SAFE_HEADING = math.pi

PATROL = {
    "station4": [(-10.8, -3.75)],
    "station2": [(-10.8, 3.75)],
    "station1": [(-9.0, 4.3), (-6.4, 4.3), (-5.0, 3.75)],
    "station3": [(-5.0, -3.75)],
}
AGAIN = {"station4": [(-6.4, -4.3), (-9.0, -4.3), (-10.8, -3.75)]}
"""Paths of the second and later rounds, if they differ."""

AGV_MOVES = {
    "agv1": [(75.0, "assembly_front"), (180.0, "kitting")],
    "agv2": [(140.0, "assembly_back")],
    "agv3": [(215.0, "warehouse")],
    "agv4": [(250.0, "assembly_front")],
}


class Track:
    """A motion under construction, piece by piece."""

    def __init__(self, at, heading=0.0, start=0.0):
        self.at = at
        self.heading = heading
        self.t = start
        self.pieces = []

    def wait(self, until):
        (x, y), t = self.at, self.t
        if until > t:
            self.pieces.append([t, until, [x], [y], [self.heading]])
            self.t = until

    def put(self, at, heading):
        """Put the body elsewhere at once."""
        self.at, self.heading = at, heading

    def cut(self, t):
        """Remove the pieces after `t`."""
        self.pieces = [piece for piece in self.pieces if piece[0] < t]
        self.pieces[-1][1] = min(t, self.pieces[-1][1])
        x, y, self.heading, *_ = pose(self.pieces, t)
        self.t, self.at = t, (x, y)

    def brake(self, acceleration):
        """Brake to a stop, straight ahead."""
        x, y, heading, vx, vy = before(self.pieces, self.t)
        speed = math.hypot(vx, vy)
        if speed == 0.0:
            return
        end = self.t + speed / acceleration
        slow = -acceleration / (2 * speed)
        self.pieces.append([self.t, end, [x, vx, slow * vx], [y, vy, slow * vy], [heading]])
        x, y, *_ = pose(self.pieces, end)
        self.t, self.at = end, (x, y)

    def follow(self, points, *, speed, acceleration):
        """Move along straight lines, from rest to rest without slowing at corners, turned ahead."""
        corners = [self.at, *points]
        lengths = [math.dist(a, b) for a, b in itertools.pairwise(corners)]
        phases = trapezoid(sum(lengths), speed, acceleration)
        done = 0.0
        for a, b, length in zip(corners, corners[1:], lengths, strict=False):
            c, s = (b[0] - a[0]) / length, (b[1] - a[1]) / length
            self.heading = math.atan2(s, c)
            for begin, end, way in within(phases, done, done + length):
                x = [a[0] + c * (way[0] - done), c * way[1], c * way[2]]
                y = [a[1] + s * (way[0] - done), s * way[1], s * way[2]]
                self.pieces.append([self.t + begin, self.t + end, x, y, [self.heading]])
            done += length
        self.t += phases[-1][1]
        self.at = corners[-1]

    def shift(self, to, rotation, *, speed=1.0, acceleration=0.5):
        """Move straight to a place from rest to rest, turning all the way."""
        (x0, y0), r0 = self.at, self.heading
        length = math.dist((x0, y0), to)
        for begin, end, way in trapezoid(length, speed, acceleration):
            part = [w / length for w in way]
            self.pieces.append(
                [
                    self.t + begin,
                    self.t + end,
                    line(x0, to[0], part),
                    line(y0, to[1], part),
                    line(r0, rotation, part),
                ]
            )
        self.t = self.pieces[-1][1]
        self.at, self.heading = to, rotation


def line(start, end, part):
    """Return the polynomial from `start` to `end` as `part` (a polynomial) goes from 0 to 1."""
    change = end - start
    return [start + change * part[0], change * part[1], change * part[2]]


def trapezoid(length, speed, acceleration):
    """Return phases from rest to rest over `length`: (begin, end, coefficients of the distance)."""
    ramp = min(speed / acceleration, math.sqrt(length / acceleration))
    top = acceleration * ramp
    climb = top * ramp / 2
    cruise = (length - 2 * climb) / top
    phases = [(0.0, ramp, (0.0, 0.0, acceleration / 2))]
    if cruise > 1e-9:
        phases.append((ramp, ramp + cruise, (climb, top, 0.0)))
    brake = phases[-1][1]
    return [*phases, (brake, brake + ramp, (length - climb, top, -acceleration / 2))]


def within(phases, low, high):
    """Return the parts of `phases` in which the distance goes from `low` to `high`."""
    for begin, end, (s, v, a) in phases:
        first, last = s, s + (end - begin) * (v + (end - begin) * a)
        if last <= low + 1e-9 or first >= high - 1e-9:
            continue
        u0 = time_at(low - s, v, a) if first < low else 0.0
        u1 = time_at(high - s, v, a) if last > high + 1e-9 else end - begin
        yield begin + u0, begin + u1, (s + u0 * (v + u0 * a), v + 2 * a * u0, a)


def time_at(way, v, a):
    """Return the time at which v u + a u² reaches `way`."""
    if abs(a) < 1e-12:
        return way / v
    return (-v + math.sqrt(max(0.0, v * v + 4 * a * way))) / (2 * a)


def pose(pieces, t):
    """Return x, y, rotation, vx, vy of a recorded motion at `t`."""
    index = bisect_right(pieces, t, key=lambda piece: piece[0]) - 1
    piece = pieces[max(index, 0)]
    return evaluate(piece, t, moving=piece[0] <= t < piece[1])


def before(pieces, t):
    """Return the same just before `t`, where the last piece ends."""
    return evaluate(pieces[-1], t, moving=True)


def evaluate(piece, t, *, moving):
    begin, end, *axes = piece
    u = min(max(t, begin), end) - begin
    x, y, rotation = (sum(c * u**k for k, c in enumerate(axis)) for axis in axes)
    vx, vy = (
        sum(k * c * u ** (k - 1) for k, c in enumerate(axis) if k) if moving else 0.0
        for axis in axes[:2]
    )
    return x, y, rotation, vx, vy


def separation(person, other, law, t):
    """Return distance and required distance between two recorded motions at `t`."""
    px, py, _, pvx, pvy = pose(person, t)
    ox, oy, _, ovx, ovy = pose(other, t)
    distance = math.hypot(px - ox, py - oy)
    if "distance" in law:
        return distance, law["distance"]
    human, robot = math.hypot(pvx, pvy), math.hypot(ovx, ovy)
    required = human * (law["t1"] + law["t2"]) + robot * law["t1"]
    return distance, required + law["stopping"] + law["intrusion"]


def violations(person, other, law, *, step=0.05):
    """Return intervals of at least `step` in which the distance is less than required."""

    def close(t):
        distance, required = separation(person, other, law, t)
        return distance < required

    def switch(low, high):
        before = close(low)
        for _ in range(50):
            middle = (low + high) / 2
            low, high = (middle, high) if close(middle) == before else (low, middle)
        return high

    intervals = []
    for i in range(round(DURATION / step)):
        low, high = i * step, (i + 1) * step
        if not close(low) and close(high):
            intervals.append([switch(low, high), DURATION])
        elif close(low) and not close(high) and intervals:
            intervals[-1][1] = switch(low, high)
    return intervals


def gantry_track(stops):
    """Return jobs between bins and AGVs, with a stop of DISABLED seconds at each of `stops`."""
    jobs = [
        (8.0, (-2.6, 2.0), 0.0),
        (20.0, (-4.4, 4.2), 1.2),
        (37.0, (-5.2, 1.2), math.pi / 2),
        (60.0, (-4.4, 0.6), 2.2),
        (95.0, (-2.8, -2.6), -math.pi / 2),
        (120.0, (-3.4, -4.6), 0.0),
        (150.0, (-9.0, -0.4), math.pi),
        (190.0, (-3.0, 3.0), 0.0),
        (230.0, (-7.0, 0.0), 0.0),
    ]
    track = Track((-7.0, 0.0))
    for start, to, rotation in jobs:
        track.wait(start)
        track.shift(to, rotation)
        for stop in stops:
            if start <= stop < track.t:
                track.cut(stop)
                track.brake(0.5)
        track.wait(max((stop + DISABLED for stop in stops if stop < track.t), default=0.0))
    return track


def person_track(name, start, heading, caught=math.inf, begin=2.0):
    """Return the patrol from `begin`. It restarts in the safe zone after `caught`."""
    track = Track(start, heading)
    events = [{"t": begin, "kind": "human_started", "person": name}]
    patrol = [*PATROL.items()]
    track.wait(begin)
    while track.t < DURATION:
        station, points = patrol.pop(0)
        event = {"person": name, "station": station, "at": points[-1]}
        events.append({"t": track.t, "kind": "goal", **event})
        track.follow(points, speed=1.0, acceleration=2.5)
        if caught < track.t:
            track.cut(caught)
            events.append(
                {"t": caught, "kind": "teleport", "person": name, "to": SAFE_ZONE}
                | {"reason": "gantry_disabled"}
            )
            track.put(SAFE_ZONE, SAFE_HEADING)
            track.wait(caught + DISABLED)
            patrol = [*PATROL.items()]
            caught = math.inf
            continue
        events.append({"t": track.t, "kind": "arrived", **event})
        track.wait(track.t + 3.0)
        patrol.append((station, AGAIN.get(station, points)))
    track.cut(DURATION)
    return track, [event for event in events if event["t"] <= DURATION]


def agv_track(lane, moves):
    track = Track(lane.position(lane.locations[lane.start]), lane.heading)
    events = []
    for start, location in moves:
        track.wait(start)
        track.follow([lane.position(lane.locations[location])], speed=2.0, acceleration=2.0)
        track.heading = lane.heading
        events.append({"t": start, "kind": "agv_moved", "agv": lane.name, "to": location})
    for piece in track.pieces:
        piece[4] = [lane.heading]
    return track, events


@functools.cache
def recording():
    """Return the sample as `sim.views.replay.render` takes it. Copy it before a change."""
    plan = floorplan.load("ariac2023")
    walker, _ = person_track("operator", SAFE_ZONE, SAFE_HEADING)
    first = violations(walker.pieces, gantry_track([]).pieces, LAW)[0][0]
    walker, events = person_track("operator", SAFE_ZONE, SAFE_HEADING, caught=first)
    later = violations(walker.pieces, gantry_track([first]).pieces, LAW)
    second = next(begin for begin, _ in later if begin > first + DISABLED)
    gantry = gantry_track([first, second])

    motions = {"operator": walker.pieces}
    bodies = [
        {"name": "operator", "category": "person", "radius": 0.3, "personality": "indifferent"},
    ]
    track, visits = person_track("visitor", (-12.0, -8.0), 0.0, begin=15.0)
    motions["visitor"] = track.pieces
    events += visits
    bodies.append({"name": "visitor", "category": "person", "radius": 0.3, "personality": "calm"})
    size = {"length": 1.05, "width": 0.95, "reach": 0.9, "mount": 0.51, "bridge": (-7.0, 7.0)}
    bodies.append({"name": "gantry", "category": "robot", **size})
    motions["gantry"] = gantry.pieces
    for lane in plan.lanes:
        track, moved = agv_track(lane, AGV_MOVES[lane.name])
        motions[lane.name] = track.pieces
        events += moved
        bodies.append(
            {"name": lane.name, "category": "vehicle", "length": lane.length, "width": lane.width}
        )

    people = [body["name"] for body in bodies if body["category"] == "person"]
    watches = [
        watch(person, other, motions)
        for person in people
        for other in motions
        if other not in people
    ]
    for t in (first, second):
        distance, required = separation(walker.pieces, gantry.pieces, LAW, t - 1e-9)
        figures = {"distance": distance, "required": required}
        events += [
            {"t": t, "kind": "violation", "person": "operator", "with": "gantry"}
            | {"penalty": True, **figures},
            {"t": t, "kind": "gantry_disabled", "seconds": DISABLED},
            {"t": t + DISABLED, "kind": "gantry_enabled"},
        ]
    events += [
        {"t": 0.0, "kind": "trial_started"},
        {"t": first - 3.0, "kind": "gantry_detected", "person": "operator"},
        {"t": 130.0, "kind": "job_done", "job": "pick_place", "part": "blue battery"}
        | {"from": "bin2", "to": "agv4"},
        {"t": 178.0, "kind": "order_submitted", "order": "MMB30521"},
        {"t": DURATION, "kind": "trial_ended"},
    ]
    order = ("trial_started", "violation", "gantry_disabled")
    events.sort(key=lambda e: (e["t"], e["kind"] not in order, e["kind"] == "trial_ended"))
    return {
        "format": "floorwalker-replay/1",
        "title": "ariac2023 · sample",
        "duration": DURATION,
        "summary": summary(events, motions),
        "floorplan": describe(plan),
        "bodies": bodies,
        "motions": motions,
        "events": events,
        "watches": watches,
    }


def watch(person, other, motions):
    law = LAW if other == "gantry" else {"distance": 2.1}
    intervals = violations(motions[person], motions[other], law)
    notice = {"notice": 2.0, "notice_cap": None} if other == "gantry" else {}
    return {"person": person, "other": other, "law": law, **notice, "violations": intervals}


def summary(events, motions):
    times = [k * 0.05 for k in range(round(DURATION / 0.05))]
    person, gantry = motions["operator"], motions["gantry"]
    apart = {t: separation(person, gantry, LAW, t) for t in times}
    nearest = min(apart, key=lambda t: apart[t][0])
    speeds = [math.hypot(*pose(person, t)[3:]) for t in times]
    return {
        "duration": DURATION,
        "penalties": sum(event["kind"] == "violation" for event in events),
        "agv_teleports": 0,
        "gantry_disabled_time": DISABLED * sum(e["kind"] == "gantry_disabled" for e in events),
        "minimum_separation": {
            "time": nearest,
            "distance": apart[nearest][0],
            "required": apart[nearest][1],
        },
        "people": {
            "operator": {
                "visits": [
                    event["station"]
                    for event in events
                    if event["kind"] == "arrived" and event["person"] == "operator"
                ],
                "distance_walked": 0.05 * sum(speeds),
                "time_standing": 0.05 * sum(speed == 0.0 for speed in speeds),
                "replans": 0,
            }
        },
    }


def describe(plan):
    """Return a floorplan as a recording has it."""
    return {
        "name": plan.name,
        "title": plan.title,
        "boundary": corners(plan.boundary),
        "obstacles": [
            {"name": o.name, "footprint": corners(o.footprint), "bottom": o.bottom, "top": o.top}
            for o in plan.obstacles
        ],
        "stations": [{"name": s.name, "at": list(s.position)} for s in plan.stations],
        "safe_zone": {"at": list(plan.safe_zone.position), "heading": plan.safe_zone.heading},
        "lanes": [
            {
                "name": lane.name,
                "from": list(lane.position(lane.limits[0])),
                "to": list(lane.position(lane.limits[1])),
                "locations": {n: list(lane.position(q)) for n, q in lane.locations.items()},
            }
            for lane in plan.lanes
        ],
        "gantry": {
            "x": [plan.gantry.x.low, plan.gantry.x.high],
            "y": [plan.gantry.y.low, plan.gantry.y.high],
        },
    }


def corners(polygon):
    return [list(point) for point in polygon.exterior.coords[:-1]]
