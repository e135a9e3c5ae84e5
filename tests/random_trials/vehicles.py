"""Random trials of vehicles: odd footprints, both drives, all controllers, fields, zones, doors."""

import math
from dataclasses import replace
from functools import cache
from pathlib import Path
from random import Random

import shapely
from shapely.geometry import Point

import floorplan
import sim
from floorplan import UserError
from navigation import FieldSupplements, needed_fields

from .floors import DoorTimes, divided_floor, random_floor, standing_place
from .trials import PERSONALITIES

FOOTPRINTS = (
    (),
    (),
    ((0.9, 0.1), (0.4, 0.45), (-0.6, 0.45), (-0.6, -0.45), (0.4, -0.45)),  # a wedge
    (
        *((0.7, -0.4), (0.7, 0.4), (0.4, 0.4), (0.4, 0.15)),
        *((-0.6, 0.15), (-0.6, -0.15), (0.4, -0.15), (0.4, -0.4)),
    ),  # a T
    ((0.9, -0.3), (0.9, 0.0), (0.3, 0.0), (0.3, 0.6), (-0.3, 0.6), (-0.3, -0.3)),  # an L
    ((1.4, -0.3), (1.4, 0.3), (-0.4, 0.3), (-0.4, -0.3)),  # long before its axis
    ((0.6, 0.0), (0.3, 0.5), (-0.3, 0.5), (-0.6, 0.0), (-0.3, -0.5), (0.3, -0.5)),
    ((0.8, 0.0), (-0.4, 0.6), (-0.4, -0.6)),
)
"""Corners of footprints in metres. An empty one is a rectangle of some size."""

LIMITS = (
    {"max_speed": 0.6, "max_acceleration": 0.5},
    {"max_speed": 1.0, "max_acceleration": 1.2, "max_jerk": 8.0},
    {"max_speed": 1.5},
    {"max_speed": 1.2, "max_acceleration": 1.0, "max_jerk": 1.5, "max_turn_speed": 0.6},
    {"max_speed": 0.8, "max_turn_acceleration": 0.8, "max_turn_jerk": 3.0},
)


TWISTS = ("ahead", "circling", "weaving", "spinning", "hesitant", "shy")
"""Functions of `twists.py`."""

ROUTED = ("oblivious", "oblivious", "oblivious", "pausing", "avoiding")


def random_trial_of_vehicles(number):
    """Return the trial of this number: 1 to 5 vehicles among 0 to 6 people on a random floor."""
    random = Random(f"vehicles {number}")
    duration = random.uniform(25.0, 70.0)
    plan = _floor(random)
    machines, fields, places = {}, {}, []
    for k in range(random.randint(1, 5)):
        name = f"bot{k}"
        keys = _vehicle(random, plan, places)
        if keys is None:
            continue
        machines[name] = sim.MachineEntry("amr", keys)
        places.append(keys["at"][:2])
        if random.random() < 0.4:
            fields[name] = _fields(random, plan, keys, duration)
    people = _people(random, plan, random.randint(0, 6), places)
    return sim.Trial(
        plan,
        name=f"vehicles{number}",
        folder=Path(__file__).parent,
        duration=duration,
        seed=number,
        rules=random.choice([sim.RULE_SETS["observe"], *sim.RULE_SETS.values()]),
        people=people,
        machines=machines,
        fields=fields,
        commands=tuple(sorted(_commands(random, [*machines], duration), key=lambda one: one.time)),
        blackouts=_blackouts(random, [*machines], duration),
        doors={
            door.name: DoorTimes(closed=((t := min(random.uniform(0.0, 30.0), 24.0), t + 10.0),))
            for door in plan.doors
        },
    )


def _floor(random):
    kind = random.random()
    if kind < 0.35:
        plan = floorplan.load("warehouse")
    elif kind < 0.7:
        plan = divided_floor(random)
        if len(plan.doors) == 2 and random.random() < 0.7:
            door, other = plan.doors
            (ax, ay), (_, by) = door.ends
            side = random.choice([-1.0, 1.0])
            gate = floorplan.Gate(name="gate", ends=door.ends, towards=(ax + side, (ay + by) / 2))
            plan = replace(plan, doors=(other,), gates=(gate,))
    else:
        plan = random_floor(random)
    west, south, east, north = plan.boundary.bounds
    zones = []
    for k, kind in enumerate(random.sample(["slow", "slow", "mute"], random.randint(0, 3))):
        x, y = random.uniform(west, east - 2), random.uniform(south, north - 2)
        area = shapely.box(x, y, x + random.uniform(1, 5), y + random.uniform(1, 5))
        most = 9.0 if kind == "mute" else random.choice([0.2, 0.4, 0.8])
        zones.append(
            floorplan.Zone(name=f"{kind}{k}", area=area.intersection(plan.boundary), max_speed=most)
        )
    zones = [one for one in zones if one.area.geom_type == "Polygon" and one.area.area > 0.5]
    return replace(plan, zones=tuple(zones))


