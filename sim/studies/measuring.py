"""One row of a study, run: its figures, or what went wrong."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

from ..record.figures import FIGURES
from ..record.social_metrics import metrics
from ..simulation import run
from .definition import Row

Record = dict[str, Any]
"""One line of a study's results: column by column, numbers, texts, or None."""


def measure(row: Row, *, with_metrics: bool = False) -> Record:
    """Run `row`: its parameters, an error (or None), and the figures of its summary.

    And its metrics of social navigation, if asked for.

    A trial that fails leaves what it raised under `error`, and no figures. Nothing here depends
    on where or when it runs.
    """
    record: Record = {"row": row.number}
    record |= {name: _plain(value) for name, value in row.parameters.items()}
    try:
        finished = run(row.trial)
    except Exception as why:  # the user's own controllers and laws may raise anything
        return record | {"error": _in_words(why)}
    left_out = {path for path, figure in FIGURES.items() if not figure.column}
    summary = {key: value for key, value in finished.summary.items() if key not in left_out}
    if with_metrics:
        summary["metrics"] = metrics(finished)
    return record | {"error": None, "unmet": len(finished.unmet)} | dict(flat(summary))


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


def _in_words(why: Exception) -> str:
    """An error on one line."""
    return " ".join(f"{type(why).__name__}: {why}".split())
