"""Oracle of vehicles: runs sampled at 200 Hz with shapely, from motions and events alone.

Footprints, fields and limits follow from the numbers of the trial. The code that made the run does
not judge it.
"""

import importlib.util
import math
from functools import cached_property

import numpy as np
import shapely
from shapely.geometry import Polygon

RATE = 200.0
"""Hz."""

STRIDE = 10
"""Distance of the samples whose differences are accelerations and jerks."""

DEEP = 2e-3
"""Metres. Less than this is no overlap."""

MOVES = 1e-3
"""m/s and rad/s. A body that is slower is at rest."""

NEAR = 3.0 / RATE
"""Maximum time between an event and its samples (s)."""

PATHS = ("oblivious", "pausing", "avoiding", "parked")
"""Controllers that plan paths, which lead through nothing."""

ROWS = ("people", "walls", "machines", "limits", "fields", "events")


def vehicle_faults(run):
    """Yield all faults of a run, in words, each with its row."""
    samples = Sampled(run)
    for row in ROWS:
        for fault in getattr(samples, row)():
            yield f"{row}: {fault}"


class Vehicle:
    """A vehicle of a trial as samples: its poses, speeds and polygons."""

    def __init__(self, name, keys, motion, t):
        self.name, self.keys, self.t = name, keys, t
        self.outline = outline_of(keys)
        self.x, self.y = motion.position(t).T
        self.turned = motion.rotation(t)
        self.reach = float(np.hypot(*shapely.get_coordinates(self.outline).T).max())
        pose = np.column_stack([self.x, self.y, self.turned])
        changes = np.abs(np.diff(pose, axis=0)).max(axis=1) > MOVES / RATE
        self.moves = np.concatenate([[False], changes]) | np.concatenate([changes, [False]])

    def __str__(self):
        return f"{self.name} ({self.keys['controller'].split(':')[-1]})"

    def placed(self, polygon, k):
        """Return a polygon of the vehicle's frame at some samples."""
        u, v = shapely.get_coordinates(polygon.exterior)[:-1].T
        c, s = np.cos(self.turned[k])[:, None], np.sin(self.turned[k])[:, None]
        x, y = self.x[k][:, None] + c * u - s * v, self.y[k][:, None] + s * u + c * v
        return shapely.polygons(np.stack([x, y], axis=-1))

    @cached_property
    def core(self):
        """Footprint without the margin within which a touch is no overlap."""
        return self.outline.buffer(-DEEP, join_style="mitre")

    @property
    def top(self):
        load = self.keys.get("load")
        return self.keys.get("height", 0.4) + (load[2] if load else 0.0)

    @property
    def stop_time(self):
        """Maximum time to come to rest (s)."""
        keys = {"max_turn_speed": 1.0, "max_turn_acceleration": 1.5, "max_turn_jerk": 6.0}
        keys = {"max_speed": 1.5, "max_acceleration": 0.7, "max_jerk": 3.0, **keys, **self.keys}
        return max(
            speed / slows + 3 * math.sqrt(speed / jerk) + 2 * slows / jerk
            for speed, slows, jerk in (
                (keys[f"max_{k}speed"], keys[f"max_{k}acceleration"], keys[f"max_{k}jerk"])
                for k in ("", "turn_")
            )
        )

    def velocity(self, stride=1):
        """Return the speeds ahead and aside (m/s) and turn rate (rad/s) between samples `stride`
        apart.
        """
        dx, dy, dr = (np.subtract(a[stride:], a[:-stride]) for a in (self.x, self.y, self.turned))
        middle = (self.turned[stride:] + self.turned[:-stride]) / 2
        c, s = np.cos(middle), np.sin(middle)
        arc = 1.0 / np.sinc(dr / 2 / math.pi)  # an arc is longer than its chord
        seconds = stride / RATE
        return arc * (c * dx + s * dy) / seconds, arc * (c * dy - s * dx) / seconds, dr / seconds


def outline_of(keys):
    """Return the footprint of a vehicle with its load (m)."""
    length, width = keys.get("size", (1.2, 0.8))
    box = shapely.box(-length / 2, -width / 2, length / 2, width / 2)
    polygon = Polygon(keys["footprint"]) if keys.get("footprint") else box
    if keys.get("load"):
        long, wide, _ = keys["load"]
        polygon = polygon.union(shapely.box(-long / 2, -wide / 2, long / 2, wide / 2)).convex_hull
    return polygon


