"""Metrics of social navigation, with groups of people and social work.

The force is that of M. Moussaïd et al., "Experimental study of the behavioural mechanisms
underlying self-organization in human crowds", Proc. R. Soc. B 276, 2009, with the constants of
HuNavSim's evaluator (its factor is 2.1, where the paper fits 4.5).

Names follow the evaluator of HuNavSim (N. Pérez-Higueras et al., "HuNavSim: A ROS 2 Human
Navigation Simulator for Benchmarking Human-Aware Robot Navigation", IEEE Robotics and Automation
Letters 8, 2023). `docs/metrics.md` has every formula and its source. Metrics are computed from
motions, not from samples.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from floorplan import UserError
from floorplan.files.dataclass import dataclass
from floorplan.files.fields import LARGEST
from floorplan.files.problems import suggestion
from navigation import Motion, Piece
from navigation.measures import Company, Courses
from navigation.polynomials import NODES_5, WEIGHTS_5

from ..core.recorder import Event, Scene, rounded
from .sampling import Span

Cubic = tuple[float, float, float, float]


@dataclass(frozen=True)
class WalkingGroup:
    """People who walk with a leader: their names, the leader's first, and their time span (s).

    `middle` is the mean of their positions.
    """

    members: tuple[str, ...]
    span: Span
    middle: Motion


def groups(
    motions: Mapping[str, Motion], events: Iterable[Event], presence: Mapping[str, Span]
) -> dict[str, WalkingGroup]:
    """Return the groups of a run by their leaders' names, from the time when all walk together."""
    members: dict[str, dict[str, float]] = {}
    for event in events:
        if event["kind"] == "walks_with":
            members.setdefault(event["other"], {}).setdefault(event["person"], event["t"])
    by_leader = {}
    for leader, others in members.items():
        names = (leader, *others)
        begin = max(*others.values(), *(presence[name][0] for name in names))
        end = min(presence[name][1] for name in names)
        if begin < end:
            middle = mean_motion([motions[name] for name in names], begin, end)
            by_leader[leader] = WalkingGroup(names, (begin, end), middle)
    return by_leader


def mean_motion(motions: Sequence[Motion], begin: float, end: float) -> Motion:
    """Return the mean motion of several bodies between two times (s)."""
    # Between changes of pieces all motions are cubics. Written from the same time, their mean is
    # the mean of their coefficients.
    parts = [motion.cut(begin, end) for motion in motions]
    cuts = sorted({t for part in parts for piece in part.pieces for t in piece[:2]})
    ahead = [list(part.pieces) for part in parts]
    pieces = []
    for since, until in itertools.pairwise(cuts):
        there: list[Piece] = []
        for left in ahead:
            while left[0].end <= since and len(left) > 1:
                left.pop(0)
            there.append(left[0].cut(since, until))
        x, y = _mean([piece.x for piece in there]), _mean([piece.y for piece in there])
        pieces.append(Piece(since, until, x, y, _mean([piece.rotation for piece in there])))
    jumps = frozenset(t for part in parts for t in part.jumps)
    return Motion(tuple(pieces), jumps)


def _mean(cubics: Sequence[Cubic]) -> Cubic:
    a, b, c, d = (sum(terms) / len(cubics) for terms in zip(*cubics, strict=True))
    return a, b, c, d


Array = NDArray[np.float64]

FACTOR, LAMBDA, GAMMA, N, N_PRIME = 2.1, 2.0, 0.35, 2.0, 3.0
"""Parameters of the force: m/s², and numbers without unit."""

STRAIGHT = 1e-9
"""Radians. There is no turning if D deviates less from the line between two bodies."""

LONGEST = 0.25
"""Seconds. Maximum length of the stretches of integration."""

_AT_ONCE = 1024
"""Number of stretches that are evaluated together, so that their data fit into the cache."""

_NODES, _WEIGHTS = np.array(NODES_5), np.array(WEIGHTS_5)


