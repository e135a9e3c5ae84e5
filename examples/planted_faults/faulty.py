"""Two gantry controllers with a planted fault each. Few random trials show either."""

import math

import sim

SIGHT = 9.4
"""Metres. The short-sighted controller ignores people who are farther away."""

PATIENCE = 50.0
"""Seconds. The impatient controller waits no longer for people."""

CREEP = 0.1
"""Share of its top speed at which the impatient controller moves on."""


class ShortSighted(sim.Caution):
    """Motion that keeps the protective separation distance from people it sees."""

    def look(self):
        """See the people around, but those far away."""
        people = yield from super().look()
        here = self._gantry.position[:2]
        return tuple(one for one in people if math.dist(one.at, here) <= SIGHT)


def short_sighted(gantry):
    """Do one task after the other, as fast as is safe for the people within sight."""
    caution = ShortSighted(gantry)
    while (task := (yield gantry.next_task())) is not None:
        pose = yield gantry.locate(task)
        if (yield from caution.go(pose, seconds=1.0)):
            yield gantry.handle(task)


def impatient(gantry):
    """Do one task after the other, as fast as is safe, and creep on after a long wait."""
    caution = sim.Caution(gantry)
    since = gantry.now
    while (task := (yield gantry.next_task())) is not None:
        pose = yield gantry.locate(task)
        if (yield from caution.go(pose, seconds=1.0)):
            yield gantry.handle(task)
            since = gantry.now
        elif gantry.now - since > PATIENCE:
            yield gantry.move_to(*pose, speed_share=CREEP)
