"""Laws in a run: custom laws, and the distance that a law required over time."""

from __future__ import annotations

import inspect
import itertools
import math
from collections.abc import Callable, Iterator, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any, TypeVar

from floorplan import UserError
from navigation import (
    ApproachLaw,
    Enclosure,
    Encounter,
    FixedDistance,
    Scaled,
    SeparationLaw,
    Shapes,
    TooClose,
    minimum_margin,
    standing,
    walk,
)
from navigation.separation import AnyLaw, is_of_motions, required_along

from ..core.body import Plans
from ..core.custom_code import CodeFolder, Kind, argument_fault, in_words, line_in
from ..core.rules import RuleSet

_Answer = TypeVar("_Answer")

METHODS = ("distance", "required")
"""A law has one of these, or both (see `navigation.Law` and `navigation.MotionLaw`)."""


class LawError(UserError):
    """A law is invalid, or has failed."""


LAW = Kind(
    noun="law",
    words=f"law: a law is a class with a method {' or '.join(METHODS)}",
    accepts=lambda law: inspect.isclass(law) and any(hasattr(law, method) for method in METHODS),
    error=LawError,
)
"""The kind of class that a rule set names."""


class OwnLaw:
    """Law of the class `package.module:Class` in `folder`, with the arguments `terms`.

    `load` imports, constructs and tests it, at the latest at its first use. Then it has the methods
    of the custom class. Laws with the same name, terms and folder are equal, and are pickled by
    these. `place` is its place in a file, for messages.
    """

    def __init__(
        self, name: str, terms: Mapping[str, Any], folder: str | Path = ".", place: str = ""
    ) -> None:
        self.name = name
        self.terms = dict(terms)
        self.folder = Path(folder).resolve()
        self.place = place
        self._law: Any = None

    def load(self) -> None:
        """Import the class, construct the law and test it, unless that was done before.

        `LawError` if there is no such class, or if the law is invalid.
        """
        if self._law is not None:
            return
        try:
            self._make()
            self._try()
        except LawError as why:
            self._forget()
            raise LawError(f"{self.place}: {why}" if self.place else str(why)) from why

    def __getattr__(self, name: str) -> Any:
        if name in METHODS and self._law is None:
            self.load()
            if name in self.__dict__:
                return self.__dict__[name]
        raise AttributeError(f"{type(self).__name__!r} object has no attribute {name!r}")

    def __repr__(self) -> str:
        terms = ", ".join(f"{name}={term!r}" for name, term in self.terms.items())
        return f"{self.name}({terms})"

    def __eq__(self, other: object) -> bool:
        return isinstance(other, OwnLaw) and self._key() == other._key()

    def __hash__(self) -> int:
        return hash(repr(self._key()))

    def __reduce__(self) -> tuple[type[OwnLaw], tuple[str, dict[str, Any], Path, str]]:
        return OwnLaw, (self.name, self.terms, self.folder, self.place)

    def _key(self) -> tuple[str, dict[str, Any], Path]:
        return self.name, self.terms, self.folder

    def _make(self) -> None:
        source = CodeFolder(self.folder).find(self.name, LAW)
        form = source.load()
        if fault := argument_fault(form, self.terms):
            raise LawError(f"the law {self}: {fault}")
        self._file = source.file
        self._law = self._asked(form, **self.terms)
        for method, checked in zip(METHODS, (self._distance, self._required), strict=True):
            if hasattr(self._law, method):
                setattr(self, method, checked)

    def _forget(self) -> None:
        self._law = None
        for method in METHODS:
            self.__dict__.pop(method, None)

    def _distance(self, human_speed: float, robot_speed: float) -> float:
        metres = self._asked(self._law.distance, human_speed, robot_speed)
        if not (isinstance(metres, int | float) and 0 <= metres < math.inf):
            speeds = f"{human_speed:g} (human) and {robot_speed:g} m/s (robot)"
            raise LawError(f"the law {self} asks for {metres!r} m at speeds of {speeds}")
        return metres

    def _required(self, encounter: Encounter, begin: float, end: float) -> Enclosure:
        required = self._asked(self._law.required, encounter, begin, end)
        if not isinstance(required, Enclosure):
            raise LawError(f"the law {self} answers with {required!r}, not with an Enclosure")
        return required

    def _asked(self, answer: Callable[..., _Answer], /, *args: Any, **terms: Any) -> _Answer:
        try:
            return answer(*args, **terms)
        except Exception as why:
            place = line_in(why, {str(self._file)})
            raise LawError(f"the law {self} failed{place}: {in_words(why)}") from why

    def _try(self) -> None:
        """Test the law, or raise a `LawError`."""
        person, machine = walk([(-3.0, 0.0), (3.0, 0.5)]), standing((0.0, 0.0))
        try:
            TooClose(self)
            if is_of_motions(self):
                minimum_margin(person, machine, self, 0.0, 8.0)
        except LawError:
            raise
        except ValueError as why:
            raise LawError(f"the law is invalid: {why}") from why


