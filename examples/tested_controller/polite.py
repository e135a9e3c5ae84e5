"""A custom gantry controller that begins no task while a person is near."""

import math

NEAR = 7.0
"""Metres. Who is nearer than this to the gantry is waited for."""


def polite(gantry):
    """Carry out one task after the other. Begin each only while no person is near."""
    while (task := (yield gantry.next_task())) is not None:
        while any(math.dist(gantry.position[:2], p.at) < NEAR for p in (yield gantry.look())):
            yield gantry.wait(0.5)
        yield gantry.do(task)
