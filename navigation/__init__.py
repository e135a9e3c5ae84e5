"""How bodies move: collision, paths, motions in continuous time, and separation."""

from .bodies import Disc
from .gantry_planner import GantryPath, GantryPlanner
from .machines import (
    ARIAC_GANTRY,
    GantryLimits,
    agv_run,
    gantry_limits,
    gantry_move,
    gantry_stop,
    lane_state,
)
from .monitor import (
    RESOLUTION,
    STANDING_SPEED,
    Apart,
    Approaching,
    Both,
    Condition,
    Moving,
    Not,
    TooClose,
    first_time,
    first_violation,
    minimum_separation,
    violations,
    when,
)
from .motion import Motion, Piece, State, join, standing
from .path import Path, PlannerInfo, PlanningError
from .planner import PathPlanner, planners
from .profiles import AxisLimits, AxisState
from .separation import FixedDistance, Law, Scaled, SeparationLaw
from .walk import can_go_on, corner_speed, remaining_path, stop_walking, walk
from .world import CollisionWorld

__all__ = [
    "ARIAC_GANTRY",
    "RESOLUTION",
    "STANDING_SPEED",
    "Apart",
    "Approaching",
    "AxisLimits",
    "AxisState",
    "Both",
    "CollisionWorld",
    "Condition",
    "Disc",
    "FixedDistance",
    "GantryLimits",
    "GantryPath",
    "GantryPlanner",
    "Law",
    "Motion",
    "Moving",
    "Not",
    "Path",
    "PathPlanner",
    "Piece",
    "PlannerInfo",
    "PlanningError",
    "Scaled",
    "SeparationLaw",
    "State",
    "TooClose",
    "agv_run",
    "can_go_on",
    "corner_speed",
    "first_time",
    "first_violation",
    "gantry_limits",
    "gantry_move",
    "gantry_stop",
    "join",
    "lane_state",
    "minimum_separation",
    "planners",
    "remaining_path",
    "standing",
    "stop_walking",
    "violations",
    "walk",
    "when",
]
