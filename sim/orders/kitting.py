"""The work on kitting orders."""

from __future__ import annotations

from functools import partial

from ..core.events import PartFaulty
from ..core.workload import Item, KittingTask, Load, Order, Part
from ..machines.gantry.tasks import Step, Task
from .layout import DISPOSAL_BINS
from .scoring import kitting_score
from .work import Cell, Work, when_all_are_done


class KittingWork(Work):
    """Fetch the tray, put the parts on it in any order, and send the AGV off.

    Parts that already lie where they should stay; others that are in the way are thrown away.
    """

    def __init__(self, order: Order, task: KittingTask, cell: Cell) -> None:
        super().__init__(order, cell, (task.agv,))
        self._kit = task
        self._faulty = {*cell.faulty.get(order.id, ())}

    def begin(self) -> list[Task]:
        """See `Work.begin`."""
        kit, cell = self._kit, self._cell
        lane = cell.fleet.lane(kit.agv)
        cell.fleet.send(kit.agv, lane.start)
        load = cell.inventory.load(kit.agv)
        tasks: list[Task] = []
        if load.tray != kit.tray and (slot := cell.inventory.take_tray(kit.tray)) is not None:
            tasks.append(self._fetch_tray(kit.agv, kit.tray, slot))
            load = Load(kit.tray)
        for quadrant, part in kit.products.items():
            tasks += self._fill(quadrant, part, load.items.get(quadrant))
        for quadrant in load.items:
            if quadrant not in kit.products:
                tasks.append(self._clear(quadrant))
        when_all_are_done(tasks, partial(cell.fleet.send, kit.agv, kit.destination))
        return tasks

    def ready(self) -> bool:
        """See `Work.ready`."""
        return self._cell.fleet.is_at(self._kit.agv, self._kit.destination)

    def score(self) -> int:
        """See `Work.score`."""
        return kitting_score(
            self._kit, self._cell.inventory.load(self._kit.agv), arrived=self.ready()
        )

    def hand_over(self) -> None:
        """Take the kit off its AGV, unless it is at an assembly station: there it is needed."""
        lane = self._cell.fleet.lane(self._kit.agv)
        location = lane.serves.get(self._kit.destination, self._kit.destination)
        if location not in lane.serves.values():
            self._cell.inventory.unload(self._kit.agv)

    def _fill(self, quadrant: int, part: Part, there: Item | None) -> list[Task]:
        """Return the tasks that get `part` into a quadrant in which there is `there`."""
        agv, cell = self._kit.agv, self._cell
        if there == Item(part):
            return []
        if there is not None and there.part == part:
            return [self._placing(quadrant, there, agv, self._from_agv(agv, quadrant, there))]
        found = cell.inventory.take(part, cell.home(agv))
        if found is None:
            self.missing.append(part)
            return []
        bin, slot, item = found
        cleared = [self._clear(quadrant)] if there is not None else []
        return [*cleared, self._placing(quadrant, item, bin, self._from_bin(bin, slot, item))]

    def _placing(self, quadrant: int, item: Item, origin: str, pick: Step) -> Task:
        agv, cell = self._kit.agv, self._cell
        put = partial(cell.inventory.lay, agv, quadrant)
        place = self._onto_agv(agv, quadrant)
        carried = self._carried(item, place, put, cell.home(agv))

        def lost() -> tuple[Step, ...]:
            cell.inventory.lift(agv, quadrant)  # if it came from there
            return carried.lost()

        def check() -> tuple[Step, ...]:
            if carried.item is None or not self._is_faulty(quadrant, carried.item):
                return ()
            # What is thrown away is nothing that the gripper was to lose.
            away = self._throwing_away(quadrant, "take_away")
            another = lost()
            task.given_up = not another
            return (*away, *another)

        task = self._task(
            "pick_place",
            (pick, place),
            carried.put_down,
            {"part": str(item.part), "from": origin, "to": agv, "quadrant": quadrant},
            stage=2,
            check=check,
            lost=lost,
        )
        return task

    def _is_faulty(self, quadrant: int, item: Item) -> bool:
        """Return the outcome of the quality check of what was placed, and record a fault."""
        if not (item.faulty or quadrant in self._faulty):
            return False
        self._faulty.discard(quadrant)
        self._cell.found_faulty.append(item.part)
        fields = {"part": str(item.part), "order": self.order.id, "agv": self._kit.agv}
        self._cell.record(PartFaulty(**fields, quadrant=quadrant))
        return True

    def _clear(self, quadrant: int) -> Task:
        """Return the task of throwing away the part in a quadrant."""
        agv, cell = self._kit.agv, self._cell
        item = cell.inventory.load(agv).items[quadrant]
        steps = self._throwing_away(quadrant, "pick")
        done = partial(cell.inventory.lift, agv, quadrant)
        fields = {"part": str(item.part), "from": agv, "to": steps[1].place}
        return self._task("dispose", steps, done, fields, stage=1)

    def _throwing_away(self, quadrant: int, action: str) -> tuple[Step, Step]:
        agv, cell = self._kit.agv, self._cell
        bin = cell.nearest(DISPOSAL_BINS, cell.home(agv))
        return (
            Step(action, cell.handling.pick, place=agv, offset=self._quadrant(agv, quadrant)),
            Step("place", cell.handling.place, place=bin),
        )
