"""Recorded walks: check tracks, and convert them to motions."""

from __future__ import annotations

import math
import re
from collections.abc import Iterator, Mapping
from dataclasses import replace
from operator import is_
from pathlib import Path
from typing import TypeVar

import numpy as np
import shapely
from numpy.lib.stride_tricks import sliding_window_view
from numpy.typing import NDArray

from floorplan import Floorplan, Point, Problem
from floorplan.files.dataclass import dataclass
from floorplan.files.problems import Fault, suggestion
from navigation import Motion, join, standing

from ...core.entries import RecordedTrack
from ...core.scenario import PersonEntry, Scenario
from ..crowd.places import wings
from .tables import METRE, Array, Samples, TrackError, Tracks
from .track_files import read_tracks

STROLL = 0.1
"""Speed below which people keep their heading, m/s."""

SHORTEST = 1e-6
"""Time between samples below which they are at one time, where a body jumps, s."""

MOST_AT_ONCE = 3
"""Maximum number of samples at one time: before and after a jump, and one of a regular series."""

AT_ONCE = MOST_AT_ONCE * SHORTEST
"""Maximum length of a jump in seconds."""


_Made = TypeVar("_Made", bound=Scenario)

Span = tuple[float, float]
"""Begin and end in seconds."""

ALWAYS = ((-math.inf, math.inf),)


@dataclass(frozen=True, eq=False)
class RecordedWalk:
    """Motion of a recorded person since the start (s), and its top speed (m/s).

    The person is on the floor in the intervals `stays` (s), and otherwise far outside.
    """

    motion: Motion
    top_speed: float
    stays: tuple[Span, ...] = ALWAYS

    @property
    def at(self) -> Point:
        """Position at the start (x, y in metres)."""
        return self.motion.state(0.0).at

    @property
    def enters_at(self) -> Point | None:
        """Position of the first entry (x, y in metres), None if the person is there at the start.

        A person who never enters has a position far outside.
        """
        enters = self.stays[0][0] if self.stays else 0.0
        return self.motion.state(enters).at if enters > 0.0 or not self.stays else None


def recorded_walks(scenario: Scenario) -> dict[str, RecordedWalk]:
    """Return the walks of all recorded people of a scenario by name.

    A `TrackError` names the file and the row of an invalid track.
    """
    return {
        entry.name: recorded_walk(entry, scenario, wings(scenario.floorplan, index))
        for index, entry in enumerate(scenario.people)
        if entry.recorded is not None
    }


def recorded_walk(entry: PersonEntry, scenario: Scenario, away: Point) -> RecordedWalk:
    """Return the walk of a recorded person, who is at `away` (x, y in metres) while absent."""
    recorded = entry.recorded
    assert recorded is not None
    if isinstance(recorded, Motion):
        return RecordedWalk(recorded, _top_speed(recorded))
    tracks, samples = _samples(recorded, entry.name, scenario.folder)
    t = samples.t / (_frame_rate(recorded, tracks) or 1.0) - recorded.since
    k = max(0, int(np.searchsorted(t, 0.0, side="right")) - 1)
    t, xy = t[k:], _places(recorded, tracks, samples)[k:]
    turned = None if samples.rotation is None else samples.rotation[k:]
    parts = _parts(t, recorded)
    shown = _on_floor(parts, xy, scenario.floorplan)
    if recorded.while_tracked:
        shown = [part for part in shown if t[part[-1]] > 0.0]
    stays: list[Span] = []
    motions: list[Motion] = []
    for part in shown:
        begin, end = t[part[[0, -1]]].tolist()
        if not stays or (recorded.while_tracked and begin - stays[-1][1] >= AT_ONCE):
            motions.append(standing(away, start=stays[-1][1] if stays else 0.0))
            stays.append((begin, end))
        stays[-1] = (stays[-1][0], end)
        looks = _headings(t[part], xy[part]) if turned is None else turned[part]
        motions.append(Motion.from_samples(t[part], xy[part], looks))
    motions.append(standing(away, start=stays[-1][1] if stays else 0.0))
    # Other people stand where their tracks begin and end, unless they jump onto the floor or off.
    if not recorded.while_tracked and shown[0] is parts[0]:
        stays[0] = (-math.inf, stays[0][1])
    if not recorded.while_tracked and shown[-1] is parts[-1]:
        stays[-1] = (stays[-1][0], math.inf)
        del motions[-1]
    if stays and stays[0][0] <= 0.0:
        del motions[0]
    motion = join(motions)
    return RecordedWalk(motion, _top_speed(motion), tuple(stays))


