"""Layout of the floor of an ARIAC trial, and positions of parts: bins, trays, AGVs, conveyor.

The numbers are those of the competition's `environment_startup.py`, `object_poses.yaml` and
`agv_macro.xacro` (2023), as offsets (m) from the centre of the obstacle.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator
from functools import partial
from typing import NamedTuple

from floorplan import Floorplan, Lane, Point
from floorplan.files.dataclass import dataclass
from navigation import Motion
from navigation.motion import Piece

from ..core.events import PartCame, PartMissed, PartTaken
from ..core.stage import Stage
from ..machines.agv.agv import Agv
from ..machines.tasks import Passing, Step
from .scoring import Inserted
from .workload import Conveyor, Item, Load, PartType, Workload

Offset = tuple[float, float]

BIN_SLOTS = range(1, 10)
TRAY_SLOTS = range(1, 7)
QUADRANTS = range(1, 5)

TABLES = ("kit_tray_table1", "kit_tray_table2")
"""Obstacles of the tray tables, with tray slots 1 to 3 and 4 to 6."""

DISPOSAL_BINS = ("disposal_bin1", "disposal_bin2", "disposal_bin3")
"""Obstacles for parts that nobody needs."""

BELT = "conveyor"
"""Obstacle of the conveyor."""

BELT_SPEED = 0.2
"""m/s. `max_velocity` of the competition's model of the conveyor belt."""

BELT_REACH = 0.14
"""Metres. Maximum distance of a part from the middle of the belt."""

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
    """Return the obstacle of the table of an assembly station: as1 has assembly_table1."""
    return station.replace("as", "assembly_table", 1)


def bin_slot(slot: int) -> Offset:
    """Return the position of a bin's slot: 1 to 9 in rows of three, from its (-x, -y) corner."""
    row, column = divmod(slot - 1, 3)
    return (_SLOT_PITCH * (row - 1), _SLOT_PITCH * (column - 1))


def tray_slot(slot: int) -> tuple[str, Offset]:
    """Return the table of a tray slot, and the slot's position on it."""
    table, k = divmod(slot - 1, 3)
    facing = _facing(TABLES[table])
    return TABLES[table], (facing * _TRAY_PITCH * (k - 1), facing * _TRAY_BEHIND)


def tool_stand(table: str, tool: str) -> Offset:
    """Return the position at a tray table of the gripper for "parts" or "trays"."""
    facing = _facing(table)
    aside = _STAND_ASIDE if tool == "trays" else -_STAND_ASIDE
    return (facing * aside, -facing * _STAND_AHEAD)


def tray_on(lane: Lane) -> Offset:
    """Return the position of the tray on the AGV of `lane`."""
    return _turned(lane, _TRAY_ON_AGV, 0.0)


def quadrant_on(lane: Lane, quadrant: int) -> Offset:
    """Return the position of a quadrant of the tray on the AGV of `lane`."""
    along = _QUADRANT_ALONG if quadrant <= 2 else -_QUADRANT_ALONG
    across = _QUADRANT_ACROSS if quadrant % 2 else -_QUADRANT_ACROSS
    return _turned(lane, _TRAY_ON_AGV + along, across)


def belt_ends(plan: Floorplan) -> tuple[Offset, Offset]:
    """Return the begin and end of the middle of the belt (x, y)."""
    footprint = plan.obstacle(BELT).footprint
    x = footprint.centroid.x + _BELT_MIDDLE
    return (x, footprint.centroid.y + _BELT_BEGINS), (x, footprint.bounds[1])


def lacking(plan: Floorplan, *, belt: bool = False) -> list[str]:
    """Return the names of obstacles of the ARIAC workcell that a floor lacks.

    The conveyor is required if the `belt` brings parts.
    """
    names = {obstacle.name for obstacle in plan.obstacles}
    stations = {station for lane in plan.lanes for station in lane.serves}
    needed = [*TABLES, *DISPOSAL_BINS, *sorted(assembly_table(station) for station in stations)]
    needed += [BELT] * belt
    return [name for name in needed if name not in names]


