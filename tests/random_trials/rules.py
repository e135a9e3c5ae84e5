"""The rule set, applied again to the violations of a run, and its figures, counted from events."""

import itertools
import math
from collections import Counter

import numpy as np
import shapely

from navigation import minimum_separation

from .movement import instants, state_of
from .separation import measured_point, pose_before

INSTANT = 1e-8
"""s. Times in events are rounded, so those no farther apart may be equal."""

FIGURE = 1e-5
"""Maximum error of values in events (m or m/s)."""

REACH = 1.25
"""Distance to a station at which a person blocked by another has arrived (m)."""


SOON = 6.0
"""s. People may be committed to walk over any place that they can reach by then."""


def rule_faults(run):
    """Return faults: required events that are missing, and events without a reason."""
    yield from _event_faults(run)
    yield from _violation_faults(run)
    yield from _consequence_faults(run)
    yield from _standing_faults(run)
    yield from _yielding_faults(run)
    yield from _figure_faults(run)
    yield from _overlap_faults(run)


def _event_faults(run):
    times = [event["t"] for event in run.events]
    if times != sorted(times) or times[0] != 0.0 or times[-1] > run.duration + INSTANT:
        yield "events are not in order, or beyond the end"
    if run.events[0]["kind"] != "trial_started" or run.events[-1]["kind"] != "trial_ended":
        yield "a run begins with trial_started and ends with trial_ended"


def _violation_faults(run):
    """Check that violations and the monitor's intervals correspond, with correct figures."""
    recorded = [event for event in run.events if event["kind"] == "violation"]
    for event in recorded:
        t, person, machine = event["t"], event["person"], event["with"]
        intervals = run.violations[person, machine]
        if not any(a - INSTANT <= t <= b + INSTANT for a, b in intervals):
            yield f"a violation that the monitor does not know: {event}"
        if t < INSTANT:
            continue  # a motion does not contain the position before a teleport
        there, robot = pose_before(run, machine, t)
        point = np.add(there, measured_point(run, machine))
        # At the time of a teleport, the person may be at its target.
        puts = [
            e["to"]
            for e in run.events
            if e["kind"] == "teleport" and e["t"] == t and e["person"] == person
        ]
        poses = [pose_before(run, person, t), *((at, 0.0) for at in puts)]
        wanted = [event[name] for name in ("distance", "human_speed", "robot_speed")]
        measured = [(math.dist(at, point), human, robot) for at, human in poses]
        if not any(np.allclose(wanted, figures, rtol=0, atol=FIGURE) for figures in measured):
            yield f"it was {measured}: {event}"
        if event["distance"] > event["required"] + FIGURE:
            yield f"a violation without need: {event}"
        if robot > FIGURE and event["cause"] == "person":
            yield f"the machine moves: {event}"
        if robot == 0.0 and event["cause"] != "person":
            yield f"the machine stands: {event}"
    for (person, machine), intervals in run.violations.items():
        times = [e["t"] for e in recorded if (e["person"], e["with"]) == (person, machine)]
        for begin, _ in intervals:
            if not any(abs(begin - t) <= INSTANT for t in times):
                yield f"no violation of {person} and {machine} is recorded at t = {begin} s"


