"""Groups of layers: those of a drawing that are read, and as what."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping
from dataclasses import dataclass
from fnmatch import fnmatchcase

from shapely.geometry import Polygon

from .problems import Problem, suggestion

BOUNDARY = "boundary"
"""The group of the outline of the floor; without groups, the layer of that name."""


@dataclass(frozen=True)
class Group:
    """Layers by patterns (`A-WALL*`), in capitals or not, and how their shapes are read.

    `z` are the heights of the shapes (metres) instead of the drawn ones. With a `line_width`
    (metres) every line stands for a wall this wide. Where it is `hollow`, outlines inside outlines
    are openings.
    """

    patterns: tuple[str, ...]
    z: tuple[float, float] | None = None
    line_width: float | None = None
    hollow: bool = False

    def has(self, layer: str) -> bool:
        """Return whether `layer` is one of them."""
        return any(fnmatchcase(layer.casefold(), one.casefold()) for one in self.patterns)


@dataclass(frozen=True)
class Drawn:
    """How a drawing is read, where the drawing itself leaves it open.

    `metre` is the length of its unit (metres), None for the unit that it gives itself. Without
    `groups` every layer is one. Ends of lines within `snap` metres of each other meet. Shapes are
    left out by their handles. A `boundary` (metres) takes the place of the drawn one.
    """

    metre: float | None = None
    groups: Mapping[str, Group] | None = None
    snap: float = 1e-6
    leave_out: frozenset[str] = frozenset()
    boundary: Polygon | None = None

    def group_of(self, layer: str) -> str | None:
        """Return the name of the first group with this layer, None if it is in none."""
        if self.groups is None:
            return BOUNDARY if layer.casefold() == BOUNDARY else layer
        return next((name for name, group in self.groups.items() if group.has(layer)), None)

    def group(self, name: str) -> Group:
        """Return the group of this name."""
        return Group(()) if self.groups is None else self.groups[name]

    def unmatched(self, layers: Collection[str]) -> Iterator[Problem]:
        """Yield a problem for each pattern that none of `layers` matches."""
        for name, group in (self.groups or {}).items():
            for pattern in group.patterns:
                if not any(Group((pattern,)).has(layer) for layer in layers):
                    hint = suggestion(pattern, sorted(layers)) if layers else "it has none"
                    yield Problem(f"no layer of the drawing matches {pattern!r}; {hint}", name)


AS_IT_IS = Drawn()
"""Reading of a drawing on its own."""
