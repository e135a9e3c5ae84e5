"""An order that is being worked on: the gantry's tasks for it, and its outcome."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field
from functools import partial
from typing import Any

from floorplan import Floorplan, Point

from ..core.recorder import Record
from ..core.workload import Item, Order, Part
from ..machines.gantry.tasks import Handling, Step, Task
from . import layout
from .carried import Carried, Found
from .fleet import Fleet
from .inventory import Inventory

Action = Callable[[], None]


@dataclass(frozen=True)
class Cell:
    """Workcell as orders use it: the floor, its inventory, the AGVs, and times of handling.

    `faulty` has the quadrants of kits in which the first part is faulty, by order; the parts that
    were found so are in `found_faulty`.
    """

    plan: Floorplan
    inventory: Inventory
    fleet: Fleet
    handling: Handling
    record: Record
    faulty: Mapping[str, frozenset[int]] = field(default_factory=dict)
    found_faulty: list[Part] = field(default_factory=list)

    def place(self, obstacle: str) -> Point:
        """Return the middle of an obstacle: x, y in metres."""
        middle = self.plan.obstacle(obstacle).footprint.centroid
        return (middle.x, middle.y)

    def home(self, agv: str) -> Point:
        """Return the place where kits are made on an AGV: x, y in metres."""
        lane = self.fleet.lane(agv)
        return lane.position(lane.locations[lane.start])

    def nearest(self, obstacles: Iterable[str], point: Point) -> str:
        """Return the obstacle whose middle is nearest to a point."""
        return min(obstacles, key=lambda name: math.dist(self.place(name), point))


class Work(ABC):
    """The work on one order.

    No other order is begun that needs what this one `holds`, AGVs and stations, until it has been
    submitted. `missing` are the parts that it lacks.
    """

    def __init__(self, order: Order, cell: Cell, holds: tuple[str, ...]) -> None:
        self.order = order
        self.holds = holds
        self.missing: list[Part] = []
        self._cell = cell

    @abstractmethod
    def begin(self) -> list[Task]:
        """Send the AGVs; return the gantry's tasks that come before the order is submitted."""

    @abstractmethod
    def ready(self) -> bool:
        """Return True if all is where it has to be for submission."""

    @abstractmethod
    def score(self) -> int:
        """Return the points for the order as things stand."""

    @abstractmethod
    def hand_over(self) -> None:
        """Take away the kit or assembly: the order has been submitted."""

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
            ready = partial(self._cell.inventory.belt.has_come, passing)
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
        """Return a part on its way; others of its kind are looked for in bins near `near`."""

        def another() -> Found | None:
            found = self._cell.inventory.take(item.part, near)
            return None if found is None else (found[2], self._from_bin(*found))

        return Carried(item, last, put, another=another, missing=self.missing)

    def _from_bin(self, bin: str, slot: int, item: Item) -> Step:
        """Taking an item from its bin, and turning it over if it is flipped."""
        seconds = self._picking(item)
        if bin == layout.BELT:
            return self._cell.inventory.belt.step(slot, seconds)
        return Step("pick", seconds, place=bin, offset=layout.bin_slot(slot))

    def _from_agv(self, agv: str, quadrant: int, item: Item) -> Step:
        return Step("pick", self._picking(item), place=agv, offset=self._quadrant(agv, quadrant))

    def _onto_agv(self, agv: str, quadrant: int) -> Step:
        return Step(
            "place",
            self._cell.handling.place,
            place=agv,
            offset=self._quadrant(agv, quadrant),
        )

    def _quadrant(self, agv: str, quadrant: int) -> layout.Offset:
        return layout.quadrant_on(self._cell.fleet.lane(agv), quadrant)

    def _picking(self, item: Item) -> float:
        handling = self._cell.handling
        return handling.pick + (handling.turn_over if item.flipped else 0.0)

    def _fetch_tray(self, agv: str, tray: int, slot: int) -> Task:
        """Change the gripper, put the tray on the AGV, and change the gripper back."""
        handling, lane = self._cell.handling, self._cell.fleet.lane(agv)
        table, at = layout.tray_slot(slot)
        nearest = self._cell.nearest(layout.TABLES, self._cell.home(agv))
        steps = (
            _change_tool(table, "trays", handling),
            Step("pick_tray", handling.pick_tray, place=table, offset=at),
            Step("place_tray", handling.place_tray, place=agv, offset=layout.tray_on(lane)),
            _change_tool(nearest, "parts", handling),
        )
        done = partial(self._cell.inventory.lay_tray, agv, tray)
        return self._task("tray", steps, done, {"tray": tray, "from": table, "to": agv})


def _change_tool(table: str, tool: str, handling: Handling) -> Step:
    return Step(
        "change_tool",
        handling.change_tool,
        place=table,
        offset=layout.tool_stand(table, tool),
    )


def when_all_are_done(tasks: list[Task], action: Action) -> None:
    """Call `action` after the last of `tasks` is done; at once if there are none."""
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
