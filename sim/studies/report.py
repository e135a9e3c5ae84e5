"""The report of a study: one HTML page that needs nothing else."""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ..views.report_page import write_report_page
from ..views.safety_report.parts import minus
from .charts import chart
from .comparison import Comparison, Spread
from .effects import contrasts
from .results import StudyResults
from .table import Cell

STANDING_OUT = 3
"""So many rows are named for what makes them stand out."""

MOST_CONTRASTS = 200
"""So many pairs of combinations are set against each other."""

MOST_ERRORS = 50
"""So many failed rows are listed."""


@dataclass(frozen=True)
class Remarkable:
    """A row to look at, and why."""

    number: int
    why: str
    combination: str


def write_report(results: StudyResults, path: Path) -> None:
    """Write the page about a study to `path`."""
    columns, compared = results.columns, results.comparison
    charts = {
        measure: chart(measure, compared.groups, spreads)
        for measure, spreads in compared.spreads.items()
        if compared.constant(measure) is None
    }
    write_report_page(
        path,
        "study.html",
        {"figure": figure, "signed": signed},
        study=results.study,
        count=len(results),
        hours=sum(float(t) for t in columns.get("duration", ()) if t is not None) / 3600,
        compared=compared,
        charts=charts,
        varying={measure: digits_of(compared.spreads[measure]) for measure in charts},
        constant={
            measure: value
            for measure in compared.spreads
            if (value := compared.constant(measure)) is not None
        },
        contrasts=[*itertools.islice(contrasts(compared), MOST_CONTRASTS)],
        most_contrasts=MOST_CONTRASTS,
        remarkable=list(_remarkable(columns, compared)),
        errors=list(results.failed.items())[:MOST_ERRORS],
        error_count=len(results.failed),
    )


def signed(value: float) -> str:
    """A difference with two digits after the point, and its sign unless it is 0."""
    return "0.00" if round(value, 2) == 0 else minus(f"{value:+.2f}")


def figure(value: float | None, digits: int | None = None) -> str:
    """A number as people read it: three or four digits that count, or `digits` after the point."""
    if value is None or value != value:
        return "–"
    if digits is None:
        digits = 0 if value == round(value) else _after_the_point(abs(value))
    return minus(f"{round(value, digits) + 0.0:,.{digits}f}")  # no negative zero


def _after_the_point(size: float) -> int:
    return 0 if size >= 1000 else 1 if size >= 100 else 2 if size >= 1 else 3


def digits_of(spreads: Sequence[Spread | None]) -> int:
    """Return how many digits after the point the largest figure needs; none for whole numbers."""
    shown = [end for s in spreads if s is not None for end in (s.mean, s.low, s.high)]
    if all(value == round(value) for value in shown):
        return 0
    return _after_the_point(max(map(abs, shown)))


def _remarkable(
    columns: Mapping[str, Sequence[Cell]], compared: Comparison
) -> Iterator[Remarkable]:
    """The rows at the far ends, each once; rows that are no different from most aren't."""
    named: set[int] = set()
    for measure in compared.spreads:
        values = measure.values(columns)
        if not measure.worst or values is None or compared.constant(measure) is not None:
            continue
        order = np.argsort(measure.worst * values, kind="stable")
        fresh = [k for k in order.tolist() if k not in named and values[k] == values[k]]
        for k in fresh[:STANDING_OUT]:
            named.add(k)
            unit = f" {measure.unit}" if measure.unit else ""
            why = f"{measure.words}: {figure(float(values[k]))}{unit}"
            yield Remarkable(int(columns["row"][k] or 0), why, compared.label_of(k))
