"""Random trials: people, machines and rules on a random floor."""

import math
from dataclasses import replace
from random import Random

import bdi
import navigation
import sim
from floorplan import starting_fault

from .floors import random_floor, standing_place

PERSONALITIES = [name for name in bdi.programs() if name not in ("visitor", "worker")]
CONTROLLERS = ("parked", "oblivious", "pausing", "avoiding")

LAWS = (
    navigation.FixedDistance(0.5),
    navigation.FixedDistance(2.1),
    navigation.SeparationLaw(t1=0.2, t2=0.3, stopping=0.2, intrusion=0.5),
    navigation.IntegralLaw(t1=0.5, t2=0.5, intrusion=0.8),
    navigation.ApproachLaw(time=1.0, intrusion=0.5),
)
"""Laws besides those of the rule sets."""


def random_trial(number):
    """The trial of this number: always the same, whatever was tried before it."""
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


def _rules(random, number):
    """Each built-in rule set in turn; some with another law."""
    rules = [*sim.RULE_SETS.values()][number % len(sim.RULE_SETS)]
    if random.random() < 0.2:
        rules = replace(rules, agv_law=random.choice(LAWS))
    if random.random() < 0.2:
        rules = replace(rules, gantry_law=random.choice(LAWS))
    return rules


def _apart(people, plan):
    """Let those start at home who would start on somebody else; anywhere, if others do so."""
    found = []
    for person in people:
        for other in found:
            radii = [entry.radius or plan.human.radius for entry in (person, other)]
            places = [entry.place_on(plan) for entry in (person, other)]
            if all(places) and math.dist(*places) < sum(radii):
                person = replace(person, at=None)
        if person.at is None and any(other.at is None for other in found):
            person = replace(person, at="anywhere")
        found.append(person)
    return tuple(found)


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
    """Often right beside an AGV, or between one and a wall."""
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
    """A program of errands to random places, at random instants, with whatever else one can do."""
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
