"""The AGVs' topics: where they are; and the services that send them somewhere."""

from __future__ import annotations

from collections.abc import Iterable
from functools import partial
from typing import Any

from ..machines.agv.agv import Agv
from .client import Client
from .exchange import Exchange
from .gate import Gate
from .readings import LOCATIONS, agv_status


class AgvTopics:
    """Publishes where AGVs are, and sends them where clients want them."""

    def __init__(self, agvs: Iterable[Agv], exchange: Exchange, gate: Gate) -> None:
        self._exchange = exchange
        self._gate = gate
        self._status = {}
        for agv in agvs:
            name = agv.lane.name
            topic = exchange.advertise(f"/ariac/{name}_status", "ariac_msgs/AGVStatus")
            self._status[agv] = topic
            exchange.provide(f"/ariac/move_{name}", "ariac_msgs/MoveAGV", partial(self._move, agv))

    def publish(self) -> None:
        """Publish the state as it is now."""
        for agv, topic in self._status.items():
            if topic.is_needed:
                self._exchange.publish(topic, agv_status(agv.lane, agv.body.state))

    def _move(self, agv: Agv, _: Client, request: dict[str, Any]) -> dict[str, Any]:
        number = request["location"]
        if not 0 <= number < len(LOCATIONS) or LOCATIONS[number] not in agv.lane.locations:
            known = [
                f"{k} {name}" for k, name in enumerate(LOCATIONS) if name in agv.lane.locations
            ]
            message = f"{agv.lane.name} has no location {number} (there are: {', '.join(known)})"
            return {"success": False, "message": message}
        self._gate.enter(f"move_{agv.lane.name}")
        agv.drive(LOCATIONS[number])
        return {"success": True, "message": f"on its way to {LOCATIONS[number]}"}
