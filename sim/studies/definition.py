"""Designs: which trials a study runs, in which variations, and how each is found again."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path

from floorplan import InputError, UserError

from ..trials.trial import Trial
from .draws import Distribution, derived_seed
from .variables import Value, Variable


class StudyError(InputError):
    """A study that can't be run."""


@dataclass(frozen=True)
class Row:
    """One run of a study: its number, what makes it differ from the others, and its trial."""

    number: int
    parameters: dict[str, Value]
    trial: Trial


@dataclass(frozen=True)
class Combination:
    """One trial with one value of everything in the grid."""

    trial: Trial
    values: tuple[Value, ...]


@dataclass(frozen=True)
class Design:
    """Trials × everything in the grid × `repeat`, with what is drawn at random for each.

    A row's seed comes from the study's seed and the row's own parameters: neither the order of
    rows nor what else is in the study matters. What is drawn depends on the repetition only, so
    that all combinations meet the same draws and can be compared pair by pair (common random
    numbers). With `metrics`, rows have those of social navigation as well. Files named in `grid`
    and `random` are seen from `folder`.
    """

    name: str
    trials: tuple[Trial, ...]
    grid: Mapping[Variable, tuple[Value, ...]] = field(default_factory=dict)
    random: Mapping[Variable, Distribution] = field(default_factory=dict)
    repeat: int = 1
    seed: int = 0
    metrics: bool = False
    folder: Path = Path()

    def __len__(self) -> int:
        """The number of rows; `OverflowError` if it does not fit into 63 bits (see `size`)."""
        return self.size

    @property
    def size(self) -> int:
        """The number of rows, however large."""
        combinations = math.prod(len(values) for values in self.grid.values())
        return len(self.trials) * self.repeat * combinations

    def rows(self, first: int = 0) -> Iterator[Row]:
        """The rows from the number `first` on: every combination once, then all once more."""
        return (self.row(number) for number in range(first, len(self)))

    def row(self, number: int) -> Row:
        """The row of that number; `ValueError` if there is none."""
        if not 0 <= number < len(self):
            raise UserError(f"{self.name} has rows 0 to {len(self) - 1}, but no row {number}")
        repetition, index = divmod(number, len(self.combinations))
        combination = self.combinations[index]
        chosen: dict[str, Value] = {"trial": combination.trial.name}
        chosen |= {what.name: one for what, one in zip(self.grid, combination.values, strict=True)}
        seed = derived_seed("run", self.seed, list(chosen.items()), repetition)
        trial = replace(combination.trial, seed=seed)
        drawn: dict[str, Value] = {}
        for what, distribution in self.random.items():
            draw = derived_seed("draw", self.seed, what.name, repetition)
            value = drawn[what.name] = distribution.draw(draw, trial)
            trial = self._put(trial, what, value)
        return Row(number, {**chosen, **drawn, "repetition": repetition, "seed": seed}, trial)

    @cached_property
    def combinations(self) -> tuple[Combination, ...]:
        """Each trial with each combination of the grid's values."""
        return tuple(
            Combination(self._with(trial, values), values)
            for trial in self.trials
            for values in itertools.product(*self.grid.values())
        )

    def _with(self, trial: Trial, values: tuple[Value, ...]) -> Trial:
        for what, value in zip(self.grid, values, strict=True):
            trial = self._put(trial, what, value)
        return trial

    def _put(self, trial: Trial, what: Variable, value: Value) -> Trial:
        return what.put(trial, value, self.folder, (*self.grid, *self.random))
