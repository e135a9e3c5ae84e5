"""Incidents of a run, and the risk at each cell of its floor."""

from __future__ import annotations

import math
from bisect import bisect_left, bisect_right
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
import shapely

from floorplan import Point, UserError
from navigation import minimum_margin

from ..core.recorder import Event, rounded
from ..machines.gantry.robot import GANTRY
from ..safety.laws import is_of_speeds_alone
from .outcome import Outcome
from .sampling import MOMENT, CellArray, Span, cells_of, moments, spread, within

CELL = 0.1
"""Metres. The side of a cell."""

Risk = Literal["margin", "time", "severity"]
"""The least margin to the required distance (m); the time without it (s); the speed then (m/s)."""


def risk(run: Outcome, of: Risk) -> CellArray:
    """Return the risk in each cell that was under a person's body: (rows, columns).

    The first cell is in the south-west corner of the floor's bounds. `ValueError` if `of` is none.
    """
    if of not in _RISKS:
        *first, last = _RISKS
        raise UserError(f"a risk map is of {', '.join(first)} or {last}, not {of!r}")
    return _RISKS[of][0](run)


def risk_of_all(maps: Iterable[CellArray], of: Risk) -> CellArray:
    """Return the risk of several runs together: the worst of any, or the time in all."""
    return np.asarray(_RISKS[of][1].reduce([*maps]))


def least_margins(run: Outcome) -> CellArray:
    """Return the least margin (metres) to any machine in each cell, (rows, columns).

    Infinite where nobody was, or nothing was required; nothing is required of a vehicle that
    stands.
    """
    least = np.full(cells_of(run.floorplan, CELL), math.inf)
    for person in run.scene.people:
        times, _ = _moments_of_person(run, person.name)
        margin = np.full(len(times), math.inf)
        for other, machine in run.violations:
            if other == person.name:
                margin = np.minimum(margin, _margins(run, person.name, machine, times))
        cells = np.full(least.shape, math.inf)
        np.minimum.at(cells, _cells(run, person.name, times), margin)
        # A violation whose person is put elsewhere at once falls between two moments.
        for at, margin_then in _begins(run, person.name):
            cells[_cell(run, at)] = min(cells[_cell(run, at)], margin_then)
        least = np.minimum(least, spread(cells, CELL, person.radius, np.minimum, math.inf))
    return least


def violation_times(run: Outcome) -> CellArray:
    """Return the time (seconds) for which people in each cell were nearer than required."""
    total = np.zeros(cells_of(run.floorplan, CELL))
    for person in run.scene.people:
        mine = run.violations_of(person.name).values()
        if not any(mine):
            continue
        times, lengths = _moments_of_person(run, person.name)
        near = within(times, [interval for some in mine for interval in some])
        cells = np.zeros(total.shape)
        np.add.at(cells, _cells(run, person.name, times[near]), lengths[near])
        total += spread(cells, CELL, person.radius, np.add, 0.0)
    return total


def severities(run: Outcome) -> CellArray:
    """Return the highest speed (m/s) of person and machine relative to each other in each cell.

    While the two were nearer than required; 0 where nobody ever was. The energy of a contact
    grows with its square (ISO/TS 15066:2016, annex A.3.4).
    """
    worst = np.zeros(cells_of(run.floorplan, CELL))
    for person in run.scene.people:
        mine = run.violations_of(person.name)
        if not any(mine.values()):
            continue
        all_times, _ = _moments_of_person(run, person.name)
        cells = np.zeros(worst.shape)
        for machine, intervals in mine.items():
            times = all_times[within(all_times, intervals)]
            speed = relative_speeds(run, person.name, machine, times)
            np.maximum.at(cells, _cells(run, person.name, times), speed)
        worst = np.maximum(worst, spread(cells, CELL, person.radius, np.maximum, 0.0))
    return worst


def relative_speeds(run: Outcome, person: str, machine: str, times: CellArray) -> CellArray:
    """Return how fast (m/s) a person and a machine move relative to each other, at each instant."""
    between = run.motions[machine].velocity(times) - run.motions[person].velocity(times)
    return np.asarray(np.hypot(*between.reshape(-1, 2).T))


RISKS: tuple[Risk, ...] = ("margin", "time", "severity")
"""All of them."""

