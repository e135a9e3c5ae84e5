"""The work on kitting orders."""

from __future__ import annotations

from functools import partial

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
            steps = (self._from_agv(agv, quadrant, there), self._onto_agv(agv, quadrant))
            return [self._placing(quadrant, part, agv, steps)]
        found = cell.inventory.take(part, cell.home(agv))
        if found is None:
            self.missing.append(part)
            return []
        bin, slot, item = found
        steps = (self._from_bin(bin, slot, item), self._onto_agv(agv, quadrant))
        cleared = [self._clear(quadrant)] if there is not None else []
        return [*cleared, self._placing(quadrant, part, bin, steps)]

    def _placing(self, quadrant: int, part: Part, origin: str, steps: tuple[Step, ...]) -> Task:
        agv = self._kit.agv
        done = partial(self._cell.inventory.lay, agv, quadrant, Item(part))
        fields = {"part": str(part), "from": origin, "to": agv, "quadrant": quadrant}
        return self._task("pick_place", steps, done, fields, stage=2)

    def _clear(self, quadrant: int) -> Task:
        """Return the task of throwing away the part in a quadrant."""
        agv, cell = self._kit.agv, self._cell
        item = cell.inventory.load(agv).items[quadrant]
        bin = cell.nearest(DISPOSAL_BINS, cell.home(agv))
        steps = (
            Step("pick", cell.handling.pick, place=agv, offset=self._quadrant(agv, quadrant)),
            Step("place", cell.handling.place, place=bin),
        )
        done = partial(cell.inventory.lift, agv, quadrant)
        fields = {"part": str(item.part), "from": agv, "to": bin}
        return self._task("dispose", steps, done, fields, stage=1)
