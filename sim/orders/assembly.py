"""The work on assembly orders, and on combined orders, which begin with a kit."""

from __future__ import annotations

from functools import partial

from ..core.workload import AssemblyTask, CombinedTask, Item, Order
from ..machines.gantry.tasks import Step, Task
from .carried import Carried
from .layout import QUADRANTS, assembly_table
from .scoring import assembly_score
from .work import Cell, Work, when_all_are_done


class _AtStation(Work):
    """Common part of assembly and combined orders: parts are inserted at a station."""

    def __init__(
        self, order: Order, task: AssemblyTask | CombinedTask, cell: Cell, agvs: tuple[str, ...]
    ) -> None:
        super().__init__(order, cell, (*agvs, task.station))
        self._assembly = task

    def ready(self) -> bool:
        """See `Work.ready`."""
        return True

    def score(self) -> int:
        """See `Work.score`."""
        inserted = self._cell.inventory.inserted(self._assembly.station)
        return assembly_score(self._assembly, inserted)

    def hand_over(self) -> None:
        """See `Work.hand_over`."""
        self._cell.inventory.hand_over(self._assembly.station)

    def _insert_from_agv(self, agv: str, quadrant: int, item: Item, *, stage: int) -> Task:
        """Take an item from an AGV that has come to the station, and insert it."""
        station, cell = self._assembly.station, self._cell
        carried = self._inserted(item)

        def done() -> None:
            if not task.given_up:
                cell.inventory.lift(agv, quadrant)
                carried.put_down()

        def lost() -> tuple[Step, ...]:
            cell.inventory.lift(agv, quadrant)
            return carried.lost()

        task = self._task(
            "assemble",
            (self._from_agv(agv, quadrant, item), self._inserting()),
            done,
            {"part": str(item.part), "from": agv, "to": station},
            stage=stage,
            ready=partial(cell.fleet.is_at, agv, station),
            lost=lost,
        )
        return task

    def _insert_from_bin(self, bin: str, slot: int, item: Item, *, stage: int) -> Task:
        """Carry an item from its bin to the station, and insert it."""
        carried = self._inserted(item)
        return self._task(
            "assemble",
            (self._from_bin(bin, slot, item), self._inserting()),
            carried.put_down,
            {"part": str(item.part), "from": bin, "to": self._assembly.station},
            stage=stage,
            lost=carried.lost,
        )

    def _inserted(self, item: Item) -> Carried:
        """Return a part on its way to be inserted."""
        station, cell = self._assembly.station, self._cell
        near = cell.place(assembly_table(station))
        return self._carried(
            item, self._inserting(), lambda one: cell.inventory.insert(station, one.part), near
        )

    def _inserting(self) -> Step:
        table = assembly_table(self._assembly.station)
        return Step("insert", self._cell.handling.insert, place=table)


class AssemblyWork(_AtStation):
    """Send the AGVs with the parts to the station, and insert the parts there in any order.

    A part that none of them has is carried over from a bin.
    """

    def __init__(self, order: Order, task: AssemblyTask, cell: Cell) -> None:
        super().__init__(order, task, cell, task.agvs)
        self._agvs = task.agvs

    def begin(self) -> list[Task]:
        """See `Work.begin`."""
        task, cell = self._assembly, self._cell
        on_agvs = {
            (agv, quadrant): item
            for agv in self._agvs
            for quadrant, item in cell.inventory.load(agv).items.items()
        }
        near = cell.place(assembly_table(task.station))
        tasks = []
        for part in task.products:
            place = next((place for place, item in on_agvs.items() if item.part == part), None)
            if place is not None:
                cell.fleet.send(place[0], task.station)
                tasks.append(self._insert_from_agv(*place, on_agvs.pop(place), stage=0))
            elif (found := cell.inventory.take(part, near)) is not None:
                tasks.append(self._insert_from_bin(*found, stage=0))
            else:
                self.missing.append(part)
        return tasks


class CombinedWork(_AtStation):
    """Make a kit on an AGV, send it to the station, and insert the parts there in any order.

    A part for which the AGV has no room is carried over from its bin.
    """

    def __init__(
        self, order: Order, task: CombinedTask, cell: Cell, agv: str, needed_trays: set[int]
    ) -> None:
        super().__init__(order, task, cell, (agv,))
        self._agv = agv
        self._needed_trays = needed_trays

    def begin(self) -> list[Task]:
        """See `Work.begin`."""
        task, cell, agv = self._assembly, self._cell, self._agv
        lane = cell.fleet.lane(agv)
        kit: list[Task] = []
        assembly: list[Task] = []
        load = cell.inventory.load(agv)
        present = dict(load.items)
        free = [quadrant for quadrant in QUADRANTS if quadrant not in present]
        for part in task.products:
            at = next((q for q, item in present.items() if item.part == part), None)
            if at is not None:
                assembly.append(self._insert_from_agv(agv, at, present.pop(at), stage=2))
                continue
            found = cell.inventory.take(part, cell.home(agv))
            if found is None:
                self.missing.append(part)
            elif free:
                quadrant = free.pop(0)
                inserting = self._insert_from_agv(agv, quadrant, Item(part), stage=2)
                kit.append(self._kit(quadrant, *found, inserting))
                assembly.append(inserting)
            else:
                assembly.append(self._insert_from_bin(*found, stage=2))
        if kit and load.tray is None:
            spare = cell.inventory.take_spare_tray(self._needed_trays)
            if spare is not None:
                slot, tray = spare
                kit.insert(0, self._fetch_tray(agv, tray, slot))
        if kit:
            cell.fleet.send(agv, lane.start)
        if assembly:
            when_all_are_done(kit, partial(cell.fleet.send, agv, task.station))
        return kit + assembly

    def _kit(self, quadrant: int, bin: str, slot: int, item: Item, inserting: Task) -> Task:
        """Return the task of placing a part; without the part it is not `inserting` it either."""
        agv, cell = self._agv, self._cell
        place = self._onto_agv(agv, quadrant)
        put = partial(cell.inventory.lay, agv, quadrant)
        carried = self._carried(item, place, put, cell.home(agv))

        def lost() -> tuple[Step, ...]:
            steps = carried.lost()
            if not steps:
                inserting.give_up()
            return steps

        return self._task(
            "pick_place",
            (self._from_bin(bin, slot, item), place),
            carried.put_down,
            {"part": str(item.part), "from": bin, "to": agv, "quadrant": quadrant},
            stage=1,
            lost=lost,
        )