def errands(
    plan: Floorplan, bins: Iterable[str], *, belt: bool = False
) -> Iterator[tuple[str, Offset]]:
    """Yield the targets of the gantry for parts in these bins: obstacles and offsets.

    If the `belt` brings parts, they include those along the conveyor.
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
    """Return the orientation of a table. The first one is rotated by half a turn."""
    return -1 if table == TABLES[0] else 1


def _turned(lane: Lane, along: float, across: float) -> Offset:
    c, s = lane.direction
    return (along * c - across * s, along * s + across * c)


@dataclass(eq=False)
class _Conveyed:
    number: int
    item: Item
    passing: Passing
    promised: bool = False
    is_gone: bool = False


class Belt:
    """Parts on the conveyor, whose positions follow from their start times.

    Parts are promised to orders, possibly before they arrive. `missed(passing)` is called for parts
    that fall off.
    """

    def __init__(
        self, stage: Stage, conveyor: Conveyor, seed: int, missed: Callable[[Passing], None]
    ) -> None:
        self._stage = stage
        self._missed = missed
        self.parts_missed = 0
        self._parts = [
            _Conveyed(number, item, Passing(track, partial(self._taken, number)))
            for number, (time, item, across) in enumerate(conveyor.coming(seed))
            for track in [track_of(stage.floorplan, time, across)]
        ]

    def begin(self, came: Callable[[], None]) -> None:
        """Schedule the arrival of each part. `came()` is called at each."""
        for one in self._parts:
            self._stage.clock.call_at(one.passing.track.start, partial(self._came, one, came))
            self._stage.clock.call_at(one.passing.track.end, partial(self._fall, one))

    def take(self, part: PartType) -> tuple[int, Item] | None:
        """Promise the next suitable part, present or future. Return its number and the item."""
        for one in self._parts:
            if one.item.part == part and not (one.promised or one.is_gone):
                one.promised = True
                return one.number, one.item
        return None

    def step(self, number: int, seconds: float) -> Step:
        """Return the step that picks a part from the belt."""
        return Step("pick", seconds=seconds, place=BELT, passing=self._parts[number].passing)

    def has_come(self, passing: Passing) -> bool:
        """Return True if a part has arrived."""
        return passing.track.start <= self._stage.clock.now

    def _came(self, one: _Conveyed, came: Callable[[], None]) -> None:
        track = one.passing.track
        at, to = (track.state(t).at for t in (track.start, track.end))
        part = str(one.item.part)
        self._stage.record(PartCame(part=part, number=one.number, at=at, to=to, falls=track.end))
        came()

    def _taken(self, number: int) -> None:
        one = self._parts[number]
        one.is_gone = True
        at = one.passing.track.state(self._stage.clock.now).at
        self._stage.record(PartTaken(part=str(one.item.part), number=number, at=at))

    def _fall(self, one: _Conveyed) -> None:
        if not one.is_gone:
            one.is_gone = True
            self.parts_missed += 1
            at = one.passing.track.state(self._stage.clock.now).at
            self._stage.record(PartMissed(part=str(one.item.part), number=one.number, at=at))
            self._missed(one.passing)


def track_of(plan: Floorplan, time: float, across: float) -> Motion:
    """Return the motion of a part from `time` (s), `across` metres from the middle."""
    (x, begin), (_, end) = belt_ends(plan)
    seconds = (begin - end) / BELT_SPEED
    x_of, y_of = (x + across, 0.0, 0.0, 0.0), (begin, -BELT_SPEED, 0.0, 0.0)
    return Motion((Piece(time, time + seconds, x_of, y_of, (0.0, 0.0, 0.0, 0.0)),))


class TakenItem(NamedTuple):
    """Item that was taken from the slot of a bin, or with its number from the conveyor."""

    bin: str
    slot: int
    item: Item


class Inventory:
    """Current contents of bins, tray tables, AGVs and assembly stations.

    The parts and trays of an order are removed when it begins, so that no other order counts on
    them.
    """

    def __init__(self, workload: Workload, plan: Floorplan, belt: Belt) -> None:
        self.belt = belt
        self._bins = {name: dict(slots) for name, slots in workload.bins.items()}
        self._trays = dict(workload.trays)
        self._loads = {lane.name: workload.loads.get(lane.name, Load()) for lane in plan.lanes}
        self._inserted: dict[str, dict[str, Inserted]] = {}
        self._places = {
            name: (footprint.x, footprint.y)
            for name in self._bins
            for footprint in [plan.obstacle(name).footprint.centroid]
        }

    def take(self, part: PartType, near: Point) -> TakenItem | None:
        """Take a part out of a bin.

        Parts that need not be turned over are preferred, then the nearest bin. If no bin has one,
        the conveyor and the part's number are returned instead, or None if there is no such part.
        """
        nearest = min(
            (
                (item.flipped, math.dist(self._places[name], near), name, slot)
                for name, slots in self._bins.items()
                for slot, item in slots.items()
                if item.part == part
            ),
            default=None,
        )
        if nearest is None:
            coming = self.belt.take(part)
            return None if coming is None else TakenItem(BELT, *coming)
        _, _, name, slot = nearest
        return TakenItem(name, slot, self._bins[name].pop(slot))

    def take_tray(self, tray: int) -> int | None:
        """Take the tray with this id from its table. Return its slot, or None if there is none."""
        slot = min((slot for slot, one in self._trays.items() if one == tray), default=None)
        if slot is not None:
            del self._trays[slot]
        return slot

    def take_spare_tray(self, needed: Iterable[int]) -> tuple[int, int] | None:
        """Take a tray that is not `needed`. Return its slot and id, or None if there is none."""
        spare = min(((slot, t) for slot, t in self._trays.items() if t not in needed), default=None)
        if spare is not None:
            del self._trays[spare[0]]
        return spare

    def load(self, agv: str) -> Load:
        """Return the load of an AGV."""
        return self._loads[agv]

    def lay_tray(self, agv: str, tray: int) -> None:
        """Put a tray on an AGV in place of its load."""
        self._loads[agv] = Load(tray)

    def lay(self, agv: str, quadrant: int, item: Item) -> None:
        """Put an item on an AGV."""
        load = self._loads[agv]
        self._loads[agv] = Load(load.tray, {**load.items, quadrant: item})

    def lift(self, agv: str, quadrant: int) -> None:
        """Take the item of a quadrant off an AGV."""
        load = self._loads[agv]
        left = {q: item for q, item in load.items.items() if q != quadrant}
        self._loads[agv] = Load(load.tray, left)

    def unload(self, agv: str) -> None:
        """Take tray and items off an AGV."""
        self._loads[agv] = Load()

    def insert(self, station: str, part: PartType) -> None:
        """Insert a part at an assembly station."""
        self._inserted.setdefault(station, {})[part.type] = Inserted(part)

    def inserted(self, station: str) -> dict[str, Inserted]:
        """Return the parts inserted at an assembly station, by type."""
        return self._inserted.get(station, {})

    def hand_over(self, station: str) -> None:
        """Remove the parts inserted at a station, and put an empty insert there."""
        self._inserted.pop(station, None)


TOLERANCE = 1e-6
"""Metres. Maximum distance of an AGV from a location that it has reached."""


class Fleet:
    """Sends AGVs to the locations of orders, and keeps them there."""

    def __init__(self, agvs: Iterable[Agv]) -> None:
        self._agvs = {agv.lane.name: agv for agv in agvs}
        self._sent: dict[str, str] = {}

    def lane(self, name: str) -> Lane:
        """Return the lane of an AGV."""
        return self._agvs[name].lane

    def serving(self, station: str) -> list[str]:
        """Return the AGVs that can go to an assembly station."""
        return [name for name, agv in self._agvs.items() if station in agv.lane.serves]

    def send(self, name: str, location: str) -> None:
        """Send an AGV to a location, to which it returns after any other move."""
        under_way = self._sent.get(name) == location and not self._agvs[name].stands
        self._sent[name] = location
        if not under_way and not self.is_at(name, location):
            self._agvs[name].drive(location)

    def release(self, name: str) -> None:
        """Release an AGV from its location."""
        self._sent.pop(name, None)

    def is_at(self, name: str, location: str) -> bool:
        """Return True if an AGV has stopped at a location."""
        agv = self._agvs[name]
        off = agv.lane_position - agv.lane.lane_position(location)
        return agv.stands and abs(off) < TOLERANCE

    def stopped(self, agv: Agv) -> None:
        """Send an AGV that has come to rest back to its location, if it has one."""
        name = agv.lane.name
        if name in self._sent:
            self.send(name, self._sent[name])
