"""Inventory of the workcell while a trial runs: the places of parts and trays."""

from __future__ import annotations

import math
from collections.abc import Iterable

from floorplan import Floorplan, Point

from ..core.workload import Item, Load, Part, Workload
from .belt import Belt
from .layout import BELT
from .scoring import Inserted


class Inventory:
    """Contents of bins, tray tables, AGVs and assembly stations now.

    What an order will need from a bin or a tray table is taken out of it as soon as the order is
    begun, so that no other order counts on it.
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

    def take(self, part: Part, near: Point) -> tuple[str, int, Item] | None:
        """Take a part out of a bin; return the bin, the slot, and the item.

        The nearest bin is preferred, and before that parts that need not be turned over. Where no
        bin has one, it is a part of the conveyor, and its number; None if there is no such part.
        """
        found = min(
            (
                (item.flipped, math.dist(self._places[name], near), name, slot)
                for name, slots in self._bins.items()
                for slot, item in slots.items()
                if item.part == part
            ),
            default=None,
        )
        if found is None:
            coming = self.belt.take(part)
            return None if coming is None else (BELT, *coming)
        _, _, name, slot = found
        return name, slot, self._bins[name].pop(slot)

    def take_tray(self, tray: int) -> int | None:
        """Take the tray with this id from its table; return its slot, None if there is none."""
        slot = min((slot for slot, one in self._trays.items() if one == tray), default=None)
        if slot is not None:
            del self._trays[slot]
        return slot

    def take_spare_tray(self, needed: Iterable[int]) -> tuple[int, int] | None:
        """Take a tray that is not `needed`; return its slot and id, None if there is none."""
        spare = min(((slot, t) for slot, t in self._trays.items() if t not in needed), default=None)
        if spare is not None:
            del self._trays[spare[0]]
        return spare

    def load(self, agv: str) -> Load:
        """Return the load of an AGV."""
        return self._loads[agv]

    def lay_tray(self, agv: str, tray: int) -> None:
        """Put a tray on an AGV; the load before it is gone with its tray."""
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

    def insert(self, station: str, part: Part) -> None:
        """Insert a part at an assembly station."""
        self._inserted.setdefault(station, {})[part.type] = Inserted(part)

    def inserted(self, station: str) -> dict[str, Inserted]:
        """Return the parts inserted at an assembly station, by type."""
        return self._inserted.get(station, {})

    def hand_over(self, station: str) -> None:
        """Take away the parts inserted at a station, and put an empty insert there."""
        self._inserted.pop(station, None)
