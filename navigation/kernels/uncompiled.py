"""What the kernels name `cython` where they are not compiled, and their structs.

Importing Cython itself would take longer than all else here, and it need not be installed.
"""

from typing import NamedTuple

compiled = False


class Wedge(NamedTuple):
    """Directions from a place, counterclockwise from its right side to its left side."""

    right_x: float
    right_y: float
    left_x: float
    left_y: float


class Portal(NamedTuple):
    """Side through which one triangle leads to another, by their numbers; ends in metres."""

    right_x: float
    right_y: float
    left_x: float
    left_y: float
    off: float
    onto: float


class Bend(NamedTuple):
    """Place at which a path bends (metres), and its unit directions before and after."""

    x: float
    y: float
    before_x: float
    before_y: float
    after_x: float
    after_y: float
