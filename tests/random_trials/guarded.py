"""Random trials of vehicles with protective fields among people, and the contacts in their runs.

The fields are those of `needed_fields`. On every side they also cover the distance that a person
walks until the vehicle has stopped.
"""

import math
from functools import cache
from random import Random

from shapely.geometry import Point

import floorplan
import sim
from floorplan import UserError
from navigation import (
    Cylinder,
    FieldSupplements,
    FixedDistance,
    Shapes,
    needed_fields,
    stopping_reach,
    violations,
)
from navigation.machines import AxisLimits
from sim.safety.margins import moving_spans

from .floors import random_floor, standing_place
from .trials import PERSONALITIES

STEPS = (0.3, 0.6, 1.0)
"""m/s. Highest speeds of the field sets below the top speed."""

FASTEST = 1.6
"""m/s. Highest speed of people, for which the fields are made."""

VEHICLES = (
    ((0.6, 0.5), "differential", 0.6, 0.5, 0.05),
    ((0.8, 0.6), "differential", 1.0, 1.2, 0.4),
    ((1.2, 0.8), "differential", 1.5, 0.7, 0.2),
    ((1.6, 0.9), "differential", 1.2, 1.0, 0.2),
    ((2.4, 0.8), "differential", 0.8, 0.8, 0.1),
    ((0.9, 0.7), "holonomic", 1.0, 0.9, 0.2),
    ((1.3, 0.6), "holonomic", 0.6, 1.1, 0.3),
)
"""Size, drive, top speed, acceleration and response time of the fields."""

TOUCH = FixedDistance(1e-6)

LATER = 1e-6
"""s. Times of events are rounded to less."""

MOVES = 1e-3
"""m/s. A person who is slower stands."""


def random_trial_with_fields(number):
    """Return the trial of this number: 1 to 10 people, 1 to 6 vehicles with protective fields."""
    random = Random(f"fields {number}")
    plan = floorplan.load("warehouse") if random.random() < 0.6 else random_floor(random)
    people = _people(random, plan, random.randint(1, 10))
    machines, fields = {}, {}
    places = [one.at for one in people]
    for _ in range(random.randint(1, 6)):
        kind = random.choice(VEHICLES)
        made = _vehicle(random, plan, kind, places)
        if made is not None:
            name = f"bot{len(machines)}"
            machines[name] = sim.MachineEntry("amr", made)
            fields[name] = sim.MachineFields(
                sets=_sets(*kind),
                response_time=kind[-1],
                restart_delay=random.choice([0.5, 2.0]),
                warning_speed=random.choice([0.2, 0.3, 0.6]),
            )
            places.append(made["at"][:2])
    return sim.Trial(
        plan,
        name=f"fields{number}",
        duration=random.uniform(30.0, 90.0),
        seed=number,
        rules=sim.RULE_SETS["observe"],
        people=people,
        machines=machines,
        fields=fields,
    )


def _people(random, plan, count):
    people = []
    for k in range(count):
        at = standing_place(random, plan)
        apart = 2 * plan.human.radius + 0.05
        while any(math.dist(at, other.at) < apart for other in people):
            at = standing_place(random, plan)
        people.append(
            sim.PersonEntry(
                f"p{k}",
                start=sim.Start(random.choice([0.0, random.uniform(0.0, 10.0)])),
                at=at,
                max_speed=random.choice([None, 0.6, 1.3, 1.6]),
                personality=random.choice(PERSONALITIES),
            )
        )
    return tuple(people)


def _vehicle(random, plan, kind, taken):
    """Return the keys of a vehicle that fits at its start, with destinations that it can reach."""
    size, drive, speed, acceleration, _ = kind
    length, width = size
    keys = {
        "size": size,
        "drive": drive,
        "max_speed": speed,
        "max_acceleration": acceleration,
        "controller": random.choice(["oblivious"] * 4 + ["pausing"]),
        "repeat": True,
    }
    west, south, east, north = plan.boundary.bounds
    away = math.hypot(length, width) / 2 + plan.human.radius + 0.1
    for _ in range(30):
        at = (random.uniform(west, east), random.uniform(south, north))
        pose = (*at, random.uniform(-math.pi, math.pi))
        apart = all(math.dist(at, other) > 2 * away for other in taken)
        lanes = (lane.footprint(lane.locations[lane.start]) for lane in plan.lanes)
        apart = apart and all(lane.distance(Point(at)) > away for lane in lanes)
        if apart and _fits(plan, keys, pose):
            keys["at"] = pose
            missions = [_mission(random, plan) for _ in range(6)]
            keys["missions"] = [one for one in missions if _fits(plan, keys, pose, one)][:3]
            if keys["missions"] and _fits(plan, keys, pose, *keys["missions"]):
                return keys
    return None


