"""What the kernels name `cython` where they are not compiled, and their structs.

Importing Cython itself would take longer than all else here, and it need not be installed.
"""

from collections.abc import Callable, Iterator, MutableSequence
from typing import Generic, NamedTuple, TypeVar, cast

compiled = False

Row = TypeVar("Row", bound=tuple[object, ...])


class Rows(Generic[Row]):
    """Structs in a row of numbers, of `width` numbers each, from the one at `o` on.

    `kind` makes one of its numbers. Structs in structs are laid out in turn.
    """

    def __init__(
        self, row: MutableSequence[float], kind: Callable[..., Row], width: int, o: int = 0
    ) -> None:
        self.row = row
        self.kind = kind
        self.width = width
        self.o = o

    def __getitem__(self, k: int) -> Row:
        o = self.o + self.width * k
        return self.kind(*self.row[o : o + self.width])

    def __setitem__(self, k: int, struct: Row) -> None:
        o = self.o + self.width * k
        self.row[o : o + self.width] = [*_numbers(struct)]


def _numbers(struct: tuple[object, ...]) -> Iterator[float]:
    for part in struct:
        if isinstance(part, tuple):
            yield from part
        else:
            yield cast(float, part)


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
    """Place at which a path bends (metres), and its unit directions before and after.

    The path touches the arc at most `reach` metres away.
    """

    x: float
    y: float
    before_x: float
    before_y: float
    after_x: float
    after_y: float
    reach: float


class TaylorModel(NamedTuple):
    """Number that changes over an interval: within `slack` of value + slope u + curve u² / 2.

    u is the time from the middle of the interval (`navigation.Enclosure`).
    """

    value: float
    slope: float
    slack: float
    curve: float


class Closest(NamedTuple):
    """Bounds on the minimum of a distance over an interval, and a time near it (seconds)."""

    low: float
    high: float
    t: float


class NearestPoint(NamedTuple):
    """Point of a footprint nearest to a place, its distance, and that of the solids (metres)."""

    x: float
    y: float
    away: float
    distance: float


class RelativeMotion(NamedTuple):
    """Motion of a person in the frame that a machine has at the middle of an interval.

    Place, velocity and half the acceleration, and how fast the machine turns. For `half` seconds
    before and after, the person stays within `bend` (m) of place and velocity, and within `jolt` if
    the acceleration counts too; the machine stays within `twist` (rad) and turns by no more than
    `swing`.
    """

    x: float
    y: float
    vx: float
    vy: float
    ax: float
    ay: float
    spin: float
    half: float
    bend: float
    jolt: float
    twist: float
    swing: float


class SearchEntry(NamedTuple):
    """Entry of a search: lower bound of a path's length, its length so far, and its last link."""

    bound: float
    so_far: float
    here: int
    there: int


class PathLeg(NamedTuple):
    """Leg of a path: start (metres), direction, length (metres), and two speeds (m/s).

    `top` is the top speed on it, `first` the highest speed at its start.
    """

    x: float
    y: float
    c: float
    s: float
    length: float
    top: float
    first: float


class SpeedLimits(NamedTuple):
    """When a person starts (seconds), how fast (m/s), and how fast they may become (m/s, m/s²)."""

    start: float
    initial_speed: float
    max_speed: float
    acceleration: float


class SeenPerson(NamedTuple):
    """Person as a machine sees them: place (metres), top speed (m/s), and a fixed distance.

    That is what a law that looks ahead requires (metres), or less than 0 where it depends on the
    machine's speed.
    """

    x: float
    y: float
    top_speed: float
    fixed: float
