"""Incidents: the times in which a person was nearer to a machine than required, one by one."""

from __future__ import annotations

import math
from bisect import bisect_left, bisect_right
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
import shapely

from floorplan import Point
from navigation import minimum_margin

from ..core.recorder import Event
from ..machines.gantry.robot import GANTRY
from ..safety.requirement_curve import is_plain
from .cells import Array
from .outcome import Outcome
from .presence import Span
from .risk import relative_speeds
from .zone_exposure import MOMENT

_AT_ONCE = 1e-6
"""Seconds. Instants of events are rounded to less than this."""

_KINDS = ("violation", "teleport", "gantry_disabled", "protective_stop", "protective_stop_ended")

_MOST_MOMENTS = 20_000
"""A long interval is looked at in so many moments at most."""


@dataclass(frozen=True)
class Incident:
    """A time in which a `person` was nearer to a `machine` than the rules required.

    From `begin` to `end` (seconds). The person was `at` a place, so far away (`distance`, metres)
    when so much was `required`; the least margin of the whole time is `margin`, at the instant
    `worst_at` (seconds), and `severity` the highest speed of the two relative to each other (m/s).
    `cause` says who moved at the beginning, `zones` where it was, and `led_to` in words what
    followed from it.
    """

    person: str
    machine: str
    begin: float
    end: float
    cause: str
    at: Point
    distance: float
    required: float
    margin: float
    worst_at: float
    severity: float
    zones: tuple[str, ...] = ()
    led_to: tuple[str, ...] = ()

    @property
    def seconds(self) -> float:
        """How long it took."""
        return self.end - self.begin


def incidents(run: Outcome) -> list[Incident]:
    """Return the incidents of a run in the order of time."""
    log = _Log(run.events)
    found = [
        _incident(run, log, person, machine, span)
        for (person, machine), intervals in run.violations.items()
        for span in intervals
    ]
    return sorted(found, key=lambda one: (one.begin, one.person, one.machine))


def worst_first(found: list[Incident]) -> list[Incident]:
    """Return incidents by what they fell short by, the most first."""
    return sorted(found, key=lambda one: (one.margin, one.begin, one.person))


def time_too_close(run: Outcome) -> float:
    """Return for how long (seconds) people were nearer than required, all of them together.

    Somebody who is too near to two machines at once counts once.
    """
    total = 0.0
    for person in run.scene.people:
        until = -math.inf
        mine = run.violations_of(person.name).values()
        # Sorted by their begins, each adds what it has beyond the end of all before it.
        for begin, end in sorted(span for some in mine for span in some):
            total += max(0.0, end - max(begin, until))
            until = max(until, end)
    return total


def time_on_floor(run: Outcome) -> float:
    """Return for how long (seconds) people were on the floor, all of them together."""
    return math.fsum(
        max(0.0, end - begin) for begin, end in (run.presence[p.name] for p in run.scene.people)
    )


class _Log:
    """The events of a run that are about violations, found by their time."""

    def __init__(self, events: Sequence[Event]) -> None:
        self._events = [event for event in events if event["kind"] in _KINDS]
        self._times = [event["t"] for event in self._events]

    def of(self, person: str, machine: str, span: Span) -> Iterator[Event]:
        """Yield the events of an interval that are about the two."""
        first = bisect_left(self._times, span[0] - _AT_ONCE)
        last = bisect_right(self._times, span[1] + _AT_ONCE)
        for event in self._events[first:last]:
            if event["kind"] == "violation":
                mine = (event["person"], event["with"]) == (person, machine)
            elif event["kind"] == "teleport":
                mine = event["person"] == person
            else:
                mine = event.get("machine", GANTRY) == machine
            if mine and event["kind"] != "protective_stop_ended":
                yield event

    def consequences(self, events: Sequence[Event], machine: str) -> Iterator[str]:
        """Yield in words what events led to."""
        for event in events:
            match event["kind"]:
                case "violation" if event.get("penalty"):
                    yield "penalty"
                case "teleport":
                    yield "person taken to the safe zone"
                case "gantry_disabled":
                    yield f"{machine} disabled for {event['seconds']:g} s"
                case "protective_stop":
                    yield f"protective stop {self._length_of(event, machine)}"

    def _length_of(self, stop: Event, machine: str) -> str:
        """Return in words how long a protective stop took."""
        for event in self._events[bisect_left(self._times, stop["t"]) :]:
            if event["kind"] == "protective_stop_ended" and event["machine"] == machine:
                return f"of {event['t'] - stop['t']:.1f} s"
        return "until the end"


def _incident(run: Outcome, log: _Log, person: str, machine: str, span: Span) -> Incident:
    begin = span[0]
    # At the instant of a violation the person may be put elsewhere: what counts is before.
    human, robot = (run.motions[name].state_before(begin) for name in (person, machine))
    times = _moments(span)
    worst_at, margin = _least_margin(run, person, machine, span, times)
    events = list(log.of(person, machine, span))
    violation = next((event for event in events if event["kind"] == "violation"), None)
    if violation is None:  # of a run that was broken off
        distance, required, cause = math.nan, math.nan, ""
    else:
        distance, required, cause = (violation[key] for key in ("distance", "required", "cause"))
    if distance - required <= margin:
        worst_at, margin = begin, distance - required
    apart = (a - b for a, b in zip(human.velocity[:2], robot.velocity[:2], strict=True))
    speeds = relative_speeds(run, person, machine, times)
    return Incident(
        person=person,
        machine=machine,
        begin=begin,
        end=span[1],
        cause=cause,
        at=human.at,
        distance=distance,
        required=required,
        margin=margin,
        worst_at=worst_at,
        severity=max(math.hypot(*apart), float(speeds.max())),
        zones=tuple(
            zone.name for zone in run.floorplan.zones if shapely.intersects_xy(zone.area, *human.at)
        ),
        led_to=tuple(dict.fromkeys(log.consequences(events, machine))),
    )


def _moments(span: Span) -> Array:
    """Return instants (N,) from the beginning of an interval to just before its end."""
    begin, end = span
    count = min(max(2, math.ceil((end - begin) / MOMENT) + 1), _MOST_MOMENTS)
    # At its end a body may be put elsewhere.
    return np.linspace(begin, max(begin, np.nextafter(end, begin)), count)


def _least_margin(
    run: Outcome, person: str, machine: str, span: Span, times: Array
) -> tuple[float, float]:
    """Return when in an interval the margin is least, and that margin: (seconds, metres).

    Solved for where the law allows it, and else the least at `times`.
    """
    begin, end = span
    shape = run.scene.machine(machine)
    law = run.scene.rules.law_of(shape)
    if not is_plain(law) or begin == end:
        margins = run.margin(person, machine, times)
        least = int(np.argmin(margins))
        return float(times[least]), float(margins[least])
    measured = run.motions[machine].translated(*run.scene.rules.measured_at(shape))
    last = float(np.nextafter(end, begin))
    return minimum_margin(run.motions[person], measured, law, begin, last)
