"""Estimates of a benchmark with their intervals of 95 % confidence, and curves over time.

Answers to the same question are alike, and so a question counts once, however often it is asked:
of its runs the share or the median is taken, and the questions are the sample.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import cache
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from .attempts import Attempt

CONFIDENCE = 0.95

_Z = 1.959963984540054
"""Of the normal distribution: 2.5 % lie above it."""

Floats = NDArray[np.float64]
_Value = TypeVar("_Value")


@dataclass(frozen=True)
class Estimate:
    """A figure, and the interval that holds its true value with 95 % confidence."""

    value: float
    low: float
    high: float


@dataclass(frozen=True)
class Curve:
    """A figure over time: from each of `seconds` on it has its value, until the next."""

    seconds: Floats
    value: Floats
    low: Floats
    high: Floats


def share(values: Sequence[float]) -> Estimate:
    """Return the mean of shares, each from 0 to 1, with Wilson's score interval.

    E. B. Wilson, Probable inference, the law of succession, and statistical inference, Journal of
    the American Statistical Association 22, 1927. Unlike the normal one it holds where all or none
    succeed.
    """
    n = len(values)
    if not n:
        return Estimate(math.nan, math.nan, math.nan)
    p = math.fsum(values) / n
    # p (1 - p) is the variance of successes and failures, and the largest that any values from 0 to
    # 1 with this mean can have (R. Bhatia and C. Davis, A better bound on the variance, American
    # Mathematical Monthly 107, 2000): of shares between, the interval is rather too wide.
    middle = (p + _Z**2 / (2 * n)) / (1 + _Z**2 / n)
    half = _Z / (1 + _Z**2 / n) * math.sqrt(p * (1 - p) / n + _Z**2 / (4 * n**2))
    # Where all or none succeed the interval ends at p, but for rounding.
    return Estimate(p, max(0.0, min(p, middle - half)), min(1.0, max(p, middle + half)))


def median(values: Sequence[float]) -> Estimate:
    """Return the median, with the interval between two of the sorted values.

    How many of n values lie below the true median is binomial with n and 1/2, whatever they are
    distributed like: H. A. David and H. N. Nagaraja, Order statistics, 3rd edition 2003, 7.1. Of
    fewer than six values no two are far enough apart: it is then from -inf to inf.
    """
    ordered = np.sort(np.asarray(values, dtype=float))
    if not len(ordered) or np.isnan(ordered).any():
        return Estimate(math.nan, math.nan, math.nan)
    low, high = _ranks(len(ordered))
    return Estimate(
        _middle(ordered),
        float(ordered[low]) if low >= 0 else -math.inf,
        float(ordered[high]) if low >= 0 else math.inf,
    )


def by_question(attempts: Iterable[Attempt], values: Iterable[_Value]) -> list[list[_Value]]:
    """Return the values of each question, in the order that the questions were asked."""
    groups: dict[int, list[_Value]] = {}
    for attempt, value in zip(attempts, values, strict=True):
        groups.setdefault(attempt.asked.query, []).append(value)
    return list(groups.values())


def success_over_time(attempts: Sequence[Attempt]) -> Curve:
    """Return the share of the questions for which there was a path after so many seconds."""
    first = [a.first_seconds if a.right else math.inf for a in attempts]
    seconds = _instants(first)
    questions = by_question(attempts, first)
    shares = [
        share([sum(one <= t for one in question) / len(question) for question in questions])
        for t in seconds
    ]
    return _curve(seconds, shares)


def cost_over_time(attempts: Sequence[Attempt]) -> Curve:
    """Return the median of the best length so far over the shortest, after so many seconds.

    A question without a path so far counts as infinitely long, so that no planner gains by
    answering only the easy ones: J. D. Gammell, M. P. Strub and V. N. Hartmann, Planner Developer
    Tools (PDT), 2022. Those that no path answers are left out.
    """
    attempts = [attempt for attempt in attempts if attempt.asked.shortest != math.inf]
    seconds = _instants(one.cpu_seconds for a in attempts for one in a.progress)
    if not len(seconds):
        return _curve(seconds, [])
    ratios = by_question(attempts, [_ratios(attempt, seconds) for attempt in attempts])
    per_question = np.array([[_middle(c) for c in np.sort(runs, axis=0).T] for runs in ratios])
    return _curve(seconds, [median(column) for column in per_question.T])


MOST_INSTANTS = 120
"""So many points a curve has at most."""


def _instants(times: Iterable[float]) -> Floats:
    """Return finite times, sorted; of many those that part them evenly."""
    finite = np.unique([t for t in times if math.isfinite(t)])
    if len(finite) > MOST_INSTANTS:
        finite = finite[np.linspace(0, len(finite) - 1, MOST_INSTANTS).astype(int)]
    return finite.astype(float)


def _ratios(attempt: Attempt, seconds: Floats) -> Floats:
    """Return the best length over the shortest after each of `seconds`; infinite without one."""
    times = [one.cpu_seconds for one in attempt.progress] if attempt.right else []
    shortest = attempt.asked.shortest
    lengths = [one.length / shortest if shortest else 1.0 for one in attempt.progress]
    best = np.array([math.inf, *lengths[: len(times)]])
    return best[np.searchsorted(times, seconds, side="right")]


def _curve(seconds: Floats, estimates: Sequence[Estimate]) -> Curve:
    figures = np.array([(e.value, e.low, e.high) for e in estimates]).reshape(-1, 3)
    return Curve(seconds, *figures.T)


def _middle(ordered: Floats) -> float:
    """Return the median of sorted values, which may be infinite."""
    low, high = float(ordered[(len(ordered) - 1) // 2]), float(ordered[len(ordered) // 2])
    return low if low == high else (low + high) / 2


@cache
def _ranks(n: int) -> tuple[int, int]:
    """Return the places (from 0) of the ends of the interval; -1 where there are too few."""
    # The true median is below the value at the place k (from 0) if at most k of the n lie below it.
    # The innermost place at which that has a probability of at most 2.5 % is the lower end; the
    # upper one mirrors it.
    below = 0.0
    for k in range(n):
        below += math.comb(n, k) / 2**n
        if below > (1 - CONFIDENCE) / 2:
            return k - 1, n - k
    return -1, n
