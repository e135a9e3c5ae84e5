"""The monitor as diagnostics, and events as JSON."""

from __future__ import annotations

import json

from ..cell import Cell
from .messages import set_header
from .node import CellNode


class Monitoring:
    """Publisher of `/diagnostics` and `events`."""

    def __init__(self, ros: CellNode, cell: Cell) -> None:
        self._cell = cell
        self._events = ros.publish_on("events", "std_msgs/msg/String", 1000)
        self._published = 0
        self._diagnostics = ros.publish_on("/diagnostics", "diagnostic_msgs/msg/DiagnosticArray")
        self._status = ros.find("diagnostic_msgs/msg/DiagnosticStatus", "/diagnostics")
        self._value = ros.find("diagnostic_msgs/msg/KeyValue", "/diagnostics")
        self._pairs = [(n, s) for n, s in cell.signals.items() if n.startswith("monitor/")]

    def publish_events(self) -> None:
        """Publish the events since the last call, each as in `events.jsonl`."""
        events = self._cell.simulation.events
        for event in events[self._published :]:
            self._events.publish(self._events.new(data=json.dumps(event, ensure_ascii=False)))
        self._published = len(events)

    def publish_diagnostics(self) -> None:
        """Publish distance and required distance of each person and machine."""
        if not self._diagnostics.is_needed:
            return
        message = self._diagnostics.new()
        set_header(message.header, self._cell.now, "")
        for name, signal in self._pairs:
            if (state := signal.read()) is None:
                continue
            _, person, machine = name.split("/")
            status = self._status(name=f"separation of {person} and {machine}", hardware_id=machine)
            too_close = state.distance < state.required
            status.level = status.ERROR if too_close else status.OK
            status.message = "violation" if too_close else "separated"
            status.values = [
                self._value(key="distance", value=f"{state.distance:.4f}"),
                self._value(key="required", value=f"{state.required:.4f}"),
            ]
            message.status.append(status)
        self._diagnostics.publish(message)
