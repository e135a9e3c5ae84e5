"""Incidents of a run, and the risk at each cell of its floor."""

from __future__ import annotations

import itertools
import math
from bisect import bisect_left, bisect_right
from collections.abc import Callable, Iterable, Iterator, Sequence
from typing import Any, Literal

import numpy as np
import shapely

from floorplan import Point, UserError
from floorplan.files.dataclass import dataclass
from navigation import minimum_margin

from ..core.recorder import Event, rounded
from ..machines.gantry.robot import GANTRY
from ..safety.laws import is_of_speeds_alone
from .outcome import Outcome
from .sampling import MOMENT, CellArray, Span, cells_of, moments, spread, within

CELL = 0.1
"""Metres. The side of a cell."""

Risk = Literal["margin", "time", "severity"]
"""Least margin to the required distance (m), time below it (s), relative speed below it (m/s)."""


def risk(run: Outcome, of: Risk) -> CellArray:
    """Return the risk in each cell that a person's body covered, shape (rows, columns).

    The first cell is in the south-west corner of the floor's bounds. `ValueError` if `of` is
    unknown.
    """
    if of not in _RISKS:
        *first, last = _RISKS
        raise UserError(f"a risk map is of {', '.join(first)} or {last}, not {of!r}")
    return _RISKS[of][0](run)


def risk_of_all(maps: Iterable[CellArray], of: Risk) -> CellArray:
    """Return the joint risk of several runs: the worst of them, or the total time."""
    return np.asarray(_RISKS[of][1].reduce([*maps]))


def least_margins(run: Outcome) -> CellArray:
    """Return the least margin (m) to any machine in each cell, shape (rows, columns).

    It is infinite in cells without people or required distances. Stationary vehicles require none.
    """

    def fill(person: str, cells: CellArray) -> None:
        times, _ = _moments_of_person(run, person)
        margin = np.full(len(times), math.inf)
        for machine in run.violations_of(person):
            margin = np.minimum(margin, _margins(run, person, machine, times))
        np.minimum.at(cells, _cells(run, person, times), margin)
        # The violation of a person who is teleported immediately lies between two samples.
        for at, margin_then in _begins(run, person):
            cells[_cell(run, at)] = min(cells[_cell(run, at)], margin_then)

    return _under_bodies(run, fill, np.minimum, math.inf)


def violation_times(run: Outcome) -> CellArray:
    """Return the time (s) for which people in each cell were nearer than required."""

    def fill(person: str, cells: CellArray) -> None:
        mine = [*itertools.chain.from_iterable(run.violations_of(person).values())]
        if mine:
            times, lengths = _moments_of_person(run, person)
            near = within(times, mine)
            np.add.at(cells, _cells(run, person, times[near]), lengths[near])

    return _under_bodies(run, fill, np.add, 0.0)


def severities(run: Outcome) -> CellArray:
    """Return the highest relative speed (m/s) of person and machine in each cell during violations.

    It is 0 in cells without violations. The energy of a contact grows with its square (ISO/TS
    15066:2016, annex A.3.4).
    """

    def fill(person: str, cells: CellArray) -> None:
        for machine, intervals in run.violations_of(person).items():
            if intervals:
                times, _ = _moments_of_person(run, person)
                times = times[within(times, intervals)]
                speed = relative_speeds(run, person, machine, times)
                np.maximum.at(cells, _cells(run, person, times), speed)

    return _under_bodies(run, fill, np.maximum, 0.0)


def _under_bodies(
    run: Outcome, fill: Callable[[str, CellArray], None], join: np.ufunc, nothing: float
) -> CellArray:
    """Return the cells that `fill` sets under the centre of each person, spread to their bodies."""
    joined = np.full(cells_of(run.floorplan, CELL), nothing)
    for person in run.scene.people:
        cells = np.full(joined.shape, nothing)
        fill(person.name, cells)
        if (cells != nothing).any():
            joined = join(joined, spread(cells, CELL, person.radius, join, nothing))
    return joined


def relative_speeds(run: Outcome, person: str, machine: str, times: CellArray) -> CellArray:
    """Return the relative speed (m/s) of a person and a machine at each time."""
    between = run.motions[machine].velocity(times) - run.motions[person].velocity(times)
    return np.asarray(np.hypot(*between.reshape(-1, 2).T))


RISKS: tuple[Risk, ...] = ("margin", "time", "severity")
"""All kinds of risk."""

_RISKS: dict[Risk, tuple[Callable[[Outcome], CellArray], np.ufunc]] = {
    "margin": (least_margins, np.minimum),
    "time": (violation_times, np.add),
    "severity": (severities, np.maximum),
}


def _moments_of_person(run: Outcome, person: str) -> tuple[CellArray, CellArray]:
    """Return sample times and durations while a started person is on the floor."""
    started = [e["t"] for e in run.events if e["kind"] == "human_started" and e["person"] == person]
    begin, end = run.presence[person]
    return moments(run.motions[person], max([begin, *started[:1]]), end if started else begin)


def _margins(run: Outcome, person: str, machine: str, times: CellArray) -> CellArray:
    """Return the margin (m) to one machine at each time, infinite if none is required."""
    if run.scene.machine(machine).category != "vehicle":
        return run.margin(person, machine, times)
    moves = np.hypot(*run.motions[machine].velocity(times).T) > 0.0
    margins = np.full(len(times), math.inf)
    margins[moves] = run.margin(person, machine, times[moves])
    return margins


