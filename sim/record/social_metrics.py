"""Metrics of social navigation: how a run went for people and machines, in comparable figures.

Names follow the evaluator of HuNavSim (N. Pérez-Higueras et al., "HuNavSim: A ROS 2 Human
Navigation Simulator for Benchmarking Human-Aware Robot Navigation", IEEE Robotics and Automation
Letters 8, 2023). `docs/metrics.md` has every formula and its source. Everything is worked out from
the motions themselves, not from samples.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterable, Mapping, Sequence
from typing import Any, Protocol

from floorplan import LARGEST, UserError, suggestion
from navigation import Company, Courses, Motion

from ..core.recorder import Event, rounded
from ..core.scene import Scene
from .groups import Group, groups
from .social_work import social_work

INTIMATE, PERSONAL, SOCIAL = 0.45, 1.2, 3.6
"""Metres. Where the intimate, personal and social spaces around a person end (E. T. Hall, "The
Hidden Dimension", 1966)."""

STANDING_SPEED, STANDING_TURN = 0.001, 0.01
"""m/s and rad/s. What is slower does not move (as HuNavSim has it)."""


MOVEMENT = (
    "time",
    "path_length",
    "cumulative_heading_changes",
    "time_not_moving",
    "maximum_speed",
    "average_speed",
    "average_acceleration",
    "average_jerk",
)
PROGRESS = ("goals", "goals_reached", "time_to_goal", "final_distance_to_goal")
DISTANCES = (
    "time",
    "average",
    "minimum",
    "maximum",
    "intimate_space_intrusions",
    "personal_space_intrusions",
    "social_space_intrusions",
)


class _Run(Protocol):
    """Parts of a run from which its metrics are worked out."""

    @property
    def scene(self) -> Scene: ...

    @property
    def duration(self) -> float: ...

    @property
    def events(self) -> Sequence[Event]: ...

    @property
    def motions(self) -> Mapping[str, Motion]: ...

    @property
    def presence(self) -> Mapping[str, tuple[float, float]]: ...


def metrics(run: _Run, *, radii: Mapping[str, float] | None = None) -> dict[str, Any]:
    """Return the metrics of every person and machine of a run, as plain numbers, lists and dicts.

    People count from their start, machines from the beginning. Distances are between centres;
    `radii` (metres, by body) are taken off them. `ValueError` if there is no body of such a name.
    """
    names = list(run.motions)
    sizes = dict(radii or {})
    for name, radius in sizes.items():
        if name not in names:
            raise UserError(f"no body is called {name!r}; {suggestion(name, names)}")
        if not 0 <= radius <= LARGEST:
            message = f"the radius of {name} must be from 0 to {LARGEST:g} m, not {radius}"
            raise UserError(message)
    people = [person.name for person in run.scene.people]
    begins = dict.fromkeys(people, run.duration)
    begins |= {
        event["person"]: event["t"]
        for event in run.events
        if event["kind"] == "human_started" and "person" in event
    }
    walk_together = groups(run.motions, run.events, run.presence)
    spans = [
        (min(max(begins.get(name, 0.0), begin), end), end)
        for name in names
        for begin, end in (run.presence[name],)
    ]
    courses = Courses(
        [*(run.motions[name] for name in names), *(one.middle for one in walk_together.values())],
        [*spans, *(one.span for one in walk_together.values())],
    )
    movements = dict(zip(names, _movements(courses), strict=False))
    beside = _companies(courses, names, people, [sizes.get(name, 0.0) for name in names])
    to_groups = _beside_groups(courses, names, walk_together, sizes)
    work = _social_work(run, dict(zip(names, spans, strict=True)), people)
    figures: dict[str, Any] = rounded(
        {
            "people": {
                name: movements[name]
                | _progress(name, run)
                | {"social_work": work[name]}
                | {"distance_to": {other: beside[name, other] for other in names if other != name}}
                | to_groups.get(name, {})
                for name in people
            },
            "machines": {
                name: movements[name]
                | {"social_work": work[name]}
                | {"distance_to_people": beside[name, "people"]}
                | to_groups.get(name, {})
                for name in names
                if name not in people
            },
        }
    )
    return figures


def _movements(courses: Courses) -> Iterable[dict[str, float]]:
    """Yield the movement of each body: `MOVEMENT`."""
    standing = courses.time_not_moving(STANDING_SPEED, STANDING_TURN)
    columns = (courses.time, courses.length, courses.turning, standing, courses.top_speed)
    totals = (courses.length, courses.acceleration, courses.jerk)
    for k, time in enumerate(courses.time):
        means = (total[k] / time if time else 0.0 for total in totals)
        figures = (*(column[k] for column in columns), *means)
        yield dict(zip(MOVEMENT, map(float, figures), strict=True))


def _progress(person: str, run: _Run) -> dict[str, Any]:
    """Return the progress of a person with their goals: `PROGRESS`."""
    mine = [event for event in run.events if event.get("person") == person]
    goals = [event for event in mine if event["kind"] == "goal"]
    times = [leg for leg in _legs(mine) if leg is not None]
    last = goals[-1].get("at") if goals else None
    at = run.motions[person].state_before(run.presence[person][1]).at
    left = math.dist(at, last) if last else None
    mean = math.fsum(times) / len(times) if times else None
    return dict(zip(PROGRESS, (len(goals), len(times), mean, left), strict=True))


def _legs(events: Iterable[Event]) -> Iterable[float | None]:
    """Yield for each goal of one person the seconds until it was reached, or None."""
    since: float | None = None
    for event in events:
        if event["kind"] in ("goal", "teleport"):
            if since is not None:
                yield None
            since = event["t"] if event["kind"] == "goal" else None
        elif event["kind"] == "arrived" and since is not None:
            yield event["t"] - since
            since = None


def _companies(
    courses: Courses, names: list[str], people: list[str], radii: list[float]
) -> dict[tuple[str, str], dict[str, float]]:
    """Distances: of each person to every other body, and of each machine to the people."""
    index = {name: k for k, name in enumerate(names)}
    pairs = [(a, b) for a in people for b in names if index[a] < index[b]]
    asked = {(a, b): (index[a], [index[b]]) for a, b in pairs}
    machines = [name for name in names if name not in people]
    if len(people) > 1:
        everybody = [index[name] for name in people]
        asked |= {(name, "people"): (index[name], everybody) for name in machines}
    found = courses.company(list(asked.values()), (INTIMATE, PERSONAL, SOCIAL), radii)
    beside = dict(zip(asked, map(_distances, found), strict=True))
    beside |= {(b, a): beside[a, b] for a, b in pairs}
    if len(people) == 1:
        beside |= {(name, "people"): beside[name, people[0]] for name in machines}
    alone = _distances(Company(0.0, 0.0, 0.0, 0.0, (0.0, 0.0, 0.0)))
    return {(name, "people"): alone for name in machines} | beside


def _beside_groups(
    courses: Courses, names: list[str], found: Mapping[str, Group], sizes: Mapping[str, float]
) -> dict[str, dict[str, Any]]:
    """Distances of each body to the middle of each group, if any, that it is not one of."""
    asked = {
        (name, leader): (k, [len(names) + j])
        for j, (leader, group) in enumerate(found.items())
        for k, name in enumerate(names)
        if name not in group.members
    }
    radii = [*(sizes.get(name, 0.0) for name in names), *(0.0 for _ in found)]
    measured = courses.company(list(asked.values()), (INTIMATE, PERSONAL, SOCIAL), radii)
    beside: dict[str, dict[str, Any]] = {}
    for (name, leader), company in zip(asked, measured, strict=True):
        to = beside.setdefault(name, {"distance_to_groups": {}})["distance_to_groups"]
        to[leader] = _distances(company)
    return beside


def _social_work(
    run: _Run, spans: Mapping[str, tuple[float, float]], people: Sequence[str]
) -> dict[str, float]:
    """Return the social work of each body beside people: m/s."""
    crowd = [(run.motions[name], spans[name]) for name in people]
    pairs = list(itertools.combinations(range(len(people)), 2))
    work = dict(zip(people, social_work(crowd, pairs).tolist(), strict=True))
    beside = [(0, k + 1) for k in range(len(people))]
    for name, span in spans.items():
        if name not in work:
            work[name] = float(social_work([(run.motions[name], span), *crowd], beside)[0])
    return work


def _distances(company: Company) -> dict[str, Any]:
    """`DISTANCES`: metres, and the share of time in each of Hall's spaces in percent."""
    time = company.time
    if not time:
        return dict(zip(DISTANCES, (0.0, None, None, None, 0.0, 0.0, 0.0), strict=True))
    intimate, personal, social = (100.0 * seconds / time for seconds in company.within)
    shares = (intimate, max(personal - intimate, 0.0), max(social - personal, 0.0))
    apart = (company.mean, company.minimum, company.maximum)
    return dict(zip(DISTANCES, (time, *apart, *shares), strict=True))
