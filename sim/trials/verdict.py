"""What became of an expectation."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Verdict:
    """What was `expected` and what was `found`, in words; whether that is as expected.

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
