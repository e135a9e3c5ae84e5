"""Values drawn at random: from where, and how, so that a seed always draws the same one."""

from __future__ import annotations

import hashlib
import json
import random
from collections.abc import Sequence
from dataclasses import dataclass
from statistics import NormalDist
from typing import Protocol

from ..trials.trial import Trial
from .variables import Value, reordered

SIGMAS = 3.0
"""Standard deviations from its mean at which a normal distribution ends, if not given."""

DECIMALS = 6
"""Numbers are drawn to this many decimals, so that they can be read."""

_TINY = 1e-15
"""The inverse of a normal distribution is not asked beyond this share."""


def derived_seed(*parts: object) -> int:
    """A seed of 63 bits that depends on nothing but `parts` (numbers, texts and lists)."""
    digest = hashlib.sha256(json.dumps(parts).encode()).digest()
    return int.from_bytes(digest[:8], "big") >> 1


class Distribution(Protocol):
    """Source of random values."""

    @property
    def extremes(self) -> Sequence[Value]:
        """The values that have to make sense if all that can be drawn are to."""
        ...

    def draw(self, seed: int, trial: Trial) -> Value:
        """The value that `seed` draws for `trial`."""
        ...


@dataclass(frozen=True)
class Uniform:
    """Any number from `low` to `high` alike; of lists of numbers, each for itself."""

    low: float | tuple[float, ...]
    high: float | tuple[float, ...]

    def __str__(self) -> str:
        return f"uniform from {self.low} to {self.high}"

    @property
    def extremes(self) -> Sequence[Value]:
        """See `Distribution`."""
        return (self.low, self.high)

    def draw(self, seed: int, trial: Trial) -> Value:
        """See `Distribution`."""
        rng = random.Random(seed)
        if isinstance(self.low, tuple) and isinstance(self.high, tuple):
            ends = zip(self.low, self.high, strict=True)
            return tuple(_between(low, high, rng.random()) for low, high in ends)
        assert not isinstance(self.low, tuple) and not isinstance(self.high, tuple)
        return _between(self.low, self.high, rng.random())


@dataclass(frozen=True)
class Normal:
    """Numbers that gather around `mean` with standard deviation `sd`, from `low` to `high`."""

    mean: float
    sd: float
    low: float
    high: float

    def __str__(self) -> str:
        return f"normal, {self.mean:g} ± {self.sd:g}, from {self.low:g} to {self.high:g}"

    @property
    def extremes(self) -> Sequence[Value]:
        """See `Distribution`."""
        return (self.low, self.high)

    def draw(self, seed: int, trial: Trial) -> Value:
        """See `Distribution`."""
        normal = NormalDist(self.mean, self.sd)
        least, most = normal.cdf(self.low), normal.cdf(self.high)
        # Inversion of the truncated distribution: one draw, whatever the limits cut off.
        share = least + random.Random(seed).random() * (most - least)
        drawn = normal.inv_cdf(min(max(share, _TINY), 1 - _TINY))
        return min(max(round(drawn, DECIMALS), self.low), self.high)


@dataclass(frozen=True)
class Choice:
    """One of several values, all alike."""

    values: tuple[Value, ...]

    def __str__(self) -> str:
        return f"one of {', '.join(map(str, self.values))}"

    @property
    def extremes(self) -> Sequence[Value]:
        """See `Distribution`."""
        return self.values

    def draw(self, seed: int, trial: Trial) -> Value:
        """See `Distribution`."""
        # Not `choice`: `random` alone is promised to draw the same in every version of Python.
        return self.values[int(random.Random(seed).random() * len(self.values))]


@dataclass(frozen=True)
class Shuffled:
    """The trial's jobs in any order; what is handed in stays behind what it needs."""

    def __str__(self) -> str:
        return "shuffled"

    @property
    def extremes(self) -> Sequence[Value]:
        """See `Distribution`."""
        return ("given",)

    def draw(self, seed: int, trial: Trial) -> Value:
        """See `Distribution`."""
        rng = random.Random(seed)
        return reordered(
            trial.gantry.jobs, lambda stretch: sorted(stretch, key=lambda _: rng.random())
        )


def _between(low: float, high: float, share: float) -> float:
    return min(max(round(low + share * (high - low), DECIMALS), low), high)