def _consequence_faults(run):
    """Check the immediate consequences of each violation, by the rule set."""
    rules = run.trial.rules
    disabled_until = grace_until = -math.inf
    silent_until = {entry.name: -math.inf for entry in run.trial.people}
    sent = set()
    for event in run.events:
        if event["kind"] != "violation":
            continue
        t, person = event["t"], event["person"]
        follow = [e for e in run.events if abs(e["t"] - t) <= INSTANT]
        is_reported = t >= silent_until[person] - INSTANT
        in_grace = disabled_until - INSTANT <= t < grace_until - INSTANT
        counts = event["with"] == "gantry" and rules.machine == "disable"
        if event["penalty"] != (counts and is_reported and not in_grace):
            yield f"should {'not ' if event['penalty'] else ''}be a penalty: {event}"
        if event["penalty"]:
            seconds = [e["seconds"] for e in follow if e["kind"] == "gantry_disabled"]
            if rules.gantry_disabled not in seconds:
                yield f"the gantry is not disabled: {event}"
            disabled_until = t + rules.gantry_disabled
            grace_until = disabled_until + rules.grace
        if is_reported and rules.person == "teleport":
            sent.add((person, round(t, 6)))
            if not any(_ends_at_home(run, e, person) for e in follow):
                yield f"{person} is not put home: {event}"
            if rules.report_every is not None:
                silent_until[person] = t + rules.report_every
        if rules.machine == "stop" and not _is_stopped(run, event["with"], t):
            yield f"the machine is not stopped: {event}"
    people = run.trial.people
    # Custom programs may send people home at any time.
    free = {entry.name for entry in people if not isinstance(entry.personality, str)}
    late = Counter()
    for event in run.events:
        t, person = event["t"], event.get("person")
        if event["kind"] == "teleport" and person not in free and (person, round(t, 6)) not in sent:
            # A person who violates again during the pause goes home again after it.
            late[person] += 1
            if late[person] > sum(who == person and when < t for who, when in sent):
                yield f"put home without need: {event}"
        if event["kind"] == "gantry_disabled" and rules.machine != "disable":
            yield f"nothing disables the gantry: {event}"
        if event["kind"] == "protective_stop" and rules.machine != "stop":
            yield f"nothing stops a machine: {event}"


def _ends_at_home(run, event, person):
    """Return whether a person is put home, or stays where an AGV leaves no room there."""
    if event.get("person") != person:
        return False
    if event["kind"] != "path_blocked":
        return event["kind"] == "teleport"
    return math.dist(event["goal"], _home(run, person)) < FIGURE


def _home(run, person):
    return _entry(run, person).home_on(run.trial.floorplan).position


def _is_stopped(run, machine, t):
    return any(a - INSTANT <= t <= b + INSTANT for a, b in _stops(run).get(machine, []))


def _stops(run):
    """Return the intervals in which each machine had to stand, according to the events."""
    stops, since = {}, {}
    for event in run.events:
        if event["kind"] == "protective_stop":
            since[event["machine"]] = event["t"]
        elif event["kind"] == "protective_stop_ended":
            machine = event["machine"]
            stops.setdefault(machine, []).append((since.pop(machine), event["t"]))
    for machine, begin in since.items():
        stops.setdefault(machine, []).append((begin, run.duration))
    return stops


def _disabled(run):
    """Return the intervals in which the gantry is disabled, from their begins and durations."""
    intervals, since, until = [], None, -math.inf
    for event in run.events:
        if event["kind"] == "gantry_disabled":
            since = event["t"] if since is None else since
            until = max(until, event["t"] + event["seconds"])
        elif event["kind"] == "gantry_enabled":
            intervals.append((since, until))
            since = None
    return intervals if since is None else [*intervals, (since, until)]


def _standing_faults(run):
    """Check that disabled and stopped machines come to rest at once, and stay there."""
    plan = run.trial.floorplan
    enabled = [e["t"] for e in run.events if e["kind"] == "gantry_enabled"]
    due = [until for _, until in _disabled(run) if until < run.duration - INSTANT]
    if len(due) > len(enabled) or any(
        abs(a - b) > INSTANT for a, b in zip(due, enabled, strict=False)
    ):
        yield f"the gantry is enabled at {enabled}, and should be at {due}"
    standing = [("gantry", *interval) for interval in _disabled(run)]
    standing += [
        (name, *interval) for name, intervals in _stops(run).items() for interval in intervals
    ]
    for machine, begin, end in standing:
        if machine == "gantry":
            # Reduce the acceleration to zero, brake, and reduce the deceleration to zero.
            braking = max(
                axis.max_speed / axis.max_acceleration + 3 * axis.max_acceleration / axis.max_jerk
                for axis in plan.gantry.axes
            )
        else:
            braking = plan.lane(machine).max_speed / plan.lane(machine).max_acceleration
        for piece in run.motions[machine].pieces:
            middle = (piece.begin + piece.end) / 2
            if not begin + braking + INSTANT < middle < end - INSTANT:
                continue
            if math.hypot(*state_of(piece, middle - piece.begin)[1]) > FIGURE:
                yield f"{machine} moves at t = {middle} s, and stands from {begin} to {end} s"


