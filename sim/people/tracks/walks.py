"""Recorded walks: the motions of people who walk as they were measured."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from functools import lru_cache
from pathlib import Path

import numpy as np
import shapely
from numpy.lib.stride_tricks import sliding_window_view
from numpy.typing import NDArray

from floorplan import Floorplan, Problem, is_there, suggestion
from navigation import Motion, join

from ...core.recorded_track import RecordedTrack
from ...core.scenario import PersonEntry, Scenario
from .bags import files_of, read_bag_tracks
from .jupedsim_tracks import read_jupedsim_tracks
from .samples import Array, Samples, TrackError, Tracks
from .text_tracks import read_parquet_tracks, read_text_tracks

READERS = {
    ".csv": read_text_tracks,
    ".txt": read_text_tracks,
    ".parquet": read_parquet_tracks,
    ".sqlite": read_jupedsim_tracks,
    ".mcap": read_bag_tracks,
    ".db3": read_bag_tracks,
}
"""Readers of files with tracks, by suffix. A folder is a bag of ROS 2."""

STROLL = 0.1
"""m/s. Who is slower than this looks where they looked before."""

SHORTEST = 1e-6
"""Seconds. Samples that are nearer are at one time, where a body jumps."""

MOST_AT_ONCE = 3
"""Samples at one time, at most: before and after a jump, and one of a regular series."""


@dataclass(frozen=True, eq=False)
class RecordedWalk:
    """The motion of somebody since their start (seconds), and a speed (m/s) they never exceed."""

    motion: Motion
    top_speed: float

    @property
    def at(self) -> tuple[float, float]:
        """Where they start (x, y in metres)."""
        return self.motion.state(0.0).at


def recorded_walks(scenario: Scenario) -> dict[str, RecordedWalk]:
    """Return the walks of all people of a scenario who were recorded, by name.

    `TrackError` says in which row of which file a track is unfit.
    """
    return {
        entry.name: recorded_walk(entry, scenario)
        for entry in scenario.people
        if entry.recorded is not None
    }


def recorded_walk(entry: PersonEntry, scenario: Scenario) -> RecordedWalk:
    """Return the walk of a person of `scenario` who was recorded."""
    recorded = entry.recorded
    assert recorded is not None
    if isinstance(recorded, Motion):
        return RecordedWalk(recorded, _top_speed(recorded))
    tracks, samples = _samples(recorded, entry.name, scenario.folder)
    t = samples.t / (_frame_rate(recorded, tracks) or 1.0) - recorded.since
    k = max(0, int(np.searchsorted(t, 0.0, side="right")) - 1)
    t, xy = t[k:], np.column_stack([samples.x, samples.y])[k:]
    turned = None if samples.rotation is None else samples.rotation[k:]
    parts = []
    for part in _on_floor(_parts(t), xy, scenario.floorplan):
        looks = _headings(t[part], xy[part]) if turned is None else turned[part]
        parts.append(Motion.from_samples(t[part], xy[part], looks))
    motion = join(parts)
    return RecordedWalk(motion, _top_speed(motion))


def track_faults(entry: PersonEntry, scenario: Scenario) -> Iterator[str]:
    """Yield what can't be about the track of somebody in a scenario."""
    recorded = entry.recorded
    if recorded is None or isinstance(recorded, Motion):
        return
    try:
        tracks, samples = _samples(recorded, entry.name, scenario.folder)
        problems = list(_problems(recorded, tracks, samples, scenario))
    except TrackError as why:
        yield str(why)
        return
    if problems:
        yield str(TrackError(recorded.file, problems))


def with_places(scenario: Scenario, walks: Mapping[str, RecordedWalk]) -> tuple[PersonEntry, ...]:
    """Return the people of a scenario; those who were recorded start where their walks do."""
    return tuple(
        replace(entry, at=walks[entry.name].at) if entry.name in walks else entry
        for entry in scenario.people
    )


def _samples(recorded: RecordedTrack, name: str, folder: Path) -> tuple[Tracks, Samples]:
    """Return the tracks of a file, and the samples of the body that is meant there."""
    path = folder / recorded.file
    try:
        if path.suffix.lower() not in READERS and not path.is_dir():
            known = ", ".join(READERS)
            message = (
                f"the name of a file of tracks ends in one of {known}, or it is a bag's folder"
            )
            raise TrackError.of(recorded.file, message)
        if not is_there(path):
            raise TrackError.of(recorded.file, "there is no such file")
        stamps = [(file.stat().st_mtime_ns, file.stat().st_size) for file in files_of(path)]
        tracks = _read(path, tuple(stamps))
    except TrackError as why:
        raise TrackError(recorded.file, why.problems) from None
    except OSError as why:
        raise TrackError.of(recorded.file, f"can't be read: {why.strerror}") from None
    bodies = tracks.bodies
    wanted = name if recorded.body is None else recorded.body
    if wanted not in bodies and recorded.body is None and len(bodies) == 1:
        (wanted,) = bodies
    if wanted not in bodies:
        hint = suggestion(wanted, bodies)
        raise TrackError.of(recorded.file, f"no body is called {wanted!r}; {hint}")
    return tracks, bodies[wanted]


@lru_cache(maxsize=8)
def _read(path: Path, stamps: tuple[tuple[int, int], ...]) -> Tracks:
    """Return the tracks at `path`, read anew when the times or sizes of its files have changed."""
    read = read_bag_tracks if path.is_dir() else READERS[path.suffix.lower()]
    return read(path)


def _frame_rate(recorded: RecordedTrack, tracks: Tracks) -> float | None:
    return (recorded.frame_rate or tracks.frame_rate) if tracks.counts_frames else None


