"""Tables of structs: rows of numbers of which each kind has a fixed width.

Only this module knows the order of the numbers of a struct. Compiled kernels use `tables.pxd`
instead, in which structs are those of C, and a view of a table is a pointer to its first struct.
Here a struct is a named tuple, which `Rows` makes from its numbers. Both files must agree.

Motions are tables of pieces: begin and end (seconds), then the four coefficients of the cubic of
each coordinate, relative to the begin. A `PlanarPiece` has x and y (metres). A `PosePiece` has a
rotation (radians) in addition.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Generic, NamedTuple, TypeAlias, TypeVar, cast

from .numbers import *
from .numbers import PLANAR_WIDTH, POSE_WIDTH, Numbers, cut, grow, part, room, row_at

Row = TypeVar("Row", bound=tuple[object, ...])


class Rows(Generic[Row]):
    """Structs of `width` numbers each in a row of numbers, from the offset `o` on.

    `kind` makes a struct of its numbers. Nested structs are stored in turn.
    """

    def __init__(self, row: Numbers, kind: Callable[..., Row], width: int, o: int = 0) -> None:
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
    for member in struct:
        if isinstance(member, tuple):
            yield from member
        else:
            yield cast(float, member)


def _view(kind: Callable[..., Row], width: int) -> Callable[[Numbers], Rows[Row]]:
    """Return a function that views a table as structs of a kind."""
    return lambda row: Rows(row, kind, width)


def _count(width: int) -> Callable[[Numbers], int]:
    """Return a function that counts the structs of a table."""
    return lambda row: len(row) // width


def _room(width: int) -> Callable[[int], Numbers]:
    """Return a function that makes a table for a number of structs."""
    return lambda count: room(width * count)


def _cut(width: int) -> Callable[[Numbers, int], None]:
    """Return a function that shortens a table to its first structs."""
    return lambda row, count: cut(row, width * count)


# Motions


class Cubic(NamedTuple):
    """Polynomial p + v u + a u² + j u³ of the time u since a piece begins."""

    p: float
    v: float
    a: float
    j: float


class PlanarPiece(NamedTuple):
    """Piece of the motion of a point: its time span (seconds), and its coordinates (metres)."""

    begin: float
    end: float
    x: Cubic
    y: Cubic


class PosePiece(NamedTuple):
    """Piece of the motion of a body: a `PlanarPiece` with a rotation (radians)."""

    begin: float
    end: float
    x: Cubic
    y: Cubic
    rotation: Cubic


class Phase(NamedTuple):
    """Phase of one coordinate: its duration (seconds), and the cubic since it began."""

    duration: float
    c: Cubic


class PathLeg(NamedTuple):
    """Segment of a path: start (metres), direction, length (metres), and two speeds (m/s).

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
    """Start of a walk (s), its initial speed (m/s), and its limits (m/s, m/s²)."""

    start: float
    initial_speed: float
    max_speed: float
    acceleration: float


def _planar_piece(begin: float, end: float, *c: float) -> PlanarPiece:
    return PlanarPiece(begin, end, Cubic(*c[:4]), Cubic(*c[4:]))


def _pose_piece(begin: float, end: float, *c: float) -> PosePiece:
    return PosePiece(begin, end, Cubic(*c[:4]), Cubic(*c[4:8]), Cubic(*c[8:]))


def _phase(duration: float, *c: float) -> Phase:
    return Phase(duration, Cubic(*c))


PlanarPieces: TypeAlias = "Rows[PlanarPiece]"
PosePieces: TypeAlias = "Rows[PosePiece]"
Phases: TypeAlias = "Rows[Phase]"
PathLegs: TypeAlias = "Rows[PathLeg]"

planar, planar_count = _view(_planar_piece, PLANAR_WIDTH), _count(PLANAR_WIDTH)
planar_room, planar_cut = _room(PLANAR_WIDTH), _cut(PLANAR_WIDTH)
poses, pose_count = _view(_pose_piece, POSE_WIDTH), _count(POSE_WIDTH)
pose_room, pose_cut = _room(POSE_WIDTH), _cut(POSE_WIDTH)
phases, phase_count, phase_room, phase_cut = _view(_phase, 5), _count(5), _room(5), _cut(5)


def pose_at(table: Numbers, t: float) -> int:
    """Return the last piece of a table that begins by `t` (s), or -1."""
    k: int = row_at(table, pose_count(table), POSE_WIDTH, t)
    return k


def planar_at(table: Numbers, t: float) -> int:
    """Return the last piece of a table that begins by `t` (s), or -1."""
    k: int = row_at(table, planar_count(table), PLANAR_WIDTH, t)
    return k


def is_pose_finite(table: Numbers, k: int) -> bool:
    """Return whether the k-th piece of a table of x, y and rotation is finite."""
    total = sum(table[POSE_WIDTH * k : POSE_WIDTH * (k + 1)])
    return total - total == 0.0  # the sum is finite only if all numbers are