def _vehicle(random, plan, taken):
    """Return the keys of a vehicle that fits at its start, with destinations that it can reach."""
    footprint = random.choice(FOOTPRINTS)
    keys = {**random.choice(LIMITS), "drive": random.choice(["differential", "holonomic"])}
    if footprint:
        keys["footprint"] = footprint
    else:
        keys["size"] = random.choice([(0.6, 0.5), (1.2, 0.8), (1.6, 0.7), (2.4, 0.8)])
    if random.random() < 0.2:
        keys["load"] = (random.uniform(0.4, 1.0), random.uniform(0.4, 1.0), 0.5)
    if keys["drive"] == "holonomic" and random.random() < 0.5:
        keys["max_side_speed"] = random.uniform(0.2, 0.9)
    if random.random() < 0.3:
        keys["priority"] = random.randint(-1, 2)
    reach = 1.5
    west, south, east, north = plan.boundary.bounds
    for _ in range(30):
        at = (random.uniform(west, east), random.uniform(south, north))
        if any(math.dist(at, other) < 2 * reach for other in taken):
            continue
        if any(
            lane.footprint(lane.locations[lane.start]).distance(Point(at)) < reach
            for lane in plan.lanes
        ) or any(door.footprint.distance(Point(at)) < reach for door in plan.doors):
            continue
        keys["at"] = (*at, random.uniform(-math.pi, math.pi))
        if not _fits(plan, keys):
            continue
        kind = random.random()
        if kind < 0.25:
            twist = random.choice(TWISTS)
            slowest = {"max_turn_speed": max(1.0, keys.get("max_turn_speed", 1.0))}
            keys |= {"max_speed": max(0.8, keys["max_speed"]), **slowest}
            return keys | {
                "controller": f"twists:{twist}",
                "rate": random.choice([2.0, 5.0, 10.0]),
            }
        if kind < 0.3:
            keys |= {"max_speed": max(0.8, keys["max_speed"])}
            return keys | {"controller": "twists:by_hand"}
        if kind < 0.35:
            return keys | {"controller": "parked"}
        keys["controller"] = random.choice(ROUTED)
        missions = [_mission(random, plan) for _ in range(5)]
        keys["missions"] = [one for one in missions if _fits(plan, keys, one)][:3]
        if keys["missions"] and _fits(plan, keys, *keys["missions"]):
            return keys | {"repeat": random.random() < 0.7}
        del keys["missions"]
    return None


def _mission(random, plan):
    kind = random.random()
    if plan.stations and kind < 0.4:
        return {"go": random.choice(plan.stations).name}
    if kind < 0.5:
        return {"wait": random.uniform(0.5, 5.0)}
    if kind < 0.6:
        return {"turn": random.uniform(-3.0, 3.0)}
    west, south, east, north = plan.boundary.bounds
    at = (random.uniform(west, east), random.uniform(south, north))
    return {"go": at if random.random() < 0.7 else (*at, random.uniform(-3.0, 3.0))}


def _model(keys, *missions):
    return sim.KINDS["amr"].read("bot", {**keys, "missions": missions})


def _fits(plan, keys, *missions):
    try:
        model = _model(keys, *missions)
        return not [*model.faults(plan, ()), *model.place_faults("bot", plan)]
    except UserError:
        return False


def _people(random, plan, count, machines):
    people = []
    for k in range(count):
        at = standing_place(random, plan)
        if at is None or any(math.dist(at, other.at) < 0.8 for other in people):
            continue
        if any(math.dist(at, other) < 2.2 for other in machines):
            continue
        people.append(
            sim.PersonEntry(
                f"p{k}",
                start=sim.Start(random.choice([0.0, random.uniform(0.0, 10.0)])),
                at=at,
                home=at,
                max_speed=random.choice([None, 0.6, 1.3, 1.6]),
                personality=random.choice(PERSONALITIES),
            )
        )
    return tuple(people)


def _fields(random, plan, keys, duration):
    response = random.choice([0.0, 0.1, 0.3])
    zones = tuple(zone.name for zone in plan.zones if zone.name.startswith("mute"))
    times = ((t := random.uniform(0.0, duration), t + 5.0),) if random.random() < 0.2 else ()
    field_keys = {**keys}
    for key in ("controller", "rate", "missions", "at", "repeat", "priority"):
        field_keys.pop(key, None)
    return sim.MachineFields(
        sets=_sets(tuple(sorted(field_keys.items())), response),
        response_time=response,
        restart_delay=random.choice([0.01, 0.5, 2.0]),
        warning_speed=random.choice([0.2, 0.4]),
        muting=sim.Muting(zones, times=times),
    )


@cache
def _sets(keys, response):
    model = _model({**dict(keys), "at": (0, 0, 0)})
    speeds = [one for one in (0.3, 0.7) if one < model.limits.top_speed]
    return needed_fields(
        model.vehicle.footprint,
        model.limits,
        [*speeds, model.limits.top_speed],
        response_time=response,
        supplements=FieldSupplements(side=0.3),
    ).sets


def _commands(random, names, duration):
    for name in names:
        if random.random() < 0.15:
            t = random.uniform(1.0, duration)
            seconds = random.choice([0.0, 0.3, 4.0])
            yield sim.Command(t, hold=name)
            yield sim.Command(t + seconds, release=name)


def _blackouts(random, names, duration):
    return tuple(
        sim.Blackout(name, sim.Start(random.uniform(1.0, duration)), random.uniform(0.2, 4.0))
        for name in names
        if random.random() < 0.1
    )
