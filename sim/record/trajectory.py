"""Trajectories of all bodies as a table in CSV."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import TextIO

import numpy as np
from numpy.typing import NDArray

from .lines import csv_line
from .outcome import Outcome
from .sampling import Array, blocks_of_instants, sample_all

COLUMNS = ("t", "body", "x", "y", "rotation", "vx", "vy")
"""Seconds, a name, metres, metres, radians, m/s, m/s."""

NANOSECOND = 1e-9
"""Seconds between the samples before and after a jump."""

DECIMALS = 6
"""Decimals of the figures."""


@dataclass(frozen=True, eq=False)
class Block:
    """Rows of a trajectory: for each body its figures (N, 5) at N instants, and which it has."""

    times: Array
    is_regular: NDArray[np.bool_]
    """False for the instants of jumps, which are not a rate apart."""
    figures: dict[str, Array]
    there: dict[str, NDArray[np.bool_]]


def blocks(run: Outcome, rate: float) -> Iterator[Block]:
    """Yield the rows of all bodies in order of time, `rate` instants a second (Hz).

    Who is not on the floor has none. Around a jump a body has two more, a nanosecond apart, so that
    nobody takes it for a fast walk.
    """
    jumps = {name: _jumps(run, name) for name in run.motions}
    count = 0
    for times in blocks_of_instants(run.duration, rate):
        count += len(times)
        since, until = times[0], count / rate
        near = {name: t[(since <= t) & (t < until)] for name, t in jumps.items()}
        if any(map(len, near.values())):
            yield _with_jumps(run, times, near)
        else:
            there = {name: run.is_present(name, times) for name in run.motions}
            regular = np.ones(len(times), dtype=bool)
            yield Block(times, regular, sample_all(run.motions, times), there)


def write_trajectory(run: Outcome, file: TextIO, rate: float) -> None:
    """Write the `blocks` of a run as CSV: seconds, metres, radians, m/s."""
    decimals = 3 if (1000 / rate).is_integer() else 9
    file.write(csv_line(COLUMNS))
    names = {name: csv_line([name]).rstrip("\n") for name in run.motions}
    for block in blocks(run, rate):
        stamps = [
            f"{t:.{decimals if is_regular else 9}f}"
            for t, is_regular in zip(block.times.tolist(), block.is_regular.tolist(), strict=True)
        ]
        tables = []
        for name, samples in block.figures.items():
            rows = zip(stamps, _texts(samples), block.there[name].tolist(), strict=True)
            cell = names[name]
            tables.append([f"{t},{cell},{row}\n" if seen else "" for t, row, seen in rows])
        file.writelines(line for rows in zip(*tables, strict=True) for line in rows)


def _jumps(run: Outcome, body: str) -> Array:
    """Return the instants around those at which a body on the floor is put elsewhere on it."""
    begin, end = run.presence[body]
    jumps = np.array([t for t in run.motions[body].jumps if begin < t < end])
    return np.union1d(jumps - NANOSECOND, jumps)


def _with_jumps(run: Outcome, times: Array, jumps: Mapping[str, Array]) -> Block:
    """Return the rows at `times`, and those at the `jumps` of bodies between them."""
    both = np.union1d(times, np.concatenate([*jumps.values()]))
    regular = np.isin(both, times)
    there = {
        name: run.is_present(name, both) & (regular | np.isin(both, jumps[name]))
        for name in run.motions
    }
    return Block(both, regular, sample_all(run.motions, both), there)


def _texts(samples: NDArray[np.float64]) -> list[str]:
    """Return the figures of each of `samples` (N, 5) as they stand in a line.

    A body that stands has the same ones again and again: they are written out once.
    """
    figures = np.round(samples, DECIMALS) + 0.0
    fresh = np.ones(len(figures), dtype=bool)
    fresh[1:] = (figures[1:] != figures[:-1]).any(axis=1)
    texts = [",".join(map(repr, row)) for row in figures[fresh].tolist()]
    return [texts[k] for k in (np.cumsum(fresh) - 1).tolist()]