def first_pieces(table: Numbers, count: int) -> Numbers:
    """Return the first pieces of a table of x and y."""
    return part(table, 0, PLANAR_WIDTH * count)


def planar_put(table: Numbers, first: Numbers) -> None:
    """Set the first pieces of a table to those of another."""
    table[: len(first)] = first


def planar_space(table: Numbers, pieces: int, legs: int) -> PathLegs:
    """Lengthen a table to a number of pieces, and return the room for `legs` behind them."""
    grow(table, PLANAR_WIDTH * pieces + 7 * legs)
    return Rows(table, PathLeg, 7, PLANAR_WIDTH * pieces)


# Places, and what is at them


class Position(NamedTuple):
    """Place on a floor (metres)."""

    x: float
    y: float


class Placement(NamedTuple):
    """Place on a floor (metres) and rotation (radians)."""

    x: float
    y: float
    rotation: float


class Circle(NamedTuple):
    """Circle on a floor (metres)."""

    x: float
    y: float
    radius: float


class Edge(NamedTuple):
    """Segment from a to b (metres)."""

    ax: float
    ay: float
    bx: float
    by: float


class SweptSegment(NamedTuple):
    """Segment from (x, y) along d, with its direction and length (metres)."""

    x: float
    y: float
    dx: float
    dy: float
    c: float
    s: float
    length: float


class Range(NamedTuple):
    """Lower and upper bound."""

    low: float
    high: float


class BoundingBox(NamedTuple):
    """Axis-aligned bounds (metres)."""

    low_x: float
    low_y: float
    high_x: float
    high_y: float


class GateLine(NamedTuple):
    """Line from a to b (metres), and the direction in which crossing is allowed."""

    ax: float
    ay: float
    bx: float
    by: float
    nx: float
    ny: float


class CellWindow(NamedTuple):
    """Rectangle of cells: its first column and row, and the number of each."""

    column: int
    row: int
    columns: int
    rows: int


Positions: TypeAlias = "Rows[Position]"
Placements: TypeAlias = "Rows[Placement]"
Circles: TypeAlias = "Rows[Circle]"
Edges: TypeAlias = "Rows[Edge]"
Boxes: TypeAlias = "Rows[BoundingBox]"
GateLines: TypeAlias = "Rows[GateLine]"

positions_of, position_count, position_room = _view(Position, 2), _count(2), _room(2)
placements_of, placement_count, placement_room = _view(Placement, 3), _count(3), _room(3)
circles_of, circle_count, circle_room, circle_cut = _view(Circle, 3), _count(3), _room(3), _cut(3)
edges_of, edge_count, edge_room = _view(Edge, 4), _count(4), _room(4)
boxes_of, box_count, box_cut = _view(BoundingBox, 4), _count(4), _cut(4)
gates_of = _view(GateLine, 6)


def first_positions(row: Numbers, count: int) -> Numbers:
    """Return the first positions of a row."""
    return part(row, 0, 2 * count)


def positions_put(row: Numbers, first: Numbers) -> None:
    """Set the first positions of a row to those of another."""
    row[: len(first)] = first


def placement_grow(row: Numbers, count: int) -> None:
    """Lengthen a row to a number of placements."""
    grow(row, 3 * count)


def row_of_box(box: BoundingBox) -> Numbers:
    """Return a row of one box."""
    return [*box]


# Candidate walks of a person among others


class CoursePlace(NamedTuple):
    """Place on a course (metres), the direction there, and the index of the segment."""

    x: float
    y: float
    c: float
    s: float
    leg: int


class CourseLeg(NamedTuple):
    """Length (metres) and direction of a segment of a course."""

    length: float
    c: float
    s: float


class Bypass(NamedTuple):
    """Places at which a walk leaves a course, is beside it, and returns, with the segment (metres).

    The index of the segment is -1 if the walk ends beside the course.
    """

    off_x: float
    off_y: float
    by_x: float
    by_y: float
    x: float
    y: float
    leg: int


class CandidateWalk(NamedTuple):
    """Walk along a course: its loss and length (metres), top speed (m/s), and delay (s).

    If `side` is not 0, the walk is `side` metres to the left after `along` metres of the course.
    """

    loss: float
    length: float
    top_speed: float
    delay: float
    along: float
    side: float


class FrenetPlace(NamedTuple):
    """Place beside a course: the distances along it and to its left (metres)."""

    along: float
    left: float


class Meeting(NamedTuple):
    """First conflict: the index of the person, or -1, and the time (seconds)."""

    person: int
    t: float


class Leader(NamedTuple):
    """Index of a leader, or -1, with the speed behind the leader and the leader's own (m/s)."""

    person: int
    speed: float
    walks_on: float


CourseLegs: TypeAlias = "Rows[CourseLeg]"
CandidateWalks: TypeAlias = "Rows[CandidateWalk]"

course_legs, course_leg_room = _view(CourseLeg, 3), _room(3)
candidates_of, candidate_count = _view(CandidateWalk, 6), _count(6)


def candidates_grow(row: Numbers, count: int) -> None:
    """Lengthen a table to at least `count` candidates."""
    grow(row, 6 * count)