def with_new_laws(rules: RuleSet) -> RuleSet:
    """Return `rules` with custom laws that are imported, constructed and tested for this run."""
    laws = {law: OwnLaw(law.name, law.terms, law.folder, law.place) for law in own_laws(rules)}
    for law in laws.values():
        law.load()

    def new(law: Any) -> Any:
        if isinstance(law, Scaled):
            return replace(law, law=new(law.law))
        return laws[law] if isinstance(law, OwnLaw) else law

    return replace(
        rules,
        gantry_law=new(rules.gantry_law),
        agv_law=new(rules.agv_law),
        notice=replace(rules.notice, law=new(rules.notice.law)),
        laws={name: new(law) for name, law in rules.laws.items()},
    )


def laws_in(rules: RuleSet) -> Iterator[AnyLaw]:
    """Yield the laws in `rules`, and the laws that they scale."""
    for law in (rules.gantry_law, rules.agv_law, rules.notice.law, *rules.laws.values()):
        while isinstance(law, Scaled):
            law = law.law
        yield law


def own_laws(rules: RuleSet) -> Iterator[OwnLaw]:
    """Yield the custom laws of `rules`."""
    return (law for law in laws_in(rules) if isinstance(law, OwnLaw))


Curve = tuple[tuple[float, float], ...]
"""Points (s, m) in order of time. Two at one time are a jump."""

EXACT = 0.01
"""Maximum error of the lines, m."""

STRIDE = 0.5
"""Duration below which a rise and fall of the curve may be missed, s."""


def is_of_speeds_alone(law: AnyLaw) -> bool:
    """Return whether `law` depends only on its parameters and two speeds."""
    return type(law) in (SeparationLaw, ApproachLaw, FixedDistance)


def requirement_curve(
    law: AnyLaw, person: Plans, machine: Plans, end: float, shapes: Shapes | None
) -> Curve:
    """Return the distance that `law` required over time until `end` (s).

    `person` and `machine` are the plans at each time, also those that were replaced later. `shapes`
    are the solids between which distances are measured, or None for centres.
    """
    changes = sorted({t for t in (*person.changes, *machine.changes) if t < end} | {end})
    points: list[tuple[float, float]] = []
    for begin, until in itertools.pairwise(changes):
        motions = (person.at(begin), machine.at(begin))
        required = required_along(law, *motions, shapes)
        cuts = {begin, until}
        cuts |= {p.begin for motion in motions for p in motion.pieces if begin < p.begin < until}
        for a, b in itertools.pairwise(sorted(cuts)):
            points += _lines(required, a, b)
    return tuple(_without_needless(points))


def _lines(
    required: Callable[[float], float], begin: float, end: float
) -> list[tuple[float, float]]:
    # Halving checks only the middle, so cut first for a rise and fall beside it.
    strides = max(1, round((end - begin) / STRIDE))
    points = [(begin, required(begin))]
    for k in range(1, strides + 1):
        t = begin + (end - begin) * k / strides
        points += _halved(required, points[-1], (t, required(t)))
    return points


def _halved(
    required: Callable[[float], float], a: tuple[float, float], b: tuple[float, float]
) -> list[tuple[float, float]]:
    """Return the points after `a` up to `b` between which the curve is straight."""
    t = (a[0] + b[0]) / 2
    middle = (t, required(t))
    # The error may be larger away from the middle, so allow half of it there.
    if abs(middle[1] - (a[1] + b[1]) / 2) <= EXACT / 2 or b[0] - a[0] < EXACT:
        return [b]
    return _halved(required, a, middle) + _halved(required, middle, b)


def _without_needless(points: list[tuple[float, float]]) -> list[tuple[float, float]]:
    """Return the same curve without points on the line between their neighbours."""
    curve: list[tuple[float, float]] = []
    for point in points:
        if curve and point == curve[-1]:
            continue
        if len(curve) > 1 and _on_line(curve[-2], curve[-1], point):
            curve.pop()
        curve.append(point)
    return curve


def _on_line(a: tuple[float, float], b: tuple[float, float], c: tuple[float, float]) -> bool:
    if not a[0] < b[0] < c[0]:
        return False
    between = a[1] + (c[1] - a[1]) * (b[0] - a[0]) / (c[0] - a[0])
    return abs(between - b[1]) < EXACT / 100
