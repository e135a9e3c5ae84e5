"""The solids, lines and words that a viewer's scene is made of, whatever the viewer.

Metres and radians, z up, in the frame of the thing that they belong to; colours are red, green,
blue and opacity, 0 … 1.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

Point3 = tuple[float, float, float]
"""x, y, z in metres."""

Color = tuple[float, float, float, float]


@dataclass(frozen=True, kw_only=True)
class Shape:
    """A shape with its middle (of an arrow, its start) at `at`, turned about z by `yaw`.

    | kind | `size` | |
    |---|---|---|
    | cube | along x, y and z | |
    | cylinder | along x, y and z | upright |
    | arrow | length, diameter of the shaft, diameter of the head | along x |
    | line | width, 0, 0 | through `points` |
    | triangles | 1, 1, 1 | three `points` each, seen from both sides |
    | label | 0, 0, height of the letters | `text` that faces whoever looks |
    """

    kind: Literal["cube", "cylinder", "arrow", "line", "triangles", "label"]
    color: Color
    size: Point3
    at: Point3 = (0.0, 0.0, 0.0)
    yaw: float = 0.0
    points: tuple[Point3, ...] = ()
    text: str = ""


@dataclass(frozen=True)
class Thing:
    """Shapes with a name that stay where they are in `frame`, and move with it."""

    name: str
    frame: str
    shapes: tuple[Shape, ...]
