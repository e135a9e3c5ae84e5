"""Output for viewers: events, diagnostics of the monitor, and markers for RViz."""

from __future__ import annotations

import json
import math
from collections.abc import Iterator, Sequence
from types import SimpleNamespace
from typing import Any

from ..cell import Cell
from ..core.recorder import Event
from ..exports import scene
from ..exports.scene import ALARM, SAFE, Color, Shape, Thing
from .messages import set_header, set_turn
from .node import LATCHED, CellNode, RosTopic


class Monitoring:
    """Publisher of `/diagnostics` and `events`."""

    def __init__(self, ros: CellNode, cell: Cell) -> None:
        self._cell = cell
        self._events = ros.publish_on("events", "std_msgs/msg/String", 1000)
        self._diagnostics = ros.publish_on("/diagnostics", "diagnostic_msgs/msg/DiagnosticArray")
        self._status = ros.find("diagnostic_msgs/msg/DiagnosticStatus", "/diagnostics")
        self._value = ros.find("diagnostic_msgs/msg/KeyValue", "/diagnostics")
        self._pairs = [(n, s) for n, s in cell.signals.items() if n.startswith("monitor/")]
        cell.signals["events"].watch(self._publish_event)

    def _publish_event(self, event: Event) -> None:
        """Publish an event as in `events.jsonl`."""
        self._events.publish(self._events.new(data=json.dumps(event, ensure_ascii=False)))

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


WIDTH = 0.04
"""Width of drawn lines, m."""

DIRECTIONS = [(math.cos(k * math.tau / 48), math.sin(k * math.tau / 48)) for k in range(49)]
"""Unit vectors to the corners of a drawn circle."""


class Markers:
    """Publisher of `markers` (latched) and `separation_markers`."""

    def __init__(self, ros: CellNode, cell: Cell) -> None:
        self._cell = cell
        array = "visualization_msgs/msg/MarkerArray"
        constant = ros.publish_on("markers", array, LATCHED)
        self._changing = ros.publish_on("separation_markers", array)
        self._marker = ros.find("visualization_msgs/msg/Marker", "markers")
        self._point = ros.find("geometry_msgs/msg/Point", "markers")
        if self._marker is not None:
            shown = cell.simulation.scene
            run: Any = SimpleNamespace(scene=shown, floorplan=shown.floorplan)
            self._publish(constant, [*scene.floor(run), *scene.bodies(run)])

    def publish(self) -> None:
        """Publish the required distances around people, and the protective fields that apply."""
        if self._changing.is_needed:
            self._publish(self._changing, [*self._distances(), *self._fields()])

    def _distances(self) -> Iterator[Thing]:
        for name, signal in self._cell.signals.items():
            state = signal.read() if name.startswith("monitor/") else None
            if state is not None and 0 < state.required < math.inf:
                circle = [(state.required * x, state.required * y) for x, y in DIRECTIONS]
                color = ALARM if state.distance < state.required else SAFE
                yield Thing(name, scene.frame(name.split("/")[1]), (_line(circle, color),))

    def _fields(self) -> Iterator[Thing]:
        simulation, now = self._cell.simulation, self._cell.now
        for name, fields in simulation.trial.fields.items():
            machine = simulation.machines[name]
            for span in fields.protective.applying(machine.body.motion, now, now, machine.loaded):
                if span.set is not None:
                    corners = [*span.set.protective, span.set.protective[0]]
                    yield Thing(f"field/{name}", scene.frame(name), (_line(corners, ALARM),))

    def _publish(self, topic: RosTopic, things: list[Thing]) -> None:
        drawn = [
            self._drawn(thing, number, shape)
            for thing in things
            for number, shape in enumerate(thing.shapes)
        ]
        topic.publish(topic.new(markers=drawn))

    def _drawn(self, thing: Thing, number: int, shape: Shape) -> Any:
        marker = self._marker(ns=thing.name, id=number, text=shape.text, frame_locked=True)
        set_header(marker.header, 0.0, thing.frame)  # at 0, the latest transform applies
        marker.type = {
            "cube": marker.CUBE,
            "cylinder": marker.CYLINDER,
            "arrow": marker.ARROW,
            "line": marker.LINE_STRIP,
            "triangles": marker.TRIANGLE_LIST,
            "label": marker.TEXT_VIEW_FACING,
        }[shape.kind]
        at, scale, color = marker.pose.position, marker.scale, marker.color
        at.x, at.y, at.z = map(float, shape.at)
        set_turn(marker.pose.orientation, shape.yaw)
        scale.x, scale.y, height = map(float, shape.size)
        scale.z = scale.y if shape.kind == "arrow" else height
        color.r, color.g, color.b, color.a = shape.color
        marker.points = [
            self._point(x=float(x), y=float(y), z=float(z)) for x, y, z in shape.points
        ]
        return marker


def _line(corners: Sequence[tuple[float, float]], color: Color) -> Shape:
    points = tuple((x, y, WIDTH) for x, y in corners)
    return Shape(kind="line", points=points, size=(WIDTH, 0.0, 0.0), color=color)
