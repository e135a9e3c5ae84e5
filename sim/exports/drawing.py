"""The scene that viewers draw of a run: the floor, and the bodies on it.

Every body has a frame of its own, at its centre on the floor, that turns with it; the gantry on
the rails of the floor has a second one, `NAME/bridge`, which follows its x only.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator

import shapely
from shapely.geometry import Polygon

from floorplan import Gantry, Obstacle, Point

from ..core.machine import Category, MachineShape
from ..core.recorder import Event
from ..core.scene import Figure
from ..machines.kinds import rails_under
from ..record.outcome import Outcome
from .shapes import Color, Point3, Shape, Thing
from .track import Pose, just_before

ROOT_FRAME = "map"
"""The frame of the floor, as ROS calls it (REP 105)."""

GROUND = (0.93, 0.93, 0.91, 1.0)
WALL = (0.62, 0.62, 0.6, 1.0)
MARKING = (0.35, 0.35, 0.35, 1.0)
PERSON = (0.0, 0.45, 0.70, 1.0)
SAFE = (0.0, 0.62, 0.45, 1.0)
MACHINES: dict[Category, Color] = {"robot": (0.90, 0.62, 0.0, 1.0), "vehicle": SAFE}
ALARM = (0.84, 0.37, 0.0, 1.0)
# Hues of M. Okabe and K. Ito, "Color Universal Design", which colour-blind people can tell apart.

ALARM_TIME = 2.0
"""Seconds for which the place of a violation is marked."""

_HAIR = 0.01
"""Metres between what lies on the floor and the floor."""

_CIRCLE = tuple((math.cos(k * math.pi / 24), math.sin(k * math.pi / 24)) for k in range(49))

_AS_IT_IS = (1.0, 1.0, 1.0)


def frame(body: str, part: str = "base") -> str:
    """Return the frame that moves with a body, or with a part of it."""
    return f"{body}/{part}"


def floor(run: Outcome) -> list[Thing]:
    """Return everything that stays where it is."""
    plan = run.floorplan
    ground = Shape(
        kind="triangles", points=_triangles(plan.boundary, -_HAIR), size=_AS_IT_IS, color=GROUND
    )
    outline = _line([(*at[:2], 0.0) for at in plan.boundary.exterior.coords], 0.05, MARKING)
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
        things.append(Thing("safe zone", ROOT_FRAME, (_circle((x, y), 1.0, 0.05, SAFE), words)))
    courses = {lane.name: tuple(map(lane.position, lane.limits)) for lane in plan.lanes}
    courses |= {machine.name: machine.course for machine in run.scene.machines if machine.course}
    for name, course in courses.items():
        line = _line([(*at, _HAIR) for at in course], 0.03, MACHINES["vehicle"])
        things.append(Thing(f"lane {name}", ROOT_FRAME, (line,)))
    if plan.gantry is not None:
        things.append(Thing("gantry rails", ROOT_FRAME, tuple(_rails(plan.gantry))))
    return things


def bodies(run: Outcome) -> list[Thing]:
    """Return everything that moves, each thing in the frame that moves it."""
    things = [
        Thing(person.name, frame(person.name), _person(person)) for person in run.scene.people
    ]
    for machine in run.scene.machines:
        name, rails = machine.name, rails_under(machine.name, run.floorplan)
        things.append(Thing(name, frame(name), tuple(_machine(machine, rails))))
        if rails is not None:
            things.append(Thing(f"{name} bridge", frame(name, "bridge"), (_bridge(rails),)))
    return things


def frames(run: Outcome, poses: Iterable[Pose]) -> Iterator[tuple[str, float, float, float]]:
    """Return the frames that move with these bodies: name, x, y, rotation."""
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
            _circle((x, y), 2 * figure.radius, 0.06, ALARM),
            _line([(x, y, height), (*end, height)], 0.04, ALARM),
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
    """Its box; its folded arm, where it has one; and the mast by which it hangs from rails."""
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
    """An obstacle as a box where it is one, else as the surface of a prism."""
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


def _line(points: Iterable[Point3], width: float, color: Color) -> Shape:
    return Shape(kind="line", points=tuple(points), size=(width, 0.0, 0.0), color=color)


def _circle(center: Point, radius: float, width: float, color: Color) -> Shape:
    x, y = center
    return _line([(x + radius * cx, y + radius * cy, _HAIR) for cx, cy in _CIRCLE], width, color)


def _label(at: Point3, text: str, color: Color) -> Shape:
    return Shape(kind="label", at=at, text=text, size=(0.0, 0.0, 0.3), color=color)
