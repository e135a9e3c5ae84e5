"""Comparisons: a number, `">= 1.0"`, `"> 1, < 2"`, or `"8.0 ± 0.1"`; and verdicts on them."""

from __future__ import annotations

import operator
import re
from collections.abc import Callable
from dataclasses import dataclass
from decimal import Decimal
from typing import Any

from floorplan import UserError, is_figure

_NUMBER = r"[-+]?(?:\d+(?:\.\d*)?|\.\d+)(?:[eE][-+]?\d+)?"
_BOUND = rf"\s*(<=|>=|==|!=|<|>)\s*({_NUMBER})\s*"
_TOLERANCE = rf"\s*({_NUMBER})\s*(?:±|\+/-)\s*({_NUMBER})\s*"
_OPERATORS: dict[str, Callable[[float, float], bool]] = {
    "<": operator.lt,
    "<=": operator.le,
    ">": operator.gt,
    ">=": operator.ge,
    "==": operator.eq,
    "!=": operator.ne,
}


@dataclass(frozen=True)
class Comparison:
    """A number passes if it passes every one of `bounds`; `text` is how it was written."""

    text: str
    bounds: tuple[tuple[str, float], ...]

    @staticmethod
    def parse(wanted: Any) -> Comparison:
        """Return the comparison that `wanted`, a number or text, stands for; else `ValueError`."""
        if is_figure(wanted):
            return Comparison(f"= {wanted}", (("==", wanted),))
        if isinstance(wanted, str):
            if tolerance := re.fullmatch(_TOLERANCE, wanted):
                middle, more = Decimal(tolerance[1]), Decimal(tolerance[2])
                if (
                    more >= 0 and is_figure(float(middle)) and is_figure(float(more))
                ):  # in decimals, for 0.7 + 0.1 is to be 0.8
                    return Comparison(
                        f"{tolerance[1]} ± {tolerance[2]}",
                        ((">=", float(middle - more)), ("<=", float(middle + more))),
                    )
            found = [re.fullmatch(_BOUND, part) for part in wanted.split(",")]
            bounds = tuple((bound[1], float(bound[2])) for bound in found if bound)
            if len(bounds) == len(found) and all(is_figure(bound) for _, bound in bounds):
                return Comparison(wanted.strip(), bounds)
        raise UserError(
            "expected a number or a comparison such as '>= 1.0', '> 1, < 2' or '8.0 ± 0.1',"
            f" found {wanted!r}"
        )

    def __str__(self) -> str:
        return self.text

    def passes(self, figure: float) -> bool:
        """Return whether `figure` is within all bounds."""
        return all(_OPERATORS[sign](figure, bound) for sign, bound in self.bounds)


@dataclass(frozen=True)
class Verdict:
    """Result of an expectation: `expected` and `found`, in words, and whether it was `met`.

    `time` is when it was decided (seconds), if at an instant. `place` are the keys under which the
    expectation stands in the trial file.
    """

    expected: str
    found: str
    met: bool
    time: float | None = None
    place: tuple[str | int, ...] = ()

    def __str__(self) -> str:
        return f"expected {self.expected}, but {self.found}"


def in_words(value: Any) -> str:
    """Return a value as files have it: true and false, and all digits of numbers."""
    return str(value).lower() if isinstance(value, bool) else str(value)
