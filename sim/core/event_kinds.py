"""The kinds of events that happen in a run, and the fields that each kind has."""

from __future__ import annotations

from typing import Literal, TypeAlias

Named = Literal[
    "person",
    "machine",
    "agv",
    "station",
    "location",
    "place",
    "part",
    "order",
    "personality",
    "kind of job",
    "type of order",
    "cause",
    "reason",
]
"""What has names in a trial. A location, which an AGV goes to, may be a lane position as well."""

Form: TypeAlias = Named | Literal["number", "text", "flag", "point", "list"]
"""What stands in a field: the name of something in the trial, or a plain value."""

_FIGURES: dict[str, Form] = {
    "distance": "number",
    "required": "number",
    "human_speed": "number",
    "robot_speed": "number",
}
_JOB: dict[str, Form] = {
    "job": "kind of job",
    "part": "part",
    "from": "place",
    "to": "place",
    "order": "order",
    "tray": "number",
    "quadrant": "number",
}

EVENT_KINDS: dict[str, dict[str, Form]] = {
    "trial_started": {"trial": "text", "floorplan": "text"},
    "trial_ended": {"interrupted": "flag"},
    "human_started": {"person": "person"},
    "personality_changed": {"person": "person", "personality": "personality"},
    "goal": {"person": "person", "station": "station", "at": "point"},
    "arrived": {"person": "person", "station": "station", "at": "point"},
    "gantry_detected": {"person": "person", "noticing_distance": "number", **_FIGURES},
    "violation": {
        "person": "person",
        "with": "machine",
        "penalty": "flag",
        "cause": "cause",
        **_FIGURES,
    },
    "penalty": {"person": "person", "cause": "cause"},
    "teleport": {"person": "person", "reason": "reason", "to": "point"},
    "protective_stop": {"machine": "machine", "person": "person"},
    "protective_stop_ended": {"machine": "machine"},
    "gantry_disabled": {"seconds": "number"},
    "gantry_enabled": {},
    "agv_moved": {"agv": "agv", "to": "location", "arrives": "number"},
    "agv_yielded": {
        "agv": "agv",
        "person": "person",
        "distance": "number",
        "required": "number",
    },
    "job_started": _JOB,
    "job_done": _JOB,
    "order_announced": {"order": "order", "type": "type of order", "priority": "flag"},
    "order_submitted": {
        "order": "order",
        "type": "type of order",
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
