"""Risk at each spot of a floor: how near people came to what the rules require, and how long."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator
from typing import Any, Literal

import numpy as np

from floorplan import Point, UserError

from ..core.recorder import rounded
from .cells import Array, cells_of, spread
from .outcome import Outcome
from .zone_exposure import moments, within

CELL = 0.1
"""Metres. The side of a cell."""

Risk = Literal["margin", "time", "severity"]
"""The least margin to the required distance (m); the time without it (s); the speed then (m/s)."""


def risk(run: Outcome, of: Risk) -> Array:
    """Return the risk in each cell that was under a person's body: (rows, columns).

    The first cell is in the south-west corner of the floor's bounds. `ValueError` if `of` is none.
    """
    if of not in _RISKS:
        *first, last = _RISKS
        raise UserError(f"a risk map is of {', '.join(first)} or {last}, not {of!r}")
    return _RISKS[of][0](run)


def risk_of_all(maps: Iterable[Array], of: Risk) -> Array:
    """Return the risk of several runs together: the worst of any, or the time in all."""
    return np.asarray(_RISKS[of][1].reduce([*maps]))


def least_margins(run: Outcome) -> Array:
    """Return the least margin (metres) to any machine in each cell, (rows, columns).

    Infinite where nobody was, or nothing was required; nothing is required of a vehicle that
    stands.
    """
    least = np.full(cells_of(run.floorplan, CELL), math.inf)
    for person in run.scene.people:
        times, _ = _moments(run, person.name)
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


def time_too_close(run: Outcome) -> Array:
    """Return the time (seconds) for which people in each cell were nearer than required."""
    total = np.zeros(cells_of(run.floorplan, CELL))
    for person in run.scene.people:
        mine = run.violations_of(person.name).values()
        if not any(mine):
            continue
        times, lengths = _moments(run, person.name)
        near = within(times, [interval for some in mine for interval in some])
        cells = np.zeros(total.shape)
        np.add.at(cells, _cells(run, person.name, times[near]), lengths[near])
        total += spread(cells, CELL, person.radius, np.add, 0.0)
    return total


def severities(run: Outcome) -> Array:
    """Return the highest speed (m/s) of person and machine relative to each other in each cell.

    While the two were nearer than required; 0 where nobody ever was. The energy of a contact
    grows with its square (ISO/TS 15066:2016, annex A.3.4).
    """
    worst = np.zeros(cells_of(run.floorplan, CELL))
    for person in run.scene.people:
        mine = run.violations_of(person.name)
        if not any(mine.values()):
            continue
        all_times, _ = _moments(run, person.name)
        cells = np.zeros(worst.shape)
        for machine, intervals in mine.items():
            times = all_times[within(all_times, intervals)]
            speed = relative_speeds(run, person.name, machine, times)
            np.maximum.at(cells, _cells(run, person.name, times), speed)
        worst = np.maximum(worst, spread(cells, CELL, person.radius, np.maximum, 0.0))
    return worst


def relative_speeds(run: Outcome, person: str, machine: str, times: Array) -> Array:
    """Return how fast (m/s) a person and a machine move relative to each other, at each instant."""
    between = run.motions[machine].velocity(times) - run.motions[person].velocity(times)
    return np.asarray(np.hypot(*between.reshape(-1, 2).T))


RISKS: tuple[Risk, ...] = ("margin", "time", "severity")
"""All of them."""

_RISKS: dict[Risk, tuple[Callable[[Outcome], Array], np.ufunc]] = {
    "margin": (least_margins, np.minimum),
    "time": (time_too_close, np.add),
    "severity": (severities, np.maximum),
}


def _moments(run: Outcome, person: str) -> tuple[Array, Array]:
    """Return the moments in which a person is on the floor, from their start on."""
    started = [e["t"] for e in run.events if e["kind"] == "human_started" and e["person"] == person]
    begin, end = run.presence[person]
    return moments(run.motions[person], max([begin, *started[:1]]), end if started else begin)


def _margins(run: Outcome, person: str, machine: str, times: Array) -> Array:
    """Return the margin (metres) to one machine at each instant; infinite if none is required."""
    margins = run.margin(person, machine, times)
    if run.scene.machine(machine).category == "vehicle":
        moves = np.hypot(*run.motions[machine].velocity(times).T) > 0.0
        margins = np.where(moves, margins, math.inf)
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


def _cells(run: Outcome, person: str, times: Array) -> tuple[Any, Any]:
    """Return the row and column of the cell in which a person's centre is at each instant."""
    return _cells_at(run, run.motions[person].position(times).reshape(-1, 2))


def _cells_at(run: Outcome, places: Array) -> tuple[Any, Any]:
    """Return the rows and columns of the cells of places (N, 2)."""
    west, south, *_ = run.floorplan.boundary.bounds
    rows, columns = cells_of(run.floorplan, CELL)
    x, y = places.T
    row = np.clip(((y - south) / CELL).astype(int), 0, rows - 1)
    return row, np.clip(((x - west) / CELL).astype(int), 0, columns - 1)
