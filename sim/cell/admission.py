"""Admission of values from outside: the one place that rejects what must not enter."""

from __future__ import annotations

import math
from collections.abc import Callable, Hashable, Iterator, Mapping, Sequence
from dataclasses import fields, is_dataclass
from typing import Any, TypeVar

import numpy as np

from floorplan import UserError
from floorplan.files.fields import LARGEST
from navigation import PlanningError

from .pace import Pace
from .values import Pose

MOST_COMMANDS = 300
"""Number of values that one command or task accepts within `PERIOD`."""

PERIOD = 0.5
"""Seconds of simulated time."""

LONGEST_SHOWN = 80
"""Characters of a value in a message."""

RECENT = 1.0
"""Seconds. Two sources of one command within this time are reported."""


class Rejected(UserError):  # noqa: N818 (what a client reads)
    """A value that a command or task rejects.

    Parameters
    ----------
    name : str
        Name of the command or task, or of its topic.
    value : object
        The value.
    reason : str
        The fault, and a valid value.
    """

    def __init__(self, name: str, value: object, reason: str) -> None:
        super().__init__(f"{name} {_shown(value)}: {reason}")
        self.name = name
        self.value = value
        self.reason = reason

    def named(self, name: str) -> Rejected:
        """Return the error with another name for the command or task."""
        return Rejected(name, self.value, self.reason)


class Notices:
    """Passes lines on to the user: one of each kind, and at most `MOST`."""

    MOST = 20

    def __init__(self, notice: Callable[[str], None]) -> None:
        self._notice = notice
        self._kinds: set[Hashable] = set()

    def add(self, line: str, kind: Hashable = None) -> None:
        """Pass a line on, unless it or another line of its kind was passed on before."""
        kind = kind or line
        if kind not in self._kinds and len(self._kinds) < self.MOST:
            self._kinds.add(kind)
            self._notice(line)


Outcome = TypeVar("Outcome")


class Admission:
    """Admits values of commands and goals of tasks.

    It rejects numbers that are not finite or too large, more than `MOST_COMMANDS` values within
    `PERIOD`, and everything after the end. `notice(text)` gets one line for each kind of fault.
    """

    def __init__(self, pace: Pace, notice: Callable[[str], None]) -> None:
        self._notices = Notices(notice)
        self._counts: dict[str, tuple[int, int]] = {}
        self._sources: dict[str, tuple[str, float]] = {}
        self._pace = pace
        self.catch_up: Callable[[], None] = pace.catch_up
        """Brings simulated time up to date, so that a value takes effect when it arrives."""

    def admit(self, name: str, value: object, source: str = "") -> None:
        """Admit a value at the present time.

        Parameters
        ----------
        name : str
            Name of the command or task.
        value : object
            Value.
        source : str, optional
            Name of the client. Two clients of one command are reported once, and the last one wins.

        Raises
        ------
        Rejected
            If the value must not enter.
        """
        for number in _numbers(value):
            if not abs(number) <= LARGEST:
                reason = f"numbers must be finite and at most {LARGEST:g}, not {_shown(number)}"
                raise self.rejected(name, value, reason)
        if not self._pace.over:
            self.catch_up()
        if self._pace.over:
            raise self.rejected(name, value, "the run is over")
        now = self._pace.now
        period, count = self._counts.get(name, (0, 0))
        this = math.floor(now / PERIOD)
        self._counts[name] = this, count = this, count + 1 if period == this else 1
        if count > MOST_COMMANDS:
            reason = f"more than {MOST_COMMANDS} commands at t = {now:g} s; not done"
            raise self.rejected(name, value, reason)
        self._check_source(name, source)

    def rejected(self, name: str, value: object, reason: str) -> Rejected:
        """Return the error for a value, and notify the user once for each name and reason."""
        why = Rejected(name, value, reason)
        self._notices.add(str(why), (name, reason.partition(" at t = ")[0]))
        return why

    def carry_out(
        self, name: str, value: Any, source: str, action: Callable[[Any], Outcome]
    ) -> Outcome:
        """Admit a value and carry it out. `Rejected` if that is impossible."""
        self.admit(name, value, source)
        try:
            return action(value)
        except (ValueError, TypeError, PlanningError) as why:
            reason = why.message if isinstance(why, PlanningError) else str(why)
            raise self.rejected(name, value, reason) from why

    def _check_source(self, name: str, source: str) -> None:
        before, at = self._sources.get(name, (source, 0.0))
        self._sources[name] = source, self._pace.now
        if source and before and source != before and abs(self._pace.now - at) <= RECENT:
            text = f"{name} is commanded by {before} and {source}; the last one counts"
            self._notices.add(text, (name, "sources"))


def _numbers(value: object) -> Iterator[float]:
    """Yield all numbers in a value."""
    if isinstance(value, bool | str | bytes):
        return
    if isinstance(value, int | float | np.number):
        yield value if isinstance(value, int) else float(value)
    elif isinstance(value, np.ndarray):
        yield from value.ravel().tolist()
    elif is_dataclass(value) and not isinstance(value, type):
        for field in fields(value):
            yield from _numbers(getattr(value, field.name))
    elif isinstance(value, Mapping):
        yield from (number for one in value.values() for number in _numbers(one))
    elif isinstance(value, Sequence):
        yield from (number for one in value for number in _numbers(one))


def _shown(value: object) -> str:
    """Return a value in short form, on one line."""
    if isinstance(value, Pose):
        text = _shown((value.x, value.y, value.heading))
    elif isinstance(value, int) and abs(value) > LARGEST:
        text = "an integer that is too large"  # Python does not print all of them
    elif isinstance(value, tuple | list) and len(value) <= 3:
        text = f"({', '.join(map(_shown, value))})"
    else:
        text = f"{value:g}" if isinstance(value, float) else " ".join(str(value).split())
    return text if len(text) <= LONGEST_SHOWN else f"{text[: LONGEST_SHOWN - 1]}…"
