"""Vehicles without a planner, and a stage that only records, for tests of traffic."""

from types import SimpleNamespace

import numpy as np
import shapely

import navigation
import sim
from sim.core.body import Body
from sim.core.clock import Clock
from sim.machines.traffic.evading import Evading
from sim.machines.traffic.traffic import Traffic

LIMITS = navigation.VehicleLimits(jerk=10.0)


class Cart(Evading):
    """A vehicle of 1 × 0.6 m with given paths and answers."""

    def __init__(self, clock, name, at, priority=0, **shape):
        keys = {"length": 1.0, "width": 0.6, "top": 0.5, "top_speed": 1.5, **shape}
        self.shape = sim.MachineShape(name=name, kind="amr", category="vehicle", **keys)
        self.body = Body(clock, name, "amr", navigation.standing(at[:2], heading=at[2]))
        self.priority = priority
        self.to = None
        self.left = []
        self.evasion = None
        self.can_detour = self.can_make_way = False
        self.asked = []

    @property
    def goal(self):
        return self.to

    @property
    def now(self):
        return self.body.clock.now

    def drive(self, *poses, goal=None):
        """Start to drive along poses, after a stop."""
        self.left, self.to = poses, poses[-1][:2] if goal is None else goal
        self.body.follow(self._path())

    def _path(self):
        stop = self.stopping(self.body.state, self.now)
        path = navigation.vehicle_path(
            stop.state(stop.end).position, self.left, stop.end, limits=LIMITS
        )
        return navigation.join([stop, path])

    def drive_on(self, *poses):
        """Drive along poses from here without a stop."""
        self.left, self.to = poses, poses[-1][:2]
        self.body.follow(
            navigation.vehicle_path(self.body.state, self.left, self.now, limits=LIMITS)
        )

    def hold(self, stands):
        if stands:
            self.body.follow(self.stopping(self.body.state, self.now))
        elif self.left:
            self.body.follow(self._path())

    def stopping(self, state, t):
        return navigation.vehicle_stop(state, t, limits=LIMITS)

    def evade(self, taken, courses):
        self.asked.append(("evade", self.now, taken, courses))
        return self.evasion

    def detour(self, taken, most):
        self.asked.append(("detour", self.now, taken, most))
        return self.can_detour

    def make_way(self, taken, courses):
        self.asked.append(("make_way", self.now, taken, courses))
        return self.can_make_way

    def times(self, what):
        """Return the times of its calls of a kind (s)."""
        return [t for kind, t, *_ in self.asked if kind == what]

    def covered(self, begin, end):
        """Return the area that the cart covers on its motion."""
        states = [self.body.motion.state(float(t)) for t in np.linspace(begin, end, 120)]
        poses = [self.shape.footprint(state.at, state.position[2]) for state in states]
        return shapely.union_all(poses)


class Floor:
    """Carts with a clock, their events and their traffic."""

    def __init__(self):
        self.clock = Clock()
        self.events = []
        self.stage = SimpleNamespace(
            clock=self.clock, record=lambda event: self.events.append((self.clock.now, event))
        )

    def cart(self, name, x, y=0.0, rotation=0.0, **keys):
        return Cart(self.clock, name, (x, y, rotation), **keys)

    def traffic(self, *carts):
        """Start the traffic of carts, and return the claimants by name."""
        self.of = Traffic(self.stage, carts)
        return {one.name: one for one in self.of._claimants}

    def until(self, t):
        self.clock.run(until=t)

    def recorded(self, kind, **fields):
        """Return times and events of a kind."""
        return [
            (t, event)
            for t, event in self.events
            if type(event).__name__ == kind
            and all(getattr(event, key) == value for key, value in fields.items())
        ]


def area_of(claim):
    """Return the union of the polygons of an area."""
    return shapely.union_all(claim.parts)
