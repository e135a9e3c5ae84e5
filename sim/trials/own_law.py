"""A law of the user's own, found by name; what goes wrong in it is told by that name."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any, TypeVar

from navigation import Enclosure, Encounter, MotionLaw, TooClose, minimum_margin, standing, walk

from .own_code import OwnCodeError, find_own, in_words, line_in, source_of

_Answer = TypeVar("_Answer")


class LawError(ValueError):
    """A law that makes no sense, or that failed when it was asked."""


class OwnLaw:
    """The law at `package.module:Class`, made with `terms` by their names.

    It has the methods that the user's class has. Two are equal if they have the same name and
    terms and come from the same folder; it travels between processes by these.
    """

    def __init__(self, name: str, terms: Mapping[str, Any], folder: str | Path = ".") -> None:
        self.name = name
        self.terms = dict(terms)
        self.folder = Path(folder).resolve()
        self._file: str | None = None
        self._law = self._made()
        for method, asked in (("distance", self._distance), ("required", self._required)):
            if hasattr(self._law, method):
                setattr(self, method, asked)
        self._try()

    def __repr__(self) -> str:
        terms = ", ".join(f"{name}={term!r}" for name, term in self.terms.items())
        return f"{self.name}({terms})"

    def __eq__(self, other: object) -> bool:
        return isinstance(other, OwnLaw) and self._key() == other._key()

    def __hash__(self) -> int:
        return hash(repr(self._key()))

    def __reduce__(self) -> tuple[type[OwnLaw], tuple[str, dict[str, Any], Path]]:
        return OwnLaw, (self.name, self.terms, self.folder)

    def _key(self) -> tuple[str, dict[str, Any], Path]:
        return self.name, self.terms, self.folder

    def _made(self) -> Any:
        try:
            law = find_own(self.name, self.folder)
        except OwnCodeError as why:
            raise LawError(f"the law {why}") from why
        if not callable(law):
            raise LawError(f"{self.name} is not a class")
        self._file = source_of(self.name, self.folder)
        return self._asked(law, **self.terms)

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
            place = line_in(why, self._file)
            raise LawError(f"the law {self} failed{place}: {in_words(why)}") from why

    def _try(self) -> None:
        """`LawError` if it is no law, or if trying it shows that it makes no sense."""
        person, machine = walk([(-3.0, 0.0), (3.0, 0.5)]), standing((0.0, 0.0))
        try:
            TooClose(self)  # type: ignore[arg-type]
            if isinstance(self, MotionLaw):
                minimum_margin(person, machine, self, 0.0, 8.0)
        except LawError:
            raise
        except ValueError as why:
            raise LawError(f"the law makes no sense: {why}") from why
