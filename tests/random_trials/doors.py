"""Closed doors: no person enters one, and people who cannot stop in time leave at once."""

import numpy as np
import shapely

from .movement import sampled

STEP = 0.01
"""Time between samples (s)."""

SLACK = 2e-3
"""m. A person no deeper than this in the door is beside it."""

OUT = 5.0
"""Maximum time from standing until a person has left a door that closed on them (s)."""


def door_faults(run):
    """Return people in closed doors, except those who leave as soon as they can."""
    human = run.trial.floorplan.human
    for door in run.trial.floorplan.doors:
        shape, times = door.closed.footprint, run.trial.doors.get(door.name)
        for begin, end in () if times is None else times.closed or ():
            t = np.arange(begin, min(end, run.duration), STEP)
            for entry in run.trial.people if len(t) else ():
                radius = entry.radius or human.radius
                most = entry.max_acceleration or human.max_acceleration
                x, y, vx, vy = sampled(run.motions[entry.name], t)
                depth = radius - shapely.distance(shapely.points(x, y), shape)
                inside = depth > SLACK
                if not inside.any():
                    continue
                speed = float(np.hypot(vx[0], vy[0]))
                where = f"{entry.name}: {door.name}, closed at t = {begin:.3f} s"
                first, last = t[inside][0], t[inside][-1]
                # A person who brakes straight ahead stops at this distance from the place at the
                # closing.
                if depth[0] + speed**2 / (2 * most) < -SLACK:
                    yield f"{where}: is in it at t = {first:.3f} s, and could have stopped"
                elif last > begin + speed / most + OUT:
                    yield f"{where}: is still, or again, in it at t = {last:.3f} s"