def _mission(random, plan):
    if plan.stations and random.random() < 0.6:
        return {"go": random.choice(plan.stations).name}
    west, south, east, north = plan.boundary.bounds
    return {"go": (random.uniform(west, east), random.uniform(south, north))}


def _fits(plan, keys, pose, *missions):
    moving = {**keys, "at": pose, "missions": missions}
    try:
        model = sim.KINDS["amr"].read("bot", moving)
        return not [*model.faults(plan, ()), *model.place_faults("bot", plan)]
    except UserError:
        return False


@cache
def _sets(size, drive, speed, acceleration, response):
    """Return field sets that include the walk of a person until the vehicle has stopped."""
    keys = {"at": (0, 0, 0), "size": size, "drive": drive}
    keys |= {"max_speed": speed, "max_acceleration": acceleration}
    model = sim.KINDS["amr"].read("bot", keys)
    limits, sets = model.limits, []
    axis = AxisLimits(limits.speed, limits.acceleration, limits.jerk)
    turn = stopping_reach(limits.turning, limits.turn_speed, response).time
    steps = [step for step in STEPS if step < speed] + [speed]
    for k, step in enumerate(steps):
        side = FASTEST * max(stopping_reach(axis, step, response).time, turn) + 0.05
        made = needed_fields(
            model.vehicle.footprint,
            limits,
            steps[max(0, k - 1) : k + 1],
            response_time=response,
            supplements=FieldSupplements(side=side),
        )
        sets += [one for one in made.sets if k == 0 or one.linear[0] >= steps[k - 1]]
        sets += [one for one in made.sets if k > 0 and one.linear[1] <= -steps[k - 1]]
    return tuple(sets)


def contacts(run):
    """Yield each contact of a vehicle and a person: its kind, the two names, and its time (s).

    "moving": the vehicle moves or turns as the contact begins, or starts during the contact.
    "braking": a person walks into a vehicle that brakes for its fields. "standing": the vehicle
    stands.
    """
    human = run.trial.floorplan.human
    for entry in run.trial.people:
        person = run.motions[entry.name]
        solid = Cylinder(radius=entry.radius or human.radius, top=human.height)
        for name in run.trial.machines:
            shape, machine = run.scene.machine(name), run.motions[name]
            shapes = Shapes(person=solid, machine=(shape.box,))
            spans = moving_spans(machine, 0.0, run.duration, turning=True)
            for begin, end in violations(person, machine, TOUCH, 0.0, run.duration, shapes=shapes):
                during = [span for span in spans if span[0] < end and begin < span[1]]
                if not during:
                    yield "standing", entry.name, name, begin
                    continue
                walks = person.state(begin).speed > MOVES
                braking = during[0][0] < begin and _stopped(run, name, begin)
                yield "braking" if walks and braking else "moving", entry.name, name, begin


def _stopped(run, machine, t):
    """Return whether the fields have stopped a machine at a time."""
    stopped = False
    for event in run.events:
        if event["t"] > t:
            break
        if event["kind"] in ("field_stop", "field_stop_ended") and event["machine"] == machine:
            stopped = event["kind"] == "field_stop"
    return stopped


def field_faults(run):
    """Yield contacts with moving vehicles, and vehicles that drive despite their fields."""
    for kind, person, machine, t in contacts(run):
        if kind != "standing":
            yield f"{machine} ({kind}) and {person} touch at t = {t:.6f} s"
    for event in run.events:
        if event["kind"] != "field_occupied":
            continue
        name, fields = event["machine"], run.trial.fields[event["machine"]]
        t = event["t"] + fields.response_time + LATER
        if event["field"] == "protective" and t < run.duration and not _stopped(run, name, t):
            yield f"{name} is not stopped at t = {t:.6f} s for {event['person']}"
    for machine, begin, end in _stops(run):
        motion = run.motions[machine]
        model = sim.KINDS["amr"].read(machine, run.trial.machines[machine].keys)
        stands = begin + model.limits.longest_stop.time + LATER
        rest = motion.cut(stands, end).pieces if stands < end else ()
        if any(not piece.stands for piece in rest):
            yield f"{machine} drives in its stop from t = {begin:.6f} s"


def _stops(run):
    """Yield the stops by fields: machine, begin and end (s)."""
    since = {}
    for event in run.events:
        if event["kind"] == "field_stop":
            since[event["machine"]] = event["t"]
        elif event["kind"] == "field_stop_ended":
            yield event["machine"], since.pop(event["machine"]), event["t"] - LATER
    yield from ((machine, begin, run.duration) for machine, begin in since.items())
