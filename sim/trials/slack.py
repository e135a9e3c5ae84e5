"""Slack of expectations: signed distances from not meeting them, in their units.

A slack is negative exactly if the expectation is not met, and minus infinity if there is nothing to
compare.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence

NOTHING = -math.inf
"""Slack of an expectation of a value that the run does not have."""

SMALLEST = -1e-9
"""Slack of an expectation that is missed by an unmeasurably small amount."""


def of_bounds(value: float, bounds: Sequence[tuple[str, float]]) -> float:
    """Return the slack of a number within bounds: pairs of a comparison sign and a number."""
    return min(_of_bound(value, sign, bound) for sign, bound in bounds)


def _of_bound(value: float, sign: str, bound: float) -> float:
    whole = isinstance(value, int) and float(bound).is_integer()
    if sign == "==":
        return -abs(value - bound) or 0.0
    if sign == "!=":
        return abs(value - bound) or (-1.0 if whole else -math.ulp(bound))
    above = sign.startswith(">")
    if sign in (">", "<"):
        # The nearest number that meets the bound: the next integer or float.
        step = 1.0 if above else -1.0
        bound = bound + step if whole else math.nextafter(bound, math.inf * step)
    return value - bound if above else bound - value


def of_flag(met: bool) -> float:
    """Return the slack of a condition: 1 if it holds, otherwise -1."""
    return 1.0 if met else -1.0


def of_visits(visited: Sequence[str], stations: Sequence[str], how: str) -> float:
    """Return the slack of visits: minus the number of wrong and missing visits."""
    if how == "never":
        return -float(sum(name in stations for name in visited)) or 0.0
    if how == "in_order":
        visits = iter(visited)
        came = itertools.takewhile(lambda name: any(name == one for one in visits), stations)
        return float(sum(1 for _ in came) - len(stations))
    if how == "begin_with":
        visited = visited[: len(stations)]
    pairs = itertools.zip_longest(stations, visited)
    return -float(sum(station != visit for station, visit in pairs)) or 0.0


def signed(slack: float, *, met: bool) -> float:
    """Return a slack with the sign of its verdict.

    An ignored short state may come nearer to a bound than the verdict says.
    """
    return max(slack, 0.0) if met else min(slack, SMALLEST)
