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
"""A functor, and the name of whom the percept is about, if it is about somebody."""


class Percepts:
    """The percepts of one mind, which stays small: of each functor it has the latest alone.

    Of percepts about other people it has the latest about each.
    """

    def __init__(self, mind: Mind) -> None:
        self._mind = mind
        self._counts: dict[Key, int] = {}
        self._latest: dict[Key, bdi.Literal] = {}
        self._unheard: set[Key] = set()

    def see(self, functor: str, *arguments: float) -> None:
        """Perceive `functor(arguments)`, and no longer what was perceived of it before."""
        self._perceive((functor,), *map(float, arguments))

    def count(self, functor: str, *who: str) -> None:
        """Perceive `functor(N)`, with N the number of times that it was perceived before.

        About somebody, who is named, `functor(Who, N)`.
        """
        key = (functor, *who)
        n = self._counts.get(key, 0)
        self._counts[key] = n + 1
        self._perceive(key, *map(as_term, who), float(n))

    def _perceive(self, key: Key, *arguments: bdi.Term) -> None:
        """Perceive something in place of what was perceived under this key before."""
        percept = bdi.Literal(key[0], arguments)
        before = self._latest.get(key)
        if before is not None:
            self._mind.remove_percept(before)
        self._latest[key] = percept
        self._unheard.add(key)
        self._mind.add_percept(percept)

    def heard(self) -> None:
        """Take note that the mind has thought about all of it."""
        self._unheard.clear()

    def pass_on(self, mind: Mind) -> Percepts:
        """Return the percepts of `mind`, which takes the place of the mind so far.

        It perceives the present state of things and the happenings that nobody has thought about
        yet; happenings are counted on.
        """
        new = Percepts(mind)
        new._counts = self._counts
        for key, percept in self._latest.items():
            if key not in self._counts or key in self._unheard:
                new._latest[key] = percept
                new._unheard.add(key)
                mind.add_percept(percept)
        return new


class Senses:
    """The percepts of a person, whichever mind they have.

    The mind thinks as soon as there are any, or if there is a `lag`, that many seconds later. The
    percepts of that time are then thought about together.
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
        """Let `mind` perceive from now on, and what the one before it did not think about."""
        before = self._percepts
        self._percepts = Percepts(mind) if before is None else before.pass_on(mind)
        self._thinking.set(self._clock.now)

    def count(self, functor: str, *who: str) -> None:
        """Perceive `functor(N)` for the Nth time, from 0; `functor(Who, N)` about somebody."""
        if self._percepts is not None:
            self._percepts.count(functor, *who)
            self._think_soon()

    def see(self, functor: str, *arguments: float) -> None:
        """Perceive `functor(arguments)`, in place of what was perceived of it before."""
        if self._percepts is not None:
            self._percepts.see(functor, *arguments)
            self._think_soon()

    @property
    def thinks_at(self) -> float:
        """Instant (seconds) by which the mind has thought about all that is perceived."""
        return self._clock.now if self._due is None else self._due

    def _think_soon(self) -> None:
        if self._lag is None:
            self._thinking.set(self._clock.now)
            return
        if self._due is None:
            self._due = self._clock.now + self._lag()
        self.think_by(self._due)

    def heard(self) -> None:
        """Take note that the mind has thought about all of it."""
        self._due = None
        if self._percepts is not None:
            self._percepts.heard()

    def think_by(self, t: float) -> None:
        """Let the mind think at `t` (seconds) at the latest."""
        t = max(t, self._clock.now)
        if self._thinking.time is None or t < self._thinking.time:
            self._thinking.set(t)


EYE_LEVEL = 0.93
"""Share of the stature at which eyes are: 1.63 m of 1.75 m, the median of men in DIN 33402-2."""


class Vision:
    """The eyes of one person, who notices machines as `noticing` says (with plain figures)."""

    def __init__(self, stage: Stage, body: Body, human: Human, noticing: NoticingEntry) -> None:
        degrees, delay = noticing.field_of_view, noticing.reaction_time
        assert isinstance(degrees, float | int | None) and isinstance(delay, float | int | None)
        self.reaction_time = 0.0 if delay is None else delay
        """Seconds from when they see something until they perceive it."""
        self._half = math.pi if degrees is None else math.radians(degrees) / 2
        self._stage = stage
        self._body = body
        self._height = EYE_LEVEL * human.height
        self._boundary = stage.floorplan.boundary if noticing.occlusion else None
        self._fixed = stage.floorplan.obstacles
        self._tree = shapely.STRtree([one.footprint for one in self._fixed])

    def see(self, machine: Machine) -> bool:
        """Return whether any of the points at which they look of `machine` can be seen now.

        These are its axis and its corners; where something may hide them, at its bottom, at its top
        and half-way.
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
        """Return whether nothing hides a point of `machine` at all of `heights` (metres)."""
        if self._boundary is None or math.dist(eye, point) == 0.0:
            return True
        line = LineString([eye, point])
        # The floor's edge hides all heights; of a point beyond it, as of a gantry that overhangs,
        # nothing is asked.
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
        """Yield what stands or hangs on the line: obstacles, and machines other than that."""
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
    """Return the parts of a line over an obstacle, as shares of its length."""
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
    """Return whether a sight line that runs from `eye` to `height` meets what fills this part."""
    # The line falls or rises evenly, so over the obstacle it is between its heights at the two
    # ends.
    along = [eye + share * (height - eye) for share in span]
    return bottom < max(along) and min(along) < top


NEAR = TooClose(FixedDistance(3.6))
"""So near is who counts as near: within 3.6 m of centres, where Hall's social space ends."""

GONE = Apart(4.1)
"""So far has to go who is gone: 0.5 m more between centres, in metres."""

NEARNESS = ("person_near", "person_gone")
"""Percepts that need a watch on every other person."""

PERCEPTS = (*NEARNESS, "in_the_way", "gives_way", "wants_to_pass", "has_left")
"""Percepts about another person, `functor(Who, N)`."""


class SocialPerception:
    """What one person perceives of others, from their start on: what their program mentions."""

    def __init__(self, stage: Stage, body: Body, senses: Senses) -> None:
        self._stage = stage
        self._body = body
        self._senses = senses
        self._heeded: frozenset[str] = frozenset()
        self._started = False
        self._watches: list[NearnessMonitor] = []

    def belong_to(self, mind: Mind) -> None:
        """Perceive from now on what the program of `mind` mentions; a mind outside hears all."""
        if isinstance(mind, bdi.Agent):
            self._heeded = mentioned(mind.program)
        elif isinstance(mind, Outside):
            self._heeded = frozenset(PERCEPTS)
        self._look_round()

    def start(self) -> None:
        """Begin to perceive: the person starts."""
        self._started = True
        self._look_round()

    def heeds(self, percept: str) -> bool:
        """Return whether the mind heeds a percept about another person."""
        return percept in self._heeded

    def perceive(self, percept: str, who: str) -> None:
        """Perceive something about `who`, if the mind heeds such percepts."""
        if self._started and self.heeds(percept):
            self._senses.count(percept, who)

    def _look_round(self) -> None:
        if self._started and not self._watches and self._heeded.intersection(NEARNESS):
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
    """Return those of the percepts about other people that stand anywhere in a program."""
    clauses = (*program.beliefs, *program.goals, *program.plans)
    words = set(re.findall(r"\w+", " ".join(map(str, clauses))))
    return frozenset(words.intersection(PERCEPTS))
