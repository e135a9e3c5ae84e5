"""Work on kitting, assembly and combined orders as tasks of the gantry."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterable, Mapping
from dataclasses import field
from functools import partial
from typing import Any

from floorplan import Floorplan, Point
from floorplan.files.dataclass import dataclass

from ..core.events import PartFaulty
from ..core.recorder import Record
from ..machines.gantry.tasks import Handling
from ..machines.tasks import Step, Task
from .inventory import (
    BELT,
    DISPOSAL_BINS,
    QUADRANTS,
    TABLES,
    Fleet,
    Inventory,
    Offset,
    TakenItem,
    assembly_table,
    bin_slot,
    quadrant_on,
    tool_stand,
    tray_on,
    tray_slot,
)
from .scoring import assembly_score, kitting_score
from .workload import AssemblyTask, CombinedTask, Item, KittingTask, Load, Order, PartType

Found = tuple[Item, Step]
"""A part, and the step that picks it."""


class Carried:
    """A part that the gantry carries for an order, replaced by another if it is lost.

    The `last` step puts it in its place, and `put` records that. `another()` returns the next part.
    If there is none, the part is added to the `missing` ones.
    """

    def __init__(
        self,
        item: Item,
        last: Step,
        put: Callable[[Item], None],
        *,
        another: Callable[[], Found | None],
        missing: list[PartType],
    ) -> None:
        self.item: Item | None = item
        self._part = item.part
        self._last = last
        self._put = put
        self._another = another
        self._missing = missing

    def put_down(self) -> None:
        """Record that the part is in its place, unless it was given up."""
        if self.item is not None:
            self._put(Item(self.item.part, faulty=self.item.faulty))  # turned over if necessary

    def lost(self) -> tuple[Step, ...]:
        """Return the steps that bring another part, none if there is none."""
        another = self._another()
        if another is None:
            self.item = None
            self._missing.append(self._part)
            return ()
        self.item, pick = another
        return (pick, self._last)


Action = Callable[[], None]


@dataclass(frozen=True, kw_only=True)
class Shop:
    """Workshop of orders: the floor, its inventory, the AGVs, and handling times.

    `faulty` contains the quadrants of kits in which the first part is faulty, by order.
    `found_faulty` contains the parts that were rejected.
    """

    plan: Floorplan
    inventory: Inventory
    fleet: Fleet
    handling: Handling
    record: Record
    faulty: Mapping[str, frozenset[int]] = field(default_factory=dict)
    found_faulty: list[PartType] = field(default_factory=list)

    def place(self, obstacle: str) -> Point:
        """Return the centre of an obstacle (m)."""
        middle = self.plan.obstacle(obstacle).footprint.centroid
        return (middle.x, middle.y)

    def home(self, agv: str) -> Point:
        """Return the position of kitting on an AGV (m)."""
        lane = self.fleet.lane(agv)
        return lane.position(lane.locations[lane.start])

    def nearest(self, obstacles: Iterable[str], point: Point) -> str:
        """Return the obstacle whose centre is nearest to a point."""
        return min(obstacles, key=lambda name: math.dist(self.place(name), point))


class Work(ABC):
    """The work on one order.

    Until it is submitted, no other order may begin that needs the AGVs and stations that it
    `holds`. `missing` are the parts that it lacks.
    """

    def __init__(self, order: Order, shop: Shop, holds: tuple[str, ...]) -> None:
        self.order = order
        self.holds = holds
        self.missing: list[PartType] = []
        self._shop = shop

    @abstractmethod
    def begin(self) -> list[Task]:
        """Send the AGVs. Return the gantry's tasks before the order is submitted."""

    @abstractmethod
    def ready(self) -> bool:
        """Return True if everything is in its place for submission."""

    @abstractmethod
    def score(self) -> int:
        """Return the current points for the order."""

    @abstractmethod
    def hand_over(self) -> None:
        """Remove the kit or assembly of a submitted order."""

    def _task(
        self,
        kind: str,
        steps: tuple[Step, ...],
        done: Action,
        fields: Mapping[str, Any],
        *,
        stage: int = 0,
        ready: Callable[[], bool] = lambda: True,
        check: Callable[[], tuple[Step, ...]] = lambda: (),
        lost: Callable[[], tuple[Step, ...]] = lambda: (),
    ) -> Task:
        fields = {**fields, "order": self.order.id}
        if (passing := steps[0].passing) is not None:
            ready = partial(self._shop.inventory.belt.has_come, passing)
        return Task(
            kind,
            steps,
            stage=stage,
            fields=fields,
            ready=ready,
            done=done,
            check=check,
            lost=lost,
        )

    def _carried(self, item: Item, last: Step, put: Callable[[Item], None], near: Point) -> Carried:
        """Return a part on its way. Replacements are taken from bins near `near`."""

        def another() -> Found | None:
            source = self._shop.inventory.take(item.part, near)
            return None if source is None else (source.item, self._from_bin(source))

        return Carried(item, last, put, another=another, missing=self.missing)

    def _from_bin(self, source: TakenItem) -> Step:
        """Return the step that picks an item from its bin or from the conveyor."""
        seconds = self._picking(source.item)
        if source.bin == BELT:
            return self._shop.inventory.belt.step(source.slot, seconds)
        return Step("pick", seconds=seconds, place=source.bin, offset=bin_slot(source.slot))

    def _from_agv(self, agv: str, quadrant: int, item: Item) -> Step:
        return Step(
            "pick", seconds=self._picking(item), place=agv, offset=self._quadrant(agv, quadrant)
        )

    def _onto_agv(self, agv: str, quadrant: int) -> Step:
        return Step(
            "place",
            seconds=self._shop.handling.place,
            place=agv,
            offset=self._quadrant(agv, quadrant),
        )

    def _quadrant(self, agv: str, quadrant: int) -> Offset:
        return quadrant_on(self._shop.fleet.lane(agv), quadrant)

    def _picking(self, item: Item) -> float:
        handling = self._shop.handling
        return handling.pick + (handling.turn_over if item.flipped else 0.0)

    def _fetch_tray(self, agv: str, tray: int, slot: int) -> Task:
        """Change the gripper, put the tray on the AGV, and change the gripper back."""
        handling, lane = self._shop.handling, self._shop.fleet.lane(agv)
        table, at = tray_slot(slot)
        nearest = self._shop.nearest(TABLES, self._shop.home(agv))
        steps = (
            _change_tool(table, "trays", handling),
            Step("pick_tray", seconds=handling.pick_tray, place=table, offset=at),
            Step("place_tray", seconds=handling.place_tray, place=agv, offset=tray_on(lane)),
            _change_tool(nearest, "parts", handling),
        )
        done = partial(self._shop.inventory.lay_tray, agv, tray)
        return self._task("tray", steps, done, {"tray": tray, "from": table, "to": agv})


