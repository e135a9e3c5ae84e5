"""People who are about to change their motions together, and their conflicts with all others."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import cython
else:
    from . import uncompiled as cython

from .throng import Throng

if not cython.compiled:
    from .discs import first_but, met
    from .numbers import *


class Movers:
    """Those of a `throng` who move from `now` on (seconds) other than they are committed to.

    In the order in which they were added: their `indices`, `tables`, `boxes` and `radii`.
    """

    def __init__(self, throng: Throng, now: float) -> None:
        self.throng = throng
        self.now = now
        self.indices: list[int] = []
        self.tables: list[Numbers] = []
        self.boxes: Numbers = room(0)
        self.radii: Numbers = room(0)
        self.among = bytearray(len(throng.radii))

    def add(self, k: cython.Py_ssize_t, table: Numbers, box: Numbers) -> None:
        """Let the k-th move so."""
        self.indices.append(k)
        self.tables.append(table)
        self.boxes.extend(box)
        self.radii.append(at(self.throng.radii)[k])
        self.among[k] = 1

    def keep(self, count: cython.Py_ssize_t) -> None:
        """Keep the first so many; the others are not to move after all."""
        i: cython.Py_ssize_t
        for i in range(count, len(self.radii)):
            self.among[self.indices[i]] = 0
        del self.indices[count:]
        del self.tables[count:]
        del self.boxes[4 * count :]
        del self.radii[count:]

    def meet(self, k: cython.Py_ssize_t, table: Numbers, box: Numbers) -> bool:
        """Return whether the k-th, who goes like this, would come too close to another of them."""
        own: float = at(self.throng.radii)[k] + self.throng.gap
        i: cython.Py_ssize_t
        for i in range(len(self.radii)):
            if self.indices[i] != k and self.met(i, table, box, own) < INFINITY:
                return True
        return False

    def met(self, i: cython.Py_ssize_t, table: Numbers, box: Numbers, own: float) -> float:
        """Return when one who keeps `own` metres meets the i-th of them; infinite if never."""
        t: float = met(table, box, self.tables, self.boxes, self.radii, own, self.now, INFINITY, i)
        return t

    def change(self, i: cython.Py_ssize_t, table: Numbers, box: Numbers) -> None:
        """Let the i-th of them move so instead."""
        self.tables[i] = table
        put(at(self.boxes), 4 * i, at(box), 0, 4)

    def first_hit(self, i: cython.Py_ssize_t) -> cython.Py_ssize_t:
        """Return whom the i-th of them would meet first of all others but these; -1 for nobody."""
        box: Numbers = part(self.boxes, 4 * i, 4)
        return self.first_other(self.indices[i], self.tables[i], box)

    def first_other(self, k: cython.Py_ssize_t, table: Numbers, box: Numbers) -> cython.Py_ssize_t:
        """Return whom the k-th, who goes like this, would meet first of all others but these.

        -1 for nobody.
        """
        throng: Throng = self.throng
        own: float = at(throng.radii)[k] + throng.gap
        before: cython.int = self.among[k]
        self.among[k] = 1
        found: cython.Py_ssize_t = first_but(
            table, box, throng.tables, throng.boxes, throng.radii, own, self.now, self.among
        )
        self.among[k] = before
        return found
