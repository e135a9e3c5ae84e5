"""Random floors: a hall with walls, machines and columns, AGV lanes, stations, and a gantry."""

import math
from dataclasses import replace

import shapely
from shapely import affinity

from floorplan import (
    Axis,
    Door,
    Floorplan,
    FloorplanError,
    Gantry,
    Human,
    Lane,
    Obstacle,
    SafeZone,
    Station,
    builtin,
    check,
    load,
)
from floorplan.checks import starting_fault
from sim.core.schedule import DoorTimes as DoorTimes

TRIES = 200
"""Number of places that are tried before a floor has no room."""


def random_floor(random):
    """Return a built-in floor or a random hall."""
    if random.random() < 0.5:
        return load(random.choice(builtin()))
    hall = None
    while hall is None:
        hall = _hall(random)
    return hall


def divided_floor(random):
    """Return a hall of two rooms with one or two doors between them, furnished like any hall."""
    plan = None
    while plan is None:
        width, depth = random.uniform(12, 26), random.uniform(6, 14)
        at, thick = width * random.uniform(0.35, 0.65), random.choice([0.1, 0.2, 0.4])
        gaps = [random.uniform(0.8, 2.0) for _ in range(random.choice([1, 1, 2]))]
        room = depth / len(gaps)
        ends = []
        for k, gap in enumerate(gaps):
            low = k * room + random.uniform(0.3, room - gap - 0.3)
            ends.append((low, low + gap))
        doors = tuple(
            Door(name=f"door{k}", ends=((at, low), (at, high)), thickness=thick)
            for k, (low, high) in enumerate(ends)
        )
        sides = [0.0, *(y for pair in ends for y in pair), depth]
        wall = tuple(
            Obstacle(
                name=f"wall.{k}",
                footprint=shapely.box(at - thick / 2, a, at + thick / 2, b),
                bottom=0.0,
                top=2.5,
            )
            for k, (a, b) in enumerate(zip(sides[::2], sides[1::2], strict=True))
        )
        keep = shapely.union_all([door.footprint.buffer(1.0) for door in doors])
        things = tuple(
            one
            for one in _obstacles(random, width, depth)
            if random.random() < 0.4 and not one.footprint.intersects(keep)
        )
        plan = _furnished(random, width, depth, (*wall, *things), doors)
    return plan


def _furnished(random, width, depth, obstacles, doors):
    """Return a hall with stations in both rooms, or None if there is no room for them."""
    boundary = shapely.box(0, 0, width, depth)
    human = Human(
        radius=random.choice([0.2, 0.25, 0.3]),
        height=1.75,
        max_speed=random.uniform(0.6, 1.8),
        max_acceleration=random.uniform(1.0, 4.0),
    )
    gantry = _gantry(random, width, depth) if random.random() < 0.3 else None
    plan = Floorplan(
        name="rooms",
        boundary=boundary,
        obstacles=obstacles,
        doors=doors,
        human=human,
        gantry=gantry,
    )
    for k in range(random.choice([0, 0, 1, 2])):
        plan = _with_lane(random, plan, f"agv{k}")
    x = doors[0].ends[0][0]
    rooms = [shapely.box(0, 0, x, depth), shapely.box(x, 0, width, depth)]
    places = [standing_place(random, plan, within=room) for room in (*rooms, *rooms, rooms[0])]
    if not all(places) or any(
        shapely.Point(places[-1]).distance(door.footprint) < 0.6 for door in doors
    ):
        return None
    zone = SafeZone(places.pop(), 0.0)
    stations = tuple(Station(f"s{k}", place) for k, place in enumerate(places))
    return replace(plan, safe_zone=zone, stations=stations)


def _hall(random):
    """Return a hall, or None if it has no room for people."""
    width, depth = random.uniform(8, 30), random.uniform(6, 20)
    boundary = shapely.box(0, 0, width, depth)
    if random.random() < 0.3:
        corner = shapely.box(width * random.uniform(0.4, 0.8), depth * 0.5, width, depth)
        boundary = boundary.difference(corner)
    plan = Floorplan(
        name="hall",
        boundary=boundary,
        obstacles=tuple(_obstacles(random, width, depth)),
        human=Human(
            radius=random.choice([0.2, 0.25, 0.3]),
            height=random.choice([1.6, 1.75, 1.9]),
            max_speed=random.uniform(0.6, 1.8),
            max_acceleration=random.uniform(1.0, 4.0),
        ),
        gantry=_gantry(random, width, depth) if random.random() < 0.7 else None,
    )
    for k in range(random.choice([0, 1, 1, 2, 3])):
        plan = _with_lane(random, plan, f"agv{k}")
    places = [place for _ in range(5) if (place := standing_place(random, plan))]
    if len(places) < 3:
        return None
    zone = SafeZone(places.pop(), random.uniform(-math.pi, math.pi))
    stations = tuple(Station(f"s{k}", place) for k, place in enumerate(places))
    return replace(plan, safe_zone=zone, stations=stations)


