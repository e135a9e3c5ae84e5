"""Separation laws: the distance that a person and a machine must keep."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, fields
from numbers import Real
from typing import Any, Protocol, TypeAlias, TypeGuard

from .encounter import Enclosure, Encounter
from .kernels.laws import LawEvaluator, LinearLaw, PathIntegralLaw, PythonLaw, ScaledLaw
from .machines import Machine, longest_stop
from .motion import Motion, Piece

_LONG = 1e4
"""Seconds. Longer than any law looks ahead or back."""

WALKING_SPEED = 1.6
"""m/s. ISO 13855:2010's approach speed of people who walk."""


_TRIED = ((0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (2.0, 1.0))
"""Speeds of human and robot in m/s, each pair as fast as the one before or faster."""


class Law(Protocol):
    """Any rule for the distance that must be kept at these speeds.

    `distance` must not shrink when either speed grows: the monitor relies on it to judge whole
    intervals of time at once.
    """

    def distance(self, human_speed: float, robot_speed: float) -> float:
        """Return the required distance in metres for these speeds in m/s."""
        ...


class MotionLaw(Protocol):
    """A rule on the motions of the two, not only on their speeds at an instant.

    A `Law` that is also one of these is judged more finely (see `minimum_margin`).
    """

    def required(self, encounter: Encounter, begin: float, end: float) -> Enclosure:
        """Return the distance in metres that is required from `begin` to `end` (seconds).

        The interval lies within `encounter`; at an instant the value is exact. Where a speed
        jumps at `end`, what is required from then on may be left out.
        """
        ...


AnyLaw: TypeAlias = Law | MotionLaw
"""A law of either kind."""


@dataclass(frozen=True)
class _KernelLaw:
    """A law that the monitor's kernel computes. Its terms are figures of at least 0."""

    def __post_init__(self) -> None:
        for term in fields(self):
            value = getattr(self, term.name)
            if value is not None or term.default is not None:
                _require_length(term.name, value)

    def required(self, encounter: Encounter, begin: float, end: float) -> Enclosure:
        """See `MotionLaw`."""
        return requirement(self, encounter, begin, end)


@dataclass(frozen=True, kw_only=True)
class SeparationLaw(_KernelLaw):
    """The protective separation distance of speed and separation monitoring, linear form.

    d = k_H (t1 + t2) + k_R t1 + B + δ with k_H the human's speed, k_R the robot's, `t1` the
    time to sense and react, `t2` the time to stop (seconds), B the distance covered while
    `stopping` and δ the `intrusion` allowance (metres).

    Source: ISO/TS 15066:2016, clause 5.5.4; linear form as in J. A. Marvel and R. Norcross,
    "Implementing speed and separation monitoring in collaborative robot workcells", Robotics
    and Computer-Integrated Manufacturing 44, 2017. `ValueError` if a term is negative.
    """

    t1: float
    t2: float
    stopping: float = 0.0
    intrusion: float = 0.0

    @classmethod
    def for_machine(cls, machine: Machine, *, t1: float, intrusion: float = 0.0) -> SeparationLaw:
        """Return the law whose `t2` and `stopping` are those of the longest stop of `machine`.

        The machine is a floorplan's `Gantry` or `Lane`, or `GantryLimits`. From no state within
        its limits does it take longer to stand, or come farther from where braking begins: S_S of
        ISO/TS 15066:2016, clause 5.5.4.2.3, at its largest. An axis with top speed v,
        acceleration a and jerk j takes at most v / a + 2 a / j (no jerk limit: v / a); both axes
        of a gantry may be that fast at once. `t1` in seconds, `intrusion` in metres. `TypeError`
        if it is no machine.
        """
        time, distance = longest_stop(machine)
        return cls(t1=t1, t2=time, stopping=distance, intrusion=intrusion)

    def distance(self, human_speed: float, robot_speed: float) -> float:
        """Return the required distance in metres for these speeds in m/s."""
        return (
            human_speed * (self.t1 + self.t2)
            + robot_speed * self.t1
            + self.stopping
            + self.intrusion
        )


@dataclass(frozen=True, kw_only=True)
class IntegralLaw(_KernelLaw):
    """The protective separation distance of speed and separation monitoring, integral form.

    S(t0) = S_H + S_R + S_S + C + Z_D + Z_R, in the terms of ISO/TS 15066:2016, clause 5.5.4.2.3:

    - S_H, the path of the human from t0 to t0 + `t1` + `t2`: ∫ v_H dt,
    - S_R, the path of the robot from t0 to t0 + `t1`, while it is sensed and reacted to: ∫ v_R dt,
    - S_S, the path of the robot from t0 + `t1` to t0 + `t1` + `t2`, while it stops: `stopping`
      metres, or if None, that of a speed which falls evenly from v_R(t0 + `t1`) to 0,
    - C, the `intrusion` distance; Z_D and Z_R, the uncertainties of where the human is
      (`human_uncertainty`) and the robot (`robot_uncertainty`), all in metres.

    The speeds are those of the known motions, into the future: the human counts as if every step
    led towards the robot. At constant speeds, and with `stopping` given, this is `SeparationLaw`.
    Discussed in J. A. Marvel and R. Norcross, "Implementing speed and separation monitoring in
    collaborative robot workcells", Robotics and Computer-Integrated Manufacturing 44, 2017.
    `ValueError` if a term is negative.
    """

    t1: float
    t2: float
    stopping: float | None = None
    intrusion: float = 0.0
    human_uncertainty: float = 0.0
    robot_uncertainty: float = 0.0


@dataclass(frozen=True, kw_only=True)
class ApproachLaw(_KernelLaw):
    """The distance to people whose speed is not known: S = K T + C of ISO 13855:2010, clause 5.

    T is the `time` in seconds from sensing a person to the end of the machine's motion, K the
    approach `speed` in m/s (people who walk: 1.6), C the `intrusion` distance in metres. ISO/TS
    15066:2016, clause 5.5.4.2.3, takes the same speed where the human's is not monitored.
    `ValueError` if a term is negative.
    """

    time: float
    intrusion: float = 0.0
    speed: float = WALKING_SPEED

    def distance(self, human_speed: float, robot_speed: float) -> float:
        """Return the required distance in metres, whatever the speeds."""
        return self.speed * self.time + self.intrusion


@dataclass(frozen=True)
class FixedDistance(_KernelLaw):
    """The same distance at any speed, in metres."""

    metres: float

    def distance(self, human_speed: float, robot_speed: float) -> float:
        """Return the required distance in metres, whatever the speeds."""
        return self.metres


@dataclass(frozen=True)
class Scaled(_KernelLaw):
    """`factor` times another law, capped at `cap` metres first: when people notice a machine.

    The distance is at most `factor` · `cap` metres. `ValueError` if either is negative.
    """

    law: AnyLaw
    factor: float
    cap: float = math.inf

    def __post_init__(self) -> None:
        _require_length("factor", self.factor)
        if not self.cap >= 0:
            raise ValueError(f"cap must be at least 0, not {self.cap}")

    def distance(self, human_speed: float, robot_speed: float) -> float:
        """Return the scaled distance in metres for these speeds in m/s.

        `TypeError` if the other law asks for more than speeds (see `is_of_speeds`).
        """
        if not is_of_speeds(self.law):
            raise TypeError(f"{self.law!r} asks for more than two speeds")
        return self.factor * min(self.law.distance(human_speed, robot_speed), self.cap)


def is_of_speeds(law: AnyLaw) -> TypeGuard[Law]:
    """Return whether two speeds are all that `law` asks for; if not, it is only a `MotionLaw`."""
    if isinstance(law, Scaled):
        return is_of_speeds(law.law)
    return hasattr(law, "distance")


def is_of_motions(law: AnyLaw) -> TypeGuard[MotionLaw]:
    """Return whether `law` judges motions."""
    return hasattr(law, "required")


def requirement(law: AnyLaw, encounter: Encounter, begin: float, end: float) -> Enclosure:
    """Return the distance in metres that any law requires in `encounter` from `begin` to `end`.

    See `MotionLaw`.
    """
    return Enclosure(*kernel_of(law).required(encounter, begin, end))


def kernel_of(law: AnyLaw) -> LawEvaluator:
    """Return what computes `law` in the monitor's kernel: a law of one's own is asked in Python."""
    make = _KERNELS.get(type(law))  # derived classes may change what they ask for
    if make is None:
        return PythonLaw(law, is_of_speeds(law), is_of_motions(law))
    return make(law)


_KERNELS: dict[type, Callable[[Any], LawEvaluator]] = {
    SeparationLaw: lambda law: LinearLaw(law.t1 + law.t2, law.t1, law.stopping, law.intrusion),
    IntegralLaw: lambda law: PathIntegralLaw(
        law.t1,
        law.t2,
        -1.0 if law.stopping is None else law.stopping,
        law.intrusion + law.human_uncertainty + law.robot_uncertainty,
    ),
    ApproachLaw: lambda law: LinearLaw(0.0, 0.0, 0.0, law.distance(0.0, 0.0)),
    FixedDistance: lambda law: LinearLaw(0.0, 0.0, 0.0, law.metres),
    Scaled: lambda law: ScaledLaw(kernel_of(law.law), law.factor, law.cap),
}


def required_at(law: AnyLaw, person: Motion, machine: Motion, t: float) -> float:
    """Return the distance in metres that `law` requires of `person` and `machine` at `t` (seconds).

    Where a speed changes at once, it is what is required from then on.
    """
    return required_along(law, person, machine)(t)


def required_along(law: AnyLaw, person: Motion, machine: Motion) -> Callable[[float], float]:
    """Return the function of t (seconds) that `required_at` is for `law`, `person` and `machine`.

    Motions are worked out once for all instants that it is asked for.
    """
    if is_of_speeds(law):
        distance = law.distance
        return lambda t: float(distance(person.state(t).speed, machine.state(t).speed))
    encounter, asked = Encounter(person, machine), kernel_of(law)

    def required(t: float) -> float:
        encounter.come_to(t)
        encounter.next_stretch(t)
        return float(asked.required(encounter, t, t)[0])

    return required


def required_at_speeds(law: AnyLaw, human_speed: float, robot_speed: float) -> float:
    """Return the distance in metres that `law` requires of two who go on at these speeds.

    `human_speed` and `robot_speed` are in m/s.
    """
    if is_of_speeds(law):
        return float(law.distance(human_speed, robot_speed))
    return required_at(law, _steady(human_speed), _steady(robot_speed), 0.0)


def _steady(speed: float) -> Motion:
    """Return going straight on at `speed` (m/s) for long before t = 0 and after."""
    nowhere = (0.0, 0.0, 0.0, 0.0)
    return Motion((Piece(-_LONG, _LONG, (0.0, speed, 0.0, 0.0), nowhere, nowhere),))


def _require_length(name: str, length: float) -> None:
    if not (isinstance(length, Real) and math.isfinite(length) and length >= 0):
        raise ValueError(f"{name} must be a number of at least 0, not {length!r}")


def require_sense(law: AnyLaw) -> None:
    """Raise `ValueError` if an object is no law, or asks for less when a speed grows.

    Only a few speeds are tried: a law that asks for less at others is not found out.
    """
    if not (hasattr(law, "distance") or is_of_motions(law)):
        raise ValueError(f"a law has a method distance or required, {law!r} has neither")
    if type(law) is FixedDistance or not is_of_speeds(law):
        return
    tried = [law.distance(human, robot) for human, robot in _TRIED]
    # Each beside the one before it, and the first beside itself. NaN is not at least anything.
    for speeds, metres, least in zip(_TRIED, tried, [tried[0], *tried], strict=False):
        if not metres >= least:
            raise ValueError(
                f"{law!r} asks for {metres} m at speeds of {speeds[0]:g} (human) and"
                f" {speeds[1]:g} m/s (robot), but for {least} m at lower ones;"
                " a law must not ask for less when speeds grow"
            )
