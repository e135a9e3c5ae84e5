"""Scene for robotics viewers: shapes, poses over time, and log lines.

Units are metres and radians, with z up, in the frame of the body. Colours are red, green, blue and
opacity from 0 to 1.

Every body has a frame at its centre on the floor that turns with it. A gantry on rails has a second
frame, `NAME/bridge`, which follows its x only.
"""

from __future__ import annotations

import heapq
import math
from collections.abc import Iterable, Iterator
from itertools import pairwise
from operator import attrgetter
from typing import Literal

import numpy as np
import shapely
from shapely.geometry import Polygon

from floorplan import Gantry, Obstacle, Point
from floorplan.files.dataclass import dataclass
from navigation import Motion

from ..core.body import Category, MachineShape
from ..core.recorder import Event, Figure
from ..core.wording import trimmed
from ..machines.gantry.robot import GANTRY
from ..machines.kinds import rails_under
from ..record.outcome import NANOSECOND, Outcome
from ..record.sampling import blocks_of_instants, sample

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
    """Named shapes that are fixed in `frame` and move with it."""

    name: str
    frame: str
    shapes: tuple[Shape, ...]


ROUNDING = 1e-8
"""Seconds. Times of events are rounded to less than this. Times of motions are exact."""


_SETS_OUT = ("goal", "replanned")
_IS_PUT = ("teleport", "left")
"""Events at which a path begins, and at which the current path ends."""


@dataclass(frozen=True)
class BodyPose:
    """The pose of a body: x, y (m) and rotation (rad), and its velocity (m/s)."""

    body: str
    x: float
    y: float
    rotation: float
    vx: float
    vy: float


@dataclass(frozen=True)
class WalkedPath:
    """Path of a person from `t` (s) to the next goal: (x, y, rotation) of its points."""

    t: float
    person: str
    points: tuple[tuple[float, float, float], ...]


@dataclass(frozen=True)
class Moment:
    """News at the time `t` (s): poses of bodies, an event, or a path that begins."""

    t: float
    poses: tuple[BodyPose, ...] = ()
    event: Event | None = None
    path: WalkedPath | None = None


def moments(run: Outcome, rate: float) -> Iterator[Moment]:
    """Yield the news of a run in order of time, with poses of every body at `rate` (Hz).

    Absent people have only the poses at their entry or exit, from or to far outside.

    Viewers interpolate between poses. Additional poses a nanosecond before and at every jump keep a
    body from sliding over the floor.
    """
    return heapq.merge(
        (Moment(event["t"], event=event) for event in run.events),
        (Moment(path.t, path=path) for path in walked_paths(run)),
        _regular(run, rate),
        _jumps(run),
        key=attrgetter("t"),
    )


def walked_paths(run: Outcome) -> list[WalkedPath]:
    """Return the paths of people from goal to goal, as walked, in order of time."""
    paths: list[WalkedPath] = []
    for person in run.scene.people:
        changes = [
            event
            for event in run.events
            if event["kind"] in (*_SETS_OUT, *_IS_PUT) and event["person"] == person.name
        ]
        ends = [*(event["t"] for event in changes[1:]), run.duration]
        for event, end in zip(changes, ends, strict=False):
            begin = event["t"] + ROUNDING
            if event["kind"] in _SETS_OUT and end - ROUNDING > begin:
                motion = run.motions[person.name].cut(begin, end - ROUNDING)
                paths.append(WalkedPath(event["t"], person.name, _corners(motion)))
    return sorted(paths, key=attrgetter("t"))


def just_before(run: Outcome, body: str, event: Event) -> tuple[float, float]:
    """Return the position (m) of a body just before `event`, which may move it."""
    return run.motions[body].state(event["t"] - ROUNDING).at


def nanoseconds(t: float) -> int:
    """Return a time (s) in nanoseconds."""
    return round(t * 1e9)


