"""One-way gates: lines on the floor that may be crossed in one direction only.

What is on the line of a gate counts as on its far side. So each place is on one side or the other,
and a path crosses a gate if, and only if, one of its legs does, wherever it bends.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from itertools import pairwise
from weakref import WeakKeyDictionary

import shapely

from floorplan import Gate, Point

from .freespace import FreeSpace
from .kernels.edges import back_through
from .kernels.numbers import numbers

_THIN = 1e-7
"""Metres. Half of the width of what a gate takes from the room on either side of it."""


class Gates:
    """Some gates, as those see them who mind them."""

    def __init__(self, gates: Iterable[Gate] = ()) -> None:
        self.all = tuple(gates)
        self.lines = [numbers((*gate.ends[0], *gate.ends[1], *gate.normal)) for gate in self.all]
        """x and y of the ends of each in turn, and of its direction."""
        self._parted: WeakKeyDictionary[FreeSpace, _Parted] = WeakKeyDictionary()

    def __repr__(self) -> str:
        return f"<Gates {', '.join(gate.name for gate in self.all)}>"

    def __bool__(self) -> bool:
        return bool(self.all)

    def allow(self, a: Point, b: Point) -> bool:
        """Return whether the segment from a to b goes through none against its direction."""
        return not any(back_through(line, *a, *b) for line in self.lines)

    def apart(self, a: Point, b: Point) -> bool:
        """Return whether the segment between a and b goes through any, whichever way."""
        return not (self.allow(a, b) and self.allow(b, a))

    def broken(self, points: Sequence[Point]) -> tuple[Gate, ...]:
        """Return those that the polyline `points` goes through against their direction."""
        return tuple(
            gate
            for gate, line in zip(self.all, self.lines, strict=True)
            if any(back_through(line, *a, *b) for a, b in pairwise(points))
        )

    def reach(self, space: FreeSpace, start: Point, goal: Point) -> bool:
        """Return whether some path within `space` leads from `start` to `goal`."""
        if not self.all:
            return space.together(start, goal)
        if not space.together(start, goal):
            return False
        parted = self._of(space)
        return parted.face_of(goal) in parted.reached(start)

    def closing(self, space: FreeSpace, start: Point) -> list[str]:
        """Return the names of the gates that would lead out of all that `start` reaches."""
        parted = self._of(space)
        reached = parted.reached(start)
        found = (
            self.all[k].name
            for k, before, behind in parted.passages
            if behind in reached and before not in reached
        )
        return [*dict.fromkeys(found)]

    def _of(self, space: FreeSpace) -> _Parted:
        known = self._parted.get(space)
        if known is None:
            known = self._parted[space] = _Parted(space, self.all)
        return known


class _Parted:
    """The parts into which gates divide a space, and the ways from one to another.

    `passages` has the number of a gate, and those of the parts before and behind it.
    """

    def __init__(self, space: FreeSpace, gates: tuple[Gate, ...]) -> None:
        self._gates = gates
        lines = shapely.linestrings([gate.ends for gate in gates])
        # A strip along each gate cuts the space: parts then are connected by passages alone.
        strips = shapely.union_all(shapely.buffer(lines, _THIN, cap_style="flat"))
        self._parts = FreeSpace(shapely.difference(space.pieces, strips))
        self.passages: list[tuple[int, int | None, int | None]] = []
        for k, gate in enumerate(gates):
            nx, ny = gate.normal
            for span in shapely.get_parts(shapely.intersection(lines[k], space.pieces)):
                if span.length > 2 * _THIN:
                    x, y = shapely.get_coordinates(span.interpolate(0.5, normalized=True))[0]
                    before, behind = (
                        self._parts.piece_of((x + side * nx, y + side * ny))
                        for side in (-2 * _THIN, 2 * _THIN)
                    )
                    self.passages.append((k, before, behind))

    def face_of(self, place: Point) -> int | None:
        """Return the number of the part that `place` is in."""
        x, y = place
        for gate in self._gates:
            (nx, ny), (ax, ay) = gate.normal, gate.ends[0]
            ahead = (x - ax) * nx + (y - ay) * ny
            # Within the strip there is no part: such a place counts for the side that it is on.
            if abs(ahead) < 2 * _THIN:
                side = 2 * _THIN if ahead >= 0 else -2 * _THIN
                x, y = x + side * nx, y + side * ny
        return self._parts.piece_of((x, y))

    def reached(self, start: Point) -> set[int | None]:
        """Return the parts to which paths lead from `start`."""
        found = {self.face_of(start)}
        while True:
            # Reachability of a directed graph, one step in every direction at a time.
            fresh = {behind for _, before, behind in self.passages if before in found} - found
            if not fresh:
                return found
            found |= fresh
