"""Findings of a study's rows for a safety report: violations, times and maps of risk."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field, replace

import numpy as np

from ..record.cells import Array
from ..record.incidents import Incident, incidents, time_on_floor, time_too_close, worst_first
from ..record.risk import RISKS, Risk, risk, risk_of_all
from ..runs.run import Run
from .comparison import Comparison, Measure, spread
from .running import of_rows
from .study import Study

VIOLATIONS = Measure("Violations", "safety.violations", "", "with any machine", chief=True)

TOO_NEAR = Measure("Nearer than required", "safety.near", "s", "all people together", chief=True)

MARGIN = Measure("Least margin", "safety.margin", "m", "to a required distance", chief=True)

KEPT = 40
"""The worst violations of a row that are kept."""


@dataclass(frozen=True, eq=False)
class RowFindings:
    """Findings of one row: how many violations, the worst of them, times in seconds, maps.

    `margin` is the least margin to a required distance (metres), NaN where nothing was required.
    """

    count: int
    worst: list[Incident]
    on_floor: float
    near: float
    margin: float
    maps: dict[Risk, Array]


@dataclass(eq=False)
class Findings:
    """Findings of all rows that did not fail.

    `maps` are those of all rows of a trial together, by its number. `worst` has the worst
    violations with the numbers of their rows.
    """

    rows: dict[int, RowFindings] = field(default_factory=dict)
    worst: list[tuple[int, Incident]] = field(default_factory=list)
    maps: dict[int, dict[Risk, Array]] = field(default_factory=dict)

    def add(self, row: int, trial: int, found: RowFindings) -> None:
        """Take in what was found in the row and the trial of these numbers."""
        self.worst += [(row, one) for one in found.worst]
        self.worst.sort(key=lambda one: (one[1].margin, one[0], one[1].begin))
        del self.worst[KEPT:]
        mine = self.maps.setdefault(trial, {})
        for of, cells in found.maps.items():
            mine[of] = risk_of_all([mine[of], cells], of) if of in mine else cells
        # The maps of single rows are not needed any more, and are large.
        self.rows[row] = replace(found, worst=[], maps={})


def findings(
    study: Study,
    failed: set[int],
    *,
    jobs: int | None = None,
    progress: Callable[[int], None] = lambda _: None,
) -> Findings:
    """Run every row that did not fail once more, and return what is found in all of them.

    `progress` is given the number of rows that are done.
    """
    together = Findings()
    each = len(study.combinations) // len(study.trials)
    rows = (row for row in study.rows() if row.number not in failed)
    for done, (row, found) in enumerate(of_rows(rows, row_findings, jobs=jobs), 1):
        together.add(row.number, row.number % len(study.combinations) // each, found)
        progress(done)
    return together


def row_findings(finished: Run) -> RowFindings:
    """Return what is found in the run of a row."""
    found = worst_first(incidents(finished))
    both = finished.scene.people and finished.scene.machines
    maps = {of: risk(finished, of) for of in RISKS} if both else {}
    margins = [one.margin for one in found[:1]]
    if both:
        margins.append(float(maps["margin"].min()))
    return RowFindings(
        count=len(found),
        worst=found[:KEPT],
        on_floor=time_on_floor(finished),
        near=time_too_close(finished),
        margin=min(filter(math.isfinite, margins), default=math.nan),
        maps=maps,
    )


def with_findings(compared: Comparison, found: Findings) -> Comparison:
    """Return a comparison that has the findings of the rows among its measures, before others."""
    count = sum(len(group.rows) for group in compared.groups)
    nothing = RowFindings(0, [], math.nan, math.nan, math.nan, {})
    rows = [found.rows.get(k, nothing) for k in range(count)]
    known = np.array([float(k in found.rows) for k in range(count)])
    figures = {
        VIOLATIONS: np.where(known > 0, [float(one.count) for one in rows], math.nan),
        TOO_NEAR: np.array([one.near for one in rows]),
        MARGIN: np.array([one.margin for one in rows]),
    }
    spreads = {
        measure: tuple(spread(values[group.rows]) for group in compared.groups)
        for measure, values in figures.items()
    }
    return replace(compared, spreads=spreads | compared.spreads, values=figures | compared.values)