def with_everybody(scenario: _Made) -> _Made:
    """Return a scenario with a person for each body of the files whose entries add all bodies."""
    people = tuple(one for entry in scenario.people for one in bodies_of(entry, scenario.folder))
    is_same = len(people) == len(scenario.people) and all(map(is_, people, scenario.people))
    return scenario if is_same else replace(scenario, people=people)


def bodies_of(entry: PersonEntry, folder: Path) -> list[PersonEntry]:
    """Return the people of an entry: one for each body of its file if it adds all bodies."""
    recorded = entry.recorded
    if not isinstance(recorded, RecordedTrack) or not recorded.everybody:
        return [entry]
    try:
        bodies = read_tracks(recorded, folder).bodies
    except TrackError:
        return [entry]  # reported together with everything else that is wrong
    # Bodies of bags have a long and a short name, the latter last.
    names = {id(samples): body for body, samples in bodies.items()}
    return [
        replace(
            entry,
            name=entry.name
            + ("" if body.isdigit() else "_")
            + re.sub(r"[^A-Za-z0-9-]+", "_", body),
            recorded=replace(recorded, body=body, while_tracked=True, everybody=False),
        )
        for body in names.values()
    ]


def track_faults(scenario: Scenario) -> Iterator[Fault]:
    """Yield the faults of all tracks of a scenario. A measured crowd has only its first one."""
    refused: set[RecordedTrack] = set()
    for k, entry in enumerate(scenario.people):
        if not isinstance(entry.recorded, RecordedTrack):
            continue
        crowd = replace(entry.recorded, body=None)
        if crowd not in refused and (fault := _fault(entry, entry.recorded, scenario)):
            yield fault, ("people", k, "recorded")
            if crowd.while_tracked:
                refused.add(crowd)


def _fault(entry: PersonEntry, recorded: RecordedTrack, scenario: Scenario) -> str:
    """Return the message about an invalid track of a person, or an empty string."""
    try:
        tracks, samples = _samples(recorded, entry.name, scenario.folder)
        problems = list(_problems(recorded, tracks, samples, scenario))
    except TrackError as why:
        return str(why)
    shown = problems[:1] if recorded.while_tracked else problems
    return str(TrackError(recorded.file, shown)) if shown else ""


def with_places(scenario: Scenario, walks: Mapping[str, RecordedWalk]) -> tuple[PersonEntry, ...]:
    """Return the people of a scenario, with the starts of recorded walks."""
    return tuple(
        replace(entry, at=walks[entry.name].at) if entry.name in walks else entry
        for entry in scenario.people
    )


def _samples(recorded: RecordedTrack, name: str, folder: Path) -> tuple[Tracks, Samples]:
    """Return the tracks of a file, and the samples of one body in it."""
    tracks = read_tracks(recorded, folder)
    bodies = tracks.bodies
    wanted = name if recorded.body is None else recorded.body
    if wanted not in bodies and recorded.body is None and len(bodies) == 1:
        (wanted,) = bodies
    if wanted not in bodies:
        hint = suggestion(wanted, bodies)
        raise TrackError.of(recorded.file, f"no body is called {wanted!r}; {hint}")
    return tracks, bodies[wanted]


def _places(recorded: RecordedTrack, tracks: Tracks, samples: Samples) -> Array:
    """Return the positions (N, 2) in metres."""
    metre = METRE[recorded.unit] if recorded.unit else tracks.metre
    return np.column_stack([samples.x, samples.y]) * metre


def _frame_rate(recorded: RecordedTrack, tracks: Tracks) -> float | None:
    return (recorded.frame_rate or tracks.frame_rate) if tracks.counts_frames else None


