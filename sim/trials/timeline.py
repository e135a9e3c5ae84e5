"""Expectations over time: what must never, always or at some time happen, and in which order.

The patterns are those of M. B. Dwyer, G. S. Avrunin and J. C. Corbett, "Patterns in property
specifications for finite-state verification", 1999: absence (never), universality (always),
existence (eventually) and response (whenever … then), each within a scope (after, before, within).
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Literal

from floorplan import UserError, is_figure, suggestion

from ..core.scenario import Scenario
from ..record.outcome import Outcome
from .comparison import Comparison, Verdict
from .occurrences import (
    EventPattern,
    Occurrence,
    read_event,
    read_occurrence,
    read_state,
)

INSTANT = 1e-6
"""Seconds. A state that lasts no longer than this counts neither as being so nor as a gap."""

Moment = tuple[float, float]
"""A time (seconds), and which of the run's events come before: those with a lower number."""

_FORMS: dict[str, set[str]] = {
    "never": {"after", "before", "within"},
    "always": {"after", "before", "within"},
    "eventually": {"after", "before", "within", "times"},
    "whenever": {"after", "before", "within", "then"},
}


@dataclass(frozen=True)
class Window:
    """The part of a run that a statement is about.

    From the time `after` (seconds) or just after the first such event, to the time `before` or
    just before the first such event from there on, and at most `within` seconds long.
    """

    after: float | EventPattern = 0.0
    before: float | EventPattern = math.inf
    within: float = math.inf

    def of(self, run: Outcome) -> tuple[Moment, Moment]:
        """Its begin and end; `ValueError` says why the run has no such part."""
        if isinstance(self.after, EventPattern):
            first = next(self.after.found(run), None)
            if first is None:
                raise UserError(f"{self.after} never happened")
            begin: Moment = (first[1]["t"], float(first[0]))
        else:
            begin = (self.after, -1.0)
            if self.after >= run.duration:
                raise UserError(f"the run ended at t = {run.duration:.3f} s")
        end: Moment = (min(run.duration, begin[0] + self.within), math.inf)
        if isinstance(self.before, EventPattern):
            ends = ((e["t"], float(k)) for k, e in self.before.found(run))
            return begin, min(end, next((m for m in ends if m > begin), end))
        if self.before < begin[0]:
            raise UserError(f"{self.after} happened at t = {begin[0]:.3f} s only")
        return begin, min(end, (self.before, math.inf))

    def __str__(self) -> str:
        parts = []
        if self.after != 0.0:
            parts.append(f"after {_moment(self.after)}")
        if self.before != math.inf:
            parts.append(f"before {_moment(self.before)}")
        if self.within != math.inf:
            parts.append(f"within {self.within:g} s")
        return "".join(f" {part}" for part in parts)


