"""A recording made up for the tests of the replay page: the ARIAC floor, 275 s, and one mishap.

It is scripted, not simulated, and shares no code with the simulation: whatever the page shows of
it can be compared with what is computed here.
"""

from __future__ import annotations

import math
from bisect import bisect_right

import floorplan

DURATION = 275.0
LAW = {"t1": 1.0, "t2": 1.5, "stopping": 0.0, "intrusion": 1.0}
SAFE_ZONE = (-15.0, -10.0)
SAFE_HEADING = math.pi

PATROL = {
    "station4": [(-10.8, -3.75)],
    "station2": [(-10.8, 3.75)],
    "station1": [(-9.0, 4.3), (-6.4, 4.3), (-5.0, 3.75)],
    "station3": [(-5.0, -3.75)],
}
SECOND_ROUND = {"station4": [(-6.4, -4.3), (-9.0, -4.3), (-10.8, -3.75)]}
WAREHOUSE_ROUND = [(-15.2, -8.6), (-14.5, 0.0), (-14.8, 8.0)]


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
        """Somewhere else at once."""
        self.at, self.heading = at, heading

    def follow(self, points, *, speed, acceleration):
        """Along straight lines, from rest to rest without slowing at corners; turned ahead."""
        corners = [self.at, *points]
        lengths = [math.dist(a, b) for a, b in zip(corners, corners[1:], strict=False)]
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
        """Straight to a place from rest to rest, turning all the way."""
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
    """The polynomial from `start` to `end` as `part` (a polynomial) goes from 0 to 1."""
    change = end - start
    return [start + change * part[0], change * part[1], change * part[2]]


def trapezoid(length, speed, acceleration):
    """Rest to rest over `length`: [(begin, end, (s0, v0, a/2))], s the way so far."""
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
    """The parts of `phases` in which the way goes from `low` to `high`."""
    for begin, end, (s, v, a) in phases:
        first, last = s, s + (end - begin) * (v + (end - begin) * a)
        if last <= low + 1e-9 or first >= high - 1e-9:
            continue
        u0 = time_at(low - s, v, a) if first < low else 0.0
        u1 = time_at(high - s, v, a) if last > high + 1e-9 else end - begin
        yield begin + u0, begin + u1, (s + u0 * (v + u0 * a), v + 2 * a * u0, a)


def time_at(way, v, a):
    """When v u + a u² reaches `way`."""
    if abs(a) < 1e-12:
        return way / v
    return (-v + math.sqrt(max(0.0, v * v + 4 * a * way))) / (2 * a)


def pose(pieces, t):
    """x, y, rotation, vx, vy at `t`: the meaning of a recorded motion, said once more."""
    index = bisect_right([piece[0] for piece in pieces], t) - 1
    begin, end, *axes = pieces[max(index, 0)]
    moving = index >= 0 and t < end
    u = min(max(t, begin), end) - begin
    x, y, rotation = (sum(c * u**k for k, c in enumerate(axis)) for axis in axes)
    vx, vy = (
        sum(k * c * u ** (k - 1) for k, c in enumerate(axis) if k) if moving else 0.0
        for axis in axes[:2]
    )
    return x, y, rotation, vx, vy


def separation(person, other, law, t):
    """Distance and required distance between two recorded motions at `t`."""
    px, py, _, pvx, pvy = pose(person, t)
    ox, oy, _, ovx, ovy = pose(other, t)
    distance = math.hypot(px - ox, py - oy)
    if "distance" in law:
        return distance, law["distance"]
    human, robot = math.hypot(pvx, pvy), math.hypot(ovx, ovy)
    required = human * (law["t1"] + law["t2"]) + robot * law["t1"]
    return distance, required + law["stopping"] + law["intrusion"]


def violations(person, other, law, *, step=0.05):
    """Where the distance is less than required, to within rounding, unless shorter than `step`."""

    def close(t):
        distance, required = separation(person, other, law, t)
        return distance < required

    def switch(low, high):
        before = close(low)
        for _ in range(50):
            middle = (low + high) / 2
            low, high = (middle, high) if close(middle) == before else (low, middle)
        return high

    found = []
    for i in range(round(DURATION / step)):
        low, high = i * step, (i + 1) * step
        if not close(low) and close(high):
            found.append([switch(low, high), DURATION])
        elif close(low) and not close(high) and found:
            found[-1][1] = switch(low, high)
    return found


def gantry_track(parked=None):
    """Jobs between bins and AGVs; standing from `parked[0]` to `parked[1]` if given."""
    jobs = [
        (8.0, (-2.6, 2.0), 0.0),
        (20.0, (-3.4, 4.4), 1.2),
        (34.0, (-5.2, 1.2), math.pi / 2),
        (60.0, (-4.4, 0.6), 2.2),
        (95.0, (-2.8, -2.6), -math.pi / 2),
        (120.0, (-3.4, -4.6), 0.0),
        (150.0, (-9.0, -0.4), math.pi),
        (190.0, (-3.0, 3.0), 0.0),
        (230.0, (-7.0, 0.0), 0.0),
    ]
    track = Track((-7.0, 0.0))
    for start, to, rotation in jobs:
        if parked and parked[0] <= start < parked[1]:
            continue
        track.wait(start)
        track.shift(to, rotation)
    return track