def _yielding_faults(run):
    """Check that a yielding AGV comes too close only to people who were put down in front of it."""
    for event in run.events:
        if event["kind"] != "violation" or event["with"] not in run.trial.yielding:
            continue
        lane, t = run.trial.floorplan.lane(event["with"]), event["t"]
        # It checks ten times a second, and then brakes.
        since = t - 0.2 - lane.max_speed / lane.max_acceleration
        put = [e["t"] for e in run.events if e["kind"] == "teleport" and since <= e["t"] <= t]
        if not put:
            yield f"it should have yielded: {event}"


def _figure_faults(run):
    """Check the figures of the summary against events and motions."""
    events = Counter(event["kind"] for event in run.events)
    violations = [event for event in run.events if event["kind"] == "violation"]
    with_gantry = [event for event in violations if event["with"] == "gantry"]
    rules, summary = run.trial.rules, run.summary
    counted = {
        "penalties": sum(event["penalty"] for event in violations),
        "agv_violations": len(violations) - len(with_gantry),
        "jobs_done": events["job_done"],
        "protective_stops": events["protective_stop"],
        "duration": round(run.duration, 9),
    }
    if rules.person == "none":
        counted["agv_teleports"] = 0
    for name, value in counted.items():
        if summary[name] != value:
            yield f"the summary says {name}: {summary[name]}, the events {value}"
    if sum(summary["violations"].values()) != len(with_gantry):
        yield f"the summary says {summary['violations']}, of {len(with_gantry)} with the gantry"
    times = {
        "gantry_disabled_time": [(a, min(b, run.duration)) for a, b in _disabled(run)],
        "protective_stop_time": [i for stops in _stops(run).values() for i in stops],
    }
    for name, intervals in times.items():
        seconds = sum(b - a for a, b in intervals)
        if abs(summary[name] - seconds) > 1e-6:
            yield f"the summary says {name}: {summary[name]}, the events {seconds}"
    for person, figures in summary["people"].items():
        yield from (f"{person}: {fault}" for fault in _person_faults(run, person, figures))


def _person_faults(run, person, figures):
    own = [event for event in run.events if event.get("person") == person]
    started = next((e["t"] for e in own if e["kind"] == "human_started"), None)
    arrivals = [e for e in own if e["kind"] == "arrived"]
    counted = {
        "started": started,
        "visits": [e["station"] for e in arrivals if e["station"] is not None],
        "replans": sum(e["kind"] == "replanned" for e in own),
    }
    for name, value in counted.items():
        if figures[name] != value:
            yield f"the summary says {name}: {figures[name]}, the events {value}"
    walked = standing = 0.0
    since = math.inf if started is None else started
    for piece in run.motions[person].pieces:
        if piece.end <= since:
            continue
        late = max(since - piece.begin, 0.0)
        offsets = [late, *(u for u in instants(piece, 0.05) if u > late)]
        at = [state_of(piece, u)[0][:2] for u in offsets]
        way = sum(map(math.dist, at, at[1:]))
        walked += way
        standing += piece.end - piece.begin - late if way < 1e-12 else 0.0
    if abs(figures["distance_walked"] - walked) > 1e-6 * (1 + walked):
        yield f"walked {walked} m, and the summary says {figures['distance_walked']} m"
    if abs(figures["time_standing"] - standing) > 1e-4:
        yield f"stood {standing} s, and the summary says {figures['time_standing']} s"
    plan, radius = run.trial.floorplan, _radius(run, person)
    for event in arrivals:
        at, speed = pose_before(run, person, event["t"])
        if math.dist(at, event["at"]) > FIGURE or speed > FIGURE:
            yield f"is at {at} at {speed} m/s: {event}"
        if event["station"] is not None:
            place = plan.station(event["station"]).position
            # The station is taken by a person who is there or is committed to go there. Within
            # reach of the station, any other person within reach of it may be in the way.
            soon = (event["t"] + wait for wait in (0.0, 1.0, 2.0, 3.0))
            near = REACH + radius if math.dist(place, event["at"]) < REACH else 2.5 * radius
            taken = any(_away(run, person, place, t) < near for t in soon)
            if math.dist(place, event["at"]) > plan.human.goal_tolerance and not taken:
                yield f"is not at the station: {event}"
    home = _home(run, person)
    for event in own:
        if event["kind"] == "teleport" and math.dist(event["to"], home) > FIGURE:
            yield from _beside_home_faults(run, event, home, radius)


