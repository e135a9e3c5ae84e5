"""Evaluations of a search: trials that were tried, and what came of each."""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Literal

from ..runs.run import Run
from ..studies.running import figures_of
from ..studies.table import Record, plain
from .objective import Objective, Situation, failure_in_words, makes_no_trial
from .space import Dimension, Point

Result = Literal["run", "error", "no trial"]
"""What came of a trial: a run, an error of somebody's code, or values that make no trial."""

SITUATION = ("worst.person", "worst.machine", "worst.time", "worst.x", "worst.y")
"""Columns of a situation."""

ALIKE = 2.0
"""Metres. Two situations of one person and machine are distinct if they are farther apart."""

APART = 0.25
"""Share of each dimension, root mean square, by which points differ where no place is known."""

Found = dict[str, Any]
"""What is left of a run: result, value, error, situation, and figures."""


@dataclass(frozen=True)
class Evaluation:
    """One evaluation: its number, its point, how that was chosen, and what came of it.

    `value` is that of the objective, None where there is none.
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
        """Return whether it breaks the objective."""
        return self.result == "error" or objective.is_broken_by(self.value)


class Keep:
    """Takes from a run what a search needs of it, in the process where it was run."""

    def __init__(self, objective: Objective) -> None:
        self._objective = objective

    def __call__(self, run: Run) -> Found:
        """Return what is left of a run."""
        found = self._objective.situation(run)
        value = self._objective.value(run)
        left: Found = {
            "result": "run",
            "error": None,
            "value": value,
            **{key: getattr(found, key.removeprefix("worst.")) for key in SITUATION},
            "figures": {k: v for k, v in figures_of(run).items() if k != "error"},
        }
        return left


def failed(why: Exception) -> Found:
    """Return what is left of a trial that raised an error."""
    result: Result = "no trial" if makes_no_trial(why) else "error"
    nothing: Found = {"value": None, **dict.fromkeys(SITUATION)}
    return {"result": result, "error": failure_in_words(why), **nothing, "figures": {}}


def evaluation_of(
    number: int, point: Point, values: Mapping[str, Any], found: Found, *, is_random: bool
) -> Evaluation:
    """Return an evaluation from what is left of its run, or from its line in a table."""
    situation = Situation(
        person=found["worst.person"] or "",
        machine=found["worst.machine"] or "",
        time=found["worst.time"],
        x=found["worst.x"],
        y=found["worst.y"],
        error=found["error"] or "",
    )
    return Evaluation(number, point, is_random, values, found["result"], found["value"], situation)


def record(one: Evaluation, found: Found) -> Record:
    """Return the line of an evaluation in the table."""
    line: Record = {"row": one.number, "sampled": "random" if one.is_random else "sampler"}
    line |= {name: plain(value) for name, value in one.values.items()}
    line |= {key: found[key] for key in ("result", "error", "value", *SITUATION)}
    line |= found["figures"]
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
        # Numbers in a message, as the time, make no other failure of it.
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
    """Return the greatest rate of breaking that is not ruled out, one-sided.

    C. J. Clopper and E. S. Pearson, "The use of confidence or fiducial limits illustrated in the
    case of the binomial", Biometrika 26, 1934: the rate at which no more than `broken` of `count`
    independent trials break with a probability of 1 - `confidence`.
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