def spans_of(flags):
    """Return the first and last sample of each stretch that is true."""
    edges = np.flatnonzero(np.diff(np.concatenate([[0], np.asarray(flags, dtype=int), [0]])))
    return [(int(a), int(b) - 1) for a, b in edges.reshape(-1, 2)]


class Sampled:
    """A run as samples, and its faults by rows."""

    def __init__(self, run):
        self.run, self.trial, self.plan = run, run.trial, run.trial.floorplan
        self.t = np.arange(0.0, run.duration, 1.0 / RATE)
        self.vehicles = {
            name: Vehicle(name, entry.keys, run.motions[name], self.t)
            for name, entry in self.trial.machines.items()
        }
        self.people_at = {
            entry.name: (
                run.motions[entry.name].position(self.t),
                entry.radius or self.plan.human.radius,
            )
            for entry in self.trial.people
        }

    def of(self, *kinds, **fields):
        """Return events of some kinds with these fields."""
        return [
            e
            for e in self.run.events
            if e["kind"] in kinds and all(e.get(key) == value for key, value in fields.items())
        ]

    def there(self, person):
        """Return whether a person is on the floor, by samples."""
        started = self.run.summary["people"][person]["started"]
        jumps = np.zeros(len(self.t), dtype=bool)
        return jumps if started is None else self.t >= started

    # People.

    def people(self):
        """Yield people hit by a moving vehicle although they could have stepped aside."""
        for name, vehicle in self.vehicles.items():
            for person, (at, radius) in self.people_at.items():
                overlap = self.touches(vehicle, vehicle.outline, at, radius - DEEP)
                overlap &= self.there(person)
                for first, last in spans_of(overlap):
                    during = slice(max(0, first - 1), last + 1)
                    if not vehicle.moves[during].any() or first == 0:
                        continue
                    walks = np.hypot(*np.diff(at[max(0, first - 3) : first + 1], axis=0).T).sum()
                    t = self.t[first]
                    if self._walks_into(vehicle, at, first, walks) or self._excused(
                        name, person, t
                    ):
                        continue
                    depth = self._depth(vehicle, at, radius, first, last)
                    yield f"{vehicle} hits {person} at t = {t:.3f} s, {depth:.3f} m deep"

    def touches(self, vehicle, polygon, at, radius):
        """Return whether the disc of a person reaches into a polygon of a vehicle, by samples."""
        touching = np.zeros(len(self.t), dtype=bool)
        reach = float(np.hypot(*shapely.get_coordinates(polygon).T).max())
        near = np.hypot(at[:, 0] - vehicle.x, at[:, 1] - vehicle.y) < reach + radius
        k = np.flatnonzero(near)
        if len(k):
            points = shapely.points(at[k])
            touching[k] = shapely.distance(vehicle.placed(polygon, k), points) < radius
        return touching

    def _walks_into(self, vehicle, at, k, walks):
        """Return whether the person's own motion makes the two touch."""
        if walks < 3 * MOVES / RATE:
            return False
        before = max(0, k - 3)
        placed = vehicle.placed(vehicle.outline, np.array([before]))[0]
        stays = vehicle.placed(vehicle.outline, np.array([k]))[0]
        gap = placed.distance(shapely.Point(at[before]))
        by_person = gap - placed.distance(shapely.Point(at[k]))
        by_vehicle = gap - stays.distance(shapely.Point(at[before]))
        return by_person >= by_vehicle

    def _excused(self, vehicle, person, t):
        """Return whether a search proves that no free place was within reach of the person."""
        if importlib.util.find_spec(f"{__package__}.escape") is None:
            return False
        escape = importlib.import_module(f"{__package__}.escape")
        return escape.avoidable(self.trial, (person, vehicle, float(t), 0.0)) is None

    def _depth(self, vehicle, at, radius, first, last):
        k = np.arange(first, last + 1)
        distance = shapely.distance(vehicle.placed(vehicle.outline, k), shapely.points(at[k]))
        return float((radius - distance).max())

    # Walls and machines.

    def walls(self):
        """Yield vehicles in obstacles of the floor, or on paths through closed gates."""
        for vehicle in self.vehicles.values():
            solid = [
                (one.name, one.footprint, None)
                for one in self.plan.obstacles
                if one.bottom < vehicle.top and one.top > 0
            ]
            outside = shapely.box(*self.plan.boundary.buffer(9.0).bounds)
            solid.append(("boundary", outside.difference(self.plan.boundary), None))
            solid += [
                (door.name, door.footprint, self.trial.doors[door.name].closed)
                for door in self.plan.doors
                if door.name in self.trial.doors
            ]
            k = np.flatnonzero(vehicle.moves | (np.arange(len(self.t)) == 0))
            if not len(k):
                continue
            placed = vehicle.placed(vehicle.core, k)
            shapely.prepare(placed)
            for what, area, times in solid:
                inside = shapely.intersects(area, placed)
                if times is not None:
                    inside &= self._drives_into(inside, self.t[k], times, vehicle.stop_time)
                if inside.any():
                    yield f"{vehicle} is in {what} at t = {self.t[k[inside.argmax()]]:.3f} s"
            yield from self._through_gates(vehicle)

    @staticmethod
    def _drives_into(inside, t, times, stop_time):
        """Return where a vehicle is in a closed door, unless it could not stop before the door."""
        driven = np.zeros(len(t), dtype=bool)
        for first, last in spans_of(inside):
            for begin, end in times:
                if not t[first] <= begin + stop_time:
                    driven[first : last + 1] |= (t[first : last + 1] > begin) & (t[first] < end)
        return driven

    def _through_gates(self, vehicle):
        if vehicle.keys.get("controller", "oblivious") not in PATHS:
            return
        ends = np.column_stack([vehicle.x, vehicle.y])
        for gate in self.plan.gates:
            (ax, ay), (bx, by) = gate.ends
            line = shapely.LineString(gate.ends)
            side = np.sign((bx - ax) * (ends[:, 1] - ay) - (by - ay) * (ends[:, 0] - ax))
            wanted = math.copysign(
                1.0, (bx - ax) * (gate.towards[1] - ay) - (by - ay) * (gate.towards[0] - ax)
            )
            for k in np.flatnonzero((side[:-1] == wanted) & (side[1:] == -wanted)):
                if shapely.LineString(ends[k : k + 2]).intersects(line):
                    yield f"{vehicle.name} drives back through {gate.name} at {self.t[k]:.3f} s"

    def machines(self):
        """Yield vehicles that overlap, whether or not the run records it."""
        names = [*self.vehicles]
        for k, one in enumerate(names):
            for other in names[k + 1 :]:
                overlap = self._overlap(self.vehicles[one], self.vehicles[other])
                recorded = [
                    e["t"]
                    for e in self.of("collision")
                    if {e["machine"], e["with"]} == {one, other}
                ]
                if not overlap.any():
                    yield from (
                        f"a collision of {one} and {other} at t = {t:.3f} s is none"
                        for t in recorded
                    )
                for first, _ in spans_of(overlap):
                    yield f"{one} and {other} overlap at t = {self.t[first]:.3f} s"

    def _overlap(self, a, b):
        overlapping = np.zeros(len(self.t), dtype=bool)
        near = np.hypot(a.x - b.x, a.y - b.y) < a.reach + b.reach
        k = np.flatnonzero(near & (a.moves | b.moves))
        if len(k):
            overlapping[k] = shapely.intersects(a.placed(a.core, k), b.placed(b.core, k))
        return overlapping

    # Limits.

    def limits(self):
        """Yield speeds, accelerations and jerks beyond the limits of a vehicle."""
        for name, vehicle in self.vehicles.items():
            keys = vehicle.keys
            speed, acceleration = keys.get("max_speed", 1.5), keys.get("max_acceleration", 0.7)
            jerk = keys.get("max_jerk", 3.0)
            aside = keys.get("max_side_speed", speed) if keys["drive"] == "holonomic" else 0.0
            turn = (
                keys.get("max_turn_speed", 1.0),
                keys.get("max_turn_acceleration", 1.5),
                keys.get("max_turn_jerk", 6.0),
            )
            steps = np.hypot(np.diff(vehicle.x), np.diff(vehicle.y))
            if len(steps) and steps.max() > 1.5 * (speed + aside) / RATE + 1e-6:
                yield f"{name} jumps at t = {self.t[steps.argmax()]:.3f} s"
                continue
            h = STRIDE / RATE
            # On contact the vehicle stops at once.
            impacts = [e["t"] for e in self.of("contact", machine=name)]
            fast = vehicle.velocity()
            slow = vehicle.velocity(STRIDE)
            for what, k, most in (
                ("ahead", 0, (speed, acceleration, jerk)),
                ("aside", 1, (aside, acceleration, jerk)),
                ("turning", 2, turn),
            ):
                v = fast[k]
                first = (slow[k][STRIDE:] - slow[k][:-STRIDE]) / h
                second = (
                    slow[k][2 * STRIDE :] - 2 * slow[k][STRIDE:-STRIDE] + slow[k][: -2 * STRIDE]
                ) / h**2
                for order, values, limit, more in (
                    ("speed", v, most[0], 2e-3),
                    ("acceleration", first, most[1], 2e-2),
                    ("jerk", second, most[2], 0.1 + 0.05 * most[2]),
                ):
                    worst, begins = np.abs(values), self.t[: len(values)]
                    for t in impacts:
                        worst[(begins > t - 3 * h - NEAR) & (begins < t + NEAR)] = 0.0
                    for sample in np.flatnonzero(worst > limit + more) if impacts else ():
                        # A vehicle may press again against a wall from which it is hardly
                        # separated.
                        if self._presses(vehicle, np.arange(sample, sample + 3 * STRIDE)):
                            worst[sample] = 0.0
                    if len(worst) and worst.max() > limit + more:
                        at = self.t[worst.argmax()]
                        yield (
                            f"{name} has {order} {what} {worst.max():.3f} of {limit:g}"
                            f" at t = {at:.3f} s"
                        )

    def _presses(self, vehicle, k):
        """Return whether a vehicle touches a wall at some of these samples."""
        room = self.plan.boundary.difference(
            shapely.union_all([one.footprint for one in (*self.plan.obstacles, *self.plan.doors)])
        )
        placed = vehicle.placed(vehicle.outline, k[k < len(self.t)])
        return bool((shapely.distance(room.boundary, placed) < DEEP).any())

    # Fields.

    def fields(self):
        """Yield occupied fields without an event, and machines that do not stop for them."""
        for name, fields in self.trial.fields.items():
            vehicle = self.vehicles[name]
            muted = self._muted(vehicle, fields)
            yield from self._muting_events(name, muted)
            applying = self._applying(vehicle, fields)
            inside, clearly, gone = (np.zeros(len(self.t), dtype=bool) for _ in range(3))
            gone[:] = True
            for at, radius in self.people_at.values():
                # Sensors also see a person who has not started.
                for k, one in enumerate(fields.sets):
                    polygon = Polygon(one.protective)
                    inside |= ~muted & (applying == k) & self.touches(vehicle, polygon, at, radius)
                    deep = self.touches(vehicle, polygon, at, radius - DEEP)
                    clearly |= ~muted & (applying == k) & deep
                    wide = self.touches(vehicle, polygon, at, radius + DEEP)
                    gone &= muted | (applying != k) | ~wide
            unprotected = (applying < 0) & ~muted
            yield from self._responses(vehicle, fields, clearly)
            yield from self._stops(vehicle, fields, clearly, gone & ~unprotected)

    def _applying(self, vehicle, fields):
        """Return the number of the field set in force at each sample, -1 for none."""
        v = [np.concatenate([values, values[-1:]]) for values in vehicle.velocity()]
        speed = np.where(vehicle.moves, np.hypot(v[0], v[1]), 0.0)
        numbers = np.full(len(self.t), -1)
        for k in reversed(range(len(fields.sets))):
            one = fields.sets[k]
            if one.load not in (None, vehicle.keys.get("load") is not None):
                continue
            along = v[0] if one.direction is None else speed
            fits = (along >= one.linear[0] - 2e-3) & (along <= one.linear[1] + 2e-3)
            fits &= (v[2] >= one.theta[0] - 2e-3) & (v[2] <= one.theta[1] + 2e-3)
            if one.direction is not None:
                first, last = one.direction
                angle = (np.arctan2(v[1], v[0]) - first + 1e-3) % math.tau
                fits &= (speed < MOVES) | (angle <= last - first + 2e-3)
            numbers[fits] = k
        return numbers

    def _muted(self, vehicle, fields):
        muted = np.zeros(len(self.t), dtype=bool)
        for begin, end in fields.muting.times:
            muted |= (self.t >= begin) & (self.t < end)
        points = shapely.points(np.column_stack([vehicle.x, vehicle.y]))
        for zone in self.plan.zones:
            if zone.name in fields.muting.zones:
                muted |= shapely.intersects(zone.area, points)
        return muted

    def _muting_events(self, name, muted):
        """Yield differences between the events of muting and the samples."""
        state, mine = np.zeros(len(self.t), dtype=bool), 0.0
        since = None
        for e in self.of("fields_muted", "fields_unmuted", machine=name):
            if e["kind"] == "fields_muted":
                since = e["t"]
            elif since is not None:
                state |= (self.t >= since) & (self.t < e["t"])
                since = None
        if since is not None:
            state |= self.t >= since
        for first, last in spans_of(state != muted):
            mine = (last - first + 1) / RATE
            if mine > NEAR:
                yield f"muting of {name} differs for {mine:.3f} s at t = {self.t[first]:.3f} s"

    def _intervals(self, begins, ends, **fields):
        """Return the intervals (s) between two kinds of events. The last one may be open."""
        intervals, since = [], None
        for e in self.of(begins, ends, **fields):
            if e["kind"] == begins and since is None:
                since = e["t"]
            elif e["kind"] == ends and since is not None:
                intervals.append((since, e["t"]))
                since = None
        return intervals if since is None else [*intervals, (since, math.inf)]

    def _responses(self, vehicle, fields, inside):
        """Yield intrusions for which a vehicle is not stopped after the response time."""
        stops = self._intervals("field_stop", "field_stop_ended", machine=vehicle.name)
        for first, _ in spans_of(inside):
            due = self.t[first] + fields.response_time + NEAR
            if due < self.run.duration and not any(
                begin <= due and self.t[first] - NEAR < end for begin, end in stops
            ):
                yield f"{vehicle.name} is not stopped at t = {due:.3f} s"

    def _stops(self, vehicle, fields, inside, free):
        """Yield stops in which a vehicle does not come to rest in time, or that end at the wrong
        time.
        """
        longest = vehicle.stop_time
        blind = self._intervals("blackout_began", "blackout_ended", machine=vehicle.name)
        dark = np.zeros(len(self.t), dtype=bool)
        for begin, end in blind:
            dark |= (self.t >= begin - NEAR) & (self.t < end + NEAR)
        name = vehicle.name
        for begin, end in self._intervals("field_stop", "field_stop_ended", machine=name):
            still = (self.t > begin + longest) & (self.t < end - NEAR)
            if (vehicle.moves & still).any():
                yield f"{name} moves in its stop from t = {begin:.3f} s"
            if end == math.inf:
                clear = (self.t > begin + longest) & free & ~dark
                for first, last in spans_of(clear):
                    if (last - first) / RATE > fields.restart_delay + 0.1:
                        yield f"{name} does not restart after t = {self.t[first]:.3f} s"
                        break
                continue
            k = int(end * RATE)
            impact = self.of("contact", machine=name, t=end)
            if k < len(self.t) and vehicle.moves[k] and not impact:
                yield f"{name} is released at t = {end:.3f} s while it moves"
            window = (self.t > end - fields.restart_delay + NEAR) & (self.t < end - NEAR)
            if (inside & window & (self.t > begin)).any():
                yield f"{name} restarts too early at t = {end:.3f} s"
            waits = (self.t > begin + longest) & (self.t < end) & free & ~dark
            for first, last in spans_of(waits):
                if (last - first) / RATE > fields.restart_delay + 0.1:
                    yield f"{name} restarts too late at t = {end:.3f} s"
                    break

    # Events and figures.

    def events(self):
        """Yield figures of the summary that differ from the events."""
        summary, run = self.run.summary, self.run
        if summary["collisions"] != len(self.of("collision")):
            yield "collisions are not those of the events"
        for name in self.vehicles:
            figures = summary["machines"][name]
            if figures["jobs_done"] != len(self.of("job_done", machine=name)):
                yield f"jobs_done of {name} are not those of the events"
            waits = self._intervals("machine_waiting", "machine_proceeds", machine=name)
            waited = sum(min(end, run.duration) - begin for begin, end in waits)
            if abs(waited - figures.get("waiting_time", 0.0)) > 1e-6:
                yield f"waiting_time of {name} is {figures['waiting_time']}, not {waited}"
            proceeds = sum(e["waited"] for e in self.of("machine_proceeds", machine=name))
            closed = sum(end - begin for begin, end in waits if end < math.inf)
            if abs(closed - proceeds) > 1e-6:
                yield f"{name} says that it waited {proceeds} s, not {closed}"
            if name in self.trial.fields:
                stops = self._intervals("field_stop", "field_stop_ended", machine=name)
                stopped = sum(min(end, run.duration) - begin for begin, end in stops)
                if len(self.of("field_stop", machine=name)) != figures["field_stops"]:
                    yield f"field_stops of {name} are not those of the events"
                if abs(stopped - figures["field_stop_time"]) > 1e-6:
                    yield f"field_stop_time of {name} is {figures['field_stop_time']}"
                slow = self._intervals("field_slowdown", "field_slowdown_ended", machine=name)
                slowed = sum(min(end, run.duration) - begin for begin, end in slow)
                slowed -= sum(
                    max(0.0, min(end, until, run.duration) - max(begin, since))
                    for begin, end in slow
                    for since, until in stops
                )
                if abs(slowed - figures["field_slow_time"]) > 1e-6:
                    yield f"field_slow_time of {name} is {figures['field_slow_time']}, not {slowed}"
            yield from self._idle(name, figures["idle_time"])
        yield from self._arrivals()
        yield from self._walked()

    def _idle(self, name, idle):
        """Yield a vehicle whose idle time differs from the time that it stands without a reason."""
        if self.of("contact", machine=name):
            return  # the vehicle stands until its controller moves it
        spans = self._intervals("machine_waiting", "machine_proceeds", machine=name)
        for kind in ("field_stop", "protective_stop"):
            spans += self._intervals(kind, f"{kind}_ended", machine=name)
        holds = self.of("commanded", hold=name) + self.of("commanded", release=name)
        times = [*sorted(e["t"] for e in holds), math.inf]
        spans += zip(times[::2], times[1::2], strict=False)
        pieces = self.run.motions[name].pieces
        spans += [(one.begin, one.end) for one in pieces if not one.stands]
        end = self.run.duration
        busy = shapely.union_all([shapely.box(a, 0, min(b, end), 1) for a, b in spans])
        free = end - busy.area
        missions = self.vehicles[name].keys.get("missions", ())
        waits = [one["wait"] for one in missions if "wait" in one]
        done = len(self.of("job_started", machine=name, job="wait"))
        if not free - done * max(waits, default=0.0) - 1e-6 <= idle <= free + 1e-6:
            yield f"idle_time of {name} is {idle}, and it stands freely for {free}"

    def _walked(self):
        """Yield people whose distance differs from their samples, unless they were put home."""
        for person, (at, _) in self.people_at.items():
            steps = np.hypot(*np.diff(at[self.there(person)], axis=0).T)
            figure = self.run.summary["people"][person]["distance_walked"]
            if not self.of("teleport", person=person) and abs(steps.sum() - figure) > 0.02:
                yield f"{person} walked {steps.sum():.3f} m, not {figure}"

    def _arrivals(self):
        """Yield jobs that end elsewhere than at their destination."""
        stations = {one.name: one.position for one in self.plan.stations}
        for name, vehicle in self.vehicles.items():
            missions = vehicle.keys.get("missions", ())
            for k, e in enumerate(self.of("job_done", machine=name)):
                mission = missions[k % len(missions)]
                if e["job"] not in mission:
                    yield f"{name} has done {e['job']} instead of {mission} at t = {e['t']:.3f} s"
                if "go" not in mission:
                    continue
                to = mission["go"]
                to = stations[to] if isinstance(to, str) else to
                motion = self.run.motions[name]
                if math.dist(motion.position(e["t"]), to[:2]) > 1e-3:
                    yield f"{name} is not at {to} at t = {e['t']:.3f} s"
                turn = motion.rotation(e["t"]) - to[2] if len(to) > 2 else 0.0
                if abs(math.remainder(turn, math.tau)) > 1e-3:
                    yield f"{name} is not turned as {to} at t = {e['t']:.3f} s"
