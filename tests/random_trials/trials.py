"""Random trials: people, machines and rules on a random floor."""

import importlib.util
import math
import sys
from dataclasses import replace
from functools import cache
from pathlib import Path
from random import Random

import shapely

import bdi
import navigation
import sim

from .floors import DoorTimes, divided_floor, random_floor, standing_place, starting_fault

PERSONALITIES = [name for name in bdi.programs() if name not in ("visitor", "worker")]
CONTROLLERS = ("parked", "oblivious", "pausing", "avoiding")

LAWS = (
    navigation.FixedDistance(0.5),
    navigation.FixedDistance(2.1),
    navigation.SeparationLaw(t1=0.2, t2=0.3, stopping=0.2, intrusion=0.5),
    navigation.IntegralLaw(t1=0.5, t2=0.5, intrusion=0.8),
    navigation.ApproachLaw(time=1.0, intrusion=0.5),
)
"""Laws in addition to those of the rule sets."""


def random_trial(number):
    """Return the trial of this number, independent of the trials before it."""
    random = Random(number)
    plan = random_floor(random)
    lanes = {lane.name: lane for lane in plan.lanes}
    duration = random.uniform(15.0, 75.0)
    return sim.Trial(
        plan,
        name=f"random{number}",
        duration=duration,
        seed=number,
        rules=_rules(random, number),
        people=_apart([_person(random, plan, k) for k in range(random.randint(1, 5))], plan),
        gantry=sim.GantryEntry() if plan.gantry is None else _gantry(random, plan),
        agvs={name: _moves(random, lane, duration) for name, lane in lanes.items()},
        yielding=frozenset(name for name in lanes if random.random() < 0.3),
    )


def random_trial_with_doors(number):
    """Return the trial of this number in the second family: vehicles and doors that close at
    random.

    Half of these trials have one person alone.
    """
    random = Random(f"doors {number}")
    plan = divided_floor(random)
    lanes = {lane.name: lane for lane in plan.lanes}
    duration = random.uniform(20.0, 60.0)
    machines = {
        f"bot{k}": bot
        for k in range(random.choice([0, 1, 1, 2]))
        if (bot := _vehicle(random, plan, duration)) is not None
    }
    count = random.choice([1, 1, 1, 2, 4, 8])
    people = [_visitor(random, plan, machines, k) for k in range(count)]
    return sim.Trial(
        plan,
        name=f"doors{number}",
        duration=duration,
        seed=number,
        rules=random.choice([sim.RULE_SETS["observe"], *sim.RULE_SETS.values()]),
        people=_apart(people, plan),
        gantry=sim.GantryEntry() if plan.gantry is None else _gantry(random, plan),
        agvs={name: _moves(random, lane, duration) for name, lane in lanes.items()},
        yielding=frozenset(name for name in lanes if random.random() < 0.3),
        machines=machines,
        doors={
            door.name: DoorTimes(closed=tuple(_intervals(random, duration))) for door in plan.doors
        },
    )


def _intervals(random, duration):
    """Yield intervals in order, in which most doors close while a person walks through."""
    t = random.choice([0.0, random.uniform(1.0, 15.0)])
    while t < duration:
        end = t + random.choice([0.5, 3.0, random.uniform(1.0, 30.0)])
        yield (t, end)
        t = end + random.uniform(1.0, 15.0)


def _visitor(random, plan, machines, k):
    """Return a person who patrols or wanders, and starts away from vehicles of other kinds."""
    parked = [at for machine in machines.values() for at in _course(machine)]
    at = standing_place(random, plan)
    doors = shapely.union_all([door.footprint for door in plan.doors])
    while at is not None and (
        any(math.dist(at, place) < 2.5 for place in parked[:1])
        or doors.distance(shapely.Point(at)) < 0.6
    ):
        at = standing_place(random, plan)
    home = None
    if _crowded(plan, plan.safe_zone.position, None):
        home = at
    return sim.PersonEntry(
        f"p{k}",
        start=_start(random),
        at=at,
        home=home,
        beliefs=("reversed",) if random.random() < 0.5 else (),
        max_speed=random.choice([None, None, 0.6, 1.5, 2.0]),
        max_acceleration=random.choice([None, None, 0.8, 2.5]),
        personality=random.choice(["indifferent", "helpful", _personality(random, plan)]),
    )


