"""One row of a study, run: its figures, or what went wrong."""

from __future__ import annotations

import traceback
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from ..core.own_source import DEFECT, is_ours
from ..record.figures import FIGURES
from ..record.social_metrics import metrics
from ..runs.run import Run
from .definition import Row

Record = dict[str, Any]
"""One line of a study's results: column by column, numbers, texts, or None."""

_LEFT_OUT = frozenset(path for path, figure in FIGURES.items() if not figure.column)


def figures_of(finished: Run, *, with_metrics: bool = False) -> Record:
    """Return the figures of a run: those of its summary, and its metrics if asked for.

    Nothing here depends on where or when it ran.
    """
    summary = {key: value for key, value in finished.summary.items() if key not in _LEFT_OUT}
    if with_metrics:
        summary["metrics"] = metrics(finished)
    return {"error": None, "unmet": len(finished.unmet)} | dict(flat(summary))


def error_in(why: Exception) -> Record:
    """Return what stands in place of figures where a trial failed: what it raised, on one line.

    An error that no input may cause is told apart, and has the place where it arose.
    """
    words = f"{type(why).__name__}: {why}"
    if not is_ours(why) and not isinstance(why, OSError):
        at = traceback.extract_tb(why.__traceback__)[-1]
        words = f"{DEFECT}: {words} ({Path(at.filename).name}, line {at.lineno})"
    return {"error": " ".join(words.split())}


def record_of(row: Row, figures: Record) -> Record:
    """Return the line of `row`: its number, its parameters, and its figures or error."""
    record: Record = {"row": row.number}
    record |= {name: _plain(value) for name, value in row.parameters.items()}
    return record | figures


def flat(figures: Mapping[str, Any], above: str = "") -> Iterator[tuple[str, Any]]:
    """Figures within figures by their names joined with dots; of a list, how long it is."""
    for key, value in figures.items():
        name = f"{above}{key}"
        if isinstance(value, Mapping):
            yield from flat(value, f"{name}.")
        elif isinstance(value, list | tuple):
            yield name, len(value)
        else:
            yield name, value


def _plain(value: Any) -> Any:
    return " ".join(str(one) for one in value) if isinstance(value, tuple) else value
