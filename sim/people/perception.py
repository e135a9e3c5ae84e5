"""Perception of a person: percepts, line of sight to machines, and awareness of people."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Iterable
from functools import lru_cache, partial

import numpy as np
import shapely
from shapely.geometry import LineString, Point

import bdi
from floorplan import Human, Obstacle
from navigation import Apart, FixedDistance, TooClose

from ..core.body import Body, Machine
from ..core.clock import Alarm, Clock, Turn
from ..core.entries import NoticingEntry
from ..core.stage import Stage
from ..safety.proximity import NearnessMonitor, by_conditions
from .minds import Mind, Outside, as_term

Key = tuple[str, ...]
"""Functor of a percept, and the name of the person it is about, if any."""


class Percepts:
    """Percepts of one mind: the latest of each functor, or of each functor and person.

    Older percepts are removed, so that the belief base stays small.
    """

    def __init__(self, mind: Mind) -> None:
        self._mind = mind
        self._counts: dict[Key, int] = {}
        self._latest: dict[Key, bdi.Literal] = {}
        self._new: set[Key] = set()

    def see(self, functor: str, *arguments: float) -> None:
        """Perceive `functor(arguments)` in place of the previous percept of this functor."""
        self._perceive((functor,), *map(float, arguments))

    def count(self, functor: str, *who: str) -> None:
        """Perceive `functor(N)` or `functor(Who, N)`, with N the number of previous ones."""
        key = (functor, *who)
        n = self._counts.get(key, 0)
        self._counts[key] = n + 1
        self._perceive(key, *map(as_term, who), float(n))

    def _perceive(self, key: Key, *arguments: bdi.Term) -> None:
        """Add a percept in place of the previous one with this key."""
        percept = bdi.Literal(key[0], arguments)
        before = self._latest.get(key)
        if before is not None:
            self._mind.remove_percept(before)
        self._latest[key] = percept
        self._new.add(key)
        self._mind.add_percept(percept)

    def heard(self) -> None:
        """Forget which percepts are new, because the mind has thought about all of them."""
        self._new.clear()

    def pass_on(self, mind: Mind) -> Percepts:
        """Return the percepts of `mind`, the successor of this mind.

        It perceives the current state, and the counted events that this mind has not yet thought
        about. The counts continue.
        """
        new = Percepts(mind)
        new._counts = self._counts
        for key, percept in self._latest.items():
            if key not in self._counts or key in self._new:
                new._latest[key] = percept
                new._new.add(key)
                mind.add_percept(percept)
        return new


class Senses:
    """Percepts of a person, for the current mind.

    The mind thinks immediately after a percept, or after a `lag` (s). It then thinks about all
    percepts of that interval together.
    """

    def __init__(
        self, clock: Clock, think: Callable[[], None], lag: Callable[[], float] | None = None
    ) -> None:
        self._clock = clock
        self._lag = lag
        self._due: float | None = None
        self._percepts: Percepts | None = None
        self._thinking = Alarm(clock, think, Turn.THOUGHT)

    def belong_to(self, mind: Mind) -> None:
        """Pass percepts to `mind` from now on, and those that the previous mind has not handled."""
        before = self._percepts
        self._percepts = Percepts(mind) if before is None else before.pass_on(mind)
        self._thinking.set(self._clock.now)

    def count(self, functor: str, *who: str) -> None:
        """Perceive `functor(N)` or `functor(Who, N)`, counted from 0."""
        if self._percepts is not None:
            self._percepts.count(functor, *who)
            self._think_soon()

    def see(self, functor: str, *arguments: float) -> None:
        """Perceive `functor(arguments)` in place of the previous percept of this functor."""
        if self._percepts is not None:
            self._percepts.see(functor, *arguments)
            self._think_soon()

    @property
    def thinks_at(self) -> float:
        """Time (s) at which the mind will have thought about all percepts."""
        return self._clock.now if self._due is None else self._due

    def _think_soon(self) -> None:
        if self._lag is None:
            self._thinking.set(self._clock.now)
            return
        if self._due is None:
            self._due = self._clock.now + self._lag()
        self.think_by(self._due)

    def heard(self) -> None:
        """Forget which percepts are new, because the mind has thought about all of them."""
        self._due = None
        if self._percepts is not None:
            self._percepts.heard()

    def think_by(self, t: float) -> None:
        """Schedule a thought at `t` (s) or earlier."""
        t = max(t, self._clock.now)
        if self._thinking.time is None or t < self._thinking.time:
            self._thinking.set(t)


EYE_LEVEL = 0.93
"""Eye height as a share of the stature: 1.63 m of 1.75 m, the median of men in DIN 33402-2."""


class Vision:
    """Line of sight of one person to machines, with the drawn parameters of `noticing`."""

    def __init__(self, stage: Stage, body: Body, human: Human, noticing: NoticingEntry) -> None:
        degrees, delay = noticing.field_of_view, noticing.reaction_time
        assert isinstance(degrees, float | int | None) and isinstance(delay, float | int | None)
        self.reaction_time = 0.0 if delay is None else delay
        """Time between seeing and perceiving (s)."""
        self._half = math.pi if degrees is None else math.radians(degrees) / 2
        self._stage = stage
        self._body = body
        self._height = EYE_LEVEL * human.height
        self._boundary = stage.floorplan.boundary if noticing.occlusion else None
        self._fixed = stage.floorplan.obstacles
        self._tree = shapely.STRtree([one.footprint for one in self._fixed])

    def see(self, machine: Machine) -> bool:
        """Return whether the axis or a corner of `machine` is visible now.

        With occlusion, three heights of each are tested: bottom, middle and top.
        """
        if self._half >= math.pi and self._boundary is None:
            return True
        x, y, heading = self._body.state.position
        at = machine.body.state.position
        shape = machine.shape
        footprint = shape.footprint(at[:2], at[2])
        if footprint.covers(Point(x, y)):
            return True
        points = [at[:2], *footprint.exterior.coords[:-1]]
        heights = (shape.bottom, (shape.bottom + shape.top) / 2, shape.top)
        return any(
            self._in_view(point[0] - x, point[1] - y, heading)
            and self._clear((x, y), (point[0], point[1]), heights, machine)
            for point in points
        )

    def _in_view(self, dx: float, dy: float, heading: float) -> bool:
        turned = math.remainder(math.atan2(dy, dx) - heading, 2 * math.pi)
        return abs(turned) <= self._half

    def _clear(
        self,
        eye: tuple[float, float],
        point: tuple[float, float],
        heights: Iterable[float],
        machine: Machine,
    ) -> bool:
        """Return whether a point of `machine` is visible at one of `heights` (m)."""
        if self._boundary is None or math.dist(eye, point) == 0.0:
            return True
        line = LineString([eye, point])
        # The boundary of the floor hides all heights. It hides no points beyond it, which an
        # overhanging gantry has.
        if self._boundary.covers(Point(point)) and not self._boundary.covers(line):
            return False
        hides = [
            (span, one.bottom, one.top)
            for one in self._around(line, machine)
            for span in _spans(line, one)
        ]
        return any(
            not any(_hidden(span, self._height, height, low, top) for span, low, top in hides)
            for height in heights
        )

    def _around(self, line: LineString, seen: Machine) -> Iterable[Obstacle]:
        """Yield the obstacles on the line, and the machines other than `seen`."""
        for index in np.sort(self._tree.query(line, predicate="intersects")):
            yield self._fixed[int(index)]
        yield from self._stage.active_closures.values()
        for machine in self._stage.machines.values():
            if machine is not seen:
                x, y, rotation = machine.body.state.position
                shape = machine.shape
                footprint = shape.footprint((x, y), rotation)
                yield Obstacle(
                    name=machine.name, footprint=footprint, bottom=shape.bottom, top=shape.top
                )


def _spans(line: LineString, obstacle: Obstacle) -> list[tuple[float, float]]:
    """Return the parts of a line over an obstacle, as fractions of its length."""
    shared = shapely.intersection(line, obstacle.footprint)
    spans = []
    for part in shapely.get_parts(shared):
        ends = [line.project(Point(at), normalized=True) for at in shapely.get_coordinates(part)]
        if ends and max(ends) > min(ends):
            spans.append((min(ends), max(ends)))
    return spans


def _hidden(
    span: tuple[float, float], eye: float, height: float, bottom: float, top: float
) -> bool:
    """Return whether a line of sight from height `eye` to `height` meets an obstacle in a part."""
    # The line is straight, so its heights over the obstacle are between those at both ends.
    along = [eye + share * (height - eye) for share in span]
    return bottom < max(along) and min(along) < top


NEAR = TooClose(FixedDistance(3.6))
"""People nearer than 3.6 m between centres count as near, the end of Hall's social space."""