def person_track(caught=None):
    """The patrol; put into the safe zone at `caught`, from where it begins again."""
    events = []
    track = Track(SAFE_ZONE, SAFE_HEADING)

    def walk(station, points):
        events.append({"t": track.t, "kind": "goal", "person": "operator", "station": station})
        track.follow(points, speed=1.0, acceleration=2.5)
        events.append({"t": track.t, "kind": "arrived", "person": "operator", "station": station})
        track.wait(track.t + 3.0)

    track.wait(2.0)
    for station, points in PATROL.items():
        walk(station, points)
    if caught is None:
        return track, events
    cut(track, caught)
    events = [event for event in events if event["t"] <= caught]
    track.put(SAFE_ZONE, SAFE_HEADING)
    track.wait(caught + 8.0)
    for station, points in (PATROL | SECOND_ROUND).items():
        if station != "station4":
            walk(station, points)
    walk("station4", SECOND_ROUND["station4"])
    walk("station2", PATROL["station2"])
    cut(track, DURATION)
    return track, [event for event in events if event["t"] <= DURATION]


def cut(track, t):
    """Forget what comes after `t`."""
    track.pieces = [piece for piece in track.pieces if piece[0] < t]
    track.pieces[-1][1] = min(t, track.pieces[-1][1])
    x, y, heading, *_ = pose(track.pieces, t)
    track.t, track.at, track.heading = t, (x, y), heading


def agv_track(lane, moves):
    events = []
    track = Track(lane.position(lane.locations[lane.start]), lane.heading)
    for start, location in moves:
        track.wait(start)
        events.append({"t": start, "kind": "agv_moved", "agv": lane.name, "to": location})
        heading = track.heading
        track.follow([lane.position(lane.locations[location])], speed=2.0, acceleration=2.0)
        for piece in track.pieces:
            piece[4] = [heading]
        track.heading = heading
    return track, events


AGV_MOVES = {
    "agv1": [(75.0, "assembly_front"), (180.0, "kitting")],
    "agv2": [(140.0, "assembly_back")],
    "agv3": [(215.0, "warehouse")],
    "agv4": [(250.0, "assembly_front")],
}


def recording():
    """The sample, in the form that `sim.replay.render` takes."""
    plan = floorplan.load("ariac2023")
    walker, _ = person_track()
    caught = violations(walker.pieces, gantry_track().pieces, LAW)[0][0]
    walker, walked = person_track(caught)
    gantry = gantry_track((caught - 10.0, caught + 8.0))
    motions = {"operator": walker.pieces, "gantry": gantry.pieces}
    events = [
        {"t": 0.0, "kind": "trial_started"},
        {"t": 2.0, "kind": "human_started", "person": "operator"},
        *walked,
        {"t": DURATION, "kind": "trial_ended"},
    ]
    for lane in plan.lanes:
        track, moved = agv_track(lane, AGV_MOVES[lane.name])
        motions[lane.name] = track.pieces
        events += moved
    for t, part, place in ((46.0, "red pump", "agv2"), (130.0, "blue battery", "agv4")):
        events.append({"t": t, "kind": "job_done", "part": part, "place": place})
    events.append({"t": 178.0, "kind": "order_submitted", "order": "MMB30521"})

    watches = []
    for other in motions:
        if other == "operator":
            continue
        law = LAW if other == "gantry" else {"distance": 2.1}
        found = violations(walker.pieces, motions[other], law)
        if other == "gantry":
            found = sorted([*found, [caught - 0.4, caught]])
        watches.append(
            {
                "person": "operator",
                "other": other,
                "law": law,
                "notice": 2.0 if other == "gantry" else None,
                "notice_cap": None,
                "violations": found,
            }
        )
    distance, required = separation(walker.pieces, gantry.pieces, LAW, caught - 1e-9)
    events += [
        {"t": caught - 3.0, "kind": "gantry_detected", "person": "operator", "with": "gantry"},
        {
            "t": caught,
            "kind": "violation",
            "person": "operator",
            "with": "gantry",
            "distance": distance,
            "required": required,
            "penalty": True,
        },
        {"t": caught, "kind": "gantry_disabled"},
        {"t": caught, "kind": "teleport", "person": "operator", "to": list(SAFE_ZONE)},
        {"t": caught + 8.0, "kind": "gantry_enabled"},
    ]
    events.sort(key=lambda event: event["t"])
    return {
        "format": "floorwalker-replay/1",
        "title": "ariac2023 · antagonistic",
        "duration": DURATION,
        "summary": {
            "duration": DURATION,
            "penalties": 1,
            "agv_teleports": 0,
            "gantry_disabled_time": 8.0,
            "minimum_separation": {"distance": distance, "time": caught, "required": required},
            "people": {
                "operator": {
                    "visits": [e["station"] for e in events if e["kind"] == "arrived"],
                    "distance_walked": 83.21,
                    "time_standing": 120.4,
                    "replans": 0,
                }
            },
        },
        "floorplan": describe(plan),
        "bodies": [
            {"name": "operator", "kind": "person", "radius": 0.3, "personality": "antagonistic"},
            {
                "name": "gantry",
                "kind": "gantry",
                "length": 1.05,
                "width": 0.95,
                "reach": 0.9,
                "mount": 0.51,
            },
            *(
                {"name": lane.name, "kind": "agv", "length": lane.length, "width": lane.width}
                for lane in plan.lanes
            ),
        ],
        "motions": motions,
        "events": events,
        "watches": watches,
    }


def describe(plan):
    """A floorplan as the recording has it."""
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
