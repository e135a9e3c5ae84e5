"""Trajectories of all bodies as a table in CSV."""

from __future__ import annotations

from typing import TextIO

import numpy as np
from numpy.typing import NDArray

from .lines import csv_line
from .outcome import Outcome
from .sampling import blocks_of_instants, sample_all

COLUMNS = ("t", "body", "x", "y", "rotation", "vx", "vy")
"""Seconds, a name, metres, metres, radians, m/s, m/s."""

DECIMALS = 6
"""Decimals of the figures."""


def write_trajectory(run: Outcome, file: TextIO, rate: float) -> None:
    """Every body on the floor, at `rate` instants a second (Hz), as CSV: metres, radians, m/s."""
    decimals = 3 if (1000 / rate).is_integer() else 9
    file.write(csv_line(COLUMNS))
    names = {name: csv_line([name]).rstrip("\n") for name in run.motions}
    for times in blocks_of_instants(run.duration, rate):
        stamps = [f"{t:.{decimals}f}" for t in times.tolist()]
        tables = []
        for name, samples in sample_all(run.motions, times).items():
            there = run.is_present(name, times).tolist()
            rows = zip(stamps, _texts(samples), there, strict=True)
            cell = names[name]
            tables.append([f"{t},{cell},{row}\n" if seen else "" for t, row, seen in rows])
        file.writelines(line for rows in zip(*tables, strict=True) for line in rows)


def _texts(samples: NDArray[np.float64]) -> list[str]:
    """Return the figures of each of `samples` (N, 5) as they stand in a line.

    A body that stands has the same ones again and again: they are written out once.
    """
    figures = np.round(samples, DECIMALS) + 0.0
    fresh = np.ones(len(figures), dtype=bool)
    fresh[1:] = (figures[1:] != figures[:-1]).any(axis=1)
    texts = [",".join(map(repr, row)) for row in figures[fresh].tolist()]
    return [texts[k] for k in (np.cumsum(fresh) - 1).tolist()]
