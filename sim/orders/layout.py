"""Places of slots, trays, quadrants and tool stands in the ARIAC workcell.

The figures are those of the competition's own `environment_startup.py`, `object_poses.yaml` and
`agv_macro.xacro` (2023), as offsets in metres from the middle of the thing they belong to.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator

from floorplan import Floorplan, Lane

Offset = tuple[float, float]

BIN_SLOTS = range(1, 10)
TRAY_SLOTS = range(1, 7)
QUADRANTS = range(1, 5)

TABLES = ("kit_tray_table1", "kit_tray_table2")
"""The obstacles that are the tray tables, with tray slots 1 to 3 and 4 to 6."""

DISPOSAL_BINS = ("disposal_bin1", "disposal_bin2", "disposal_bin3")
"""The obstacles into which parts are thrown that nobody needs."""

BELT = "conveyor"
"""The obstacle that is the conveyor."""

BELT_SPEED = 0.2
"""m/s, as in the `max_velocity` of the competition's model of the conveyor belt."""

BELT_REACH = 0.14
"""Metres. The farthest that a part lies from the middle of the belt."""

_BELT_MIDDLE = -0.055
_BELT_BEGINS = 4.005

_SLOT_PITCH = 0.18
_TRAY_PITCH = 0.43
_TRAY_BEHIND = 0.11
_STAND_ASIDE = 0.2
_STAND_AHEAD = 0.35
_TRAY_ON_AGV = -0.2
_QUADRANT_ALONG = 0.1275
_QUADRANT_ACROSS = 0.0925


def assembly_table(station: str) -> str:
    """Return the obstacle that is the table of an assembly station: as1 has assembly_table1."""
    return station.replace("as", "assembly_table", 1)


def bin_slot(slot: int) -> Offset:
    """Return the place of a bin's slot: 1 to 9 in rows of three, from its (-x, -y) corner."""
    row, column = divmod(slot - 1, 3)
    return (_SLOT_PITCH * (row - 1), _SLOT_PITCH * (column - 1))


def tray_slot(slot: int) -> tuple[str, Offset]:
    """Return the table on which a tray slot is, and the slot's place on it."""
    table, k = divmod(slot - 1, 3)
    facing = _facing(TABLES[table])
    return TABLES[table], (facing * _TRAY_PITCH * (k - 1), facing * _TRAY_BEHIND)


def tool_stand(table: str, tool: str) -> Offset:
    """Return the place at a tray table where the gripper for "parts" or "trays" is taken up."""
    facing = _facing(table)
    aside = _STAND_ASIDE if tool == "trays" else -_STAND_ASIDE
    return (facing * aside, -facing * _STAND_AHEAD)


def tray_on(lane: Lane) -> Offset:
    """Return the place of the tray on the AGV of `lane`."""
    return _turned(lane, _TRAY_ON_AGV, 0.0)


def quadrant_on(lane: Lane, quadrant: int) -> Offset:
    """Return the place of a quadrant of the tray on the AGV of `lane`."""
    along = _QUADRANT_ALONG if quadrant <= 2 else -_QUADRANT_ALONG
    across = _QUADRANT_ACROSS if quadrant % 2 else -_QUADRANT_ACROSS
    return _turned(lane, _TRAY_ON_AGV + along, across)


def belt_ends(plan: Floorplan) -> tuple[Offset, Offset]:
    """Return where parts are put on the middle of the belt, and where they fall off (x, y)."""
    footprint = plan.obstacle(BELT).footprint
    x = footprint.centroid.x + _BELT_MIDDLE
    return (x, footprint.centroid.y + _BELT_BEGINS), (x, footprint.bounds[1])


def lacking(plan: Floorplan, *, belt: bool = False) -> list[str]:
    """Return the names of the obstacles that a floor lacks to be like the ARIAC workcell.

    The conveyor counts if the `belt` brings parts.
    """
    names = {obstacle.name for obstacle in plan.obstacles}
    stations = {station for lane in plan.lanes for station in lane.serves}
    needed = [*TABLES, *DISPOSAL_BINS, *sorted(assembly_table(station) for station in stations)]
    needed += [BELT] * belt
    return [name for name in needed if name not in names]


def errands(
    plan: Floorplan, bins: Iterable[str], *, belt: bool = False
) -> Iterator[tuple[str, Offset]]:
    """Yield the places to which parts in these bins may send the gantry: obstacles, offsets.

    And those along the conveyor, if the `belt` brings parts.
    """
    if belt and any(obstacle.name == BELT for obstacle in plan.obstacles):
        middle = plan.obstacle(BELT).footprint.centroid
        for x, y in belt_ends(plan):
            for across in (-BELT_REACH, BELT_REACH):
                yield BELT, (x + across - middle.x, y - middle.y)
    for name in bins:
        yield from ((name, bin_slot(slot)) for slot in BIN_SLOTS)
    yield from map(tray_slot, TRAY_SLOTS)
    for table in TABLES:
        yield from ((table, tool_stand(table, tool)) for tool in ("parts", "trays"))
    stations = {station for lane in plan.lanes for station in lane.serves}
    tables = sorted(assembly_table(station) for station in stations)
    yield from ((name, (0.0, 0.0)) for name in (*DISPOSAL_BINS, *tables))


def _facing(table: str) -> int:
    """The first table is turned by half a turn against the second, whose axes are the floor's."""
    return -1 if table == TABLES[0] else 1


def _turned(lane: Lane, along: float, across: float) -> Offset:
    c, s = lane.direction
    return (along * c - across * s, along * s + across * c)