@dataclass(frozen=True)
class Statement:
    """One expectation over time: `what` never, always or eventually within `window`.

    `whenever` asks that each event that matches `trigger` is followed by `what` within a time.
    """

    form: Literal["never", "always", "eventually", "whenever"]
    what: Occurrence
    window: Window
    times: Comparison | None = None
    trigger: EventPattern | None = None
    delay: float = math.inf

    def check(self, run: Outcome) -> Verdict:
        """Return whether it holds in `run`."""
        try:
            window = self.window.of(run)
        except UserError as why:
            return Verdict(str(self), str(why), False)
        if self.form == "whenever":
            return self._answered(run, *window)
        if self.form == "always":
            gap = self._gap(run, *window)
            found = "so all the time" if gap is None else f"not so at t = {gap:.3f} s"
            return Verdict(str(self), found, gap is None, gap)
        times = self._times(run, *window)
        first = times[0] if times else None
        if self.form == "never":
            return Verdict(str(self), _listed(times), not times, first)
        met = self.times.passes(len(times)) if self.times else bool(times)
        return Verdict(str(self), _listed(times), met, first)

    def _times(self, run: Outcome, begin: Moment, end: Moment) -> list[float]:
        """Return when it happens, or begins to hold, between two moments."""
        if isinstance(self.what, EventPattern):
            return [e["t"] for k, e in self.what.found(run) if begin < (e["t"], k) < end]
        parts = [(max(b, begin[0]), min(e, end[0])) for b, e in self.what.intervals(run)]
        return [since for since, until in parts if until - since > INSTANT]

    def _gap(self, run: Outcome, begin: Moment, end: Moment) -> float | None:
        """Return when a state first fails to hold, between two moments."""
        assert not isinstance(self.what, EventPattern)
        since = begin[0]
        for lower, upper in [*self.what.intervals(run), (end[0], math.inf)]:
            if min(lower, end[0]) - since > INSTANT:
                return since
            since = max(since, upper)
        return None

    def _answered(self, run: Outcome, begin: Moment, end: Moment) -> Verdict:
        assert self.trigger is not None
        answered = 0
        for k, event in self.trigger.found(run):
            moment: Moment = (event["t"], float(k))
            if not begin < moment < end:
                continue
            until = event["t"] + self.delay
            if not self._times(run, moment, (min(until, run.duration), math.inf)):
                if until > run.duration:
                    continue  # there is no telling what would have followed
                found = f"none followed {self.trigger.kind} at t = {event['t']:.3f} s"
                return Verdict(str(self), found, False, event["t"])
            answered += 1
        return Verdict(str(self), f"followed each of {answered}", True)

    def __str__(self) -> str:
        if self.trigger is not None:
            return f"whenever {self.trigger}, then {self.what} within {self.delay:g} s{self.window}"
        times = f" {self.times} times" if self.times else ""
        return f"{self.form} {self.what}{times}{self.window}"


def read_statement(written: Any, trial: Scenario) -> Statement:
    """The statement that `written` stands for; `ValueError` says what is wrong with it."""
    if not isinstance(written, Mapping):
        raise UserError(f"expected keys with one of {', '.join(_FORMS)} among them: {written!r}")
    (form, *others) = [key for key in _FORMS if key in written] or [""]
    if not form or others:
        raise UserError(f"expected exactly one of {', '.join(_FORMS)}, found {list(written)}")
    for key in written:
        if key != form and key not in _FORMS[form]:
            hint = suggestion(str(key), sorted(_FORMS[form]))
            raise UserError(f"{form!r} takes no {key!r}; {hint}")
    after = _scope("after", written.get("after", 0.0), trial)
    before = _scope("before", written.get("before", math.inf), trial)
    if isinstance(after, float) and isinstance(before, float) and after >= before:
        raise UserError(f"before: expected more than the {after:g} s of after, found {before:g}")
    within = _seconds("within", written["within"]) if "within" in written else math.inf
    if form == "whenever":
        if "then" not in written or "within" not in written:
            raise UserError("'whenever' needs then: what is to follow, and within: seconds")
        what = read_occurrence(written["then"], trial)
        trigger = read_event(written["whenever"], trial)
        window = Window(after, before)
        return Statement("whenever", what, window, trigger=trigger, delay=within)
    window = Window(after, before, within)
    what = (read_state if form == "always" else read_occurrence)(written[form], trial)
    if within <= INSTANT and not isinstance(what, EventPattern):
        raise UserError(f"within: a state lasts; expected more than {INSTANT:g} s")
    if form == "always":
        return Statement("always", what, window)
    if form == "never":
        return Statement("never", what, window)
    times = Comparison.parse(written["times"]) if "times" in written else None
    return Statement("eventually", what, window, times)


def _scope(key: str, written: Any, trial: Scenario) -> float | EventPattern:
    if isinstance(written, str | Mapping):
        return read_event(written, trial)
    return math.inf if written == math.inf and key == "before" else _seconds(key, written)


def _seconds(key: str, written: Any) -> float:
    if not (is_figure(written) and written >= 0):
        raise UserError(f"{key}: expected seconds, found {written!r}")
    return float(written)


def _moment(at: float | EventPattern) -> str:
    return f"{at:g} s" if isinstance(at, float) else str(at)


def _listed(times: list[float]) -> str:
    """Instants in words, the first few of them."""
    if not times:
        return "it never happened"
    shown = ", ".join(f"{t:.3f} s" for t in times[:3])
    return f"it happened at t = {shown}" + (f" and {len(times) - 3} more" * (len(times) > 3))
