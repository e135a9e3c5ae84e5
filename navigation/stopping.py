"""How long and how far machines go on once they brake."""

from __future__ import annotations

import math
from typing import NamedTuple, TypeAlias

from floorplan import Gantry, Lane

from .machines import GantryLimits, gantry_limits
from .profiles import AxisLimits

Machine: TypeAlias = Gantry | Lane | GantryLimits
"""What moves beside people: a gantry, an AGV on its lane, or the limits of a gantry's axes."""


class Stop(NamedTuple):
    """The end of a motion, from the instant at which braking begins."""

    time: float
    """Seconds to standstill."""
    distance: float
    """Metres from where braking begins to where the machine stands."""


def longest_stop(machine: Machine) -> Stop:
    """Return the longest and the farthest stop that the limits of `machine` leave it.

    A gantry brakes each axis by itself. It stands when the slowest axis does, rotation included,
    and goes farthest if x and y both do. An AGV brakes along its lane, without a limit of jerk.
    `TypeError` for anything else.
    """
    if isinstance(machine, Lane):
        return _of_axis(AxisLimits(machine.max_speed, machine.max_acceleration))
    limits = gantry_limits(machine) if isinstance(machine, Gantry) else machine
    if not (
        isinstance(limits, tuple)
        and len(limits) == 3
        and all(isinstance(axis, AxisLimits) for axis in limits)
    ):
        raise TypeError(f"expected a Gantry, a Lane or GantryLimits, found {machine!r}")
    x, y, rotation = (_of_axis(axis) for axis in limits)
    return Stop(max(x.time, y.time, rotation.time), math.hypot(x.distance, y.distance))


def _of_axis(limits: AxisLimits) -> Stop:
    """Return the longest stop of one axis.

    From speed v, and no acceleration, the jerk-limited profile takes T = v / a + a / j and covers
    v T / 2; where a is never reached, since v j < a², T = 2 √(v / j). Source: L. Biagiotti and
    C. Melchiorri, "Trajectory Planning for Automatic Machines and Robots", 2008, section 3.4.

    The longest stop begins when the axis still accelerates, by a₀, and can just stay within its
    top speed v: it reaches it a₀ / j later and v a₀ / j - a₀³ / (6 j²) farther on.
    """
    v, a, j = limits.max_speed, limits.max_acceleration, limits.max_jerk
    braking = v / a + a / j if v * j >= a * a else 2 * math.sqrt(v / j)
    accelerating = min(a, math.sqrt(2 * j * v))
    easing = accelerating / j
    return Stop(easing + braking, v * (easing + braking / 2) - accelerating * easing**2 / 6)
