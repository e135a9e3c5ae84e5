"""Work of people: tasks, lists of them, and the times in which they are done."""

from __future__ import annotations

import math
from dataclasses import dataclass
from random import Random
from typing import Literal

Kind = Literal["fixed", "uniform", "triangular", "normal", "lognormal", "exponential"]

SHORTEST = 0.1
"""Seconds. Draws that are shorter count as this long."""


@dataclass(frozen=True)
class Duration:
    """Length of a task in seconds, fixed or drawn.

    `values` are the seconds if fixed; [low, high] if uniform; [low, most likely, high] if
    triangular; [mean, standard deviation] if normal; [median, standard deviation of the
    logarithm] if lognormal; the mean if exponential. No draw is shorter than `SHORTEST`.
    """

    kind: Kind
    values: tuple[float, ...]

    @property
    def mean(self) -> float:
        """The length (seconds) that is usual: the mean, or of a lognormal one the median."""
        values = self.values
        if self.kind == "fixed":
            return values[0]
        usual = sum(values) / len(values) if self.kind in ("uniform", "triangular") else values[0]
        return max(usual, SHORTEST)

    def draw(self, random: Random) -> float:
        """Return a length (seconds), drawn from `random` unless it is fixed."""
        values = self.values
        if self.kind == "fixed":
            return values[0]
        if self.kind == "uniform":
            drawn = random.uniform(values[0], values[1])
        elif self.kind == "triangular":
            drawn = random.triangular(values[0], values[2], values[1])
        elif self.kind == "normal":
            drawn = random.normalvariate(values[0], values[1])
        elif self.kind == "lognormal":
            drawn = random.lognormvariate(math.log(values[0]), values[1])
        else:
            drawn = random.expovariate(1 / values[0])
        return max(drawn, SHORTEST)


@dataclass(frozen=True)
class WorkTask:
    """Something to do at the station `at`.

    It is there from `time` (seconds) on. With `every` it comes again every so many seconds, `count`
    times in all, or until the end. Those of a higher `priority` are offered first.
    """

    at: str
    duration: Duration
    name: str = ""
    time: float = 0.0
    priority: int = 0
    every: float | None = None
    count: int | None = None

    @property
    def label(self) -> str:
        """Its name, or that of its station where it has none."""
        return self.name or self.at


@dataclass(frozen=True)
class WorkList:
    """Tasks that people share; with `repeat` each is there again as soon as it is done."""

    tasks: tuple[WorkTask, ...]
    repeat: bool = False


Shift = tuple[float, float]
"""Begin and end, seconds."""


class Instant(float):
    """Seconds of a trial that were given as a time of day, which is the text `given`."""

    given: str

    def __new__(cls, seconds: float, given: str = "") -> Instant:
        """Return the seconds with their text."""
        made = super().__new__(cls, seconds)
        made.given = given
        return made


def as_given(time: float) -> str:
    """Return an instant of a trial as its file has it: a time of day, or seconds."""
    return time.given if isinstance(time, Instant) else f"{time:,.12g} s"
