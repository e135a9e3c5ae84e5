"""Events and lasting states of a run, as expectations write them."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any, Protocol

from floorplan import UserError, is_figure, suggestion
from navigation import FixedDistance, Motion, Moving, TooClose, standing, when

from ..core.events import EVENT_KINDS, Form
from ..core.recorder import Event
from ..core.scenario import Scenario
from ..record.outcome import Outcome
from .comparison import Comparison, in_words
from .names import checked_name, known_names, machines, people
from .own_events import event_kinds

Interval = tuple[float, float]
"""From when to when, seconds."""


class State(Protocol):
    """Something that holds for a while."""

    def intervals(self, run: Outcome) -> list[Interval]:
        """Return when it holds, in order of time."""
        ...


@dataclass(frozen=True)
class EventPattern:
    """Events of a kind whose fields are as they should be."""

    kind: str
    fields: tuple[tuple[str, Any], ...] = ()

    def matches(self, event: Event) -> bool:
        """Return whether `event` is one of these."""
        return event["kind"] == self.kind and all(
            _is(event.get(key), wanted) for key, wanted in self.fields
        )

    def found(self, run: Outcome) -> Iterator[tuple[int, Event]]:
        """Yield the events that match, with their number among all events of the run."""
        return ((k, event) for k, event in enumerate(run.events) if self.matches(event))

    def __str__(self) -> str:
        fields = ", ".join(f"{key} {in_words(wanted)}" for key, wanted in self.fields)
        return f"{self.kind} ({fields})" if fields else self.kind


@dataclass(frozen=True)
class Near:
    """The centres of two bodies are nearer than `metres` to each other; or not, if `apart`."""

    bodies: tuple[str, str]
    metres: float
    apart: bool = False

    def intervals(self, run: Outcome) -> list[Interval]:
        """See `State`."""
        first, second = (run.motions[name] for name in self.bodies)
        near = list(when(TooClose(FixedDistance(self.metres)), first, second, 0.0, run.duration))
        return complement(near, run.duration) if self.apart else near

    def __str__(self) -> str:
        first, second = self.bodies
        return f"{first} and {second} {'at least' if self.apart else 'within'} {self.metres:g} m"


@dataclass(frozen=True)
class Moves:
    """A body moves, faster than 0.01 m/s; or stands, if `not moving`."""

    body: str
    moving: bool = True

    def intervals(self, run: Outcome) -> list[Interval]:
        """See `State`."""
        here: Motion = standing((0.0, 0.0))
        moves = list(when(Moving(), here, run.motions[self.body], 0.0, run.duration))
        return moves if self.moving else complement(moves, run.duration)

    def __str__(self) -> str:
        return f"{self.body} {'moving' if self.moving else 'standing'}"


Occurrence = EventPattern | Near | Moves


def complement(intervals: list[Interval], end: float) -> list[Interval]:
    """Return the time between 0 and `end` that is in none of the intervals."""
    edges = [0.0, *(t for interval in intervals for t in interval), end]
    gaps = zip(edges[::2], edges[1::2], strict=True)
    return [(begin, end) for begin, end in gaps if end > begin]


def read_event(written: Any, trial: Scenario) -> EventPattern:
    """Return the events that `written` stands for; `ValueError` says what is wrong with it."""
    if isinstance(written, str):
        written = {"kind": written}
    if not isinstance(written, Mapping) or "kind" not in written:
        raise UserError(f"expected a kind of event, or keys with kind among them: {written!r}")
    named = str(written["kind"])
    kind = checked_name(named, "kind of event", event_kinds(trial, named))
    if kind not in EVENT_KINDS:  # its fields are read once it is defined, as the run begins
        return EventPattern(kind)
    forms = EVENT_KINDS[kind].forms
    fields = []
    for key, wanted in written.items():
        if key == "kind":
            continue
        if key not in forms:
            hint = suggestion(str(key), forms) if forms else "it has no fields"
            raise UserError(f"an event {kind!r} has no field {key!r}; {hint}")
        fields.append((key, _value(kind, key, forms[key], wanted, trial)))
    return EventPattern(kind, tuple(fields))


def read_occurrence(written: Any, trial: Scenario) -> Occurrence:
    """Return the event or state that `written` stands for; `ValueError` says what is wrong."""
    if isinstance(written, Mapping) and "kind" not in written:
        return read_state(written, trial)
    return read_event(written, trial)


def read_state(written: Any, trial: Scenario) -> Near | Moves:
    """Return the state that `written` stands for; `ValueError` says what is wrong with it."""
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


def _value(kind: str, key: str, form: Form, wanted: Any, trial: Scenario) -> Any:
    if form == "number":
        return Comparison.parse(wanted)
    if form == "flag":
        if not isinstance(wanted, bool):
            raise UserError(f"{key}: expected true or false, found {wanted!r}")
        return wanted
    if form in ("point", "list"):
        raise UserError(f"{key} of an event {kind!r} is a {form}; only single values are compared")
    if form == "location" and is_figure(wanted):
        return wanted
    known = known_names(trial, form)
    if known is not None:
        return checked_name(wanted, form, known)
    if not isinstance(wanted, str):
        raise UserError(f"{key}: expected text, found {wanted!r}")
    return wanted


def _body(name: Any, trial: Scenario) -> str:
    return checked_name(name, "body", [*people(trial), *machines(trial)])


def _is(found: Any, wanted: Any) -> bool:
    if isinstance(wanted, Comparison):
        return is_figure(found) and wanted.passes(found)
    return bool(found == wanted)
