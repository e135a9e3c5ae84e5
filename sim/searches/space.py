"""Search space of a study: its grid and distributions as dimensions."""

from __future__ import annotations

import random
from collections.abc import Iterator, Mapping
from dataclasses import replace
from typing import Any

from floorplan import UserError
from floorplan.files.dataclass import dataclass

from ..core.entries import is_number
from ..studies.design import (
    DECIMALS,
    Choice,
    Distribution,
    Normal,
    Row,
    Shuffled,
    Study,
    Uniform,
    derived_seed,
)
from ..studies.variables import Value, reordered
from ..trials.trial import Trial

Coordinate = Value
"""Value of one dimension: a number, or one of its values."""

Point = Mapping[str, Any]
"""Coordinates by the name of their dimension."""


@dataclass(frozen=True)
class Dimension:
    """One dimension of a search: numbers from `low` to `high`, or one of `values`.

    `variable` is the name of its variable in the study. Random numbers are uniform, or have the
    distribution `normal`.
    """

    name: str
    variable: str
    low: float = 0.0
    high: float = 0.0
    values: tuple[Value, ...] = ()
    normal: Normal | None = None

    def draw(self, share: float) -> Coordinate:
        """Return the quantile of a `share` (0 to 1) of the distribution."""
        if self.values:
            return self.values[min(int(share * len(self.values)), len(self.values) - 1)]
        if self.normal is not None:
            return self.normal.quantile(share)
        return self.rounded(self.low + share * (self.high - self.low))

    def rounded(self, number: float) -> float:
        """Return a number within the dimension, with the decimals of drawn numbers."""
        return min(max(round(number, DECIMALS), self.low), self.high)

    def fault(self, coordinate: Any) -> str:
        """Return the problem of a coordinate, or an empty text."""
        if self.values:
            if coordinate in self.values:
                return ""
            return f"must be one of {', '.join(map(str, self.values))}, not {coordinate!r}"
        if is_number(coordinate) and self.low <= coordinate <= self.high:
            return ""
        return f"must be a number from {self.low:g} to {self.high:g}, not {coordinate!r}"

    def share(self, coordinate: Any) -> float:
        """Return the relative position of a coordinate in the dimension, from 0 to 1."""
        if self.values:
            return self.values.index(coordinate) / max(len(self.values) - 1, 1)
        width = self.high - self.low
        return (float(coordinate) - self.low) / width if width else 0.0


class Space:
    """All trials that a study can draw: its trials, its grid and its distributions.

    Samplers choose values of `dimensions`. A custom distribution has no dimension. Its value is
    drawn for each trial.
    """

    def __init__(self, study: Study) -> None:
        self.study = study
        self.dimensions = tuple(_dimensions(study))
        if not self.dimensions:
            raise UserError(
                f"nothing varies in the study {study.name!r}: give distributions as `random:`,"
                " or several trials or values in `grid:`"
            )

    def random_point(self, number: int) -> dict[str, Coordinate]:
        """Return the random point of the evaluation of that number."""
        return {
            one.name: one.draw(
                random.Random(derived_seed("point", self.study.seed, one.name, number)).random()
            )
            for one in self.dimensions
        }

    def fault(self, point: Any) -> str:
        """Return the problem of a point, or an empty text."""
        names = [one.name for one in self.dimensions]
        if not isinstance(point, Mapping) or {*point} != {*names}:
            return f"a point must have values for {', '.join(names)}, not {point!r}"
        for one in self.dimensions:
            if fault := one.fault(point[one.name]):
                return f"{one.name} {fault}"
        return ""

    def row(self, number: int, point: Point) -> Row:
        """Return the trial at a point with its values. `UserError` if there is no such trial."""
        study = self.study
        values: dict[str, Value] = {}
        name = point.get("trial", study.trials[0].name)
        trial = next(one for one in study.trials if one.name == name)
        seed = derived_seed("search", study.seed, number)
        trial = replace(trial, seed=seed)
        others = (*study.grid, *study.random)
        for what, choices in study.grid.items():
            values[what.name] = point.get(what.name, choices[0])
            trial = what.put(trial, values[what.name], study.folder, others)
        for what, distribution in study.random.items():
            value = self._value(what.name, distribution, point, trial, number)
            values[what.name] = value
            trial = what.put(trial, value, study.folder, others)
        return Row(number, {"trial": name, **values, "seed": seed}, trial)

    def _value(
        self, name: str, distribution: Distribution, point: Point, trial: Trial, number: int
    ) -> Value:
        mine: list[Any] = [point[one.name] for one in self.dimensions if one.variable == name]
        match distribution:
            case Uniform(low=tuple()):
                return tuple(mine)
            case Shuffled():
                jobs = trial.gantry.jobs
                return reordered(jobs, lambda stretch: sorted(stretch, key=mine.__getitem__))
            case Uniform() | Normal() | Choice():
                only: Value = mine[0]
                return only
        return distribution.draw(derived_seed("draw", self.study.seed, name, number), trial)


def _dimensions(study: Study) -> Iterator[Dimension]:
    if len(study.trials) > 1:
        yield Dimension("trial", "trial", values=tuple(trial.name for trial in study.trials))
    for what, values in study.grid.items():
        if len(values) > 1:
            yield Dimension(what.name, what.name, values=values)
    for what, distribution in study.random.items():
        yield from _of_distribution(what.name, distribution, study)


def _of_distribution(name: str, distribution: Distribution, study: Study) -> Iterator[Dimension]:
    match distribution:
        case Uniform(low=tuple() as lows, high=tuple() as highs):
            for k, (low, high) in enumerate(zip(lows, highs, strict=True)):
                yield Dimension(f"{name}[{k}]", name, float(low), float(high))
        case Uniform(low=int() | float() as low, high=int() | float() as high):
            yield Dimension(name, name, float(low), float(high))
        case Normal():
            yield Dimension(
                name, name, float(distribution.low), float(distribution.high), normal=distribution
            )
        case Choice():
            yield Dimension(name, name, values=distribution.values)
        case Shuffled():
            # Jobs are sorted by random keys (J. C. Bean, "Genetic algorithms and random keys for
            # sequencing and optimization", ORSA Journal on Computing 6, 1994).
            for k in range(max(len(trial.gantry.jobs) for trial in study.trials)):
                yield Dimension(f"{name}[{k}]", name, 0.0, 1.0)
