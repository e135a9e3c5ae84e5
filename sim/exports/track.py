"""A run for viewers that draw from frames and poses, moment by moment."""

from __future__ import annotations

import heapq
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise
from operator import attrgetter

import numpy as np

from navigation import Motion

from ..core.recorder import Event
from ..record.outcome import Outcome
from ..record.sampling import blocks_of_instants, sample
from ..record.trajectory import NANOSECOND

ROUNDING = 1e-8
"""Seconds. Instants of events are rounded to less than this, instants of motions are exact."""


_SETS_OUT = ("goal", "replanned")
_IS_PUT = ("teleport", "left")
"""Events at which a path begins, and at which one ends that was under way."""


@dataclass(frozen=True)
class Pose:
    """The pose of a body: x, y (metres), rotation (radians); and its velocity (m/s)."""

    body: str
    x: float
    y: float
    rotation: float
    vx: float
    vy: float


@dataclass(frozen=True)
class WalkedPath:
    """The path of a person from `t` (seconds) until a new goal: (x, y, rotation) of its points."""

    t: float
    person: str
    points: tuple[tuple[float, float, float], ...]


@dataclass(frozen=True)
class Moment:
    """The news of the instant `t` (seconds): poses of bodies, an event, or a path that begins."""

    t: float
    poses: tuple[Pose, ...] = ()
    event: Event | None = None
    path: WalkedPath | None = None


def moments(run: Outcome, rate: float) -> Iterator[Moment]:
    """Return the moments of a run in order of time, with the pose of every body at `rate` (Hz).

    Who is not on the floor has none but the jump by which they come or go, from or to far outside.

    Viewers draw a straight line from one pose to the next: another pose a nanosecond before
    every jump, and one at it, keep them from drawing a body that slides over the floor.
    """
    return heapq.merge(
        (Moment(event["t"], event=event) for event in run.events),
        (Moment(path.t, path=path) for path in walked_paths(run)),
        _regular(run, rate),
        _jumps(run),
        key=attrgetter("t"),
    )


def walked_paths(run: Outcome) -> list[WalkedPath]:
    """Return the paths of people from goal to goal, in order of time; as walked, not as planned."""
    found: list[WalkedPath] = []
    for person in run.scene.people:
        changes = [
            event
            for event in run.events
            if event["kind"] in (*_SETS_OUT, *_IS_PUT) and event["person"] == person.name
        ]
        ends = [*(event["t"] for event in changes[1:]), run.duration]
        for event, end in zip(changes, ends, strict=False):
            begin = event["t"] + ROUNDING
            if event["kind"] in _SETS_OUT and end - ROUNDING > begin:
                motion = run.motions[person.name].cut(begin, end - ROUNDING)
                found.append(WalkedPath(event["t"], person.name, _corners(motion)))
    return sorted(found, key=attrgetter("t"))


def just_before(run: Outcome, body: str, event: Event) -> tuple[float, float]:
    """Return the place (x, y in metres) of a body just before `event`, not where that put it."""
    return run.motions[body].state(event["t"] - ROUNDING).at


def nanoseconds(t: float) -> int:
    """Return an instant (seconds) in nanoseconds, as viewers count."""
    return round(t * 1e9)


def _regular(run: Outcome, rate: float) -> Iterator[Moment]:
    for times in blocks_of_instants(run.duration, rate):
        tables = {name: sample(m, times).tolist() for name, m in run.motions.items()}
        there = {name: run.is_present(name, times).tolist() for name in run.motions}
        for k, t in enumerate(times.tolist()):
            poses = (Pose(name, *table[k]) for name, table in tables.items() if there[name][k])
            yield Moment(t, tuple(poses))


def _jumps(run: Outcome) -> list[Moment]:
    found = [
        Moment(t, (Pose(name, *sample(motion, np.array([t]))[0].tolist()),))
        for name, motion in run.motions.items()
        for jump in motion.jumps
        for t in (jump - NANOSECOND, jump)
    ]
    return sorted(found, key=attrgetter("t"))


def _corners(motion: Motion) -> tuple[tuple[float, float, float], ...]:
    """Return the poses at which the pieces of a motion begin, and the last one ends; none twice."""
    corners = [motion.state(piece.begin).position for piece in motion.pieces]
    corners.append(motion.state_before(motion.end).position)
    new = [after for before, after in pairwise(corners) if after[:2] != before[:2]]
    return (corners[0], *new)
