"""All topics of the competition: its person, the machines, orders and phases."""

from __future__ import annotations

from ..cell import Cell
from ..core.recorder import Event
from ..orders.workload import Order, Workload
from ..people.person import Person
from ..people.programs import EXTERNAL
from ..trials.trial import Trial
from .human_topics import HumanTopics
from .machine_topics import add_agvs
from .messages import human_state, order_message
from .transport import Caller, Transport, Values

READY, STARTED, ANNOUNCED, ENDED = 1, 2, 3, 4
"""Phases of ariac_msgs/CompetitionState. ANNOUNCED: started, and all orders are announced."""

_MOST_ORDERS = 1000


class CompetitionTopics:
    """Topics and services of ARIAC 2023.

    They drive the first external person. If there is none, they show the first person.
    """

    def __init__(self, cell: Cell, transport: Transport) -> None:
        self._cell = cell
        self._transport = transport
        advertise = transport.advertise
        phase = "ariac_msgs/CompetitionState"
        self._orders = advertise("/ariac/orders", "ariac_msgs/Order", latched=_MOST_ORDERS)
        self._phase = advertise("/ariac/competition_state", phase, latched=1)
        self._unannounced: dict[str, Order] = {}
        driven = driven_person(cell.simulation.trial)
        self._driven = "" if driven is None else cell.simulation.people[driven].name
        self._human = None
        if self._driven:
            advertise("/ariac_human/state", "ariac_msgs/HumanState", self._read_state)
            self._human = HumanTopics(self._driven, cell, transport)
        add_agvs(cell, transport)
        transport.provide("/ariac/end_competition", "std_srvs/Trigger", self._end)
        cell.signals["events"].watch(self._announce)
        self.enter(READY)

    @property
    def person(self) -> Person | None:
        """Person of the topics."""
        return self._cell.simulation.person(self._driven) if self._driven else None

    def _read_state(self) -> Values:
        gantry, person = self._cell.simulation.gantry, self.person
        assert person is not None
        height = gantry.gantry.rail_height if gantry else 0.0
        return human_state(person.body.state, gantry.state if gantry else None, height)

    def repeat(self) -> None:
        """Publish a violation again that the agent has not answered."""
        if self._human is not None:
            self._human.repeat()

    def enter(self, phase: int) -> None:
        """Publish that the competition enters a phase."""
        self._transport.publish(self._phase, {"competition_state": phase})

    def _end(self, _: Caller, __: Values) -> Values:
        self._cell.admission.admit("/ariac/end_competition", None)
        self._cell.pace.end()
        return {"success": True, "message": f"ended at t = {self._cell.now:g} s"}

    def _announce(self, event: Event) -> None:
        """Publish an order that is announced."""
        trial = self._cell.simulation.trial
        if event["kind"] == "trial_started":
            orders = trial.workload.orders if isinstance(trial.workload, Workload) else ()
            self._unannounced = {order.id: order for order in orders}
        elif event["kind"] == "order_announced":
            order = self._unannounced.pop(event["order"])
            self._transport.publish(self._orders, order_message(order, trial.floorplan))
            if not self._unannounced:
                self.enter(ANNOUNCED)


def driven_person(trial: Trial) -> int | None:
    """Return the index of the person of the topics: the first external one, or the first."""
    external = [k for k, person in enumerate(trial.people) if person.personality == EXTERNAL]
    return external[0] if external else (0 if trial.people else None)
