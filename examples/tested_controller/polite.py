"""A gantry controller of one's own: begins nothing while somebody is near."""

import math

NEAR = 7.0
"""Metres. Who is nearer than this to the gantry is waited for."""


def polite(gantry):
    """One task after the other, each begun only while nobody is near."""
    while (task := (yield gantry.next_task())) is not None:
        while any(math.dist(gantry.position[:2], p.at) < NEAR for p in (yield gantry.look())):
            yield gantry.wait(0.5)
        yield gantry.do(task)