def _overlap_faults(run):
    """Check with the exact monitor that no two people overlap."""
    for one, other in itertools.combinations(run.summary["people"], 2):
        a, b = run.motions[one], run.motions[other]
        t, apart = minimum_separation(a, b, 0.0, run.duration)
        if apart < _radius(run, one) + _radius(run, other):
            yield f"{one} and {other} overlap at t = {t} s: {apart} m between their centres"


def _away(run, person, place, t):
    """Return the distance to the nearest other person from a place (m)."""
    others = [name for name in run.summary["people"] if name != person]
    gaps = [math.dist(pose_before(run, name, t)[0], place) for name in others]
    return min(gaps, default=math.inf)


def _entry(run, person):
    return next(entry for entry in run.trial.people if entry.name == person)


def _radius(run, person):
    radius = _entry(run, person).radius
    return run.trial.floorplan.human.radius if radius is None else radius


def _top_speed(run, person):
    speed = _entry(run, person).max_speed
    return run.trial.floorplan.human.max_speed if speed is None else speed


ANNOUNCED = 10.0
"""Time before the start of an AGV from which people take it into account (s)."""


def _beside_home_faults(run, event, home, radius):
    """Check that people are put beside their home only if it is taken, or may be soon."""
    plan, t = run.trial.floorplan, event["t"]
    gaps = []
    for lane in plan.lanes:
        (x, y), _ = pose_before(run, lane.name, t)
        q = math.dist(lane.origin, (x, y))
        gaps.append(lane.footprint(q).distance(shapely.Point(home)))
        moves = run.trial.agvs.get(lane.name, ())
        drives = pose_before(run, lane.name, t)[1] > 0.0
        if drives or any(t <= move.time <= t + ANNOUNCED for move in moves):
            on_lane = shapely.LineString([lane.position(q) for q in lane.limits])
            gaps.append(on_lane.distance(shapely.Point(home)) - lane.length)
    others = [entry.name for entry in run.trial.people if entry.name != event["person"]]
    places = [(name, pose_before(run, name, t)[0]) for name in others]
    # Two people may be sent home at the same time, and share it.
    earlier = run.events[: run.events.index(event)]
    places += [
        (other["person"], other["to"])
        for other in earlier
        if other["kind"] == "teleport" and other["t"] == t
    ]
    soon = any(math.dist(at, home) < SOON * _top_speed(run, name) + radius for name, at in places)
    if min(gaps, default=math.inf) > radius + FIGURE and not soon:
        yield f"there is room at home: {event}"
    there = [o.footprint for o in plan.obstacles if o.overlaps(0.0, plan.human.height)]
    line = shapely.LineString([home, event["to"]])
    if shapely.union_all(there).distance(line) < radius - 1e-4:
        yield f"was put behind something: {event}"
