"""Trajectories of all bodies as a table in CSV."""

from __future__ import annotations

import csv
from typing import TextIO

import numpy as np

from .outcome import Outcome
from .sampling import blocks_of_instants, sample_all

COLUMNS = ("t", "body", "x", "y", "rotation", "vx", "vy")
"""Seconds, a name, metres, metres, radians, m/s, m/s."""

DECIMALS = 6
"""Decimals of the figures."""


def write_trajectory(run: Outcome, file: TextIO, rate: float) -> None:
    """Every body on the floor, at `rate` instants a second (Hz), as CSV: metres, radians, m/s."""
    decimals = 3 if (1000 / rate).is_integer() else 9
    writer = csv.writer(file, lineterminator="\n")
    writer.writerow(COLUMNS)
    for times in blocks_of_instants(run.duration, rate):
        stamps = [f"{t:.{decimals}f}" for t in times.tolist()]
        tables = []
        for name, samples in sample_all(run.motions, times).items():
            figures = (np.round(samples, DECIMALS) + 0.0).tolist()
            there = run.is_present(name, times).tolist()
            rows = zip(stamps, figures, there, strict=True)
            tables.append([[stamp, name, *row] if seen else None for stamp, row, seen in rows])
        writer.writerows(row for rows in zip(*tables, strict=True) for row in rows if row)