def _problems(
    recorded: RecordedTrack, tracks: Tracks, samples: Samples, scenario: Scenario
) -> Iterator[Problem]:
    """Yield the problems of the samples with their rows."""
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
    is_gap = _are_gaps(steps, recorded)
    for k in () if recorded.while_tracked else np.flatnonzero(is_gap).tolist():
        yield at(
            k + 1,
            f"a gap of {steps[k]:.3g} s: there is nothing from t = {t[k]:.9g} s on; mend the"
            f" track, or give a longest_gap of more than {recorded.longest_gap:g} s",
        )
    xy = _places(recorded, tracks, samples)
    gone = np.hypot(*np.diff(xy, axis=0).T)
    fast = (gone > recorded.top_speed * steps) & (steps >= SHORTEST)
    jumps = np.flatnonzero(fast & ~(is_gap & recorded.while_tracked))
    for k in jumps.tolist():
        yield at(
            k + 1,
            f"a jump of {gone[k]:.3g} m in {steps[k]:.3g} s; mend the track, give a top_speed"
            f" of more than {recorded.top_speed:g} m/s, or state the jump by two samples at one"
            " time, one before it and one after it",
        )
    shown = np.concatenate([np.arange(0), *_on_floor(_parts(t, recorded), xy, scenario.floorplan)])
    yield from (at(k, words) for k, words in _outside(shown, xy, scenario.floorplan))
    if recorded.while_tracked:
        return
    if t[-1] < recorded.since:
        yield at(len(t) - 1, f"the track ends at t = {t[-1]:.9g} s, before since")
    elif t[0] - recorded.since >= scenario.duration:
        yield at(
            0,
            f"the track begins at t = {t[0]:.9g} s, and the trial is over by then;"
            " give since: the time of the file at the person's start",
        )


def _late(t: Array) -> NDArray[np.bool_]:
    """Return whether each sample except the first is too early: (N - 1,)."""
    steps = np.diff(t)
    late = steps < 0.0
    at_once = steps < SHORTEST
    if len(t) > MOST_AT_ONCE:
        late[MOST_AT_ONCE - 1 :] |= sliding_window_view(at_once, MOST_AT_ONCE).all(axis=1)
    return late


def _are_gaps(steps: Array, recorded: RecordedTrack) -> NDArray[np.bool_]:
    return steps > recorded.longest_gap * (1 + 1e-9)


def _parts(t: Array, recorded: RecordedTrack) -> list[NDArray[np.intp]]:
    """Return the samples of each part between jumps, which are two samples at one time.

    Gaps in which the person is absent also separate parts.
    """
    steps = np.diff(t)
    cuts = steps < SHORTEST
    if recorded.while_tracked:
        cuts |= _are_gaps(steps, recorded)
    parts = np.split(np.arange(len(t)), np.flatnonzero(cuts) + 1)
    # A single sample lasts no time, except at an end of a track whose person stays there.
    ends = () if recorded.while_tracked else (0, len(parts) - 1)
    return [part for k, part in enumerate(parts) if len(part) > 1 or k in ends]


def _on_floor(parts: list[NDArray[np.intp]], xy: Array, plan: Floorplan) -> list[NDArray[np.intp]]:
    """Return `parts` without a first or last one outside the floor, from or to which a body jumps.

    If all parts are outside, all are returned.
    """
    outside = [not shapely.intersects_xy(plan.boundary, *xy[part].T).any() for part in parts]
    return parts if all(outside) else parts[outside[0] : len(parts) - outside[-1]]


def _outside(shown: NDArray[np.intp], xy: Array, plan: Floorplan) -> Iterator[tuple[int, str]]:
    """Yield the first of the samples `shown` outside the floor, with a message."""
    outside = shown[~shapely.intersects_xy(plan.boundary, *xy[shown].T)]
    if outside.size:
        x, y = xy[outside[0]]
        more = f", as are {outside.size - 1} more" if outside.size > 1 else ""
        yield (
            int(outside[0]),
            f"({x:g}, {y:g}) is outside the boundary of the floor (metres){more}",
        )


def _headings(t: Array, xy: Array) -> Array:
    """Return the heading at each sample: the direction of the walk."""
    steps = np.diff(xy, axis=0)
    angles = np.arctan2(steps[:, 1], steps[:, 0])
    walks = np.hypot(*steps.T) > STROLL * np.diff(t)
    if not walks.any():
        return np.zeros(len(t))
    # The heading of each step is that of the last step at walking speed, or of the first one.
    last = np.maximum.accumulate(np.where(walks, np.arange(len(walks)), -1))
    last[last < 0] = int(np.argmax(walks))
    headings: Array = angles[last]
    return np.append(headings, headings[-1])


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
