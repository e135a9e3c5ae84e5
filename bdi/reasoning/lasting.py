"""Answers that last: they follow from beliefs alone, so they are kept until one of these changes.

Programs ask the same of the same beliefs again and again, as for the station after this one.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import TypeAlias

from ..language.terms import Term, is_ground

Question: TypeAlias = "tuple[Term | None, ...]"
"""Arguments of a query: values without variables, and None for each variable."""

Values: TypeAlias = "tuple[Term, ...]"
"""Values of the variables of a query, in one of its answers."""


class KeptAnswers:
    """Answers of a `source` to one question, found out as far as anybody has asked for them.

    `failures` is asked how many internal actions have failed.
    """

    def __init__(self, source: Iterator[Values], failures: Callable[[], int]) -> None:
        self.lasts = True
        """False once it turns out that they have to be found out anew the next time."""
        self._source = source
        self._failures = failures
        self._found: list[Values] = []

    def __iter__(self) -> Iterator[Values]:
        at = 0
        while at < len(self._found) or self._find_another():
            yield self._found[at]
            at += 1

    def _find_another(self) -> bool:
        """Find the next answer; return whether there is one."""
        before, lasts, self.lasts = self._failures(), self.lasts, False
        values = next(self._source, None)  # if this raises, they do not last
        # A failure is reported each time, and variables are other ones each time.
        self.lasts = lasts and self._failures() == before
        if values is None:
            return False
        self.lasts = self.lasts and all(map(is_ground, values))
        self._found.append(values)
        return True
