"""Sampling of motions: presence, sample times, grid cells, and dwell times in zones."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence

import numpy as np
import shapely
from numpy.typing import NDArray

from floorplan import Floorplan, UserError, Zone
from floorplan.files.dataclass import dataclass
from navigation import Motion

from ..core.recorder import Event

Span = tuple[float, float]
"""Begin and end in seconds."""

ROUNDING = 1e-8
"""Seconds. Times of events are rounded to less than this."""


def stays(
    motions: Mapping[str, Motion], events: Iterable[Event], duration: float
) -> dict[str, tuple[Span, ...]]:
    """Return the intervals in which each body of a run is on the floor.

    Their times are exact times of motions. Times of events are rounded.
    """
    spans: dict[str, tuple[Span, ...]] = dict.fromkeys(motions, ((0.0, duration),))
    for event in events:
        kind, person = event["kind"], event.get("person")
        if kind not in ("awaited", "entered", "left") or person not in spans:
            continue
        if kind == "awaited":
            spans[person] = ()
            continue
        t, before = _exact(motions[person], event["t"]), spans[person]
        if kind == "entered":
            spans[person] = (*before, (t, duration))
        elif before:
            spans[person] = (*before[:-1], (before[-1][0], t))
    return spans


def _exact(motion: Motion, t: float) -> float:
    """Return the exact time of the jump recorded at `t` (s)."""
    return next((jump for jump in motion.jumps if abs(jump - t) < ROUNDING), t)


Array = NDArray[np.float64]

BLOCK = 8192
"""Number of times that are sampled together."""

MOST = 100_000_000
"""Maximum number of sample times of a run."""


def instants(duration: float, rate: float) -> Array:
    """Return times (N,) from 0 to `duration` (s) at `rate` (Hz).

    `ValueError` if the rate is not positive, or if there are more than `MOST` times.
    """
    require_instants(duration, rate)
    return np.arange(_count(duration, rate)) / rate


def blocks_of_instants(duration: float, rate: float) -> Iterator[Array]:
    """Yield the same times, at most `BLOCK` of them together."""
    count = _count(duration, rate)
    for first in range(0, count, BLOCK):
        yield np.arange(first, min(first + BLOCK, count)) / rate


def sample(motion: Motion, times: Array) -> Array:
    """Return x, y, rotation and velocity of a motion at `times` (N,), shape (N, 5).

    Units are m, rad and m/s.
    """
    return np.column_stack([motion.position(times), motion.rotation(times), motion.velocity(times)])


def sample_all(motions: Mapping[str, Motion], times: Array) -> dict[str, Array]:
    """Return the samples of every motion at `times` (N,) by name. See `sample`."""
    return {name: sample(motion, times) for name, motion in motions.items()}


def require_rate(rate: float) -> None:
    """Raise `ValueError` if `rate` (Hz) is not positive and finite."""
    if not (np.isfinite(rate) and rate > 0):
        raise UserError(f"rate must be more than 0 Hz, not {rate:g}")


def require_instants(duration: float, rate: float) -> None:
    """Raise `ValueError` if `duration` (s) at `rate` (Hz) has more than `MOST` times."""
    if duration * rate > MOST:
        raise UserError(f"{duration:g} s at {rate:g} Hz are more than {MOST:,} instants")


def _count(duration: float, rate: float) -> int:
    require_rate(rate)
    # The product may be slightly less than a whole number, as 4.35 × 100 is.
    return int(duration * rate + 1e-9) + 1


CellArray = NDArray[np.float64]

_HAIR = 1e-9
"""Metres. Tolerance of the distance between cells."""


def cells_of(plan: Floorplan, side: float) -> tuple[int, int]:
    """Return the number of rows and columns of cells with this side (m) in the floor's bounds."""
    west, south, east, north = plan.boundary.bounds
    return (math.ceil((north - south) / side), math.ceil((east - west) / side))


def spread(
    cells: CellArray, side: float, radius: float, join: Callable[..., CellArray], nothing: float
) -> CellArray:
    """Return each cell joined with all cells within `radius` (m). `side` is in metres.

    `nothing` is the value beyond the floor.
    """
    reach = math.ceil(radius / side)
    rows, columns = cells.shape
    padded = np.pad(cells, reach, constant_values=nothing)
    joined = np.full_like(cells, nothing)
    for i in range(-reach, reach + 1):
        for j in range(-reach, reach + 1):
            # The array is shifted once for each cell of the disc: a dilation, or a sum, by its
            # mask.
            if math.hypot(i, j) * side < radius + _HAIR:
                joined = join(joined, padded[reach + i :, reach + j :][:rows, :columns])
    return joined


MOMENT = 0.02
"""Seconds. Sampling interval of moving bodies."""

TimeArray = NDArray[np.float64]


@dataclass(frozen=True)
class Stay:
    """A person's `span` on the floor, and the intervals in which they are `too_close`."""

    motion: Motion
    span: Span
    too_close: Sequence[Span]


def zone_exposures(zones: Sequence[Zone], stays: Sequence[Stay]) -> dict[str, dict[str, float]]:
    """Return figures of each zone by name, for all people. A person is where their centre is.

    `time_occupied` and `time_too_close` are in seconds, with an error of at most 0.02 s per
    crossing of the border. `entries` counts entries, and people who are inside at first.
    """
    figures: dict[str, dict[str, float]] = {
        zone.name: {"time_occupied": 0.0, "time_too_close": 0.0, "entries": 0} for zone in zones
    }
    for stay in stays if zones else ():
        times, lengths = moments(stay.motion, *stay.span)
        x, y = stay.motion.position(times).reshape(-1, 2).T
        near = within(times, stay.too_close)
        for zone in zones:
            inside = _inside(zone, x, y)
            mine = figures[zone.name]
            mine["time_occupied"] += float(lengths[inside].sum())
            mine["entries"] += int(np.sum(inside[1:] & ~inside[:-1])) + int(inside[:1].sum())
            mine["time_too_close"] += float((lengths * near)[inside].sum())
    return figures


def _inside(zone: Zone, x: TimeArray, y: TimeArray) -> NDArray[np.bool_]:
    """Return which positions (m, (N,) each) are in a zone, testing only those in its bounds."""
    west, south, east, north = zone.area.bounds
    inside: NDArray[np.bool_] = (x >= west) & (x <= east) & (y >= south) & (y <= north)
    inside[inside] = shapely.intersects_xy(zone.area, x[inside], y[inside])
    return inside


def moments(motion: Motion, begin: float, end: float) -> tuple[TimeArray, TimeArray]:
    """Return the middles and durations (s, (N,) each) of parts of a motion from `begin` to `end`.

    Parts with motion are at most `MOMENT` long.
    """
    if end <= begin:
        return np.empty(0), np.empty(0)
    middles, lengths = [], []
    for piece in motion.cut(begin, end).pieces:
        duration = piece.end - piece.begin
        count = max(1, math.ceil(duration / MOMENT)) if piece.moves else 1
        middles.append(piece.begin + duration / count * (np.arange(count) + 0.5))
        lengths.append(np.full(count, duration / count))
    return np.concatenate(middles), np.concatenate(lengths)


def within(times: TimeArray, intervals: Sequence[Span]) -> NDArray[np.bool_]:
    """Return which of `times` (s) lie in one of the intervals."""
    inside = np.zeros(len(times), dtype=bool)
    for begin, end in intervals:
        inside |= (times >= begin) & (times < end)
    return inside
