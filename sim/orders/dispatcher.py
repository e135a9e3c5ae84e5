"""Orders of a running trial: announced, worked on, submitted, and scored."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any

from ..core.body import Machine
from ..core.events import OrderAnnounced, OrderSubmitted
from ..core.stage import Stage
from ..machines.agv.agv import Agv
from ..machines.gantry.robot import GantryRobot
from .inventory import Belt, Fleet, Inventory
from .scoring import best_score
from .work import AssemblyWork, CombinedWork, KittingWork, Shop, Work, when_all_are_done
from .workload import AssemblyTask, CombinedTask, KittingTask, Order, Workload


class _OrderProgress:
    """Progress of an order, with times in seconds."""

    def __init__(self, order: Order) -> None:
        self.order = order
        self.announced: float | None = None
        self.submitted: float | None = None
        self.score = 0
        self.missing: list[str] = []

    @property
    def figures(self) -> dict[str, Any]:
        took = None
        if self.announced is not None and self.submitted is not None:
            took = self.submitted - self.announced
        return {
            "type": self.order.kind,
            "priority": self.order.priority,
            "announced": self.announced,
            "submitted": self.submitted,
            "time": took,
            "score": self.score,
            "best": best_score(self.order.task),
            "missing": self.missing,
        }


class Dispatcher:
    """Announces the orders of a workload, and creates the tasks of the gantry.

    An order begins as soon as no other order holds the AGVs and the station it needs. Priority
    orders are first. `all_done` is called when no order is left that can be submitted.
    """

    def __init__(
        self,
        stage: Stage,
        workload: Workload,
        gantry: GantryRobot,
        all_done: Callable[[], None],
        seed: int,
    ) -> None:
        plan = stage.floorplan
        agvs = [machine for machine in stage.machines.values() if isinstance(machine, Agv)]
        self._fleet = Fleet(agvs)
        self._stage = stage
        self._clock = stage.clock
        self._workload = workload
        self._gantry = gantry
        self._record = stage.record
        self._all_done = all_done
        self._belt = Belt(stage, workload.conveyor, seed, gantry.missed)
        inventory = Inventory(workload, plan, self._belt)
        self._shop = Shop(
            plan=plan,
            inventory=inventory,
            fleet=self._fleet,
            handling=gantry.handling,
            record=stage.record,
            faulty=workload.faulty,
        )
        gantry.gripper.will_lose(workload.drops)
        self._orders = {order.id: _OrderProgress(order) for order in workload.orders}
        self._waiting: list[Order] = []
        self._begun: list[Work] = []
        self._finished: list[Work] = []
        self._needed_trays = {
            order.task.tray for order in workload.orders if isinstance(order.task, KittingTask)
        }
        gantry.tasks.more_to_come = True

    def begin(self) -> None:
        """Wait for the announcements of orders, and for malfunctions."""
        triggers = self._stage.triggers
        self._stage.on_rest.append(self._came_to_rest)
        self._belt.begin(self._gantry.tasks.reconsider)
        for order in self._workload.orders:
            triggers.add(order.announcement, partial(self._announce, order))
        for malfunction in self._workload.malfunctions:
            stand = partial(self._gantry.malfunction, malfunction.seconds)
            triggers.add(malfunction.start, stand)

    @property
    def figures(self) -> dict[str, Any]:
        """Figures of the summary: every order, and the points of all orders."""
        orders = {name: progress.figures for name, progress in self._orders.items()}
        return {
            "orders": orders,
            "score": sum(figures["score"] for figures in orders.values()),
            "best_score": sum(figures["best"] for figures in orders.values()),
            "parts_faulty": len(self._shop.found_faulty),
            "parts_missed": self._belt.parts_missed,
        }

    def _came_to_rest(self, machine: Machine) -> None:
        """Update the orders after a machine has come to rest."""
        if isinstance(machine, Agv):
            self._fleet.stopped(machine)
            self._submit_orders()

    def _announce(self, order: Order) -> None:
        self._orders[order.id].announced = self._clock.now
        self._record(OrderAnnounced(order=order.id, type=order.kind, priority=order.priority))
        self._waiting.append(order)
        self._waiting.sort(key=lambda waiting: not waiting.priority)
        self._begin_orders()

    def _begin_orders(self) -> None:
        """Begin every order whose resources are free, without using those of earlier ones."""
        in_use = {thing for work in self._begun for thing in work.holds}
        for order in list(self._waiting):
            work = self._work_on(order, in_use)
            if work is not None:
                self._waiting.remove(order)
                self._begin(work)
                in_use.update(work.holds)
            else:
                # The resources of a waiting order are reserved, because later orders might overtake
                # it repeatedly.
                in_use.update(_wanted(order))

    def _begin(self, work: Work) -> None:
        order = work.order
        self._begun.append(work)
        tasks = work.begin()
        progress = self._orders[order.id]
        progress.missing = [str(part) for part in work.missing]
        when_all_are_done(tasks, partial(self._finish, work))
        self._gantry.tasks.add(tasks, first=order.priority)

    def _work_on(self, order: Order, reserved: set[str]) -> Work | None:
        """Return the work on an order, or None while its resources are held."""
        task = order.task
        if isinstance(task, CombinedTask):
            return self._combined_work(order, task, reserved)
        if reserved.intersection(_wanted(order)):
            return None
        if isinstance(task, AssemblyTask):
            return AssemblyWork(order, task, self._shop)
        return KittingWork(order, task, self._shop)

    def _combined_work(self, order: Order, task: CombinedTask, reserved: set[str]) -> Work | None:
        """Return the work on a combined order, on the free AGV with the smallest load."""
        free = [agv for agv in self._fleet.serving(task.station) if agv not in reserved]
        if task.station in reserved or not free:
            return None
        agv = min(free, key=lambda name: len(self._shop.inventory.load(name).items))
        return CombinedWork(order, task, self._shop, agv, self._needed_trays)

    def _finish(self, work: Work) -> None:
        """Submit an order whose tasks are done when everything is in its place."""
        self._finished.append(work)
        self._clock.call_at(self._clock.now, self._submit_orders)

    def _submit_orders(self) -> None:
        for work in [work for work in self._finished if work.ready()]:
            self._finished.remove(work)
            self._submit(work)

    def _submit(self, work: Work) -> None:
        order, progress = work.order, self._orders[work.order.id]
        progress.submitted = self._clock.now
        progress.missing = [str(part) for part in work.missing]
        progress.score = work.score()
        self._record(
            OrderSubmitted(
                order=order.id,
                type=order.kind,
                score=progress.score,
                best=best_score(order.task),
                missing=progress.missing,
            )
        )
        work.hand_over()
        self._begun.remove(work)
        for thing in work.holds:
            self._fleet.release(thing)
        self._begin_orders()
        if not self._begun and not self._to_be_announced():
            self._gantry.tasks.more_to_come = False
            self._gantry.tasks.reconsider()
            self._all_done()

    def _to_be_announced(self) -> bool:
        """Return True if an order will be announced even without further work."""
        return any(
            progress.announced is None and progress.order.announcement.time is not None
            for progress in self._orders.values()
        )


def _wanted(order: Order) -> tuple[str, ...]:
    """Return the AGVs and stations that an order names."""
    task = order.task
    if isinstance(task, KittingTask):
        return (task.agv,)
    if isinstance(task, AssemblyTask):
        return (*task.agvs, task.station)
    return (task.station,)
