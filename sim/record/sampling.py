"""Motions as tables: where bodies are at instants a rate apart."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

import numpy as np
from numpy.typing import NDArray

from floorplan import UserError
from navigation import Motion

Array = NDArray[np.float64]

BLOCK = 8192
"""Number of instants worked out at a time when a run is sampled piece by piece."""

MOST = 100_000_000
"""Largest number of instants at which a run is sampled."""


def instants(duration: float, rate: float) -> Array:
    """`rate` instants a second (Hz), from 0 to `duration` (seconds): (N,).

    `ValueError` if the rate isn't positive, or if there are more than `MOST` instants.
    """
    require_instants(duration, rate)
    return np.arange(_count(duration, rate)) / rate


def blocks_of_instants(duration: float, rate: float) -> Iterator[Array]:
    """The same instants, `BLOCK` of them at a time."""
    count = _count(duration, rate)
    for first in range(0, count, BLOCK):
        yield np.arange(first, min(first + BLOCK, count)) / rate


def sample(motion: Motion, times: Array) -> Array:
    """A motion at `times` (N,): x, y, rotation, and the velocity along x and y, (N, 5).

    Metres, radians, m/s.
    """
    return np.column_stack([motion.position(times), motion.rotation(times), motion.velocity(times)])


def sample_all(motions: Mapping[str, Motion], times: Array) -> dict[str, Array]:
    """Every motion at `times` (N,) as `sample` has it, by its name."""
    return {name: sample(motion, times) for name, motion in motions.items()}


def require_rate(rate: float) -> None:
    """`ValueError` if `rate` is nothing to sample at (Hz)."""
    if not (np.isfinite(rate) and rate > 0):
        raise UserError(f"rate must be more than 0 Hz, not {rate:g}")


def require_instants(duration: float, rate: float) -> None:
    """`ValueError` if `duration` (seconds) at `rate` (Hz) is more than `MOST` instants."""
    if duration * rate > MOST:
        raise UserError(f"{duration:g} s at {rate:g} Hz are more than {MOST:,} instants")


def _count(duration: float, rate: float) -> int:
    require_rate(rate)
    # The product may be a hair less than the whole number that is meant: 4.35 × 100 is.
    return int(duration * rate + 1e-9) + 1
