"""The solids, lines and words that a viewer's scene is made of, whatever the viewer.

Metres and radians, z up, in the frame of the thing that they belong to; colours are red, green,
blue and opacity, 0 … 1.
"""

from __future__ import annotations

from dataclasses import dataclass

Point3 = tuple[float, float, float]
"""x, y, z in metres."""

Color = tuple[float, float, float, float]


@dataclass(frozen=True)
class Block:
    """A box: its centre, its length, width and height, turned about z by `yaw`."""

    center: Point3
    size: Point3
    color: Color
    yaw: float = 0.0


@dataclass(frozen=True)
class Tube:
    """An upright cylinder: the centre of its axis, its radius and height."""

    center: Point3
    radius: float
    height: float
    color: Color


@dataclass(frozen=True)
class Arrow:
    """An arrow along x from `start`, `length` metres long."""

    start: Point3
    length: float
    color: Color


@dataclass(frozen=True)
class Line:
    """A line through points, `width` metres wide."""

    points: tuple[Point3, ...]
    width: float
    color: Color


@dataclass(frozen=True)
class Surface:
    """Triangles: three points each, seen from both sides."""

    points: tuple[Point3, ...]
    color: Color


@dataclass(frozen=True)
class Label:
    """Words that face whoever looks, letters `size` metres high."""

    at: Point3
    text: str
    size: float
    color: Color


Shape = Block | Tube | Arrow | Line | Surface | Label


@dataclass(frozen=True)
class Thing:
    """Shapes with a name that stay where they are in `frame`, and move with it."""

    name: str
    frame: str
    shapes: tuple[Shape, ...]
