"""A law of the user's own, found by name; errors in it are reported by that name."""

from __future__ import annotations

import ast
import inspect
import math
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import Any, TypeVar

from floorplan import UserError
from navigation import (
    Enclosure,
    Encounter,
    Scaled,
    TooClose,
    is_of_motions,
    minimum_margin,
    standing,
    walk,
)

from ..core.own_code import import_own
from ..core.own_source import (
    Definition,
    Kind,
    OwnCodeError,
    find_source,
    in_words,
    is_plain,
    line_in,
)
from ..core.own_source import methods as written_methods
from ..core.rules import RuleSet

_Answer = TypeVar("_Answer")

METHODS = ("distance", "required")
"""A law has one of these, or both (see `navigation.Law` and `navigation.MotionLaw`)."""


def _may_be_law(definition: Definition) -> bool:
    if not isinstance(definition, ast.ClassDef):
        return False
    return not is_plain(definition) or not written_methods(definition).isdisjoint(METHODS)


LAW = Kind(
    words=f"law: a law is a class with a method {' or '.join(METHODS)}",
    written=_may_be_law,
    made=lambda law: inspect.isclass(law) and any(hasattr(law, method) for method in METHODS),
)
"""The kind of class that a rule set names."""


class LawError(UserError):
    """A law that makes no sense, or that failed when it was asked."""


class OwnLaw:
    """The law at `package.module:Class` in `folder`, made with `terms` by their names.

    It is imported, made and tried by `load`, at the latest when it is first asked; then it has the
    methods that the user's class has. Two are equal if they have the same name and terms and come
    from the same folder; it travels between processes by these. `place` is where it is written,
    for messages.
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
        """Import the class, make the law and try it, if that was not done before.

        `LawError` if there is no such class, or if trying the law shows that it makes no sense.
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
        try:
            source = find_source(self.name, self.folder, LAW)
            form = import_own(source)
        except OwnCodeError as why:
            raise LawError(f"the law {why}") from why
        self._file = source.file
        self._law = self._asked(form, **self.terms)
        for method, asked in zip(METHODS, (self._distance, self._required), strict=True):
            if hasattr(self._law, method):
                setattr(self, method, asked)

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
        """Try the law; `LawError` if it is none, or if trying shows that it makes no sense."""
        person, machine = walk([(-3.0, 0.0), (3.0, 0.5)]), standing((0.0, 0.0))
        try:
            TooClose(self)
            if is_of_motions(self):
                minimum_margin(person, machine, self, 0.0, 8.0)
        except LawError:
            raise
        except ValueError as why:
            raise LawError(f"the law makes no sense: {why}") from why


def own_laws(rules: RuleSet) -> Iterator[OwnLaw]:
    """Yield the laws of the user's own in `rules`, also those that another one scales."""
    for law in (rules.gantry_law, rules.agv_law, rules.notice.law, *rules.laws.values()):
        while isinstance(law, Scaled):
            law = law.law
        if isinstance(law, OwnLaw):
            yield law
