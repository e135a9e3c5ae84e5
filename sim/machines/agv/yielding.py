"""AGVs that yield: the test that one can still stop before a person comes too close."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import NamedTuple

from floorplan import Lane
from navigation import AnyLaw, AxisState, Motion, lane_state, required_at_speeds

from ...core.body import Body

LOOK = 0.1
"""Seconds between two looks of an AGV that yields at where people are."""

STRIDE = 0.05
"""Seconds. Length of the strides into which the path ahead is cut; each is judged by its worst."""

MARGIN = 0.02
"""Metres. Kept beyond the required distance, so that rounding can't decide."""

SPEEDS = 40
"""The required distance is computed for so many speeds, and taken from the next higher one."""


@dataclass(frozen=True)
class Sighting:
    """Somebody an AGV yields to: their distance from its centre, and the required one (metres)."""

    name: str
    distance: float
    required: float


class Foresight:
    """Worst-case test of a motion on a lane, by people's positions and top speeds.

    A motion is safe if all along it nobody who walks straight at the AGV from now on, at top
    speed, gets closer than the rules' law requires of somebody of that speed.
    """

    # A person of top speed v is within v t of their present place at t, whatever they do, so that
    # their distance from the AGV is at least the present distance from its place at t, less v t.
    # Over a stride of the motion each term takes its worst value: the nearest point of the
    # stretch, the reach at the stride's end, the highest speed that the AGV has in it. The test
    # therefore covers every instant and not samples of them, and errs on the safe side alone. As
    # the stop at the end of the drive belongs to the motion, an AGV that passed the last look can
    # still stop safely if it fails the next: no later look has to succeed.

    def __init__(self, lane: Lane, law: AnyLaw, offset: float) -> None:
        self._lane = lane
        self._law = law
        self._offset = offset
        self._people: list[tuple[Body, float, list[float]]] = []

    def watch(self, person: Body, top_speed: float) -> None:
        """Yield to this person from now on, who walks at `top_speed` (m/s) at most."""
        step = self._lane.max_speed / SPEEDS
        required = [required_at_speeds(self._law, top_speed, k * step) for k in range(SPEEDS + 1)]
        self._people.append((person, top_speed, required))

    def in_the_way(self, motion: Motion, now: float, seconds: float) -> Sighting | None:
        """Return who makes it unsafe to follow `motion` for `seconds` from `now` and then to stop.

        None if it is safe.
        """
        strides = [*self._strides(motion, now, max(0.0, min(seconds, motion.end - now)))]
        for person, top_speed, required in self._people:
            along, across = self._on_lane(person.at)
            for stride in strides:
                kept = required[self._grade(stride.speed)] + MARGIN
                beside = max(stride.low - along, along - stride.high, 0.0)
                if math.hypot(beside, across) - top_speed * stride.until < kept:
                    here = math.hypot(along - strides[0].begin, across)
                    return Sighting(person.name, here, kept)
        return None

    def _strides(self, motion: Motion, now: float, drive: float) -> Iterator[_Stride]:
        """Yield the strides of `motion` for `drive` seconds, and then those of braking."""
        speed = max(
            motion.state(t).speed for t in (now, *(p.begin for p in motion.pieces_from(now)))
        )
        count = math.ceil(drive / STRIDE)
        places = [self._state(motion, now + drive * k / count).position for k in range(count)]
        state = self._state(motion, now + drive)
        for k, (a, b) in enumerate(itertools.pairwise([*places, state.position]), 1):
            yield _Stride(a, b, drive * k / count, speed)
        for stride in _braking(state, self._lane.max_acceleration):
            yield stride._replace(until=drive + stride.until)

    def _state(self, motion: Motion, t: float) -> AxisState:
        return lane_state(self._lane, motion.state(t))

    def _on_lane(self, at: tuple[float, float]) -> tuple[float, float]:
        """Return the position of a place along the lane, and its distance from the lane (metres).

        Along the lane from where the AGV's measured point is at position 0.
        """
        (x0, y0), (c, s) = self._lane.origin, self._lane.direction
        x, y = at[0] - x0, at[1] - y0
        return x * c + y * s - self._offset, abs(y * c - x * s)

    def _grade(self, speed: float) -> int:
        return min(math.ceil(speed / self._lane.max_speed * SPEEDS - 1e-9), SPEEDS)


class _Stride(NamedTuple):
    """A stretch of the path ahead: from lane position `begin` to `end`, over after `until` seconds.

    `speed` (m/s) is the highest that counts for it.
    """

    begin: float
    end: float
    until: float
    speed: float

    @property
    def low(self) -> float:
        return min(self.begin, self.end)

    @property
    def high(self) -> float:
        return max(self.begin, self.end)


def _braking(state: AxisState, deceleration: float) -> Iterator[_Stride]:
    """Yield the strides of the fastest stop from `state`."""
    q, v = state.position, state.velocity
    duration = abs(v) / deceleration
    count = math.ceil(duration / STRIDE)
    place = q
    for k in range(1, count + 1):
        until = duration * k / count
        before = duration * (k - 1) / count
        onwards = q + math.copysign(1.0, v) * (abs(v) * until - deceleration * until**2 / 2)
        yield _Stride(place, onwards, until, abs(v) - deceleration * before)
        place = onwards
