"""What a law requires at an instant, or of steady speeds."""

from __future__ import annotations

from .encounter import encounters
from .motion import Motion, Piece
from .separation import AnyLaw, is_of_speeds, requirement

_LONG = 1e4
"""Seconds. Longer than any law looks ahead or back."""


def required_at(law: AnyLaw, person: Motion, machine: Motion, t: float) -> float:
    """The distance in metres that `law` requires of `person` and `machine` at `t` (seconds).

    Where a speed changes at once, it is what is required from then on.
    """
    if is_of_speeds(law):
        return float(law.distance(person.state(t).speed, machine.state(t).speed))
    return float(requirement(law, next(encounters(person, machine, t, t)), t, t).value)


def required_at_speeds(law: AnyLaw, human_speed: float, robot_speed: float) -> float:
    """The distance in metres that `law` requires of two who go on at these speeds.

    `human_speed` and `robot_speed` are in m/s.
    """
    if is_of_speeds(law):
        return float(law.distance(human_speed, robot_speed))
    return required_at(law, _steady(human_speed), _steady(robot_speed), 0.0)


def _steady(speed: float) -> Motion:
    """Going straight on at `speed` (m/s) for long before t = 0 and after."""
    nowhere = (0.0, 0.0, 0.0, 0.0)
    return Motion((Piece(-_LONG, _LONG, (0.0, speed, 0.0, 0.0), nowhere, nowhere),))