_RISKS: dict[Risk, tuple[Callable[[Outcome], CellArray], np.ufunc]] = {
    "margin": (least_margins, np.minimum),
    "time": (violation_times, np.add),
    "severity": (severities, np.maximum),
}


def _moments_of_person(run: Outcome, person: str) -> tuple[CellArray, CellArray]:
    """Return the moments in which a person is on the floor, from their start on."""
    started = [e["t"] for e in run.events if e["kind"] == "human_started" and e["person"] == person]
    begin, end = run.presence[person]
    return moments(run.motions[person], max([begin, *started[:1]]), end if started else begin)


def _margins(run: Outcome, person: str, machine: str, times: CellArray) -> CellArray:
    """Return the margin (metres) to one machine at each instant; infinite if none is required."""
    if run.scene.machine(machine).category != "vehicle":
        return run.margin(person, machine, times)
    moves = np.hypot(*run.motions[machine].velocity(times).T) > 0.0
    margins = np.full(len(times), math.inf)
    margins[moves] = run.margin(person, machine, times[moves])
    return margins


def _begins(run: Outcome, person: str) -> Iterator[tuple[Point, float]]:
    """Yield where a person was as each of their violations began, and the margin then (metres)."""
    # Events have rounded times: by such a one the person may be elsewhere already.
    begins = {
        (machine, rounded(begin)): begin
        for machine, intervals in run.violations_of(person).items()
        for begin, _ in intervals
    }
    for event in run.events:
        if event["kind"] == "violation" and event["person"] == person:
            known = (event["with"], event["t"])
            t = begins[known] if known in begins else event["t"]
            at = run.motions[person].state_before(t).at
            yield at, event["distance"] - event["required"]


def _cell(run: Outcome, at: Point) -> tuple[int, int]:
    """Return the row and column of the cell of a place."""
    row, column = _cells_at(run, np.array([at]))
    return int(row[0]), int(column[0])


def _cells(run: Outcome, person: str, times: CellArray) -> tuple[Any, Any]:
    """Return the row and column of the cell in which a person's centre is at each instant."""
    return _cells_at(run, run.motions[person].position(times).reshape(-1, 2))


def _cells_at(run: Outcome, places: CellArray) -> tuple[Any, Any]:
    """Return the rows and columns of the cells of places (N, 2)."""
    west, south, *_ = run.floorplan.boundary.bounds
    rows, columns = cells_of(run.floorplan, CELL)
    x, y = places.T
    row = np.clip(((y - south) / CELL).astype(int), 0, rows - 1)
    return row, np.clip(((x - west) / CELL).astype(int), 0, columns - 1)


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
        end - begin for person in run.scene.people for begin, end in run.stays[person.name]
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
    times = _sample_times(span)
    worst_at, margin = _least_margin(run, person, machine, span, times)
    events = list(log.of(person, machine, span))
    violation = next((event for event in events if event["kind"] == "violation"), None)
    if violation is None:  # it began before the warm-up, or the run was broken off
        distance = float(run.distance(person, machine, begin))
        required, cause = float(run.required(person, machine, begin)), ""
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


def _sample_times(span: Span) -> CellArray:
    """Return instants (N,) from the beginning of an interval to just before its end."""
    begin, end = span
    count = min(max(2, math.ceil((end - begin) / MOMENT) + 1), _MOST_MOMENTS)
    # At its end a body may be put elsewhere.
    return np.linspace(begin, max(begin, np.nextafter(end, begin)), count)


def _least_margin(
    run: Outcome, person: str, machine: str, span: Span, times: CellArray
) -> tuple[float, float]:
    """Return when in an interval the margin is least, and that margin: (seconds, metres).

    Solved for where the law allows it, and else the least at `times`.
    """
    begin, end = span
    shape = run.scene.machine(machine)
    law = run.scene.rules.law_of(shape)
    if not is_of_speeds_alone(law) or begin == end:
        margins = run.margin(person, machine, times)
        least = int(np.argmin(margins))
        return float(times[least]), float(margins[least])
    measured = run.motions[machine].translated(*run.scene.rules.measured_at(shape))
    last = float(np.nextafter(end, begin))
    shapes = run.scene.shapes(person, machine)
    return minimum_margin(run.motions[person], measured, law, begin, last, shapes=shapes)
