"""Separation laws: the distance that a person and a machine must keep."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import fields
from numbers import Real
from typing import Any, Protocol, TypeAlias, TypeGuard

from floorplan.files.dataclass import dataclass

from .encounter import Shapes
from .kernels.encounter import Encounter
from .kernels.laws import (
    LawEvaluator,
    LinearLaw,
    PathIntegralLaw,
    PythonLaw,
    ScaledLaw,
    evaluator_of,
)
from .kernels.results import Enclosure
from .machines import Machine, longest_stop
from .motion import Motion, Piece

_LONG = 1e4
"""Seconds. More than the horizon of any law."""

WALKING_SPEED = 1.6
"""Approach speed of walking people in ISO 13855:2010, in m/s."""


class Law(Protocol):
    """Interface of laws that depend on two speeds.

    The required distance must not decrease with either speed. The monitor relies on that to
    evaluate whole intervals.
    """

    def distance(self, human_speed: float, robot_speed: float) -> float:
        """Return the required distance.

        Parameters
        ----------
        human_speed, robot_speed : float
            Speeds in m/s.

        Returns
        -------
        float
            Distance in metres.
        """
        ...


class MotionLaw(Protocol):
    """Interface of laws that depend on the motions of both bodies.

    If a law implements both interfaces, the monitor uses this one, with finer tolerance.
    """

    def required(self, encounter: Encounter, begin: float, end: float) -> Enclosure:
        """Return the required distance over an interval.

        Parameters
        ----------
        encounter : Encounter
            Bounds on the two motions.
        begin, end : float
            Interval within the encounter in seconds. If a speed jumps at `end`, the requirement
            after it may be ignored.

        Returns
        -------
        Enclosure
            Distance in metres. It must be exact if `begin` equals `end`.
        """
        ...


AnyLaw: TypeAlias = Law | MotionLaw
"""A law of either kind."""


@dataclass(frozen=True)
class _KernelLaw:
    """Law that the monitor's kernel evaluates. Its values are at least 0."""

    def __post_init__(self) -> None:
        for term in fields(self):
            value = getattr(self, term.name)
            if value is not None or term.default is not None:
                _require_length(term.name, value)

    def required(self, encounter: Encounter, begin: float, end: float) -> Enclosure:
        """See `MotionLaw`."""
        return self.evaluator().required(encounter, begin, end)

    def evaluator(self) -> LawEvaluator:
        """Return the kernel's evaluator. Methods of derived classes are called in Python."""
        kind = type(self)
        base = next(base for base in kind.__mro__ if base in _EVALUATORS)
        own_required = kind.required is not _KernelLaw.required
        if own_required or getattr(kind, "distance", None) is not getattr(base, "distance", None):
            return PythonLaw(self, is_of_speeds(self), own_required)
        return _EVALUATORS[base](self)


@dataclass(frozen=True, kw_only=True)
class SeparationLaw(_KernelLaw):
    """Protective separation distance of speed and separation monitoring, linear form.

    Parameters
    ----------
    t1 : float
        Time in seconds to sense and react.
    t2 : float
        Time in seconds to stop.
    stopping : float, optional
        Distance in metres that the machine covers while it stops.
    intrusion : float, optional
        Intrusion distance in metres.

    Raises
    ------
    ValueError
        If a value is negative or not finite.

    Notes
    -----
    d = k_H (t1 + t2) + k_R t1 + B + δ with k_H and k_R the speeds of human and robot, B the
    `stopping` distance and δ the `intrusion` distance. Source: ISO/TS 15066:2016, clause 5.5.4.
    Linear form: J. A. Marvel and R. Norcross, "Implementing speed and separation monitoring in
    collaborative robot workcells", Robotics and Computer-Integrated Manufacturing 44, 2017.

    Examples
    --------
    >>> from navigation import SeparationLaw
    >>> law = SeparationLaw(t1=1.0, t2=1.5, stopping=0.0, intrusion=1.0)
    >>> law.distance(human_speed=1.0, robot_speed=0.5)
    4.0
    """

    t1: float
    t2: float
    stopping: float = 0.0
    intrusion: float = 0.0

    @classmethod
    def for_machine(cls, machine: Machine, *, t1: float, intrusion: float = 0.0) -> SeparationLaw:
        """Return the law with the longest stop of a machine as `t2` and `stopping`.

        Parameters
        ----------
        machine : Gantry, Lane or tuple of AxisLimits
            Gantry or lane of a floorplan, or limits of a gantry.
        t1 : float
            Time in seconds to sense and react.
        intrusion : float, optional
            Intrusion distance in metres.

        Returns
        -------
        SeparationLaw
            Law that is valid for all states of the machine within its limits.

        Raises
        ------
        TypeError
            If `machine` is none.

        Notes
        -----
        The stop is the maximum of S_S in ISO/TS 15066:2016, clause 5.5.4.2.3. An axis with maximum
        speed v, acceleration a and jerk j stops within v / a + 2 a / j, or v / a without a jerk
        limit. Both axes of a gantry may have maximum speed.
        """
        time, distance = longest_stop(machine)
        return cls(t1=t1, t2=time, stopping=distance, intrusion=intrusion)

    def distance(self, human_speed: float, robot_speed: float) -> float:
        """Return the required distance in metres at these speeds in m/s."""
        return (
            human_speed * (self.t1 + self.t2)
            + robot_speed * self.t1
            + self.stopping
            + self.intrusion
        )


