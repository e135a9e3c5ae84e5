"""Output for viewers: events, diagnostics of the monitor, and markers for RViz."""

from __future__ import annotations

import json
import math
from collections.abc import Iterable, Iterator, Sequence
from types import SimpleNamespace
from typing import Any

from ..cell import Cell
from ..competition import Values
from ..competition.messages import about_z, header
from ..exports import scene
from ..exports.scene import ALARM, SAFE, Shape, Thing
from .node import CellNode

MOST_EVENTS = 1000
"""Number of events in the queue of their topic."""

DIAGNOSTICS = 1.0
"""Hz, in simulated time."""

STATES = {False: (b"\0", "separated"), True: (b"\2", "violation")}
"""Level and message of a diagnostic_msgs/DiagnosticStatus: whether a distance is too short."""


def add_monitoring(ros: CellNode, cell: Cell) -> None:
    """Publish `/diagnostics` of each person and machine, and `events` as in `events.jsonl`."""
    pairs = [(name, one) for name, one in cell.signals.items() if name.startswith("monitor/")]

    def diagnostics() -> Values:
        status = []
        for name, signal in pairs:
            if (state := signal.read()) is not None:
                _, person, machine = name.split("/")
                level, message = STATES[state.distance < state.required]
                values = {"distance": state.distance, "required": state.required}
                status.append(
                    {
                        "name": f"separation of {person} and {machine}",
                        "hardware_id": machine,
                        "level": level,
                        "message": message,
                        "values": [{"key": k, "value": f"{v:.4f}"} for k, v in values.items()],
                    }
                )
        return {"header": header(cell.now, ""), "status": status}

    ros.advertise("/diagnostics", "diagnostic_msgs/DiagnosticArray", diagnostics, rate=DIAGNOSTICS)
    events = ros.advertise("events", "std_msgs/String", depth=MOST_EVENTS)
    cell.signals["events"].watch(
        lambda event: ros.publish(events, {"data": json.dumps(event, ensure_ascii=False)})
    )


WIDTH = 0.04
"""Width of drawn lines, m."""

KINDS = {"arrow": 0, "cube": 1, "cylinder": 3, "line": 4, "label": 9, "triangles": 11}
"""Types of visualization_msgs/Marker."""

MARKERS = "visualization_msgs/MarkerArray"


def add_markers(ros: CellNode, cell: Cell) -> None:
    """Publish `markers` of floor and bodies, latched, and `separation_markers` that change."""
    shown = cell.simulation.scene
    run: Any = SimpleNamespace(scene=shown, floorplan=shown.floorplan)
    constant = ros.advertise("markers", MARKERS, latched=1)
    ros.publish(constant, _drawn([*scene.floor(run), *scene.bodies(run)]))
    changing = lambda: _drawn([*_distances(cell), *_fields(cell)])  # noqa: E731
    ros.advertise("separation_markers", MARKERS, changing)


def _distances(cell: Cell) -> Iterator[Thing]:
    """Yield the required distances around people."""
    for name, signal in cell.signals.items():
        state = signal.read() if name.startswith("monitor/") else None
        if state is not None and 0 < state.required < math.inf:
            color = ALARM if state.distance < state.required else SAFE
            circle = scene.circle((0.0, 0.0), state.required, WIDTH, color)
            yield Thing(name, scene.frame(name.split("/")[1]), (circle,))


def _fields(cell: Cell) -> Iterator[Thing]:
    """Yield the protective fields that apply."""
    simulation, now = cell.simulation, cell.now
    for name, fields in simulation.trial.fields.items():
        machine = simulation.machines[name]
        for span in fields.protective.applying(machine.body.motion, now, now, machine.loaded):
            if span.set is not None:
                corners = [(x, y, WIDTH) for x, y in span.set.protective]
                outline = scene.polyline([*corners, corners[0]], WIDTH, ALARM)
                yield Thing(f"field/{name}", scene.frame(name), (outline,))


def _drawn(things: Iterable[Thing]) -> Values:
    return {
        "markers": [
            _marker(thing, number, shape)
            for thing in things
            for number, shape in enumerate(thing.shapes)
        ]
    }


def _marker(thing: Thing, number: int, shape: Shape) -> Values:
    length, width, height = shape.size
    size = (length, width, width if shape.kind == "arrow" else height)
    return {
        "header": header(0.0, thing.frame),  # at 0, the latest transform applies
        "frame_locked": True,
        "ns": thing.name,
        "id": number,
        "type": KINDS[shape.kind],
        "pose": {"position": _xyz(shape.at), "orientation": about_z(shape.yaw)},
        "scale": _xyz(size),
        "color": dict(zip("rgba", shape.color, strict=True)),
        "points": [_xyz(point) for point in shape.points],
        "text": shape.text,
    }


def _xyz(values: Sequence[float]) -> Values:
    return dict(zip("xyz", map(float, values), strict=True))