def _regular(run: Outcome, rate: float) -> Iterator[Moment]:
    for times in blocks_of_instants(run.duration, rate):
        tables = {name: sample(m, times).tolist() for name, m in run.motions.items()}
        there = {name: run.is_present(name, times).tolist() for name in run.motions}
        for k, t in enumerate(times.tolist()):
            poses = (BodyPose(name, *table[k]) for name, table in tables.items() if there[name][k])
            yield Moment(t, tuple(poses))


def _jumps(run: Outcome) -> list[Moment]:
    jumps = [
        Moment(t, (BodyPose(name, *sample(motion, np.array([t]))[0].tolist()),))
        for name, motion in run.motions.items()
        for jump in motion.jumps
        for t in (jump - NANOSECOND, jump)
    ]
    return sorted(jumps, key=attrgetter("t"))


def _corners(motion: Motion) -> tuple[tuple[float, float, float], ...]:
    """Return the poses at the begins of the pieces of a motion and at its end, each once."""
    corners = [motion.state(piece.begin).position for piece in motion.pieces]
    corners.append(motion.state_before(motion.end).position)
    new = [after for before, after in pairwise(corners) if after[:2] != before[:2]]
    return (corners[0], *new)


Level = Literal["info", "warning", "error"]

LEVELS: dict[str, Level] = {
    "collision": "error",
    "contact": "error",
    "violation": "error",
    "field_slowdown": "warning",
    "field_stop": "warning",
    "gantry_disabled": "warning",
    "machine_blocked": "warning",
    "protective_stop": "warning",
    "robot_malfunction": "warning",
    "notice": "warning",
    "path_blocked": "warning",
    "teleport": "warning",
    "traffic_deadlock": "warning",
    "warning": "warning",
}
"""Log levels by kind of event. Other events are "info"."""


@dataclass(frozen=True)
class LogLine:
    """One line of a log: its time (s), level, subject and text."""

    t: float
    level: Level
    name: str
    text: str


def line(event: Event) -> LogLine:
    """Return the log line of an event: its kind, and its fields as name=value."""
    kind = event["kind"]
    subject = next((role for role in ("person", "agv", "machine") if event.get(role)), "")
    who = event[subject] if subject else _subject(event)
    fields = [
        f"{name}={_shown(value)}"
        for name, value in event.items()
        if name not in ("t", "kind", subject)
    ]
    return LogLine(event["t"], LEVELS.get(kind, "info"), who, " ".join([kind, *fields]))


def _subject(event: Event) -> str:
    """Return the subject of an event without a body."""
    return "trial" if "trial" in event["kind"] or "machines" in event else GANTRY


def _shown(value: object) -> str:
    if isinstance(value, float):
        return trimmed(value)
    if isinstance(value, list | tuple):
        return "(" + ", ".join(_shown(inner) for inner in value) + ")"
    return "none" if value is None else str(value)


ROOT_FRAME = "map"
"""Frame of the floor, as named by ROS (REP 105)."""

GROUND = (0.93, 0.93, 0.91, 1.0)
WALL = (0.62, 0.62, 0.6, 1.0)
MARKING = (0.35, 0.35, 0.35, 1.0)
PERSON = (0.0, 0.45, 0.70, 1.0)
SAFE = (0.0, 0.62, 0.45, 1.0)
MACHINES: dict[Category, Color] = {"robot": (0.90, 0.62, 0.0, 1.0), "vehicle": SAFE}
ALARM = (0.84, 0.37, 0.0, 1.0)
# Colours of M. Okabe and K. Ito, "Color Universal Design", for all kinds of colour vision.

ALARM_TIME = 2.0
"""Seconds for which the position of a violation is marked."""

_HAIR = 0.01
"""Metres between flat shapes and the floor."""

_CIRCLE = tuple((math.cos(k * math.pi / 24), math.sin(k * math.pi / 24)) for k in range(49))

_AS_IT_IS = (1.0, 1.0, 1.0)


def frame(body: str, part: str = "base") -> str:
    """Return the frame that moves with a body, or with a part of it."""
    return f"{body}/{part}"