# Bends of a floor, and the search for paths over them


class Wedge(NamedTuple):
    """Directions from a place, counterclockwise from its right side to its left side."""

    right_x: float
    right_y: float
    left_x: float
    left_y: float


class Portal(NamedTuple):
    """Side between two triangles, by their numbers, from `off` to `onto`. Ends are in metres."""

    right_x: float
    right_y: float
    left_x: float
    left_y: float
    off: float
    onto: float


class WaitingPortal(NamedTuple):
    """Portal in the queue, by its number, and the wedge that leads through it."""

    portal: float
    wedge: Wedge


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


class Link(NamedTuple):
    """Number of the bend to which a link leads, and the length of the link (metres)."""

    to: float
    length: float


class SearchEntry(NamedTuple):
    """Entry of a search: lower bound of a path's length, its length so far, and its last link."""

    bound: float
    so_far: float
    here: int
    there: int


def _waiting_portal(portal: float, *wedge: float) -> WaitingPortal:
    return WaitingPortal(portal, Wedge(*wedge))


Portals: TypeAlias = "Rows[Portal]"
WaitingPortals: TypeAlias = "Rows[WaitingPortal]"
Bends: TypeAlias = "Rows[Bend]"
Links: TypeAlias = "Rows[Link]"
Entries: TypeAlias = "Rows[SearchEntry]"

portals_of, waiting_of, bends_of = _view(Portal, 6), _view(_waiting_portal, 5), _view(Bend, 7)
bend_count, bend_cut = _count(7), _cut(7)
link_rows, link_count, link_room, link_cut = _view(Link, 2), _count(2), _room(2), _cut(2)
entries_of, entry_count, entry_room = _view(SearchEntry, 4), _count(4), _room(4)


def waiting_grow(row: Numbers, count: int) -> None:
    """Lengthen a table to at least `count` portals."""
    grow(row, 5 * count)


def entries_grow(row: Numbers, count: int) -> None:
    """Lengthen a table to at least `count` entries."""
    grow(row, 4 * count)


# Distances and speeds over intervals


class TaylorModel(NamedTuple):
    """Number that changes over an interval: within `slack` of value + slope u + curve u² / 2.

    u is the time since the middle of the interval (`navigation.Enclosure`).
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
    """Motion of a person in the frame of a machine at the middle of an interval.

    It has the place, the velocity and half the acceleration of the person, and the turn rate of the
    machine. For `half` seconds before and after the middle, the person stays within `bend` (m) of
    the tangent, and within `jolt` (m) of the parabola. The machine stays within `twist` (rad) of a
    constant turn rate, and turns by at most `swing`.
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


class FramePath(NamedTuple):
    """Path of a person in the frame of a machine, within `bend` (metres) of a tangent."""

    tangent: Edge
    bend: float


class FieldTouch(NamedTuple):
    """Contact of a disc with a field on a path: never, perhaps or always.

    In the second case, the path is divided at the share `cut`.
    """

    state: int
    cut: float


class SweepDrift(NamedTuple):
    """Distance of paths from their chords in an interval (metres).

    It is a mean of 0, a and b, and at most `bend` in any direction in addition.
    """

    ax: float
    ay: float
    bx: float
    by: float
    bend: float


class BodyVelocity(NamedTuple):
    """Velocity of a body in its own frame over an interval: forwards and to the left (m/s).

    For `half` seconds before and after the middle, both stay within `bend` of the value there and
    their rates (m/s²). The turn rate (rad/s) stays within `turn_slack`.
    """

    ahead: float
    aside: float
    ahead_rate: float
    aside_rate: float
    turn: float
    turn_slack: float
    half: float
    bend: float


class FieldSpeeds(NamedTuple):
    """Velocities at which a set of fields applies: ranges of speed (m/s) and turn rate (rad/s).

    `directed` is 0 if the speed is that along the heading, and otherwise the speed over the floor,
    in directions from a to b: unit vectors, up to half a turn apart (1) or more (2).
    """

    low: float
    high: float
    turn_low: float
    turn_high: float
    directed: float
    ax: float
    ay: float
    bx: float
    by: float
    tolerance: float


class SeenPerson(NamedTuple):
    """Person in the view of a machine: place (metres), top speed (m/s), and a fixed distance.

    The fixed distance (metres) is that of a predictive law. It is negative if the law depends on
    the machine's speed.
    """

    x: float
    y: float
    top_speed: float
    fixed: float


class MovingPerson(NamedTuple):
    """Person with a known velocity: place (metres) and velocity (m/s)."""

    x: float
    y: float
    vx: float
    vy: float


FieldRows: TypeAlias = "Rows[FieldSpeeds]"
SeenPeople: TypeAlias = "Rows[SeenPerson]"
MovingPeople: TypeAlias = "Rows[MovingPerson]"

field_speeds, field_count = _view(FieldSpeeds, 10), _count(10)
seen_people, moving_people, person_count = _view(SeenPerson, 4), _view(MovingPerson, 4), _count(4)
