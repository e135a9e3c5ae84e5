"""Expectations over time: comparisons, event patterns, and temporal statements.

The patterns are those of M. B. Dwyer, G. S. Avrunin and J. C. Corbett, "Patterns in property
specifications for finite-state verification", 1999: absence (never), universality (always),
existence (eventually) and response (whenever … then), each within a scope (after, before, within).
"""

from __future__ import annotations

import math
import operator
import re
from collections.abc import Callable, Iterator, Mapping
from dataclasses import KW_ONLY
from decimal import Decimal
from typing import Any, Literal, Protocol

from floorplan import UserError
from floorplan.files.dataclass import dataclass
from floorplan.files.fields import is_figure
from floorplan.files.problems import suggestion
from navigation import (
    FixedDistance,
    Motion,
    Moving,
    TooClose,
    minimum_separation,
    standing,
    when,
)

from ..core.events import EVENT_KINDS, Form
from ..core.recorder import Event
from ..core.scenario import Scenario
from ..core.wording import times
from ..record.outcome import Outcome
from . import slack
from .names import checked_name, event_kinds, known_names, machines, people

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
class NumberCondition:
    """Bounds of a number that must all hold, and their `text` in the file."""

    text: str
    bounds: tuple[tuple[str, float], ...]

    @staticmethod
    def parse(written: Any) -> NumberCondition:
        """Return the comparison of `written`, a number or text. `UserError` if it is invalid."""
        if is_figure(written):
            return NumberCondition(f"= {written}", (("==", written),))
        if isinstance(written, str):
            if tolerance := re.fullmatch(_TOLERANCE, written):
                middle, more = Decimal(tolerance[1]), Decimal(tolerance[2])
                if (
                    more >= 0 and is_figure(float(middle)) and is_figure(float(more))
                ):  # as decimals, so that 0.7 + 0.1 is 0.8
                    return NumberCondition(
                        f"{tolerance[1]} ± {tolerance[2]}",
                        ((">=", float(middle - more)), ("<=", float(middle + more))),
                    )
            matches = [re.fullmatch(_BOUND, part) for part in written.split(",")]
            bounds = tuple((bound[1], float(bound[2])) for bound in matches if bound)
            if len(bounds) == len(matches) and all(is_figure(bound) for _, bound in bounds):
                return NumberCondition(written.strip(), bounds)
        raise UserError(
            "expected a number or a comparison such as '>= 1.0', '> 1, < 2' or '8.0 ± 0.1',"
            f" found {written!r}"
        )

    def __str__(self) -> str:
        return self.text

    def passes(self, figure: float) -> bool:
        """Return whether `figure` is within all bounds."""
        return all(_OPERATORS[sign](figure, bound) for sign, bound in self.bounds)

    def slack(self, figure: float) -> float:
        """Return the distance of `figure` from leaving the bounds, negative outside."""
        if not isinstance(figure, int | float):
            return slack.NOTHING
        return slack.of_bounds(figure, self.bounds)


@dataclass(frozen=True)
class Verdict:
    """Result of an expectation: `expected` and `found` in words, and whether it was `met`.

    `slack` is the distance from not being met, in `unit`. It is negative exactly if it was not met.
    `time` (s) is the decisive instant, if there is one. `place` has the keys of the expectation in
    the trial file.
    """

    expected: str
    _: KW_ONLY
    found: str
    met: bool
    slack: float
    unit: str = ""
    time: float | None = None
    place: tuple[str | int, ...] = ()

    def __str__(self) -> str:
        return f"expected {self.expected}, but {self.found}"

    @property
    def slack_in_words(self) -> str:
        """Slack and its unit, or an empty text if there was nothing to compare."""
        if math.isinf(self.slack):
            return ""
        return f"{self.slack:.6g} {self.unit}".strip()


def in_words(value: Any) -> str:
    """Return a value in the form of files: true and false, and all digits of numbers."""
    return str(value).lower() if isinstance(value, bool) else str(value)


Interval = tuple[float, float]
"""Begin and end in seconds."""


class LastingState(Protocol):
    """State that holds during intervals."""

    def intervals(self, run: Outcome) -> list[Interval]:
        """Return the intervals in which it holds, in order of time."""
        ...


