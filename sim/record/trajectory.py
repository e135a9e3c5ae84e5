"""Trajectories of all bodies as a table in CSV."""

from __future__ import annotations

import csv
from typing import TextIO

from .outcome import Outcome
from .sampling import blocks_of_instants, sample_all

COLUMNS = ("t", "body", "x", "y", "rotation", "vx", "vy")
"""Seconds, a name, metres, metres, radians, m/s, m/s."""

DECIMALS = 6
"""Decimals of the figures."""


def write_trajectory(run: Outcome, file: TextIO, rate: float) -> None:
    """Every body at `rate` instants a second (Hz) as CSV: metres, radians, m/s."""
    decimals = 3 if (1000 / rate).is_integer() else 9
    writer = csv.writer(file, lineterminator="\n")
    writer.writerow(COLUMNS)
    for times in blocks_of_instants(run.duration, rate):
        samples = sample_all(run.motions, times)
        rows = {name: (values + 0.0).tolist() for name, values in samples.items()}
        for k, t in enumerate(times.tolist()):
            stamp = f"{t:.{decimals}f}"
            writer.writerows(
                [stamp, name, *(round(v, DECIMALS) for v in of_body[k])]
                for name, of_body in rows.items()
            )
