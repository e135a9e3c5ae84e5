"""Samplers of a search: they propose points and receive the values of the objective."""

from __future__ import annotations

import math
import warnings
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any, Protocol

from floorplan import UserError

from ..core.custom_code import CodeFolder, Kind, in_words
from ..views.report_page import MissingExtraError
from .space import Coordinate, Dimension, Point, Space

if TYPE_CHECKING:
    from optuna.trial import Trial as OptunaTrial


class SamplerError(UserError):
    """Error of a sampler that cannot be found, fails, or proposes an invalid point."""


class Sampler(Protocol):
    """Chooses the points of a search.

    It is constructed with the dimensions of the space and a seed. It must depend on nothing else,
    so that a search can be repeated and resumed.
    """

    def ask(self, count: int) -> Sequence[Point]:
        """Return `count` points: a value by the name of each dimension."""
        ...

    def tell(self, points: Sequence[Point], values: Sequence[float | None]) -> None:
        """Receive the objective at points, which may include random ones.

        Lower values are worse for the controller. A value is None if a point makes no trial, minus
        infinity if the controller failed, and infinity if a run does not have the figure.
        """
        ...


MakesSampler = Callable[[Sequence[Dimension], int], Sampler]
"""A class of samplers, or a function that makes one."""


class NoSampler:
    """Sampler of a search in which all points are random."""

    def __init__(self, dimensions: Sequence[Dimension], seed: int) -> None:
        pass

    def ask(self, count: int) -> Sequence[Point]:
        """See `Sampler`. It is never called."""
        raise NotImplementedError

    def tell(self, points: Sequence[Point], values: Sequence[float | None]) -> None:
        """See `Sampler`."""


class TpeSampler:
    """Tree-structured Parzen estimator of optuna, multivariate.

    J. Bergstra, R. Bardenet, Y. Bengio and B. Kégl, "Algorithms for hyper-parameter optimization",
    Advances in Neural Information Processing Systems 24, 2011.
    """

    def __init__(self, dimensions: Sequence[Dimension], seed: int) -> None:
        try:
            import optuna
        except ImportError:
            message = "the sampler tpe needs: pip install 'floorwalker[search]'"
            raise MissingExtraError(message) from None
        optuna.logging.set_verbosity(optuna.logging.ERROR)
        self._optuna = optuna
        self._dimensions = dimensions
        self._distributions = {one.name: self._distribution(one) for one in dimensions}
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # about experimental options of optuna
            sampler = optuna.samplers.TPESampler(
                seed=seed % 2**32, n_startup_trials=0, multivariate=True, constant_liar=True
            )
        self._study = optuna.create_study(sampler=sampler)
        self._asked: list[tuple[Point, OptunaTrial]] = []

    def ask(self, count: int) -> Sequence[Point]:
        """See `Sampler`."""
        return [self._next() for _ in range(count)]

    def tell(self, points: Sequence[Point], values: Sequence[float | None]) -> None:
        """See `Sampler`."""
        states = self._optuna.trial.TrialState
        for point, value in zip(points, values, strict=True):
            proposed = next((trial for one, trial in self._asked if one is point), None)
            state = states.FAIL if value is None else states.COMPLETE
            if proposed is not None:
                self._study.tell(proposed, value, state=state)
                continue
            params = {one.name: _index(one, point[one.name]) for one in self._dimensions}
            self._study.add_trial(
                self._optuna.trial.create_trial(
                    params=params, distributions=self._distributions, value=value, state=state
                )
            )
        self._asked.clear()

    def _next(self) -> Point:
        trial = self._study.ask(self._distributions)
        point = {one.name: self._coordinate(one, trial) for one in self._dimensions}
        self._asked.append((point, trial))
        return point

    def _coordinate(self, one: Dimension, trial: OptunaTrial) -> Coordinate:
        parameter = trial.params[one.name]
        return one.values[parameter] if one.values else one.rounded(parameter)

    def _distribution(self, one: Dimension) -> Any:
        kinds = self._optuna.distributions
        if one.values:
            return kinds.CategoricalDistribution(range(len(one.values)))
        return kinds.FloatDistribution(one.low, one.high)


def _index(one: Dimension, coordinate: Any) -> Any:
    return one.values.index(coordinate) if one.values else coordinate


SAMPLERS: dict[str, MakesSampler] = {"tpe": TpeSampler, "random": NoSampler}
"""Samplers by name."""

SAMPLER = Kind(
    noun="sampler",
    words="sampler: a sampler is a class with methods ask and tell",
    accepts=lambda made: callable(made),
    error=SamplerError,
    builtin=SAMPLERS,
)
"""The kind of class that a search names."""


def find_sampler(name: str | MakesSampler, folder: CodeFolder) -> MakesSampler:
    """Return the built-in sampler of that name, or the class `package.module:Class`.

    `SamplerError` if `folder` does not contain it.
    """
    if not isinstance(name, str):
        return name
    if name in SAMPLERS:
        return SAMPLERS[name]
    custom: MakesSampler = folder.find(name, SAMPLER).load()
    return custom


class Checked:
    """Sampler whose points are checked. Its errors are raised as `SamplerError`."""

    def __init__(self, make: MakesSampler, space: Space, seed: int) -> None:
        self._name = getattr(make, "__qualname__", type(make).__qualname__)
        self._space = space
        self._sampler = self._guarded(make, space.dimensions, seed)
        for method in ("ask", "tell"):
            if not callable(getattr(self._sampler, method, None)):
                raise SamplerError(f"the sampler {self._name} has no method {method}")

    def ask(self, count: int) -> list[Point]:
        """Return `count` points of the space."""
        if not count:
            return []
        points = self._guarded(self._sampler.ask, count)
        if not isinstance(points, Sequence) or isinstance(points, str):
            raise SamplerError(f"the sampler {self._name} must return a list, not {points!r}")
        if len(points) != count:
            message = f"must return {count} points, not {len(points)}"
            raise SamplerError(f"the sampler {self._name} {message}")
        for point in points:
            if fault := self._space.fault(point):
                raise SamplerError(f"the sampler {self._name} returned a wrong point: {fault}")
        return [*points]

    def tell(self, points: Sequence[Point], values: Sequence[float | None]) -> None:
        """Pass the objective at points to the sampler."""
        self._guarded(self._sampler.tell, points, values)

    def _guarded(self, call: Callable[..., Any], *arguments: Any) -> Any:
        try:
            return call(*arguments)
        except UserError:
            raise
        except Exception as why:
            raise SamplerError(f"the sampler {self._name} failed: {in_words(why)}") from why


def told(value: float | None, *, failed: bool) -> float | None:
    """Return the value of a run for samplers, or infinity if it has none."""
    if failed:
        return -math.inf
    return math.inf if value is None else value