def _course(machine):
    """Return the course of a vehicle: its start and its turning points."""
    keys = machine.keys
    return keys["course"] if "course" in keys else [keys["origin"]]


def _vehicle(random, plan, duration):
    """Return a vehicle that the floor does not have (an AGV head-on or a tugger), or None."""
    solid = shapely.union_all(
        [
            plan.boundary.exterior,
            *(one.footprint for one in plan.obstacles),
            *(door.footprint for door in plan.doors),
            *(lane.footprint(q) for lane in plan.lanes for q in lane.limits),
        ]
    )
    west, south, east, north = plan.boundary.bounds
    for _ in range(20):
        x, y = random.uniform(west, east), random.uniform(south, north)
        if random.random() < 0.5:
            heading, length = random.choice([0.0, math.pi / 2, math.pi]), random.uniform(3, 10)
            end = (x + length * math.cos(heading), y + length * math.sin(heading))
            line = shapely.LineString([(x, y), end])
            if not plan.boundary.contains(line) or line.distance(solid) < 1.3:
                continue
            times = sorted(random.uniform(0.0, duration) for _ in range(random.randint(1, 4)))
            moves = [{"time": t, "to": length * ((k + 1) % 2)} for k, t in enumerate(times)]
            keys = {
                "origin": (x, y),
                "heading": heading,
                "limits": (0.0, length),
                "size": (random.uniform(0.8, 1.6), random.uniform(0.5, 0.9)),
                "max_speed": random.uniform(0.5, 2.0),
                "max_acceleration": random.uniform(0.4, 2.0),
                "moves": moves,
                "yield": random.random() < 0.2,
            }
            return sim.MachineEntry("agv", keys)
        across, along = random.uniform(2, 5), random.uniform(2, 5)
        corners = [(x, y), (x + across, y), (x + across, y + along), (x, y + along)]
        ring = shapely.LinearRing(corners)
        if not plan.boundary.contains(ring) or ring.distance(solid) < 1.4:
            continue
        keys = {
            "course": tuple(corners),
            "speed": random.uniform(0.5, 1.5),
            "stop": random.uniform(1.0, 10.0),
        }
        return sim.MachineEntry(_tugger(), keys)
    return None


@cache
def _tugger():
    """Return the machine of the examples that the library does not know."""
    file = Path(__file__).parents[2] / "examples" / "tugger.py"
    spec = importlib.util.spec_from_file_location("tugger", file)
    module = sys.modules["tugger"] = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module.Tugger


def _rules(random, number):
    """Return a built-in rule set by turns, sometimes with another law."""
    rules = [*sim.RULE_SETS.values()][number % len(sim.RULE_SETS)]
    if random.random() < 0.2:
        rules = replace(rules, agv_law=random.choice(LAWS))
    if random.random() < 0.2:
        rules = replace(rules, gantry_law=random.choice(LAWS))
    return rules


def _apart(people, plan):
    """Move people whose start overlaps another person to their homes, or anywhere if these are
    taken.
    """
    placed = []
    for person in people:
        for other in placed:
            radii = [entry.radius or plan.human.radius for entry in (person, other)]
            places = [entry.place_on(plan) for entry in (person, other)]
            if all(places) and math.dist(*places) < sum(radii):
                person = replace(person, at=None)
        if person.at is None and any(other.at is None for other in placed):
            person = replace(person, at="anywhere")
        placed.append(person)
    return tuple(placed)


def _person(random, plan, k):
    radius = random.choice([None, None, None, 0.2, 0.35, 0.5])
    zone = plan.safe_zone
    home = None
    if _crowded(plan, zone.position, radius) or random.random() < 0.15:
        home = standing_place(random, plan, radius)
    if home is None and _crowded(plan, zone.position, radius):
        radius = None
    return sim.PersonEntry(
        f"p{k}",
        start=_start(random),
        at=None if random.random() < 0.3 else _start_place(random, plan, radius),
        home=home,
        beliefs=("reversed",) if random.random() < 0.3 else (),
        radius=radius,
        max_speed=random.choice([None, 0.4, 1.5, 2.5]),
        max_acceleration=random.choice([None, 0.5, 1.0, 4.0]),
        changes=tuple(_changes(random)),
        personality=_personality(random, plan),
    )


