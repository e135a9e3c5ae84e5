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


def of_bounds(found: float, bounds: Sequence[tuple[str, float]]) -> float:
    """Return the slack of a number within bounds: pairs of a comparison sign and a number."""
    return min(_of_bound(found, sign, bound) for sign, bound in bounds)


def _of_bound(found: float, sign: str, bound: float) -> float:
    whole = isinstance(found, int) and float(bound).is_integer()
    if sign == "==":
        return -abs(found - bound) or 0.0
    if sign == "!=":
        return abs(found - bound) or (-1.0 if whole else -math.ulp(bound))
    above = sign.startswith(">")
    if sign in (">", "<"):
        # The nearest number that meets the bound: the next integer or float.
        step = 1.0 if above else -1.0
        bound = bound + step if whole else math.nextafter(bound, math.inf * step)
    return found - bound if above else bound - found


def of_flag(met: bool) -> float:
    """Return the slack of a condition: 1 if it holds, otherwise -1."""
    return 1.0 if met else -1.0


def of_visits(found: Sequence[str], stations: Sequence[str], how: str) -> float:
    """Return the slack of visits: minus the number of wrong and missing visits."""
    if how == "never":
        return -float(sum(name in stations for name in found)) or 0.0
    if how == "in_order":
        visits = iter(found)
        came = itertools.takewhile(lambda name: any(name == one for one in visits), stations)
        return float(sum(1 for _ in came) - len(stations))
    if how == "begin_with":
        found = found[: len(stations)]
    pairs = itertools.zip_longest(stations, found)
    return -float(sum(wanted != visit for wanted, visit in pairs)) or 0.0


def signed(slack: float, *, met: bool) -> float:
    """Return a slack with the sign of its verdict.

    An ignored short state may come nearer to a bound than the verdict says.
    """
    return max(slack, 0.0) if met else min(slack, SMALLEST)
