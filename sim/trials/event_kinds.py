"""The kinds of events that happen in a run, and the fields that each kind has."""

from __future__ import annotations

from typing import Literal

Form = Literal["person", "machine", "agv", "station", "number", "text", "flag", "point", "list"]
"""What stands in a field: the name of something in the trial, or a plain value."""

_FIGURES: dict[str, Form] = {
    "distance": "number",
    "required": "number",
    "human_speed": "number",
    "robot_speed": "number",
}
_JOB: dict[str, Form] = {
    "job": "text",
    "part": "text",
    "from": "text",
    "to": "text",
    "order": "text",
    "tray": "number",
    "quadrant": "number",
}

EVENT_KINDS: dict[str, dict[str, Form]] = {
    "trial_started": {"trial": "text", "floorplan": "text"},
    "trial_ended": {"interrupted": "flag"},
    "human_started": {"person": "person"},
    "personality_changed": {"person": "person", "personality": "text"},
    "goal": {"person": "person", "station": "station", "at": "point"},
    "arrived": {"person": "person", "station": "station", "at": "point"},
    "gantry_detected": {"person": "person", "noticing_distance": "number", **_FIGURES},
    "violation": {
        "person": "person",
        "with": "machine",
        "penalty": "flag",
        "cause": "text",
        **_FIGURES,
    },
    "penalty": {"person": "person", "cause": "text"},
    "teleport": {"person": "person", "reason": "text", "to": "point"},
    "gantry_disabled": {"seconds": "number"},
    "gantry_enabled": {},
    "agv_moved": {"agv": "agv", "to": "text", "arrives": "number"},
    "agv_yielded": {
        "agv": "agv",
        "person": "person",
        "distance": "number",
        "required": "number",
    },
    "job_started": _JOB,
    "job_done": _JOB,
    "order_announced": {"order": "text", "type": "text", "priority": "flag"},
    "order_submitted": {
        "order": "text",
        "type": "text",
        "score": "number",
        "best": "number",
        "missing": "list",
    },
    "robot_malfunction": {"seconds": "number"},
    "path_blocked": {"person": "person", "goal": "point", "message": "text", "by": "agv"},
    "goal_occupied": {"person": "person", "goal": "point", "by": "agv"},
    "goal_free": {"person": "person", "goal": "point"},
    "replanned": {"person": "person", "goal": "point"},
    "said": {"person": "person", "text": "text"},
    "notice": {"text": "text", "field": "text", "line": "number"},
    "warning": {"person": "person", "text": "text", "file": "text", "line": "number"},
}