@dataclass(frozen=True)
class EventPattern:
    """Pattern of events of a kind, with conditions on their fields."""

    kind: str
    fields: tuple[tuple[str, Any], ...] = ()

    def matches(self, event: Event) -> bool:
        """Return whether `event` matches the pattern."""
        return event["kind"] == self.kind and all(
            _is(event.get(key), condition) for key, condition in self.fields
        )

    def found(self, run: Outcome) -> Iterator[tuple[int, Event]]:
        """Yield the matching events with their index in the run."""
        return ((k, event) for k, event in enumerate(run.events) if self.matches(event))

    def __str__(self) -> str:
        fields = ", ".join(f"{key} {in_words(condition)}" for key, condition in self.fields)
        return f"{self.kind} ({fields})" if fields else self.kind


@dataclass(frozen=True)
class Near:
    """State in which the centres of two bodies are nearer than `metres`, or not, if `apart`."""

    bodies: tuple[str, str]
    metres: float
    apart: bool = False

    def intervals(self, run: Outcome) -> list[Interval]:
        """See `LastingState`."""
        first, second = (run.motions[name] for name in self.bodies)
        near = list(when(TooClose(FixedDistance(self.metres)), first, second, 0.0, run.duration))
        return complement(near, run.duration) if self.apart else near

    def spare(self, run: Outcome, begin: float, end: float) -> float:
        """Return the minimum distance from `begin` to `end` (s) minus `metres`."""
        first, second = (run.motions[name] for name in self.bodies)
        return minimum_separation(first, second, begin, end)[1] - self.metres

    def __str__(self) -> str:
        first, second = self.bodies
        return f"{first} and {second} {'at least' if self.apart else 'within'} {self.metres:g} m"


@dataclass(frozen=True)
class Moves:
    """State in which a body moves faster than 0.01 m/s, or does not, if `not moving`."""

    body: str
    moving: bool = True

    def intervals(self, run: Outcome) -> list[Interval]:
        """See `LastingState`."""
        here: Motion = standing((0.0, 0.0))
        moves = list(when(Moving(), here, run.motions[self.body], 0.0, run.duration))
        return moves if self.moving else complement(moves, run.duration)

    def __str__(self) -> str:
        return f"{self.body} {'moving' if self.moving else 'standing'}"


Occurrence = EventPattern | Near | Moves


def complement(intervals: list[Interval], end: float) -> list[Interval]:
    """Return the intervals between 0 and `end` (s) outside the given intervals."""
    edges = [0.0, *(t for interval in intervals for t in interval), end]
    gaps = zip(edges[::2], edges[1::2], strict=True)
    return [(begin, end) for begin, end in gaps if end > begin]


def read_event(written: Any, trial: Scenario) -> EventPattern:
    """Return the event pattern of `written`. `UserError` if it is invalid."""
    if isinstance(written, str):
        written = {"kind": written}
    if not isinstance(written, Mapping) or "kind" not in written:
        raise UserError(f"expected a kind of event, or keys with kind among them: {written!r}")
    named = str(written["kind"])
    kind = checked_name(named, "kind of event", event_kinds(trial, named))
    if kind not in EVENT_KINDS:  # custom events are defined when the run begins
        return EventPattern(kind)
    forms = EVENT_KINDS[kind].forms
    fields = []
    for key, value in written.items():
        if key == "kind":
            continue
        if key not in forms:
            hint = suggestion(str(key), forms) if forms else "it has no fields"
            raise UserError(f"an event {kind!r} has no field {key!r}; {hint}")
        fields.append((key, _value(kind, key, forms[key], value, trial)))
    return EventPattern(kind, tuple(fields))


def read_occurrence(written: Any, trial: Scenario) -> Occurrence:
    """Return the event pattern or state of `written`. `UserError` if it is invalid."""
    if isinstance(written, Mapping) and "kind" not in written:
        return read_state(written, trial)
    return read_event(written, trial)