def _crowded(plan, at, radius):
    return bool(starting_fault(plan, at, radius))


def _start_place(random, plan, radius):
    """Return a starting place, often right beside an AGV, or between an AGV and a wall."""
    if plan.lanes and random.random() < 0.5:
        lane = random.choice(plan.lanes)
        q = random.choice([lane.locations[lane.start], random.uniform(*lane.limits)])
        return standing_place(random, plan, radius, lane.footprint(q).buffer(0.4))
    return standing_place(random, plan, radius)


def _personality(random, plan):
    name = random.choice([*PERSONALITIES, "wanderer", "wanderer"])
    if name != "wanderer":
        return name
    return bdi.parse(_wanderer(random, plan))


def _wanderer(random, plan):
    """Return a program of errands to random places at random times, with all other actions."""
    west, south, east, north = plan.boundary.bounds

    def step():
        kind = random.random()
        if kind < 0.6:
            return f"!to({random.uniform(west, east):.3f}, {random.uniform(south, north):.3f})"
        return random.choice(
            [
                "!try_stop",
                f"walk_speed({random.uniform(0.1, 1.0):.2f})",
                f"!back({random.uniform(0.1, 3.0):.2f})",
                "!face",
                "!between",
                "!near",
                "teleport_safe" if random.random() < 0.2 else "!face",
            ]
        )

    steps = "; ".join(
        f".wait({random.choice([0, 50, 300, 1000, 4000]) + random.randint(0, 999)}); {step()}"
        for _ in range(random.randint(3, 20))
    )
    return f"""
!go.
+!go <- {steps}.
+!to(X, Y) <- move(X, Y, 0).
-!to(_, _).
+!try_stop <- stop_movement.
+!back(D) <- move_away(D).
-!back(_).
+!face <- face_gantry.
-!face.
+!between <- step_between.
-!between.
+!near <- move_to_gantry.
-!near.
"""


def _start(random):
    return sim.Start(random.choice([0.0, 0.0, 1.0, random.uniform(0.0, 20.0)]))


def _changes(random):
    for _ in range(random.choice([0, 0, 0, 1, 2])):
        when = sim.Start(random.uniform(0.0, 60.0))
        if random.random() < 0.3:
            when = sim.Start(event="violation")
        yield sim.PersonalityChange(when, random.choice(PERSONALITIES))


def _gantry(random, plan):
    gantry = plan.gantry
    bounds = [(axis.low, axis.high) for axis in gantry.axes]

    def pose():
        return tuple(random.uniform(*bound) for bound in bounds)

    def job():
        if random.random() < 0.2:
            return sim.Job("wait", seconds=random.uniform(0.1, 8.0))
        if places and random.random() < 0.4:
            return sim.Job("pick_place", pick=random.choice(places), place=random.choice(places))
        return sim.Job("move", target=pose())

    places = [
        name
        for name, (x, y) in {
            **{o.name: o.footprint.centroid.coords[0] for o in plan.obstacles},
            **{s.name: s.position for s in plan.stations},
        }.items()
        if not gantry.faults((x, y, 0.0))
    ]
    places += [lane.name for lane in plan.lanes if _within_reach(lane, gantry)]
    return sim.GantryEntry(
        random.choice(CONTROLLERS),
        at=None if random.random() < 0.5 else pose(),
        jobs=tuple(job() for _ in range(random.randint(0, 4))),
        repeat=random.random() < 0.5,
    )


def _within_reach(lane, gantry):
    return any(not gantry.faults((*lane.position(q), 0.0)) for q in lane.locations.values())


def _moves(random, lane, duration):
    times = sorted(random.uniform(0.0, duration) for _ in range(random.randint(0, 5)))
    return tuple(
        sim.AgvMove(time, random.choice([*lane.locations, random.uniform(*lane.limits)]))
        for time in times
    )
