"""Evaluations of a search: points, results and distinct cases."""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Mapping, Sequence
from typing import Any, Literal

from floorplan.files.dataclass import dataclass

from ..runs.run import Run
from ..studies.running import figures_of
from ..studies.table import Record, plain
from .objective import Objective, Situation, failure_in_words, makes_no_trial
from .space import Dimension, Point

Result = Literal["run", "error", "no trial"]
"""Result of a trial: a run, an error of custom code, or values that make no trial."""

SITUATION = ("worst.person", "worst.machine", "worst.time", "worst.x", "worst.y")
"""Columns of a situation."""

ALIKE = 2.0
"""Metres. Two situations of one person and machine are distinct if they are farther apart."""

APART = 0.25
"""Minimum difference of points without a situation: root mean square share of each dimension."""

Found = dict[str, Any]
"""Outcome of a run: result, value, error, situation, and figures."""


@dataclass(frozen=True)
class Evaluation:
    """One evaluation: its number, its point, how that was chosen, and its result.

    `value` is the value of the objective, None if there is none.
    """

    number: int
    point: Point
    is_random: bool
    values: Mapping[str, Any]
    result: Result
    value: float | None
    situation: Situation

    @property
    def rank(self) -> float:
        """The value for sorting: errors first, runs without a value last."""
        if self.result == "error":
            return -math.inf
        return math.inf if self.value is None else self.value

    def is_break(self, objective: Objective) -> bool:
        """Return True if it breaks the objective."""
        return self.result == "error" or objective.is_broken_by(self.value)


class Keep:
    """Reduces a run to its outcome for the search, in the process of the run."""

    def __init__(self, objective: Objective) -> None:
        self._objective = objective

    def __call__(self, run: Run) -> Found:
        """Return the outcome of a run."""
        situation = self._objective.situation(run)
        value = self._objective.value(run)
        left: Found = {
            "result": "run",
            "error": None,
            "value": value,
            **{key: getattr(situation, key.removeprefix("worst.")) for key in SITUATION},
            "figures": {k: v for k, v in figures_of(run).items() if k != "error"},
        }
        return left


def failed(why: Exception) -> Found:
    """Return the outcome of a trial that raised an error."""
    result: Result = "no trial" if makes_no_trial(why) else "error"
    nothing: Found = {"value": None, **dict.fromkeys(SITUATION)}
    return {"result": result, "error": failure_in_words(why), **nothing, "figures": {}}


def evaluation_of(
    number: int, point: Point, values: Mapping[str, Any], outcome: Found, *, is_random: bool
) -> Evaluation:
    """Return the evaluation of an outcome, which may come from a table."""
    situation = Situation(
        person=outcome["worst.person"] or "",
        machine=outcome["worst.machine"] or "",
        time=outcome["worst.time"],
        x=outcome["worst.x"],
        y=outcome["worst.y"],
        error=outcome["error"] or "",
    )
    return Evaluation(
        number, point, is_random, values, outcome["result"], outcome["value"], situation
    )


def record(one: Evaluation, outcome: Found) -> Record:
    """Return the row of an evaluation."""
    line: Record = {"row": one.number, "sampled": "random" if one.is_random else "sampler"}
    line |= {name: plain(value) for name, value in one.values.items()}
    line |= {key: outcome[key] for key in ("result", "error", "value", *SITUATION)}
    line |= outcome["figures"]
    return line


def distinct(
    tried: Iterable[Evaluation],
    dimensions: Sequence[Dimension],
    most: int,
) -> list[Evaluation]:
    """Return the worst evaluations that differ from each other, the worst first."""
    chosen: list[Evaluation] = []
    for one in sorted(tried, key=lambda one: (one.rank, one.number)):
        if len(chosen) == most:
            break
        if not any(_alike(one, other, dimensions) for other in chosen):
            chosen.append(one)
    return chosen


def _alike(one: Evaluation, other: Evaluation, dimensions: Sequence[Dimension]) -> bool:
    a, b = one.situation, other.situation
    if a.error or b.error:
        # Errors that differ only in numbers, for example the time, are the same failure.
        return re.sub(r"[\d.]+", "", a.error) == re.sub(r"[\d.]+", "", b.error)
    if (a.person, a.machine) != (b.person, b.machine):
        return False
    if a.x is not None and a.y is not None and b.x is not None and b.y is not None:
        return math.dist((a.x, a.y), (b.x, b.y)) <= ALIKE
    off = [
        float(one.point[d.name] != other.point[d.name])
        if d.values
        else d.share(one.point[d.name]) - d.share(other.point[d.name])
        for d in dimensions
    ]
    return math.sqrt(sum(x * x for x in off) / len(off)) <= APART


def upper_bound(broken: int, count: int, confidence: float = 0.95) -> float:
    """Return the one-sided upper confidence limit of the rate of breaking.

    C. J. Clopper and E. S. Pearson, "The use of confidence or fiducial limits illustrated in the
    case of the binomial", Biometrika 26, 1934. At this rate, at most `broken` of `count`
    independent trials break with probability 1 - `confidence`.
    """
    if broken >= count:
        return 1.0
    low, high = broken / count, 1.0
    for _ in range(60):
        middle = (low + high) / 2
        if _at_most(broken, count, middle) > 1 - confidence:
            low = middle
        else:
            high = middle
    return high


def _at_most(broken: int, count: int, rate: float) -> float:
    """Return the probability that at most `broken` of `count` trials break at this rate."""
    if rate >= 1.0:
        return 0.0
    logs = (
        math.lgamma(count + 1)
        - math.lgamma(k + 1)
        - math.lgamma(count - k + 1)
        + k * math.log(rate or 5e-324)
        + (count - k) * math.log1p(-rate)
        for k in range(broken + 1)
    )
    return math.fsum(map(math.exp, logs))