def _begins(run: Outcome, person: str) -> Iterator[tuple[Point, float]]:
    """Yield the position of a person and the margin (m) at the begin of each violation."""
    # Times of events are rounded, and a person may have been teleported by then.
    begins = {
        (machine, rounded(begin)): begin
        for machine, intervals in run.violations_of(person).items()
        for begin, _ in intervals
    }
    for event in run.events:
        if event["kind"] == "violation" and event["person"] == person:
            key = (event["with"], event["t"])
            t = begins[key] if key in begins else event["t"]
            at = run.motions[person].state_before(t).at
            yield at, event["distance"] - event["required"]


def _cell(run: Outcome, at: Point) -> tuple[int, int]:
    """Return the row and column of the cell of a position."""
    row, column = _cells_at(run, np.array([at]))
    return int(row[0]), int(column[0])


def _cells(run: Outcome, person: str, times: CellArray) -> tuple[Any, Any]:
    """Return the rows and columns of the cells of a person's centre at each time."""
    return _cells_at(run, run.motions[person].position(times).reshape(-1, 2))


def _cells_at(run: Outcome, places: CellArray) -> tuple[Any, Any]:
    """Return the rows and columns of the cells of positions (N, 2)."""
    west, south, *_ = run.floorplan.boundary.bounds
    rows, columns = cells_of(run.floorplan, CELL)
    x, y = places.T
    row = np.clip(((y - south) / CELL).astype(int), 0, rows - 1)
    return row, np.clip(((x - west) / CELL).astype(int), 0, columns - 1)


_AT_ONCE = 1e-6
"""Seconds. Times of events are rounded to less than this."""

_KINDS = ("violation", "teleport", "gantry_disabled", "protective_stop", "protective_stop_ended")

_MOST_MOMENTS = 20_000
"""Maximum number of samples of an interval."""


@dataclass(frozen=True)
class Incident:
    """A time in which a `person` was nearer to a `machine` than the rules required.

    It lasts from `begin` to `end` (s). The person was `at` a position, at a `distance` (m) below
    the `required` one (m). `margin` is the least margin of the interval, at the time `worst_at`
    (s). `severity` is the highest relative speed (m/s). `cause` is the body that moved at the
    begin. `zones` contain the position. `led_to` lists the consequences in words.
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
        """Duration (s)."""
        return self.end - self.begin


def incidents(run: Outcome) -> list[Incident]:
    """Return the incidents of a run in the order of time."""
    log = _Log(run.events)
    unsorted = [
        _incident(run, log, person, machine, span)
        for (person, machine), intervals in run.violations.items()
        for span in intervals
    ]
    return sorted(unsorted, key=lambda one: (one.begin, one.person, one.machine))


def worst_first(unsorted: list[Incident]) -> list[Incident]:
    """Return incidents in order of margin, the least first."""
    return sorted(unsorted, key=lambda one: (one.margin, one.begin, one.person))


def time_too_close(run: Outcome) -> float:
    """Return the total time (s) for which people were nearer than required.

    A person who is too near to two machines at the same time counts once.
    """
    total = 0.0
    for person in run.scene.people:
        until = -math.inf
        mine = run.violations_of(person.name).values()
        # In order of their begins, each interval adds its part after the end of all earlier ones.
        for begin, end in sorted(span for some in mine for span in some):
            total += max(0.0, end - max(begin, until))
            until = max(until, end)
    return total


def time_on_floor(run: Outcome) -> float:
    """Return the total time (s) for which people were on the floor."""
    return math.fsum(
        end - begin for person in run.scene.people for begin, end in run.stays[person.name]
    )


class _Log:
    """Events of a run that concern violations, indexed by time."""

    def __init__(self, events: Sequence[Event]) -> None:
        self._events = [event for event in events if event["kind"] in _KINDS]
        self._times = [event["t"] for event in self._events]

    def of(self, person: str, machine: str, span: Span) -> Iterator[Event]:
        """Yield the events of an interval that concern the two."""
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
        """Yield the consequences of events in words."""
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
        """Return the duration of a protective stop in words."""
        for event in self._events[bisect_left(self._times, stop["t"]) :]:
            if event["kind"] == "protective_stop_ended" and event["machine"] == machine:
                return f"of {event['t'] - stop['t']:.1f} s"
        return "until the end"


def _incident(run: Outcome, log: _Log, person: str, machine: str, span: Span) -> Incident:
    begin = span[0]
    # The person may be teleported at the instant of the violation, so the states before it count.
    human, robot = (run.motions[name].state_before(begin) for name in (person, machine))
    times = _sample_times(span)
    worst_at, margin = _least_margin(run, person, machine, span, times)
    events = list(log.of(person, machine, span))
    violation = next((event for event in events if event["kind"] == "violation"), None)
    if violation is None:  # it began in the warm-up, or the run was interrupted
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
    """Return times (N,) from the begin of an interval to just before its end."""
    begin, end = span
    count = min(max(2, math.ceil((end - begin) / MOMENT) + 1), _MOST_MOMENTS)
    # A body may be teleported at the end.
    return np.linspace(begin, max(begin, np.nextafter(end, begin)), count)


def _least_margin(
    run: Outcome, person: str, machine: str, span: Span, times: CellArray
) -> tuple[float, float]:
    """Return the time (s) and value (m) of the least margin in an interval.

    It is exact if the law depends on speeds only, and otherwise the least at `times`.
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
