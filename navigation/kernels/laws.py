"""Evaluation of separation laws at two speeds, and over an interval of an encounter.

Over an interval the required distance is a Taylor model (see `odometer`). The linear law is that of
speed and separation monitoring in ISO/TS 15066, 5.5.4.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from .results import Enclosure

if TYPE_CHECKING:
    import cython
else:
    from . import uncompiled as cython

if not cython.compiled:
    from .cubics import *
    from .encounter import Encounter
    from .odometer import Odometer, enclosure_of, radius_of, speed_over


class LawEvaluator:
    """Separation law with `distance` for two speeds, and `require` for an encounter.

    `of_speeds` is true if the law depends on two speeds alone, and `steady` if it depends on
    neither. Messages name `source`.
    """

    def __init__(self, of_speeds: bool, source: Any = None, *, steady: bool = False) -> None:
        self.of_speeds = of_speeds
        self.steady = steady
        self.source = source

    def distance(self, human: float, robot: float) -> float:
        return 0.0

    def require(self, encounter: Encounter, begin: float, end: float) -> TaylorModel:
        return TaylorModel(0.0, 0.0, 0.0, 0.0)

    def required(self, encounter: Encounter, begin: float, end: float) -> Enclosure:
        """Return the required distance over an interval."""
        return enclosure_of(self.require(encounter, begin, end))


def evaluator_of(law: Any) -> LawEvaluator:
    """Return the evaluator of a law.

    Raises
    ------
    ValueError
        If a custom law has no method for it, or decreases with a speed.
    """
    if isinstance(law, LawEvaluator):
        return law
    if hasattr(law, "evaluator"):
        evaluator: LawEvaluator = law.evaluator()
        return evaluator
    return PythonLaw(law, hasattr(law, "distance"), hasattr(law, "required"))


def require_sense(law: Any) -> None:
    """Raise `ValueError` if a law decreases with a speed. Only a few speeds are tested."""
    least: Any = None
    for human, robot in ((0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (2.0, 1.0)):
        metres = law.distance(human, robot)
        if least is None:
            least = metres
        # NaN fails this comparison too, also with itself.
        if not metres >= least:
            raise ValueError(
                f"{law!r} asks for {metres} m at speeds of {human:g} (human) and"
                f" {robot:g} m/s (robot), but for {least} m at lower ones;"
                " a law must not ask for less when speeds grow"
            )
        least = metres


class LinearLaw(LawEvaluator):
    """`human` · v_H + `robot` · v_R + `stopping` + `intrusion`."""

    def __init__(self, human: float, robot: float, stopping: float, intrusion: float) -> None:
        super().__init__(True, steady=human == 0.0 == robot)
        self.human = human
        self.robot = robot
        self.stopping = stopping
        self.intrusion = intrusion

    def distance(self, human: float, robot: float) -> float:
        return human * self.human + robot * self.robot + self.stopping + self.intrusion

    def require(self, encounter: Encounter, begin: float, end: float) -> TaylorModel:
        fixed: float = self.stopping + self.intrusion
        if self.steady:
            return TaylorModel(fixed, 0.0, 0.0, 0.0)
        human: TaylorModel = encounter.person.speed_over(begin, end)
        robot: TaylorModel = encounter.machine.speed_over(begin, end)
        return TaylorModel(
            human.value * self.human + robot.value * self.robot + fixed,
            human.slope * self.human + robot.slope * self.robot,
            human.slack * self.human + robot.slack * self.robot,
            0.0,
        )


class PathIntegralLaw(LawEvaluator):
    """Integral form (`navigation.IntegralLaw`). A negative `stopping` means linear braking."""

    def __init__(self, t1: float, t2: float, stopping: float, allowance: float) -> None:
        super().__init__(False)
        self.t1 = t1
        self.t2 = t2
        self.stopping = stopping
        self.allowance = allowance

    def require(self, encounter: Encounter, begin: float, end: float) -> TaylorModel:
        human: Odometer = encounter.human
        robot: Odometer = encounter.robot
        walked: TaylorModel = human.length_ahead(begin, end, self.t1 + self.t2)
        driven: TaylorModel = robot.length_ahead(begin, end, self.t1)
        # Taylor models add up term by term: value, slope, slack and curve.
        value: float = walked.value + driven.value
        slope: float = walked.slope + driven.slope
        slack: float = walked.slack + driven.slack
        curve: float = walked.curve + driven.curve
        if self.stopping >= 0.0:
            return TaylorModel(value + (self.stopping + self.allowance), slope, slack, curve)
        speed: TaylorModel = speed_over(robot.table, begin + self.t1, end + self.t1)
        half: float = self.t2 / 2
        return TaylorModel(
            value + speed.value * half + self.allowance,
            slope + speed.slope * half,
            slack + speed.slack * half,
            curve,
        )


class ScaledLaw(LawEvaluator):
    """`factor` times another law, capped first at `cap` metres."""

    def __init__(self, law: LawEvaluator, factor: float, cap: float) -> None:
        super().__init__(law.of_speeds, steady=law.steady)
        self.law = law
        self.factor = factor
        self.cap = cap

    def distance(self, human: float, robot: float) -> float:
        return self.factor * min(self.law.distance(human, robot), self.cap)

    def require(self, encounter: Encounter, begin: float, end: float) -> TaylorModel:
        whole: TaylorModel = self.law.require(encounter, begin, end)
        around: float = radius_of(whole, (end - begin) / 2)
        # Where the cap is in reach, the requirement is no Taylor model, and only two bounds remain.
        if whole.value + around <= self.cap:
            return TaylorModel(
                whole.value * self.factor,
                whole.slope * self.factor,
                whole.slack * self.factor,
                whole.curve * self.factor,
            )
        low: float = self.factor * min(whole.value - around, self.cap)
        high: float = self.factor * self.cap
        return TaylorModel((low + high) / 2, 0.0, (high - low) / 2, 0.0)


class PythonLaw(LawEvaluator):
    """Law in Python: `source` has a method `distance` (`of_speeds`), `required` or both."""

    def __init__(self, source: Any, of_speeds: bool, of_motions: bool) -> None:
        super().__init__(of_speeds, source)
        self.of_motions = of_motions
        if not (of_speeds or of_motions):
            raise ValueError(f"a law has a method distance or required, {source!r} has neither")
        if of_speeds:
            require_sense(source)

    def distance(self, human: float, robot: float) -> float:
        return float(self.source.distance(human, robot))

    def require(self, encounter: Encounter, begin: float, end: float) -> TaylorModel:
        if self.of_motions:
            required = self.source.required(encounter, begin, end)
            return TaylorModel(required.value, required.slope, required.slack, required.curve)
        human: Range = encounter.person.speeds(begin, end)
        robot: Range = encounter.machine.speeds(begin, end)
        # A law of two speeds does not decrease with either, so the bounds of the speeds give its
        # bounds.
        low: float = self.distance(human.low, robot.low)
        high: float = self.distance(human.high, robot.high)
        return TaylorModel((low + high) / 2, 0.0, (high - low) / 2, 0.0)