def _change_tool(table: str, tool: str, handling: Handling) -> Step:
    return Step(
        "change_tool",
        seconds=handling.change_tool,
        place=table,
        offset=tool_stand(table, tool),
    )


def when_all_are_done(tasks: list[Task], action: Action) -> None:
    """Call `action` after the last of `tasks` is done, immediately if there are none."""
    left = len(tasks)

    def count(done: Action) -> None:
        nonlocal left
        done()
        left -= 1
        if left == 0:
            action()

    for task in tasks:
        task.done = partial(count, task.done)
    if not tasks:
        action()


class KittingWork(Work):
    """Fetches the tray, puts the parts on it in any order, and sends the AGV off.

    Parts that are already in their places stay. Others that are in the way are thrown away.
    """

    def __init__(self, order: Order, task: KittingTask, shop: Shop) -> None:
        super().__init__(order, shop, (task.agv,))
        self._kit = task
        self._faulty = {*shop.faulty.get(order.id, ())}

    def begin(self) -> list[Task]:
        """See `Work.begin`."""
        kit, shop = self._kit, self._shop
        lane = shop.fleet.lane(kit.agv)
        shop.fleet.send(kit.agv, lane.start)
        load = shop.inventory.load(kit.agv)
        tasks: list[Task] = []
        if load.tray != kit.tray and (slot := shop.inventory.take_tray(kit.tray)) is not None:
            tasks.append(self._fetch_tray(kit.agv, kit.tray, slot))
            load = Load(kit.tray)
        for quadrant, part in kit.products.items():
            tasks += self._fill(quadrant, part, load.items.get(quadrant))
        for quadrant in load.items:
            if quadrant not in kit.products:
                tasks.append(self._clear(quadrant))
        when_all_are_done(tasks, partial(shop.fleet.send, kit.agv, kit.destination))
        return tasks

    def ready(self) -> bool:
        """See `Work.ready`."""
        return self._shop.fleet.is_at(self._kit.agv, self._kit.destination)

    def score(self) -> int:
        """See `Work.score`."""
        return kitting_score(
            self._kit, self._shop.inventory.load(self._kit.agv), arrived=self.ready()
        )

    def hand_over(self) -> None:
        """Take the kit off its AGV, unless an assembly station needs it."""
        lane = self._shop.fleet.lane(self._kit.agv)
        location = lane.serves.get(self._kit.destination, self._kit.destination)
        if location not in lane.serves.values():
            self._shop.inventory.unload(self._kit.agv)

    def _fill(self, quadrant: int, part: PartType, there: Item | None) -> list[Task]:
        """Return the tasks that put `part` into a quadrant that contains `there`."""
        agv, shop = self._kit.agv, self._shop
        if there == Item(part):
            return []
        if there is not None and there.part == part:
            return [self._placing(quadrant, there, agv, self._from_agv(agv, quadrant, there))]
        source = shop.inventory.take(part, shop.home(agv))
        if source is None:
            self.missing.append(part)
            return []
        cleared = [self._clear(quadrant)] if there is not None else []
        pick = self._from_bin(source)
        return [*cleared, self._placing(quadrant, source.item, source.bin, pick)]

    def _placing(self, quadrant: int, item: Item, origin: str, pick: Step) -> Task:
        agv, shop = self._kit.agv, self._shop
        put = partial(shop.inventory.lay, agv, quadrant)
        place = self._onto_agv(agv, quadrant)
        carried = self._carried(item, place, put, shop.home(agv))

        def lost() -> tuple[Step, ...]:
            shop.inventory.lift(agv, quadrant)  # if it came from there
            return carried.lost()

        def check() -> tuple[Step, ...]:
            if carried.item is None or not self._is_faulty(quadrant, carried.item):
                return ()
            # Drops of the trial do not concern parts that are thrown away.
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
        """Return the outcome of the quality check of a placed part, and record a fault."""
        if not (item.faulty or quadrant in self._faulty):
            return False
        self._faulty.discard(quadrant)
        self._shop.found_faulty.append(item.part)
        fields = {"part": str(item.part), "order": self.order.id, "agv": self._kit.agv}
        self._shop.record(PartFaulty(**fields, quadrant=quadrant))
        return True

    def _clear(self, quadrant: int) -> Task:
        """Return the task that throws away the part in a quadrant."""
        agv, shop = self._kit.agv, self._shop
        item = shop.inventory.load(agv).items[quadrant]
        steps = self._throwing_away(quadrant, "pick")
        done = partial(shop.inventory.lift, agv, quadrant)
        fields = {"part": str(item.part), "from": agv, "to": steps[1].place}
        return self._task("dispose", steps, done, fields, stage=1)

    def _throwing_away(self, quadrant: int, action: str) -> tuple[Step, Step]:
        agv, shop = self._kit.agv, self._shop
        bin = shop.nearest(DISPOSAL_BINS, shop.home(agv))
        return (
            Step(
                action, seconds=shop.handling.pick, place=agv, offset=self._quadrant(agv, quadrant)
            ),
            Step("place", seconds=shop.handling.place, place=bin),
        )