GONE = Apart(4.1)
"""People count as gone at 0.5 m more between centres."""

NEARNESS = ("person_near", "person_gone")
"""Percepts that need a monitor for every other person."""

PERCEPTS = (*NEARNESS, "in_the_way", "gives_way", "wants_to_pass", "has_left")
"""Percepts about another person, `functor(Who, N)`."""


class SocialPerception:
    """Percepts about other people from the start of a person, if the program mentions them."""

    def __init__(self, stage: Stage, body: Body, senses: Senses) -> None:
        self._stage = stage
        self._body = body
        self._senses = senses
        self._relevant: frozenset[str] = frozenset()
        self._started = False
        self._watches: list[NearnessMonitor] = []

    def belong_to(self, mind: Mind) -> None:
        """Perceive what the program of `mind` mentions. A mind outside perceives everything."""
        if isinstance(mind, bdi.Agent):
            self._relevant = mentioned(mind.program)
        elif isinstance(mind, Outside):
            self._relevant = frozenset(PERCEPTS)
        self._watch_others()

    def start(self) -> None:
        """Begin to perceive at the start of the person."""
        self._started = True
        self._watch_others()

    def heeds(self, percept: str) -> bool:
        """Return whether the mind responds to a percept about another person."""
        return percept in self._relevant

    def perceive(self, percept: str, who: str) -> None:
        """Add a percept about `who` if the mind responds to it."""
        if self._started and self.heeds(percept):
            self._senses.count(percept, who)

    def _watch_others(self) -> None:
        if self._started and not self._watches and self._relevant.intersection(NEARNESS):
            self._watches = [
                NearnessMonitor(
                    self._stage,
                    (self._body, one.body),
                    by_conditions(NEAR, GONE),
                    partial(self._nearness, one.name),
                )
                for one in self._stage.people
                if one.body is not self._body
            ]

    def _nearness(self, who: str, is_near: bool) -> None:
        self.perceive(NEARNESS[0] if is_near else NEARNESS[1], who)


@lru_cache(maxsize=1024)
def mentioned(program: bdi.Program) -> frozenset[str]:
    """Return the percepts about other people that a program mentions."""
    clauses = (*program.beliefs, *program.goals, *program.plans)
    words = set(re.findall(r"\w+", " ".join(map(str, clauses))))
    return frozenset(words.intersection(PERCEPTS))
