"""A run as one table in CSV: a row for every body at every instant."""

from __future__ import annotations

from pathlib import Path

from ..record.outcome import Outcome, write_trajectory


def write(run: Outcome, path: Path, rate: float) -> None:
    """Write `run` to `path` at `rate` (Hz); see `write_trajectory`."""
    with path.open("w", encoding="utf-8", newline="\n") as file:
        write_trajectory(run, file, rate)