class _AtStation(Work):
    """Base of assembly and combined orders, whose parts are inserted at a station."""

    def __init__(
        self, order: Order, task: AssemblyTask | CombinedTask, shop: Shop, agvs: tuple[str, ...]
    ) -> None:
        super().__init__(order, shop, (*agvs, task.station))
        self._assembly = task

    def ready(self) -> bool:
        """See `Work.ready`."""
        return True

    def score(self) -> int:
        """See `Work.score`."""
        inserted = self._shop.inventory.inserted(self._assembly.station)
        return assembly_score(self._assembly, inserted)

    def hand_over(self) -> None:
        """See `Work.hand_over`."""
        self._shop.inventory.hand_over(self._assembly.station)

    def _insert_from_agv(self, agv: str, quadrant: int, item: Item, *, stage: int) -> Task:
        """Take an item from an AGV at the station, and insert it."""
        station, shop = self._assembly.station, self._shop
        carried = self._inserted(item)

        def done() -> None:
            if not task.given_up:
                shop.inventory.lift(agv, quadrant)
                carried.put_down()

        def lost() -> tuple[Step, ...]:
            shop.inventory.lift(agv, quadrant)
            return carried.lost()

        task = self._task(
            "assemble",
            (self._from_agv(agv, quadrant, item), self._inserting()),
            done,
            {"part": str(item.part), "from": agv, "to": station},
            stage=stage,
            ready=partial(shop.fleet.is_at, agv, station),
            lost=lost,
        )
        return task

    def _insert_from_bin(self, source: TakenItem, *, stage: int) -> Task:
        """Carry an item from its bin to the station, and insert it."""
        carried = self._inserted(source.item)
        return self._task(
            "assemble",
            (self._from_bin(source), self._inserting()),
            carried.put_down,
            {"part": str(source.item.part), "from": source.bin, "to": self._assembly.station},
            stage=stage,
            lost=carried.lost,
        )

    def _inserted(self, item: Item) -> Carried:
        """Return a part on its way to be inserted."""
        station, shop = self._assembly.station, self._shop
        near = shop.place(assembly_table(station))
        return self._carried(
            item, self._inserting(), lambda one: shop.inventory.insert(station, one.part), near
        )

    def _inserting(self) -> Step:
        table = assembly_table(self._assembly.station)
        return Step("insert", seconds=self._shop.handling.insert, place=table)