@dataclass(frozen=True, kw_only=True)
class IntegralLaw(_KernelLaw):
    """Protective separation distance of speed and separation monitoring, integral form.

    It uses the future speeds of the known motions. At constant speeds and with `stopping` it equals
    `SeparationLaw`.

    Parameters
    ----------
    t1 : float
        Time in seconds to sense and react.
    t2 : float
        Time in seconds to stop.
    stopping : float, optional
        Distance in metres that the machine covers while it stops. By default its speed at t0 + `t1`
        decreases linearly to 0.
    intrusion : float, optional
        Intrusion distance C in metres.
    human_uncertainty, robot_uncertainty : float, optional
        Position uncertainties Z_D and Z_R in metres.

    Raises
    ------
    ValueError
        If a value is negative or not finite.

    Notes
    -----
    S(t0) = S_H + S_R + S_S + C + Z_D + Z_R as in ISO/TS 15066:2016, clause 5.5.4.2.3:

    - S_H is the path length of the human from t0 to t0 + t1 + t2, as if directed towards the robot,
    - S_R is the path length of the robot from t0 to t0 + t1,
    - S_S is the path length of the robot from t0 + t1 to t0 + t1 + t2, while it stops.

    Discussed in J. A. Marvel and R. Norcross, "Implementing speed and separation monitoring in
    collaborative robot workcells", Robotics and Computer-Integrated Manufacturing 44, 2017.
    """

    t1: float
    t2: float
    stopping: float | None = None
    intrusion: float = 0.0
    human_uncertainty: float = 0.0
    robot_uncertainty: float = 0.0


@dataclass(frozen=True, kw_only=True)
class ApproachLaw(_KernelLaw):
    """Distance to people with unknown speed, independent of both speeds.

    Parameters
    ----------
    time : float
        Time in seconds from sensing a person to the end of the machine's motion.
    intrusion : float, optional
        Intrusion distance in metres.
    speed : float, optional
        Approach speed in m/s.

    Raises
    ------
    ValueError
        If a value is negative or not finite.

    Notes
    -----
    S = K T + C with K the approach speed, T the time and C the intrusion distance: ISO 13855:2010,
    clause 5. ISO/TS 15066:2016, clause 5.5.4.2.3, takes the same speed if the human's is not
    monitored.
    """

    time: float
    intrusion: float = 0.0
    speed: float = WALKING_SPEED

    def distance(self, human_speed: float, robot_speed: float) -> float:
        """Return the required distance in metres at any speeds."""
        return self.speed * self.time + self.intrusion


@dataclass(frozen=True)
class FixedDistance(_KernelLaw):
    """Same distance at any speeds.

    Parameters
    ----------
    metres : float
        Distance in metres.

    Raises
    ------
    ValueError
        If the distance is negative or not finite.
    """

    metres: float

    def distance(self, human_speed: float, robot_speed: float) -> float:
        """Return the required distance in metres at any speeds."""
        return self.metres


