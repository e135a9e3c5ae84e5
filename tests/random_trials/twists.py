"""Functions and a generator that drive vehicles of random trials by twists."""

import math


def ahead(vehicle):
    """Always drive ahead, also after each stop."""
    return (0.7, 0.0)


def circling(vehicle):
    return (0.5, 0.4)


def weaving(vehicle):
    return (0.6, 0.7 * math.sin(vehicle.now))


def spinning(vehicle):
    return (0.0, 0.8 if vehicle.now % 10.0 < 6.0 else -0.5)


def hesitant(vehicle):
    """Drive ahead, sometimes backwards, and sometimes stand."""
    return ((0.6, 0.0), None, (-0.3, 0.2), (0.0, 0.0))[int(vehicle.now / 1.7) % 4]


def shy(vehicle):
    """Drive ahead, but away from people who are near."""
    x, y, _ = vehicle.position
    near = any(math.dist(one.at, (x, y)) < 2.5 for one in vehicle.people)
    return (-0.3, 0.4) if near else (0.6, 0.15)


def by_hand(vehicle):
    """Drive by twists, stops and waits by turns."""
    while True:
        if not vehicle.disabled:
            yield vehicle.twist((0.5, 0.3), 2.0)
            yield vehicle.stop()
        yield vehicle.wait(0.5)
        if not vehicle.disabled:
            yield vehicle.twist((-0.2, 0.0), 1.0)
        yield vehicle.wait(0.2)