class AssemblyWork(_AtStation):
    """Sends the AGVs with the parts to the station, and inserts the parts in any order.

    Parts that no AGV has are carried over from bins.
    """

    def __init__(self, order: Order, task: AssemblyTask, shop: Shop) -> None:
        super().__init__(order, task, shop, task.agvs)
        self._agvs = task.agvs

    def begin(self) -> list[Task]:
        """See `Work.begin`."""
        task, shop = self._assembly, self._shop
        on_agvs = {
            (agv, quadrant): item
            for agv in self._agvs
            for quadrant, item in shop.inventory.load(agv).items.items()
        }
        near = shop.place(assembly_table(task.station))
        tasks = []
        for part in task.products:
            place = next((place for place, item in on_agvs.items() if item.part == part), None)
            if place is not None:
                shop.fleet.send(place[0], task.station)
                tasks.append(self._insert_from_agv(*place, on_agvs.pop(place), stage=0))
            elif (source := shop.inventory.take(part, near)) is not None:
                tasks.append(self._insert_from_bin(source, stage=0))
            else:
                self.missing.append(part)
        return tasks


class CombinedWork(_AtStation):
    """Makes a kit on an AGV, sends it to the station, and inserts the parts in any order.

    Parts for which the AGV has no room are carried over from bins.
    """

    def __init__(
        self, order: Order, task: CombinedTask, shop: Shop, agv: str, needed_trays: set[int]
    ) -> None:
        super().__init__(order, task, shop, (agv,))
        self._agv = agv
        self._needed_trays = needed_trays

    def begin(self) -> list[Task]:
        """See `Work.begin`."""
        task, shop, agv = self._assembly, self._shop, self._agv
        lane = shop.fleet.lane(agv)
        kit: list[Task] = []
        assembly: list[Task] = []
        load = shop.inventory.load(agv)
        present = dict(load.items)
        free = [quadrant for quadrant in QUADRANTS if quadrant not in present]
        for part in task.products:
            at = next((q for q, item in present.items() if item.part == part), None)
            if at is not None:
                assembly.append(self._insert_from_agv(agv, at, present.pop(at), stage=2))
                continue
            source = shop.inventory.take(part, shop.home(agv))
            if source is None:
                self.missing.append(part)
            elif free:
                quadrant = free.pop(0)
                inserting = self._insert_from_agv(agv, quadrant, Item(part), stage=2)
                kit.append(self._kit(quadrant, source, inserting))
                assembly.append(inserting)
            else:
                assembly.append(self._insert_from_bin(source, stage=2))
        if kit and load.tray is None:
            spare = shop.inventory.take_spare_tray(self._needed_trays)
            if spare is not None:
                slot, tray = spare
                kit.insert(0, self._fetch_tray(agv, tray, slot))
        if kit:
            shop.fleet.send(agv, lane.start)
        if assembly:
            when_all_are_done(kit, partial(shop.fleet.send, agv, task.station))
        return kit + assembly

    def _kit(self, quadrant: int, source: TakenItem, inserting: Task) -> Task:
        """Return the task that places a part. Without it, the part is not `inserted` either."""
        agv, shop = self._agv, self._shop
        place = self._onto_agv(agv, quadrant)
        put = partial(shop.inventory.lay, agv, quadrant)
        carried = self._carried(source.item, place, put, shop.home(agv))

        def lost() -> tuple[Step, ...]:
            steps = carried.lost()
            if not steps:
                inserting.give_up()
            return steps

        return self._task(
            "pick_place",
            (self._from_bin(source), place),
            carried.put_down,
            {"part": str(source.item.part), "from": source.bin, "to": agv, "quadrant": quadrant},
            stage=1,
            lost=lost,
        )
