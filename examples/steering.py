"""A controller of a vehicle as roboticists write it: a function that returns a twist."""

import math

NEAR = 2.5
"""Metres. The vehicle stops for people who are nearer."""


def circle(vehicle):
    """Drive in a circle, at 0.4 m/s and 0.8 rad/s, while no person is near."""
    near = any(math.dist(person.at, vehicle.position[:2]) < NEAR for person in vehicle.people)
    return (0.0, 0.0) if near else (0.4, 0.8)
