"""Orders of the ARIAC competition as ROS messages."""

from __future__ import annotations

from typing import Any

from ..orders import AssemblyTask, KittingTask, Order, Part
from .conformance import blank
from .message_types import message_type
from .readings import LOCATIONS

_KINDS = ("kitting", "assembly", "combined")
_COLORS = ("red", "green", "blue", "orange", "purple")
_TYPES = {"battery": 10, "pump": 11, "sensor": 12, "regulator": 13}


def order_message(order: Order) -> dict[str, Any]:
    """ariac_msgs/Order. How assembled parts lie is not kept in a trial, and left blank."""
    message = blank(message_type("ariac_msgs/Order"))
    message |= {"id": order.id, "type": _KINDS.index(order.kind), "priority": order.priority}
    task = order.task
    if isinstance(task, KittingTask):
        message["kitting_task"] = {
            "agv_number": _number(task.agv),
            "tray_id": task.tray,
            "destination": LOCATIONS.index(task.destination),
            "parts": [
                {"part": _part(part), "quadrant": quadrant}
                for quadrant, part in sorted(task.products.items())
            ],
        }
        return message
    parts = [_assembled(part) for part in task.products]
    work = {"station": _number(task.station), "parts": parts}
    if isinstance(task, AssemblyTask):
        message["assembly_task"] = {"agv_numbers": [_number(agv) for agv in task.agvs], **work}
    else:
        message["combined_task"] = work
    return message


def _assembled(part: Part) -> dict[str, Any]:
    return blank(message_type("ariac_msgs/AssemblyPart")) | {"part": _part(part)}


def _part(part: Part) -> dict[str, int]:
    return {"color": _COLORS.index(part.color), "type": _TYPES[part.type]}


def _number(name: str) -> int:
    """The number in a name: agv3 is 3, as2 is 2."""
    return int("".join(filter(str.isdigit, name)))