def social_force(apart: Array, velocity: Array) -> Array:
    """Return the force per mass (m/s²) on a body from another one, shape (2, N).

    `apart` is from the body to the other one (m), and `velocity` the body's minus the other's
    (m/s), each (2, N). The force of the body on the other one is its opposite.
    """
    # In the paper's terms `towards` is D = λ Δv + e, `angle` is θ from D to e, and `width` is B = γ
    # |D|. The force has a part that slows down, along D, and a part that turns, across it. For the
    # other body, e, Δv and D are the opposite, and θ is the same.
    distance = np.maximum(_length(apart), 1e-9)
    direction = apart / distance
    towards = LAMBDA * velocity + direction
    length = np.maximum(_length(towards), 1e-9)
    along = towards / length
    across = along[0] * direction[1] - along[1] * direction[0]
    angle = np.arctan2(across, along[0] * direction[0] + along[1] * direction[1])
    # No side if D is parallel to e, because rounding would decide.
    side = np.where(np.abs(across) > STRAIGHT, np.sign(across), 0.0)
    width = GAMMA * length
    nearness, turn = -distance / width, (width * angle) ** 2
    slowing = -FACTOR * np.exp(nearness - N_PRIME**2 * turn)
    turning = -FACTOR * side * np.exp(nearness - N**2 * turn)
    x, y = along
    return np.stack((slowing * x - turning * y, slowing * y + turning * x))


def social_work(
    bodies: Sequence[tuple[Motion, tuple[float, float]]], pairs: Sequence[tuple[int, int]]
) -> Array:
    """Return ∫ |Σ force of others on the body| + Σ |force of the body on each other| dt, m/s: (B,).

    Each body has the span (s) in which it is present. `pairs` are pairs of indices, each pair once.
    """
    work = np.zeros(len(bodies))
    spans = np.array([span for _, span in bodies])
    for begins, halves in _stretches(bodies):
        u = halves[:, None] * (1 + _NODES)
        cubics = np.array([motion.cubics(begins)[:, :2] for motion, _ in bodies])
        c0, c1, c2, c3 = np.moveaxis(cubics, (3, 2), (0, 2))[..., None]
        shape = (len(bodies), 2, u.size)
        at = (c0 + u * (c1 + u * (c2 + u * c3))).reshape(shape)
        velocity = (c1 + u * (2 * c2 + u * 3 * c3)).reshape(shape)
        felt, exerted = np.zeros(shape), np.zeros((len(bodies), u.size))
        there = np.searchsorted(begins, spans) * u.shape[1]
        for one, other in pairs:
            both = slice(max(there[one, 0], there[other, 0]), min(there[one, 1], there[other, 1]))
            force = social_force(
                at[other, :, both] - at[one, :, both],
                velocity[one, :, both] - velocity[other, :, both],
            )
            felt[one, :, both] += force
            felt[other, :, both] -= force
            size = _length(force)
            exerted[one, both] += size
            exerted[other, both] += size
        weights = (halves[:, None] * _WEIGHTS).ravel()
        work += ((_length(felt.swapaxes(0, 1)) + exerted) * weights).sum(1)
    return work


def _stretches(
    bodies: Sequence[tuple[Motion, tuple[float, float]]],
) -> Iterator[tuple[Array, Array]]:
    """Yield begins and half durations (s) of consecutive stretches, (S,) each.

    Between two cuts, motions are polynomials and nobody comes or goes. The integrand is smooth
    there, so that Gauss-Legendre quadrature with five nodes, exact up to the ninth degree, needs
    only short stretches. Across a cut it would lose that order.
    """
    spans = [t for _, span in bodies for t in span]
    changes = (t for motion, _ in bodies for piece in motion.pieces for t in piece[:2])
    cuts = {*spans, *(t for t in changes if min(spans) < t < max(spans))}
    edges = np.array(sorted(cuts))
    shares = np.maximum(np.ceil(np.diff(edges) / LONGEST).astype(int), 1)
    halves = np.repeat(np.diff(edges) / shares / 2, shares)
    number = np.arange(len(halves)) - np.repeat(np.cumsum(shares) - shares, shares)
    begins = np.repeat(edges[:-1], shares) + 2 * number * halves
    for first in range(0, len(begins), _AT_ONCE):
        part = slice(first, first + _AT_ONCE)
        yield begins[part], halves[part]