def floor(run: Outcome) -> list[Thing]:
    """Return everything that does not move."""
    plan = run.floorplan
    ground = Shape(
        kind="triangles", points=_triangles(plan.boundary, -_HAIR), size=_AS_IT_IS, color=GROUND
    )
    outline = polyline([(*at[:2], 0.0) for at in plan.boundary.exterior.coords], 0.05, MARKING)
    things = [Thing("floor", ROOT_FRAME, (ground, outline))]
    things += [
        Thing(f"obstacle {obstacle.name}", ROOT_FRAME, (_solid(obstacle),))
        for obstacle in plan.obstacles
    ]
    for station in plan.stations:
        x, y = station.position
        disc = _cylinder((x, y, _HAIR), plan.human.goal_tolerance, _HAIR, MARKING)
        words = _label((x, y, 0.4), station.name, MARKING)
        things.append(Thing(f"station {station.name}", ROOT_FRAME, (disc, words)))
    if plan.safe_zone is not None:
        x, y = plan.safe_zone.position
        words = _label((x, y, 0.4), "safe zone", SAFE)
        things.append(Thing("safe zone", ROOT_FRAME, (circle((x, y), 1.0, 0.05, SAFE), words)))
    courses = {lane.name: tuple(map(lane.position, lane.limits)) for lane in plan.lanes}
    courses |= {machine.name: machine.course for machine in run.scene.machines if machine.course}
    for name, course in courses.items():
        line = polyline([(*at, _HAIR) for at in course], 0.03, MACHINES["vehicle"])
        things.append(Thing(f"lane {name}", ROOT_FRAME, (line,)))
    if plan.gantry is not None:
        things.append(Thing("gantry rails", ROOT_FRAME, tuple(_rails(plan.gantry))))
    return things


def bodies(run: Outcome) -> list[Thing]:
    """Return everything that moves, each thing in its frame."""
    things = [
        Thing(person.name, frame(person.name), _person(person)) for person in run.scene.people
    ]
    for machine in run.scene.machines:
        name, rails = machine.name, rails_under(machine.name, run.floorplan)
        things.append(Thing(name, frame(name), tuple(_machine(machine, rails))))
        if rails is not None:
            things.append(Thing(f"{name} bridge", frame(name, "bridge"), (_bridge(rails),)))
    return things


def frames(run: Outcome, poses: Iterable[BodyPose]) -> Iterator[tuple[str, float, float, float]]:
    """Return the frames of bodies: name, x, y, rotation."""
    for pose in poses:
        yield frame(pose.body), pose.x, pose.y, pose.rotation
        if rails_under(pose.body, run.floorplan) is not None:
            yield frame(pose.body, "bridge"), pose.x, 0.0, 0.0


def violation(run: Outcome, event: Event) -> Thing:
    """Return the mark of a `violation`: a ring round the person, a line to the machine, a label."""
    person, machine = event["person"], event["with"]
    (x, y), end = just_before(run, person, event), just_before(run, machine, event)
    figure = next(one for one in run.scene.people if one.name == person)
    height = figure.height / 2
    middle = ((x + end[0]) / 2, (y + end[1]) / 2, height + 0.4)
    return Thing(
        f"violation {person} {machine}",
        ROOT_FRAME,
        (
            circle((x, y), 2 * figure.radius, 0.06, ALARM),
            polyline([(x, y, height), (*end, height)], 0.04, ALARM),
            _label(middle, f"closer than {event['required']:.2f} m", ALARM),
        ),
    )


def _person(person: Figure) -> tuple[Shape, ...]:
    radius, height = person.radius, person.height
    return (
        _cylinder((0.0, 0.0, height / 2), radius, height, PERSON),
        _arrow((radius, 0.0, 0.75 * height), 2 * radius, PERSON),
        _label((0.0, 0.0, height + 0.3), person.name, PERSON),
    )


