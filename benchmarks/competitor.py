"""The table and the picture of docs/competitor-study.md, from the results of that study.

floorwalker study examples/competitor.study.yaml
python benchmarks/competitor.py studies/competitor/results.csv docs/images/competitor.png
"""

from __future__ import annotations

import csv
import statistics
import sys
from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from sim.studies.comparison import spread

PERSONALITIES = ("indifferent", "antagonistic", "helpful")
CONTROLLERS = ("oblivious", "pausing", "avoiding")
COLOURS = {"oblivious": "#7f7f7f", "pausing": "#0072b2", "avoiding": "#d55e00"}

Row = dict[str, str]

MEASURES: dict[str, Callable[[Row], float]] = {
    "score": lambda row: float(row["score"]),
    "penalties": lambda row: float(row["penalties"]),
    "caused by the gantry": lambda row: float(row["violations.gantry"]),
    "gantry disabled, s": lambda row: float(row["gantry_disabled_time"]),
    "minimum distance, m": lambda row: float(row["minimum_separation.distance"]),
}


def interval(values: Sequence[float]) -> tuple[float, float]:
    """The 95 % confidence interval of the mean, as in the report of a study."""
    limits = spread(np.array(values))
    if limits is None:
        raise ValueError("there are no rows of this pair")
    return limits.low, limits.high


def chosen(rows: Sequence[Row], personality: str, controller: str) -> list[Row]:
    """The rows of one cell of the grid."""
    return [
        row for row in rows if row["personality"] == personality and row["controller"] == controller
    ]


def table(rows: Sequence[Row]) -> str:
    """Means with 95 % intervals as Markdown."""
    lines = [f"| person, controller | {' | '.join(MEASURES)} |", "|---" * (len(MEASURES) + 1) + "|"]
    for personality in PERSONALITIES:
        for controller in CONTROLLERS:
            cell = chosen(rows, personality, controller)
            shown = []
            for measure in MEASURES.values():
                values = [measure(row) for row in cell]
                low, high = interval(values)
                shown.append(f"{statistics.fmean(values):.2f} ± {(high - low) / 2:.2f}")
            lines.append(f"| {personality}, {controller} | {' | '.join(shown)} |")
    return "\n".join(lines)


def picture(rows: Sequence[Row], path: Path) -> None:
    """Score and penalties of every pair, with 95 % intervals."""
    figure = Figure(figsize=(7.2, 2.9), layout="constrained")
    axes = figure.subplots(1, 3)
    for axis, name in zip(axes, ("score", "penalties", "gantry disabled, s"), strict=True):
        for k, controller in enumerate(CONTROLLERS):
            for place, personality in enumerate(PERSONALITIES):
                values = [MEASURES[name](row) for row in chosen(rows, personality, controller)]
                mean, (low, high) = statistics.fmean(values), interval(values)
                axis.errorbar(
                    place + 0.22 * (k - 1),
                    mean,
                    yerr=[[mean - low], [high - mean]],
                    fmt="o^s"[k],
                    color=COLOURS[controller],
                    capsize=2,
                    markersize=5,
                    label=controller if place == 0 and axis is axes[0] else None,
                )
        axis.set_xticks(range(3), PERSONALITIES, fontsize=8)
        axis.set_title(name, fontsize=9)
        axis.set_ylim(bottom=0)
        axis.tick_params(axis="y", labelsize=8)
        axis.spines[["top", "right"]].set_visible(False)
    figure.legend(loc="outside lower center", ncols=3, frameon=False, fontsize=8)
    figure.savefig(path, dpi=160)


def rows_of(results: Path) -> list[Row]:
    """Return the rows of a study's results that did not fail."""
    with results.open(encoding="utf-8", newline="") as file:
        return [row for row in csv.DictReader(file) if not row["error"]]


def main() -> None:
    """Print the table, and draw the picture if a path is given for it."""
    if len(sys.argv) not in (2, 3):
        sys.exit(__doc__)
    rows = rows_of(Path(sys.argv[1]))
    print(table(rows))
    if len(sys.argv) == 3:
        picture(rows, Path(sys.argv[2]))


if __name__ == "__main__":
    main()