def _length(vectors: Array) -> Array:
    """Return the lengths (...) of vectors (2, ...)."""
    x, y = vectors
    return np.asarray(np.sqrt(x * x + y * y))


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
    """Parts of a run that its metrics need."""

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
    """Return metrics of social navigation for each person and machine.

    People are evaluated from their start, machines from the begin.

    Parameters
    ----------
    run : Run
        The run.
    radii : mapping, optional
        Radii in metres by body, which are subtracted from the distances between centres.

    Returns
    -------
    dict
        Numbers, lists and dictionaries by body.

    Raises
    ------
    ValueError
        If `radii` names an unknown body.
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
    """Yield the time (s) until each goal of one person was reached, or None."""
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
    """Return the distances of each person to other bodies, and of each machine to people."""
    index = {name: k for k, name in enumerate(names)}
    pairs = [(a, b) for a in people for b in names if index[a] < index[b]]
    queries = {(a, b): (index[a], [index[b]]) for a, b in pairs}
    machines = [name for name in names if name not in people]
    if len(people) > 1:
        everybody = [index[name] for name in people]
        queries |= {(name, "people"): (index[name], everybody) for name in machines}
    companies = courses.company(list(queries.values()), (INTIMATE, PERSONAL, SOCIAL), radii)
    beside = dict(zip(queries, map(_distances, companies), strict=True))
    beside |= {(b, a): beside[a, b] for a, b in pairs}
    if len(people) == 1:
        beside |= {(name, "people"): beside[name, people[0]] for name in machines}
    alone = _distances(Company(0.0, 0.0, 0.0, 0.0, (0.0, 0.0, 0.0)))
    return {(name, "people"): alone for name in machines} | beside


def _beside_groups(
    courses: Courses,
    names: list[str],
    groups: Mapping[str, WalkingGroup],
    sizes: Mapping[str, float],
) -> dict[str, dict[str, Any]]:
    """Return the distances of each body to the middle of each group of other people."""
    queries = {
        (name, leader): (k, [len(names) + j])
        for j, (leader, group) in enumerate(groups.items())
        for k, name in enumerate(names)
        if name not in group.members
    }
    radii = [*(sizes.get(name, 0.0) for name in names), *(0.0 for _ in groups)]
    measured = courses.company(list(queries.values()), (INTIMATE, PERSONAL, SOCIAL), radii)
    beside: dict[str, dict[str, Any]] = {}
    for (name, leader), company in zip(queries, measured, strict=True):
        to = beside.setdefault(name, {"distance_to_groups": {}})["distance_to_groups"]
        to[leader] = _distances(company)
    return beside


def _social_work(
    run: _Run, spans: Mapping[str, tuple[float, float]], people: Sequence[str]
) -> dict[str, float]:
    """Return the social work of each body beside people (m/s)."""
    crowd = [(run.motions[name], spans[name]) for name in people]
    pairs = list(itertools.combinations(range(len(people)), 2))
    work = dict(zip(people, social_work(crowd, pairs).tolist(), strict=True))
    beside = [(0, k + 1) for k in range(len(people))]
    for name, span in spans.items():
        if name not in work:
            work[name] = float(social_work([(run.motions[name], span), *crowd], beside)[0])
    return work


def _distances(company: Company) -> dict[str, Any]:
    """Return `DISTANCES`: metres, and the share of time in each of Hall's spaces in percent."""
    time = company.time
    if not time:
        return dict(zip(DISTANCES, (0.0, None, None, None, 0.0, 0.0, 0.0), strict=True))
    intimate, personal, social = (100.0 * seconds / time for seconds in company.within)
    shares = (intimate, max(personal - intimate, 0.0), max(social - personal, 0.0))
    apart = (company.mean, company.minimum, company.maximum)
    return dict(zip(DISTANCES, (time, *apart, *shares), strict=True))
