"""Effect sizes: Cliff's delta of groups of rows that differ in one factor."""

from __future__ import annotations

import itertools
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from .comparison import CONFIDENCE, RESAMPLES, Comparison, Floats, Group, Measure


@dataclass(frozen=True)
class Effect:
    """Cliff's delta of two groups, and the ends of the interval that holds the true one."""

    delta: float
    low: float
    high: float


@dataclass(frozen=True)
class Contrast:
    """Two groups that differ in one factor only, and the effect of that on each telling measure.

    An effect is None where no repetition has the figure in both.
    """

    one: Group
    other: Group
    effects: dict[Measure, Effect | None]


def contrasts(compared: Comparison) -> Iterator[Contrast]:
    """Yield every pair of groups that differ in one factor, the first factor's pairs first.

    They are compared by the `telling` measures.
    """
    measures = compared.telling
    for factor in range(len(compared.factors)):
        for one, other in itertools.combinations(compared.groups, 2):
            pairs = zip(one.values, other.values, strict=True)
            differing = [k for k, (a, b) in enumerate(pairs) if a != b]
            if differing == [factor]:
                effects = {
                    measure: cliffs_delta(
                        compared.values[measure][one.rows], compared.values[measure][other.rows]
                    )
                    for measure in measures
                }
                yield Contrast(one, other, effects)


def cliffs_delta(one: Floats, other: Floats) -> Effect | None:
    """Return how often figures of `one` are above those of `other`, less how often below.

    That is P(X > Y) - P(X < Y) over all pairs of rows, from -1 to 1: N. Cliff, "Dominance
    statistics: Ordinal analyses to answer ordinal questions", Psychological Bulletin 114, 1993.
    The k-th figures of both are of one repetition, which all combinations meet with the same
    draws; repetitions in which either is missing (NaN) are left out, None if none is left. The
    interval is the percentile bootstrap over repetitions, as that of `comparison.spread`.
    """
    count = min(len(one), len(other))
    there = ~(np.isnan(one[:count]) | np.isnan(other[:count]))
    x, y = one[:count][there], other[:count][there]
    n = len(x)
    if not n:
        return None
    order = np.argsort(y, kind="stable")
    below = np.searchsorted(y[order], x, "left")
    up_to = np.searchsorted(y[order], x, "right")

    def deltas(times: Floats) -> Floats:
        """Return the delta of each row of `times`: how often each repetition is taken."""
        passed = np.concatenate([np.zeros((len(times), 1)), times[:, order].cumsum(axis=1)], axis=1)
        # Of the sorted others, an x is above those before `below`, and below those from `up_to` on:
        # passed[below] - (n - passed[up_to]).
        above_less_below: Floats = passed[:, below] + passed[:, up_to] - n
        dominance: Floats = (times * above_less_below).sum(axis=1)
        return dominance / n**2

    drawn = np.random.default_rng(0).multinomial(n, np.full(n, 1 / n), size=RESAMPLES)
    tail = (1 - CONFIDENCE) / 2
    low, high = np.quantile(deltas(drawn.astype(float)), [tail, 1 - tail])
    return Effect(float(deltas(np.ones((1, n)))[0]), float(low), float(high))
