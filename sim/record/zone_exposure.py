"""Exposure: how long people are in each zone of a floor, and how long too close to a machine."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import shapely
from numpy.typing import NDArray

from floorplan import Zone
from navigation import Motion

from .presence import Span

MOMENT = 0.02
"""Seconds. Whoever moves is looked at so often."""

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Stay:
    """Somebody who is on the floor for a `span` of a run, and `too_close` within some intervals."""

    motion: Motion
    span: Span
    too_close: Sequence[Span]


def zone_exposures(zones: Sequence[Zone], stays: Sequence[Stay]) -> dict[str, dict[str, float]]:
    """Return figures of each zone by name, of all people together; where their centre is counts.

    `time_occupied` and `time_too_close` are in seconds, right to 0.02 s for each time that
    somebody goes in or out; `entries` is how often somebody comes in, or is there at first.
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


def _inside(zone: Zone, x: Array, y: Array) -> NDArray[np.bool_]:
    """Return which places (metres, (N,) each) are in a zone; only those in its bounds are asked."""
    west, south, east, north = zone.area.bounds
    inside: NDArray[np.bool_] = (x >= west) & (x <= east) & (y >= south) & (y <= north)
    inside[inside] = shapely.intersects_xy(zone.area, x[inside], y[inside])
    return inside


def moments(motion: Motion, begin: float, end: float) -> tuple[Array, Array]:
    """Return the middles and lengths (seconds, (N,) each) of parts of a motion between instants.

    Parts in which it moves are no longer than `MOMENT`; in the others it stands.
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


def within(times: Array, intervals: Sequence[Span]) -> NDArray[np.bool_]:
    """Return for each of `times` (seconds) whether it lies in one of the intervals."""
    found = np.zeros(len(times), dtype=bool)
    for begin, end in intervals:
        found |= (times >= begin) & (times < end)
    return found
