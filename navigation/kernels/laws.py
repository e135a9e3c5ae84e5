"""Separation laws: what they require at two speeds, and over an interval of an encounter."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    import cython
else:
    from . import uncompiled as cython

if not cython.compiled:
    from .encounter import EncounterBounds
    from .odometer import PathLength, TaylorModel
else:
    from cython.cimports.navigation.kernels.encounter import EncounterBounds
    from cython.cimports.navigation.kernels.odometer import PathLength, TaylorModel


class LawEvaluator:
    """A separation law: `distance` from two speeds, `require` of an encounter, in `out`.

    `of_speeds` is False where two speeds are not all it asks for, and `steady` True where not even
    they matter; `source` is named in messages.
    """

    def __init__(self, of_speeds: bool, source: Any = None, *, steady: bool = False) -> None:
        self.of_speeds = of_speeds
        self.steady = steady
        self.source = source
        self.out = TaylorModel()

    def distance(self, human: float, robot: float) -> float:
        return 0.0

    def require(self, encounter: EncounterBounds, begin: float, end: float) -> cython.int:
        return 0

    def required(
        self, encounter: EncounterBounds, begin: float, end: float
    ) -> tuple[float, float, float, float]:
        """Return the required distance over an interval: value, slope, slack and curve."""
        self.require(encounter, begin, end)
        return self.out.numbers()


class LinearLaw(LawEvaluator):
    """`human` · v_H + `robot` · v_R + `stopping` + `intrusion`."""

    def __init__(self, human: float, robot: float, stopping: float, intrusion: float) -> None:
        super().__init__(True, steady=human == 0.0 == robot)
        self.speeds = TaylorModel(), TaylorModel()
        self.human = human
        self.robot = robot
        self.stopping = stopping
        self.intrusion = intrusion

    def distance(self, human: float, robot: float) -> float:
        return human * self.human + robot * self.robot + self.stopping + self.intrusion

    def require(self, encounter: EncounterBounds, begin: float, end: float) -> cython.int:
        fixed: float = self.stopping + self.intrusion
        if self.steady:
            return self.out.set(fixed, 0.0, 0.0, 0.0)
        human: TaylorModel
        robot: TaylorModel
        human, robot = self.speeds
        encounter.person.speed(begin, end, human)
        encounter.machine.speed(begin, end, robot)
        return self.out.set(
            human.value * self.human + robot.value * self.robot + fixed,
            human.slope * self.human + robot.slope * self.robot,
            human.slack * self.human + robot.slack * self.robot,
            0.0,
        )


class PathIntegralLaw(LawEvaluator):
    """The integral form (`navigation.IntegralLaw`); `stopping` is negative where it is braking."""

    def __init__(self, t1: float, t2: float, stopping: float, allowance: float) -> None:
        super().__init__(False)
        self.t1 = t1
        self.t2 = t2
        self.stopping = stopping
        self.allowance = allowance

    def require(self, encounter: EncounterBounds, begin: float, end: float) -> cython.int:
        human: PathLength
        robot: PathLength
        human, robot = encounter.paths()
        human.look_ahead(begin, end, self.t1 + self.t2)
        robot.look_ahead(begin, end, self.t1)
        # Enclosures of two figures add up term by term: value, slope, slack and curve.
        value: float = human.out.value + robot.out.value
        slope: float = human.out.slope + robot.out.slope
        slack: float = human.out.slack + robot.out.slack
        curve: float = human.out.curve + robot.out.curve
        if self.stopping >= 0.0:
            return self.out.set(value + (self.stopping + self.allowance), slope, slack, curve)
        robot.look(begin + self.t1, end + self.t1)
        half: float = self.t2 / 2
        return self.out.set(
            value + robot.out.value * half + self.allowance,
            slope + robot.out.slope * half,
            slack + robot.out.slack * half,
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

    def require(self, encounter: EncounterBounds, begin: float, end: float) -> cython.int:
        self.law.require(encounter, begin, end)
        whole: TaylorModel = self.law.out
        half: float = (end - begin) / 2
        around: float = (abs(whole.slope) + abs(whole.curve) * half / 2) * half + whole.slack
        # The cap bends the figure. Where it is out of reach nothing changes; else two bounds
        # remain.
        if whole.value + around <= self.cap:
            return self.out.set(
                whole.value * self.factor,
                whole.slope * self.factor,
                whole.slack * self.factor,
                whole.curve * self.factor,
            )
        low: float = self.factor * min(whole.value - around, self.cap)
        high: float = self.factor * self.cap
        return self.out.set((low + high) / 2, 0.0, (high - low) / 2, 0.0)


class PythonLaw(LawEvaluator):
    """A law that is written in Python: `source` has a method `distance`, `required` or both."""

    def __init__(self, source: Any, of_speeds: bool, of_motions: bool) -> None:
        super().__init__(of_speeds, source)
        self.of_motions = of_motions

    def distance(self, human: float, robot: float) -> float:
        return float(self.source.distance(human, robot))

    def require(self, encounter: EncounterBounds, begin: float, end: float) -> cython.int:
        if self.of_motions:
            required = self.source.required(encounter, begin, end)
            return self.out.set(required.value, required.slope, required.slack, required.curve)
        encounter.look(begin, end)
        # A law of two speeds must not ask for less when they grow (`TooClose` checks it), so its
        # bounds are those of the speeds.
        low: float = self.distance(encounter.person.low, encounter.machine.low)
        high: float = self.distance(encounter.person.high, encounter.machine.high)
        return self.out.set((low + high) / 2, 0.0, (high - low) / 2, 0.0)