def _problems(
    recorded: RecordedTrack, tracks: Tracks, samples: Samples, scenario: Scenario
) -> Iterator[Problem]:
    """Yield what is wrong with the samples, each with its row."""
    rate = _frame_rate(recorded, tracks)
    if tracks.counts_frames and not rate:
        yield Problem("counts frames, and does not say how many a second has: give frame_rate")
        return

    def at(k: int, message: str) -> Problem:
        row = int(samples.rows[k])
        if tracks.row == "line":
            return Problem(message, line=row)
        place = f"{samples.place}, " if samples.place else ""
        return Problem(f"{place}{tracks.row} {row}: {message}")

    t = samples.t / (rate or 1.0)
    steps = np.diff(t)
    if (late := np.flatnonzero(_late(t))).size:
        for k in late.tolist():
            before = f"{tracks.row} {samples.rows[k]}"
            yield at(k + 1, f"t = {t[k + 1]:.9g} s is not after the {t[k]:.9g} s of {before}")
        return
    gaps = np.flatnonzero(steps > recorded.longest_gap * (1 + 1e-9))
    for k in gaps.tolist():
        yield at(
            k + 1,
            f"a gap of {steps[k]:.3g} s: there is nothing from t = {t[k]:.9g} s on; mend the"
            f" track, or give a longest_gap of more than {recorded.longest_gap:g} s",
        )
    gone = np.hypot(np.diff(samples.x), np.diff(samples.y))
    jumps = np.flatnonzero((gone > recorded.top_speed * steps) & (steps >= SHORTEST))
    for k in jumps.tolist():
        yield at(
            k + 1,
            f"a jump of {gone[k]:.3g} m in {steps[k]:.3g} s; mend the track, give a top_speed"
            f" of more than {recorded.top_speed:g} m/s, or state the jump by two samples at one"
            " time, one before it and one after it",
        )
    xy = np.column_stack([samples.x, samples.y])
    shown = _on_floor(_parts(t), xy, scenario.floorplan)
    yield from (
        at(k, words) for k, words in _outside(np.concatenate(shown), xy, scenario.floorplan)
    )
    if t[-1] < recorded.since:
        yield at(len(t) - 1, f"the track ends at t = {t[-1]:.9g} s, before since")
    elif t[0] - recorded.since >= scenario.duration:
        yield at(
            0,
            f"the track begins at t = {t[0]:.9g} s, and the trial is over by then;"
            " give since: the time of the file at the person's start",
        )


def _late(t: Array) -> NDArray[np.bool_]:
    """Return for each sample but the first whether it is earlier than it may be: (N - 1,)."""
    steps = np.diff(t)
    late = steps < 0.0
    at_once = steps < SHORTEST
    if len(t) > MOST_AT_ONCE:
        late[MOST_AT_ONCE - 1 :] |= sliding_window_view(at_once, MOST_AT_ONCE).all(axis=1)
    return late


def _parts(t: Array) -> list[NDArray[np.intp]]:
    """Return the samples between jumps; two samples at one time are the ends of two parts."""
    parts = np.split(np.arange(len(t)), np.flatnonzero(np.diff(t) < SHORTEST) + 1)
    # A sample alone between others at its time is where the body is for no time.
    return [part for k, part in enumerate(parts) if len(part) > 1 or k in (0, len(parts) - 1)]


def _on_floor(parts: list[NDArray[np.intp]], xy: Array, plan: Floorplan) -> list[NDArray[np.intp]]:
    """Return `parts` without the first or last of several that is outside the floor throughout.

    The body comes by a jump from outside, or leaves by one; all parts if that leaves none.
    """
    outside = [not shapely.intersects_xy(plan.boundary, *xy[part].T).any() for part in parts]
    return parts if all(outside) else parts[outside[0] : len(parts) - outside[-1]]


def _outside(shown: NDArray[np.intp], xy: Array, plan: Floorplan) -> Iterator[tuple[int, str]]:
    """Yield the first of the samples `shown` that is outside the floor, and what is wrong."""
    outside = shown[~shapely.intersects_xy(plan.boundary, *xy[shown].T)]
    if outside.size:
        x, y = xy[outside[0]]
        more = f", as are {outside.size - 1} more" if outside.size > 1 else ""
        yield (
            int(outside[0]),
            f"({x:g}, {y:g}) is outside the boundary of the floor (metres){more}",
        )


def _headings(t: Array, xy: Array) -> Array:
    """Return the direction in which somebody looks at each sample: where they walk."""
    steps = np.diff(xy, axis=0)
    angles = np.arctan2(steps[:, 1], steps[:, 0])
    walks = np.hypot(*steps.T) > STROLL * np.diff(t)
    if not walks.any():
        return np.zeros(len(t))
    # The last direction in which they walked; before the first, that one.
    # The number of the last step at which they walked, for each step.
    known = np.maximum.accumulate(np.where(walks, np.arange(len(walks)), -1))
    known[known < 0] = int(np.argmax(walks))
    looks: Array = angles[known]
    return np.append(looks, looks[-1])


def _top_speed(motion: Motion) -> float:
    """Return a speed (m/s) that `motion` never exceeds.

    The velocity of a piece is a quadratic of time, and stays within its control points.
    """
    durations = np.array([piece.end - piece.begin for piece in motion.pieces])[:, None]
    curves = np.array([[piece.x, piece.y] for piece in motion.pieces])
    first = curves[..., 1]
    # Control points of the velocity c₁ + 2 c₂ u + 3 c₃ u²: at the ends, and c₁ + c₂ T between.
    second = first + curves[..., 2] * durations
    third = first + (2 * curves[..., 2] + 3 * curves[..., 3] * durations) * durations
    return float(max(np.hypot(*one.T).max() for one in (first, second, third)))
