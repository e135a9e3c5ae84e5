"""Outcome of a run, and its trajectories as a CSV table."""

import csv
import io
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import KW_ONLY, field
from functools import cached_property
from pathlib import Path
from typing import Any, TextIO

import numpy as np
from numpy.typing import ArrayLike, NDArray

from floorplan import Floorplan, UserError
from floorplan.files.dataclass import dataclass
from navigation import Motion
from navigation.separation import is_of_speeds

from ..core.body import PERSON
from ..core.recorder import Event, Scene, Thought
from ..safety.laws import Curve, is_of_speeds_alone
from .sampling import Array, Span, blocks_of_instants, instants, sample_all, stays
from .social_metrics import metrics


@dataclass(frozen=True)
class Outcome:
    """Outcome of a run: its summary, its events, and the motion of every body in closed form.

    `violations` contains, for each person and machine, the intervals (s) in which they were closer
    than the rules require. `requirements` contains the required distances, if they cannot be
    computed from speeds. `thoughts` contains the thoughts of people, if a listener wanted them.
    """

    scene: Scene
    duration: float
    _: KW_ONLY
    summary: dict[str, Any]
    events: tuple[Event, ...]
    motions: dict[str, Motion]
    violations: dict[tuple[str, str], tuple[tuple[float, float], ...]]
    thoughts: tuple[Thought, ...] = ()
    requirements: dict[tuple[str, str], Curve] = field(default_factory=dict)

    def __repr__(self) -> str:
        about = f"{self.duration:g} s, {len(self.motions)} bodies, {len(self.events)} events"
        return f"<{type(self).__name__} of {self.scene.trial!r}: {about}>"

    @property
    def floorplan(self) -> Floorplan:
        """Floor of the run."""
        return self.scene.floorplan

    def distance(self, person: str, other: str, t: ArrayLike) -> NDArray[np.float64]:
        """Return the distance between two bodies as the rules measure it.

        Distances are measured between centres, except for AGVs under rules with an `agv_offset`,
        and for machines under rules between surfaces.

        Parameters
        ----------
        person : str
            Name of a person.
        other : str
            Name of a machine or another person.
        t : array_like, shape (N,)
            Times in seconds.

        Returns
        -------
        ndarray, shape (N,)
            Distances in metres.

        Raises
        ------
        KeyError
            If there is no body of that name.
        """
        is_machine = self.scene.kind(other) != PERSON
        shapes = self.scene.shapes(person, other) if is_machine else None
        if shapes is not None:
            times = np.ravel(np.asarray(t, dtype=np.float64))
            motion = self.motions[other]
            poses = np.column_stack([motion.position(times), motion.rotation(times)])
            distances = shapes.distances(self.motions[person].position(times), poses)
            return np.asarray(distances.reshape(np.shape(t)))
        apart = self.motions[other].position(t) - self.motions[person].position(t)
        if is_machine:
            apart = apart + self.scene.rules.measured_at(self.scene.machine(other))
        return np.asarray(np.linalg.norm(apart, axis=-1))

    def required(self, person: str, machine: str, t: ArrayLike) -> NDArray[np.float64]:
        """Return the required distance between a person and a machine.

        With laws that depend on more than speeds it is accurate to 0.01 m.

        Parameters
        ----------
        person, machine : str
            Names.
        t : array_like, shape (N,)
            Times in seconds.

        Returns
        -------
        ndarray, shape (N,)
            Distances in metres.

        Raises
        ------
        KeyError
            If the two were not monitored.
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
        if is_of_speeds_alone(law):  # its formula takes arrays as well
            return np.array(np.broadcast_to(distance(*speeds), times.shape), dtype=np.float64)
        return np.asarray(np.vectorize(distance, otypes=[np.float64])(*speeds))

    def margin(self, person: str, machine: str, t: ArrayLike) -> NDArray[np.float64]:
        """Return the distance minus the required distance.

        Parameters
        ----------
        person, machine, t
            See `required`.

        Returns
        -------
        ndarray, shape (N,)
            Margins in metres, negative during violations.
        """
        return self.distance(person, machine, t) - self.required(person, machine, t)

    def violations_of(self, person: str) -> dict[str, tuple[tuple[float, float], ...]]:
        """Return the violations of a person, by machine.

        Parameters
        ----------
        person : str
            Name of the person.

        Returns
        -------
        dict of str to tuple of (float, float)
            Intervals in seconds.
        """
        return {pair[1]: some for pair, some in self.violations.items() if pair[0] == person}

    @cached_property
    def stays(self) -> dict[str, tuple[tuple[float, float], ...]]:
        """Intervals (begin, end) in seconds in which each body is on the floor.

        Otherwise its motion is far outside.
        """
        return stays(self.motions, self.events, self.duration)

    @cached_property
    def presence(self) -> dict[str, tuple[float, float]]:
        """First entry and last exit of each body in seconds.

        Both are the end of the run for a body that is never on the floor.
        """
        return {
            name: (mine[0][0], mine[-1][1]) if mine else (self.duration, self.duration)
            for name, mine in self.stays.items()
        }

    def is_present(self, body: str, times: NDArray[np.float64]) -> NDArray[np.bool_]:
        """Return whether a body is on the floor.

        Parameters
        ----------
        body : str
            Name of the body.
        times : ndarray, shape (N,)
            Times in seconds.
        """
        there = np.zeros(times.shape, dtype=bool)
        for begin, end in self.stays[body]:
            until = times <= end if end == self.duration else times < end
            there |= (times >= begin) & until & (begin < self.duration)
        return there

    @cached_property
    def metrics(self) -> dict[str, Any]:
        """Metrics of social navigation. See `sim.metrics`."""
        return metrics(self)

    def sample(self, rate: float = 20.0) -> dict[str, NDArray[np.float64]]:
        """Return the trajectories of all bodies, sampled from 0 to the end.

        Parameters
        ----------
        rate : float, optional
            Sampling rate in Hz.

        Returns
        -------
        dict of str to ndarray
            "t", shape (N,), in seconds. For each body, shape (N, 5): x and y in metres, rotation in
            radians, and velocity along x and y in m/s.

        Raises
        ------
        ValueError
            If the rate is not positive.
        """
        times = instants(self.duration, rate)
        return {"t": times, **sample_all(self.motions, times)}

    def table(self, rate: float = 20.0) -> dict[str, NDArray[Any]]:
        """Return the trajectories of all bodies as columns of one table, in order of time.

        There are no rows for bodies that are not on the floor.

        Parameters
        ----------
        rate : float, optional
            Sampling rate in Hz.

        Returns
        -------
        dict of str to ndarray
            "t" (s), "body", "x", "y" (m), "rotation" (rad), "vx" and "vy" (m/s), each of shape
            (N,).

        Raises
        ------
        ValueError
            If the rate is not positive.

        Examples
        --------
        `pandas.DataFrame(run.table())` is a data frame.
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


