"""Random trials with recorded people, any law, and a vehicle that stops at once.

Motions of people and AGVs end at rest. Tracks end where the recording stopped, and a custom machine
may behave in any way.
"""

import math
from dataclasses import dataclass, replace
from random import Random

import numpy as np

import navigation
import sim

from .trials import random_trial


class OfSpeeds:
    """A custom law of two speeds."""

    def distance(self, human_speed, robot_speed):
        """Return the required distance (m)."""
        return 0.4 + 1.5 * human_speed + robot_speed**2


class OfMotions:
    """Custom law of motions: the walk of the person within 0.8 s, plus a length."""

    def required(self, encounter, begin, end):
        """Return the required distance (m) from `begin` to `end` (s)."""
        return encounter.human.ahead(begin, end, 0.8) + 0.6


LINEAR = navigation.SeparationLaw(t1=1.0, t2=1.5, intrusion=1.0)
INTEGRAL = navigation.IntegralLaw(t1=0.5, t2=1.0, intrusion=0.8)

LAWS = (
    LINEAR,
    navigation.SeparationLaw(t1=0.1, t2=0.4, stopping=0.3),
    INTEGRAL,
    navigation.IntegralLaw(t1=0.3, t2=0.6, stopping=0.4, intrusion=1.2, robot_uncertainty=0.1),
    navigation.ApproachLaw(time=1.0, intrusion=0.5),
    navigation.FixedDistance(1.5),
    navigation.Scaled(LINEAR, 1.5, cap=3.0),
    navigation.Scaled(INTEGRAL, 0.7),
    OfSpeeds(),
    OfMotions(),
)
"""All kinds of laws that a trial can have."""


@dataclass(frozen=True)
class Cart(sim.MachineModel):
    """A vehicle on a straight course (metres), which stops at each end at once."""

    course: tuple[tuple[float, float], tuple[float, float]]
    speed: float
    pause: float

    def shape(self, name, plan):
        """See `MachineModel`."""
        return sim.MachineShape(
            name=name,
            kind="cart",
            category="vehicle",
            length=0.8,
            width=0.6,
            top=1.0,
            top_speed=self.speed,
            course=self.course,
        )

    def make(self, name, stage):
        """See `MachineModel`."""
        return MovingCart(self, name, stage)


class MovingCart(sim.Machine):
    """A cart under way."""

    def __init__(self, model, name, stage):
        self.shape = model.shape(name, stage.floorplan)
        at = navigation.standing(model.course[0], start=stage.clock.now)
        self.body = sim.Body(stage.clock, name, "cart", at)
        self._model, self._stage = model, stage
        self._ends = model.course
        self._next = sim.Alarm(stage.clock, self._drive, sim.Turn.MOTION_ENDS)

    def begin(self):
        """Drive at once."""
        self._drive()

    def hold(self, stands):
        """Stop at once, or start again."""
        now = self._stage.clock.now
        self.body.follow(navigation.standing(self.body.at, start=now))
        self._next.set(None if stands else now + self._model.pause)

    def _drive(self):
        now, (x, y) = self._stage.clock.now, self.body.at
        begin, end = self._ends = self._ends[::-1]
        end = begin if math.dist((x, y), begin) > 1e-9 else end
        seconds = math.dist((x, y), end) / self._model.speed
        rates = ((end[0] - x) / seconds, (end[1] - y) / seconds)
        cubics = ((x, rates[0], 0.0, 0.0), (y, rates[1], 0.0, 0.0), (0.0, 0.0, 0.0, 0.0))
        self.body.follow(navigation.Motion((navigation.Piece(now, now + seconds, *cubics),)))
        self._next.set(now + seconds + self._model.pause)


def tracked_trial(number):
    """Return the random trial of this number with recorded people and another law."""
    random = Random(f"track {number}")
    trial = random_trial(number)
    law, of_cart = (random.choice(LAWS) for _ in range(2))
    rules = replace(
        [*sim.RULE_SETS.values()][random.randrange(len(sim.RULE_SETS))],
        name="random",
        gantry_law=LAWS[number % len(LAWS)],
        agv_law=law,
        laws={"cart": of_cart},
    )
    tracked = tuple(_tracked(random, trial, k) for k in range(random.randint(1, 2)))
    west, south, east, north = trial.floorplan.boundary.bounds
    ends = tuple((random.uniform(west, east), random.uniform(south, north)) for _ in range(2))
    keys = {"course": ends, "speed": random.uniform(0.3, 1.5), "pause": random.uniform(0.0, 8.0)}
    return replace(
        trial,
        name=f"tracked{number}",
        rules=rules,
        people=(*trial.people[: random.randint(0, 2)], *tracked),
        machines={"cart": sim.MachineEntry(Cart, keys)} if random.random() < 0.5 else {},
    )


def _tracked(random, trial, k):
    """Return a person whose track ends in motion, often before the trial does."""
    bounds = np.array(trial.floorplan.boundary.bounds).reshape(2, 2)
    count = random.randint(3, 40)
    steps = np.array([random.uniform(0.2, 0.6) for _ in range(count)])
    angle, speed = random.uniform(-math.pi, math.pi), random.uniform(0.3, 1.8)
    at, places = np.array([random.uniform(*axis) for axis in bounds.T.tolist()]), []
    for step in steps.tolist():
        places.append(at)
        angle += random.gauss(0.0, 0.4)
        at = np.clip(
            at + speed * step * np.array([math.cos(angle), math.sin(angle)]), *(bounds + 1e-6)
        )
    t = np.concatenate([[0.0], np.cumsum(steps[1:])])
    # A monotone cubic joins the samples of a tracker and comes to rest where it turns. One more
    # piece at constant speed ends in motion.
    motion = navigation.Motion.from_samples(t, np.array(places))
    (x, y), end = places[-1].tolist(), float(t[-1])
    last = random.uniform(0.3, 2.0)
    rates = (speed * math.cos(angle), speed * math.sin(angle))
    cubics = ((x, rates[0], 0.0, 0.0), (y, rates[1], 0.0, 0.0), (0.0, 0.0, 0.0, 0.0))
    piece = navigation.Piece(end, end + last, *cubics)
    return sim.PersonEntry(
        f"track{k}",
        recorded=navigation.Motion((*motion.pieces, piece)),
        start=sim.Start(random.choice([0.0, random.uniform(0.0, 10.0)])),
    )