def read_state(written: Any, trial: Scenario) -> Near | Moves:
    """Return the state of `written`. `UserError` if it is invalid."""
    keys = set(written) if isinstance(written, Mapping) else set()
    for key, apart in (("near", False), ("apart", True)):
        if keys == {key, "metres"}:
            pair, metres = written[key], written["metres"]
            if not (isinstance(pair, list) and len(pair) == 2):
                raise UserError(f"{key}: expected the names of two bodies, found {pair!r}")
            first, second = (_body(name, trial) for name in pair)
            if first == second:
                raise UserError(f"{key}: expected two bodies, found {first!r} twice")
            if not (is_figure(metres) and metres > 0):
                raise UserError(f"metres: expected a number of more than 0, found {metres!r}")
            return Near((first, second), float(metres), apart)
    for key in ("moving", "standing"):
        if keys == {key}:
            return Moves(_body(written[key], trial), key == "moving")
    raise UserError(
        "expected a state: {near: [BODY, BODY], metres: M}, {apart: [BODY, BODY], metres: M},"
        f" {{moving: BODY}} or {{standing: BODY}}, found {written!r}"
    )


def _value(kind: str, key: str, form: Form, value: Any, trial: Scenario) -> Any:
    if form == "number":
        return NumberCondition.parse(value)
    if form == "flag":
        if not isinstance(value, bool):
            raise UserError(f"{key}: expected true or false, found {value!r}")
        return value
    if form in ("point", "list"):
        raise UserError(f"{key} of an event {kind!r} is a {form}; only single values are compared")
    if form == "location" and is_figure(value):
        return value
    names = known_names(trial, form)
    if names is not None:
        return checked_name(value, form, names)
    if not isinstance(value, str):
        raise UserError(f"{key}: expected text, found {value!r}")
    return value


def _body(name: Any, trial: Scenario) -> str:
    return checked_name(name, "body", [*people(trial), *machines(trial)])


def _is(value: Any, condition: Any) -> bool:
    if isinstance(condition, NumberCondition):
        return is_figure(value) and condition.passes(value)
    return bool(value == condition)


INSTANT = 1e-6
"""Seconds. Shorter states and shorter gaps between states are ignored."""

Moment = tuple[float, float]
"""Time (s) and number of the events before it."""

_FORMS: dict[str, set[str]] = {
    "never": {"after", "before", "within"},
    "always": {"after", "before", "within"},
    "eventually": {"after", "before", "within", "times"},
    "whenever": {"after", "before", "within", "then"},
}