def csv_line(cells: Iterable[str]) -> str:
    """Return texts as a line of CSV, quoted if necessary."""
    line = io.StringIO()
    csv.writer(line, lineterminator="\n").writerow(cells)
    return line.getvalue()


class WholeLines:
    """Writer of a text file that writes each line completely or, on failure, nothing of it.

    Without `end` the file is new, and `FileExistsError` is raised if it exists. Otherwise the file
    is cut to its first `end` bytes and continued.
    """

    def __init__(self, path: Path, end: int | None = None) -> None:
        self._file = path.open("xb" if end is None else "ab", buffering=0)
        self._end = end or 0
        self._file.truncate(self._end)

    def write(self, line: str) -> None:
        """Add a line. Raises `OSError` if the disk is full, without leaving a part of it."""
        data = memoryview(f"{line}\n".encode())
        at = 0
        try:
            while at < len(data):
                at += self._file.write(data[at:])
        except OSError:
            self._file.truncate(self._end)
            self._file.seek(self._end)
            raise
        self._end += len(data)

    def close(self) -> None:
        """Close the file."""
        self._file.close()


COLUMNS = ("t", "body", "x", "y", "rotation", "vx", "vy")
"""Columns of a trajectory: s, name, m, m, rad, m/s, m/s."""

NANOSECOND = 1e-9
"""Seconds between the samples before and after a jump."""

DECIMALS = 6
"""Number of decimals of the values."""


@dataclass(frozen=True, eq=False)
class Block:
    """Rows of a trajectory: values (N, 5) of each body at N times, and whether it is present."""

    times: Array
    is_regular: NDArray[np.bool_]
    """False for the instants of jumps, which are not a rate apart."""
    figures: dict[str, Array]
    there: dict[str, NDArray[np.bool_]]


def blocks(run: Outcome, rate: float) -> Iterator[Block]:
    """Yield the rows of all bodies in order of time at a sampling rate (Hz).

    A body has no rows while it is not on the floor. At a jump it has two more rows, a nanosecond
    apart, to distinguish the jump from fast walking.
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
    """Return the times around those at which a present body jumps to another position."""
    jumps = [
        t for t in run.motions[body].jumps for begin, end in run.stays[body] if begin < t < end
    ]
    return np.array(sorted({*(t - NANOSECOND for t in jumps), *jumps}), dtype=float)


def _with_jumps(run: Outcome, times: Array, jumps: Mapping[str, Array]) -> Block:
    """Return the rows at `times`, and those at the `jumps` of bodies between them."""
    # `np.union1d` and `np.isin` would import numpy.ma, which takes longer than writing the rows.
    both = np.sort(np.concatenate([times, *jumps.values()]))
    both = both[np.append(True, both[1:] != both[:-1])]
    regular = _are_among(both, times)
    there = {
        name: run.is_present(name, both) & (regular | _are_among(both, jumps[name]))
        for name in run.motions
    }
    return Block(both, regular, sample_all(run.motions, both), there)


def _are_among(times: Array, rising: Array) -> NDArray[np.bool_]:
    """Return which of `times` (N,) are among other times, which increase."""
    return np.searchsorted(rising, times, "left") < np.searchsorted(rising, times, "right")


def _texts(samples: NDArray[np.float64]) -> list[str]:
    """Return the cells of each row of `samples` (N, 5).

    Rows of a stationary body are equal and formatted once.
    """
    figures = np.round(samples, DECIMALS) + 0.0
    fresh = np.ones(len(figures), dtype=bool)
    fresh[1:] = (figures[1:] != figures[:-1]).any(axis=1)
    texts = [",".join(map(repr, row)) for row in figures[fresh].tolist()]
    return [texts[k] for k in (np.cumsum(fresh) - 1).tolist()]


def span_of(run: Outcome, within: Span | None) -> Span:
    """Return the time span to draw: `within`, clipped to the run, or the whole run.

    Raises `ValueError` if it is empty.
    """
    begin, end = within or (0.0, run.duration)
    begin, end = max(begin, 0.0), min(end, run.duration)
    if not begin < end:
        raise UserError(
            f"there is nothing between {begin:g} and {end:g} s: the run goes from 0 to"
            f" {run.duration:g} s"
        )
    return begin, end
