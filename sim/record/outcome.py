"""Outcome of a run."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from floorplan import Floorplan
from navigation import Motion, is_of_speeds

from ..core.body import PERSON
from ..core.recorder import Event, Thought
from ..core.scene import Scene
from ..safety.requirement_curve import Curve, is_plain
from .presence import presence
from .sampling import instants, sample_all
from .social_metrics import metrics


@dataclass(frozen=True)
class Outcome:
    """A run that happened: its summary, its events, and the motion of every body in closed form.

    `scene` is where it took place. `violations` holds, for each person and machine, the intervals
    (seconds) in which they were closer than the rules require; `requirements` what the rules
    required of them, where that can't be worked out from speeds and the terms of a known law.
    `thoughts` holds what went on in people's minds, if a listener wanted to know (as a
    `Recording` does).
    """

    scene: Scene
    duration: float
    summary: dict[str, Any]
    events: tuple[Event, ...]
    motions: dict[str, Motion]
    violations: dict[tuple[str, str], tuple[tuple[float, float], ...]]
    thoughts: tuple[Thought, ...] = ()
    requirements: dict[tuple[str, str], Curve] = field(default_factory=dict, kw_only=True)

    def __repr__(self) -> str:
        about = f"{self.duration:g} s, {len(self.motions)} bodies, {len(self.events)} events"
        return f"<{type(self).__name__} of {self.scene.trial!r}: {about}>"

    @property
    def floorplan(self) -> Floorplan:
        """The floor it took place on."""
        return self.scene.floorplan

    def distance(self, person: str, other: str, t: ArrayLike) -> NDArray[np.float64]:
        """Return the distance in metres between two bodies at `t` (seconds), as the rules measure.

        One figure for each time: between centres, but for AGVs under rules with an `agv_offset`.
        `other` is a machine, or a person. `KeyError` if there is no such body.
        """
        apart = self.motions[other].position(t) - self.motions[person].position(t)
        if self.scene.kind(other) != PERSON:
            apart = apart + self.scene.rules.measured_at(self.scene.machine(other))
        return np.asarray(np.linalg.norm(apart, axis=-1))

    def required(self, person: str, machine: str, t: ArrayLike) -> NDArray[np.float64]:
        """The distance in metres that the rules required between two bodies at `t` (seconds).

        One figure for each time; right to 0.01 m with a law that looks at more than speeds.
        `KeyError` if the two were not watched.
        """
        times = np.asarray(t, dtype=np.float64)
        curve = self.requirements.get((person, machine))
        if curve is not None:
            return np.asarray(np.interp(times, *np.array(curve).T))
        law = self.scene.rules.law_of(self.scene.machine(machine))
        if not is_of_speeds(law):
            raise KeyError((person, machine))
        speeds = [np.hypot(*self.motions[name].velocity(times).T) for name in (person, machine)]
        distance: Any = law.distance
        if is_plain(law):  # its formula takes arrays as well
            return np.array(np.broadcast_to(distance(*speeds), times.shape), dtype=np.float64)
        return np.asarray(np.vectorize(distance, otypes=[np.float64])(*speeds))

    def margin(self, person: str, machine: str, t: ArrayLike) -> NDArray[np.float64]:
        """Return `distance` less `required`: what two bodies have to spare at `t`, metres."""
        return self.distance(person, machine, t) - self.required(person, machine, t)

    def violations_of(self, person: str) -> dict[str, tuple[tuple[float, float], ...]]:
        """Return the `violations` of a person, by machine."""
        return {pair[1]: some for pair, some in self.violations.items() if pair[0] == person}

    @cached_property
    def presence(self) -> dict[str, tuple[float, float]]:
        """From when to when (s) each body is on the floor; it is far outside before and after."""
        return presence(self.motions, self.events, self.duration)

    def is_present(self, body: str, times: NDArray[np.float64]) -> NDArray[np.bool_]:
        """Return for each of `times` (s) whether a body is on the floor."""
        begin, end = self.presence[body]
        until = times <= end if end == self.duration else times < end
        return np.asarray((times >= begin) & until & (begin < self.duration))

    @cached_property
    def metrics(self) -> dict[str, Any]:
        """The metrics of social navigation, as `sim.metrics` works them out."""
        return metrics(self)

    def sample(self, rate: float = 20.0) -> dict[str, NDArray[np.float64]]:
        """Every body at `rate` instants a second (Hz), from 0 to the end.

        The result has "t" (N,) in seconds, and for each body (N, 5): x, y in metres, rotation
        in radians, and the velocity along x and y in m/s. `ValueError` if the rate isn't positive.
        """
        times = instants(self.duration, rate)
        return {"t": times, **sample_all(self.motions, times)}

    def table(self, rate: float = 20.0) -> dict[str, NDArray[Any]]:
        """Every body on the floor at `rate` instants a second (Hz), as the columns of one table.

        They are "t" (s), "body", "x", "y" (m), "rotation" (rad), "vx" and "vy" (m/s), in order of
        time: `pandas.DataFrame(run.table())`. Who is not there at an instant has no row.
        `ValueError` if the rate isn't positive.
        """
        times = instants(self.duration, rate)
        there = np.array([self.is_present(name, times) for name in self.motions], dtype=bool)
        seen = there.reshape(-1, len(times)).T  # (N, B), like what follows
        sampled = sample_all(self.motions, times).values()
        figures = np.stack([np.empty((len(times), 5)), *sampled], axis=1)[:, 1:][seen]
        return {
            "t": np.broadcast_to(times[:, np.newaxis], seen.shape)[seen],
            "body": np.broadcast_to(np.array(list(self.motions), dtype=str), seen.shape)[seen],
            **dict(zip(("x", "y", "rotation", "vx", "vy"), figures.T, strict=True)),
        }