@dataclass(frozen=True)
class Window:
    """Time span of a run to which a statement applies.

    It begins at the time `after` (s) or just after the first such event, and ends at the time
    `before` or just before the first such event after the begin. It lasts at most `within` seconds.
    """

    after: float | EventPattern = 0.0
    before: float | EventPattern = math.inf
    within: float = math.inf

    def of(self, run: Outcome) -> tuple[Moment, Moment]:
        """Return its begin and end. `UserError` if the run has no such span."""
        if isinstance(self.after, EventPattern):
            first = next(self.after.found(run), None)
            if first is None:
                raise UserError(f"{self.after} never happened")
            # Times of events are rounded, so that the last may be after the end.
            begin: Moment = (min(first[1]["t"], run.duration), float(first[0]))
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
    """Expectation over time: `what` never, always or eventually occurs within `window`.

    With `whenever`, each event that matches `trigger` must be followed by `what` within a time.
    """

    form: Literal["never", "always", "eventually", "whenever"]
    what: Occurrence
    _: KW_ONLY
    window: Window
    times: NumberCondition | None = None
    trigger: EventPattern | None = None
    delay: float = math.inf

    def check(self, run: Outcome) -> Verdict:
        """Return the verdict for `run`."""
        try:
            window = self.window.of(run)
        except UserError as why:
            return Verdict(str(self), found=str(why), met=False, slack=slack.NOTHING)
        if self.form == "whenever":
            return self._answered(run, *window)
        if self.form == "always":
            gap = self._gap(run, *window)
            result = "so all the time" if gap is None else f"not so at t = {gap:.3f} s"
            return self._verdict(run, window, result, gap is None, gap, 0)
        times = self._times(run, *window)
        first = times[0] if times else None
        if self.form == "never":
            met = not times
        else:
            met = self.times.passes(len(times)) if self.times else bool(times)
        return self._verdict(run, window, _listed(times), met, first, len(times))

    def _verdict(
        self,
        run: Outcome,
        window: tuple[Moment, Moment],
        result: str,
        met: bool,
        time: float | None,
        count: int,
    ) -> Verdict:
        """Return the verdict, with its slack."""
        (begin, _), (end, _) = window
        amount, unit = self._slack(run, begin, end, count)
        amount = slack.signed(amount, met=met)
        return Verdict(str(self), found=result, met=met, time=time, slack=amount, unit=unit)

    def _slack(self, run: Outcome, begin: float, end: float, count: int) -> tuple[float, str]:
        """Return the slack and its unit. It is a distance, a count or a duration."""
        what = self.what
        if isinstance(what, Near) and self.times is None and what.apart == (self.form == "always"):
            spare = what.spare(run, begin, end)
            return (-spare if self.form == "eventually" else spare), "m"
        if isinstance(what, EventPattern) or self.form == "eventually":
            condition = self.times or NumberCondition.parse(0 if self.form == "never" else ">= 1")
            return condition.slack(count), ""
        parts = ((max(b, begin), min(e, end)) for b, e in what.intervals(run))
        duration = sum(max(until - since, 0.0) for since, until in parts)
        return (-duration if self.form == "never" else duration - (end - begin)), "s"

    def _times(self, run: Outcome, begin: Moment, end: Moment) -> list[float]:
        """Return the times of the events or begins of the state between two moments."""
        if isinstance(self.what, EventPattern):
            return [e["t"] for k, e in self.what.found(run) if begin < (e["t"], k) < end]
        parts = [(max(b, begin[0]), min(e, end[0])) for b, e in self.what.intervals(run)]
        return [since for since, until in parts if until - since > INSTANT]

    def _gap(self, run: Outcome, begin: Moment, end: Moment) -> float | None:
        """Return the first time between two moments at which a state does not hold, or None."""
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
        least = self.delay
        missed: Event | None = None
        for k, event in self.trigger.found(run):
            moment: Moment = (event["t"], float(k))
            if not begin < moment < end:
                continue
            until = event["t"] + self.delay
            if self._times(run, moment, (min(until, run.duration), math.inf)):
                answered += 1
            elif until > run.duration:
                continue  # events after the end of the run are unknown
            elif missed is None:
                missed = event
            followed = self._times(run, moment, (run.duration, math.inf)) or [run.duration]
            least = min(least, until - followed[0])
        amount = slack.signed(least, met=missed is None)
        if missed is None:
            result = f"followed each of {answered}"
            return Verdict(str(self), found=result, met=True, slack=amount, unit="s")
        result = f"none followed {self.trigger.kind} at t = {missed['t']:.3f} s"
        return Verdict(str(self), found=result, met=False, time=missed["t"], slack=amount, unit="s")

    def __str__(self) -> str:
        if self.trigger is not None:
            return f"whenever {self.trigger}, then {self.what} within {self.delay:g} s{self.window}"
        times = f" {self.times} times" if self.times else ""
        return f"{self.form} {self.what}{times}{self.window}"


def read_statement(written: Any, trial: Scenario) -> Statement:
    """Return the statement of `written`. `UserError` if it is invalid."""
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
        return Statement("whenever", what, window=window, trigger=trigger, delay=within)
    window = Window(after, before, within)
    what = (read_state if form == "always" else read_occurrence)(written[form], trial)
    if within <= INSTANT and not isinstance(what, EventPattern):
        raise UserError(f"within: a state lasts; expected more than {INSTANT:g} s")
    if form == "always":
        return Statement("always", what, window=window)
    if form == "never":
        return Statement("never", what, window=window)
    times = NumberCondition.parse(written["times"]) if "times" in written else None
    return Statement("eventually", what, window=window, times=times)


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


def _listed(instants: list[float]) -> str:
    """Return times of events in words."""
    if not instants:
        return "it never happened"
    return f"it happened at t = {times(instants, 3)}"