@dataclass(frozen=True)
class Scaled(_KernelLaw):
    """Multiple of another law, such as the distance at which people notice a machine.

    Parameters
    ----------
    law : Law or MotionLaw
        Other law.
    factor : float
        Factor.
    cap : float, optional
        Maximum distance of the other law in metres. The result is at most `factor` times `cap`.

    Raises
    ------
    ValueError
        If `factor` or `cap` is negative.
    """

    law: AnyLaw
    factor: float
    cap: float = math.inf

    def __post_init__(self) -> None:
        _require_length("factor", self.factor)
        if not self.cap >= 0:
            raise ValueError(f"cap must be at least 0, not {self.cap}")

    def distance(self, human_speed: float, robot_speed: float) -> float:
        """Return the scaled distance in metres at these speeds in m/s.

        `TypeError` if the other law depends on more than two speeds.
        """
        if not is_of_speeds(self.law):
            raise TypeError(f"{self.law!r} asks for more than two speeds")
        return self.factor * min(self.law.distance(human_speed, robot_speed), self.cap)


def is_of_speeds(law: AnyLaw) -> TypeGuard[Law]:
    """Return whether `law` depends on two speeds alone. Otherwise it is only a `MotionLaw`."""
    if isinstance(law, Scaled):
        return is_of_speeds(law.law)
    return hasattr(law, "distance")


def is_of_motions(law: AnyLaw) -> TypeGuard[MotionLaw]:
    """Return whether `law` evaluates motions."""
    return hasattr(law, "required")


_EVALUATORS: dict[type, Callable[[Any], LawEvaluator]] = {
    SeparationLaw: lambda law: LinearLaw(law.t1 + law.t2, law.t1, law.stopping, law.intrusion),
    IntegralLaw: lambda law: PathIntegralLaw(
        law.t1,
        law.t2,
        -1.0 if law.stopping is None else law.stopping,
        law.intrusion + law.human_uncertainty + law.robot_uncertainty,
    ),
    ApproachLaw: lambda law: LinearLaw(0.0, 0.0, 0.0, law.distance(0.0, 0.0)),
    FixedDistance: lambda law: LinearLaw(0.0, 0.0, 0.0, law.metres),
    Scaled: lambda law: ScaledLaw(evaluator_of(law.law), law.factor, law.cap),
}


def required_at(
    law: AnyLaw, person: Motion, machine: Motion, t: float, shapes: Shapes | None = None
) -> float:
    """Return the distance in metres that `law` requires of two motions at `t` (seconds).

    At a change of speed it is the requirement after it. The encounter for the law has distances
    between centres, or between the surfaces of `shapes`.
    """
    return required_along(law, person, machine, shapes)(t)


def required_along(
    law: AnyLaw, person: Motion, machine: Motion, shapes: Shapes | None = None
) -> Callable[[float], float]:
    """Return `required_at` as a function of t (seconds), for many times."""
    if is_of_speeds(law):
        distance = law.distance
        return lambda t: float(distance(person.state(t).speed, machine.state(t).speed))
    gauges = () if shapes is None else shapes.gauges
    encounter, evaluator = Encounter(person, machine, gauges), evaluator_of(law)

    def required(t: float) -> float:
        encounter.come_to(t)
        encounter.next_stretch(t)
        return evaluator.required(encounter, t, t).value

    return required


def required_at_speeds(law: AnyLaw, human_speed: float, robot_speed: float) -> float:
    """Return the distance in metres that `law` requires at constant speeds (m/s)."""
    if is_of_speeds(law):
        return float(law.distance(human_speed, robot_speed))
    return required_at(law, _steady(human_speed), _steady(robot_speed), 0.0)


def _steady(speed: float) -> Motion:
    """Return a straight motion at `speed` (m/s) long before and after t = 0."""
    nowhere = (0.0, 0.0, 0.0, 0.0)
    return Motion((Piece(-_LONG, _LONG, (0.0, speed, 0.0, 0.0), nowhere, nowhere),))


def _require_length(name: str, length: float) -> None:
    if not (isinstance(length, Real) and math.isfinite(length) and length >= 0):
        raise ValueError(f"{name} must be a number of at least 0, not {length!r}")