def standing_place(random, plan, radius=None, within=None):
    """Return a starting place within a polygon (the boundary's bounds if None), or None."""
    west, south, east, north = (plan.boundary if within is None else within).bounds
    for _ in range(TRIES):
        at = (random.uniform(west, east), random.uniform(south, north))
        if not starting_fault(plan, at, radius):
            return at
    return None


def _obstacles(random, width, depth):
    for k in range(random.randint(0, 9)):
        x, y = random.uniform(0, width), random.uniform(0, depth)
        kind = random.choice(["box", "box", "turned", "round", "wall", "wall"])
        if kind == "round":
            shape = shapely.Point(x, y).buffer(random.uniform(0.1, 1.0), quad_segs=8)
        elif kind == "wall":  # often from side to side, with or without a door
            thick = random.choice([0.05, 0.1, 0.25])
            length = random.choice([2.0, 5.0, 40.0])
            across = random.random() < 0.5
            shape = shapely.box(x, y, x + (thick if across else length), y + thick)
            if across:
                shape = shapely.box(x, y, x + thick, y + length)
            if random.random() < 0.6:
                door = random.uniform(0.5, 2.0)
                along = random.uniform(0, min(length, depth if across else width))
                gap = (x - 1, y + along, x + 1, y + along + door)
                if not across:
                    gap = (x + along, y - 1, x + along + door, y + 1)
                for part, half in enumerate(shapely.get_parts(shape.difference(shapely.box(*gap)))):
                    yield Obstacle(name=f"wall{k}.{part}", footprint=half, bottom=0.0, top=2.5)
                continue
        else:
            shape = shapely.box(x, y, x + random.uniform(0.3, 4), y + random.uniform(0.3, 4))
            if kind == "turned":
                shape = affinity.rotate(shape, random.uniform(0, 180))
        bottom, top = random.choice([(0.0, 1.0), (0.0, 2.5), (1.5, 3.0), (2.2, 3.0), (0.3, 0.4)])
        yield Obstacle(name=f"{kind}{k}", footprint=shape, bottom=bottom, top=top)


def _with_lane(random, plan, name):
    """Return the plan with one more lane, if one is found that leads through nothing."""
    west, south, east, north = plan.boundary.bounds
    for _ in range(TRIES // 10):
        length = random.uniform(2, 0.8 * (east - west))
        stop = random.uniform(0, length)
        lane = Lane(
            name=name,
            origin=(random.uniform(west, east), random.uniform(south, north)),
            heading=random.choice([0.0, math.pi / 2, math.pi, random.uniform(-3, 3)]),
            limits=(0.0, length),
            locations={"near": 0.0, "between": stop, "far": length},
            start=random.choice(["near", "between", "far"]),
            length=random.uniform(0.6, 2.0),
            width=random.uniform(0.4, 1.0),
            height=random.uniform(0.3, 1.5),
            max_speed=random.uniform(0.5, 2.5),
            max_acceleration=random.uniform(0.5, 3.0),
        )
        ends = shapely.MultiPolygon([lane.footprint(q) for q in lane.limits])
        wider = replace(plan, lanes=(*plan.lanes, lane))
        try:
            check(wider)
        except FloorplanError:
            continue
        if plan.boundary.contains(ends.convex_hull):
            return _with_wall_along(random, wider, lane) if random.random() < 0.5 else wider
    return plan


def _with_wall_along(random, plan, lane):
    """Return the plan with a wall beside the lane, so near that people stand close to both."""
    (x, y), (c, s) = lane.origin, lane.direction
    begin, end = sorted(random.uniform(*lane.limits) for _ in range(2))
    away = lane.width / 2 + random.uniform(0.05, 0.8)
    side = [(x + q * c - away * s, y + q * s + away * c) for q in (begin - 1.0, end + 1.0)]
    wall = shapely.LineString(side).buffer(0.03, cap_style="flat")
    walled = replace(
        plan,
        obstacles=(
            *plan.obstacles,
            Obstacle(name=f"{lane.name}_wall", footprint=wall, bottom=0.0, top=2.5),
        ),
    )
    try:
        check(walled)
    except FloorplanError:
        return plan
    return walled


def _gantry(random, width, depth):
    def axis(low, high):
        return Axis(
            low=low,
            high=high,
            max_speed=random.uniform(0.3, 1.5),
            max_acceleration=random.uniform(0.3, 1.5),
            max_jerk=random.uniform(1, 4),
        )

    x, y = axis(1.0, width - 1.0), axis(1.0, depth - 1.0)
    return Gantry(
        x=x,
        y=y,
        rotation=axis(-2 * math.pi, 2 * math.pi),
        start=(random.uniform(x.low, x.high), random.uniform(y.low, y.high), 0.0),
        torso=(1.0, 0.9, 1.24, 2.71),
        arm_mount=(0.5, 2.0),
        arm_reach=0.9,
        arm_bottom=random.uniform(0.9, 1.8),
        rail_height=2.9,
        tray_height=1.3,
    )