def _machine(machine: MachineShape, rails: Gantry | None) -> Iterator[Shape]:
    """Return its box, its folded arm if there is one, and the mast below rails."""
    color, bottom, top = MACHINES[machine.category], machine.bottom, machine.top
    yield _cube(
        (0.0, 0.0, (bottom + top) / 2), (machine.length, machine.width, top - bottom), color
    )
    low, height = bottom, (bottom + top) / 2
    if rails is not None:
        low, (_, height) = rails.arm_bottom, rails.arm_mount
        mast = rails.rail_height - top
        if mast > 0:
            yield _cube((0.0, 0.0, top + mast / 2), (0.2, 0.2, mast), color)
    if machine.reach > 0:
        faint = (*color[:3], 0.25)
        yield _cylinder((0.0, 0.0, (low + top) / 2), machine.reach, top - low, faint)
        length = max(machine.reach - machine.mount, 0.1)
        yield _arrow((machine.mount, 0.0, height), length, color)
    if rails is None:
        yield _label((0.0, 0.0, top + 0.3), machine.name, color)


def _bridge(gantry: Gantry) -> Shape:
    low, high = gantry.y.low, gantry.y.high
    center = (0.0, (low + high) / 2, gantry.rail_height + 0.1)
    return _cube(center, (0.3, high - low, 0.2), MACHINES["robot"])


def _rails(gantry: Gantry) -> Iterator[Shape]:
    low, high = gantry.x.low, gantry.x.high
    for y in (gantry.y.low, gantry.y.high):
        center = ((low + high) / 2, y, gantry.rail_height + 0.1)
        yield _cube(center, (high - low, 0.15, 0.15), WALL)


def _solid(obstacle: Obstacle) -> Shape:
    """Return an obstacle as a box if it is one, otherwise as the surface of a prism."""
    footprint, bottom, top = obstacle.footprint, obstacle.bottom, obstacle.top
    corners = list(footprint.exterior.coords)
    around = footprint.minimum_rotated_rectangle
    if len(corners) == 5 and math.isclose(around.area, footprint.area, rel_tol=1e-9):
        (ax, ay), (bx, by), (cx, cy) = (corner[:2] for corner in corners[:3])
        center = ((ax + cx) / 2, (ay + cy) / 2, (bottom + top) / 2)
        size = (math.dist((ax, ay), (bx, by)), math.dist((bx, by), (cx, cy)), top - bottom)
        return _cube(center, size, WALL, yaw=math.atan2(by - ay, bx - ax))
    points: list[Point3] = []
    for ring in (footprint.exterior, *footprint.interiors):
        for (ax, ay), (bx, by) in zip(ring.coords[:-1], ring.coords[1:], strict=True):
            a, b, c, d = (ax, ay, bottom), (bx, by, bottom), (bx, by, top), (ax, ay, top)
            points += [a, b, c, a, c, d]
    points += [*_triangles(footprint, top), *_triangles(footprint, bottom)]
    return Shape(kind="triangles", points=tuple(points), size=_AS_IT_IS, color=WALL)


def _triangles(polygon: Polygon, z: float) -> tuple[Point3, ...]:
    parts = shapely.get_parts(shapely.constrained_delaunay_triangles(polygon))
    return tuple((x, y, z) for part in parts for x, y in part.exterior.coords[:3])


def _cube(center: Point3, size: Point3, color: Color, yaw: float = 0.0) -> Shape:
    return Shape(kind="cube", at=center, size=size, color=color, yaw=yaw)


def _cylinder(center: Point3, radius: float, height: float, color: Color) -> Shape:
    size = (2 * radius, 2 * radius, height)
    return Shape(kind="cylinder", at=center, size=size, color=color)


def _arrow(start: Point3, length: float, color: Color) -> Shape:
    return Shape(kind="arrow", at=start, size=(length, 0.12, 0.3), color=color)


def polyline(points: Iterable[Point3], width: float, color: Color) -> Shape:
    """Return lines of a width (m) through points."""
    return Shape(kind="line", points=tuple(points), size=(width, 0.0, 0.0), color=color)


def circle(center: Point, radius: float, width: float, color: Color) -> Shape:
    """Return a circle on the ground, drawn with a width (m)."""
    x, y = center
    return polyline([(x + radius * cx, y + radius * cy, _HAIR) for cx, cy in _CIRCLE], width, color)


def _label(at: Point3, text: str, color: Color) -> Shape:
    return Shape(kind="label", at=at, text=text, size=(0.0, 0.0, 0.3), color=color)
