"""How bodies move: collision, paths, motions in continuous time, and separation."""

from .among import Mover, Passage, plan_among
from .bodies import Disc
from .catalog import planners
from .choice import PlannerChoice
from .clearance import Swath, first_conflict, swath, walked
from .conditions import (
    STANDING_SPEED,
    Apart,
    Approaching,
    Both,
    Condition,
    Moving,
    Not,
    Overlapping,
    TooClose,
)
from .courses import Company, Courses
from .crowding import Nearest, nearest_pair
from .encounter import Encounter
from .gantry_planner import GantryPath, GantryPlanner
from .kernels.braking import Stops
from .kernels.candidates import Candidates
from .kernels.discs import first_met, within_bounds
from .kernels.edges import Legs, legs_of, touches
from .kernels.following import followed
from .kernels.foresight import Foresight
from .kernels.grid import middles
from .kernels.lookout import most_remote, nearest_on
from .kernels.movers import Movers
from .kernels.numbers import numbers
from .kernels.pieces import walked_and_stood
from .kernels.retreats import Retreats
from .kernels.throng import Throng
from .kernels.ways_round import CHUNK, WaysRound
from .lookout import Lookout
from .machines import (
    ARIAC_GANTRY,
    GantryLimits,
    Machine,
    Stop,
    agv_run,
    agv_stop,
    agv_stops,
    gantry_limits,
    gantry_move,
    gantry_stop,
    gantry_stops,
    lane_state,
    longest_stop,
)
from .monitor import (
    RESOLUTION,
    first_interval,
    first_time,
    first_violation,
    minimum_margin,
    minimum_separation,
    violations,
    when,
)
from .motion import Cubic, Motion, Piece, State, join, standing
from .narrows import Narrows
from .odometer import Enclosure, Odometer
from .pace import pace, paced
from .path import Path, PlannerError, PlannerInfo, PlanningError, Watch
from .planner import PathPlanner
from .profiles import AxisLimits, AxisState
from .separation import (
    AnyLaw,
    ApproachLaw,
    FixedDistance,
    IntegralLaw,
    Law,
    MotionLaw,
    Scaled,
    SeparationLaw,
    is_of_motions,
    is_of_speeds,
    required_along,
    required_at,
    required_at_speeds,
    requirement,
)
from .surfaces import Box, Cylinder, Shapes, agv_box, folded_arm, torso_box
from .track import Track
from .walk import can_go_on, corner_speed, leg_to, remaining_path, stop_walking, walk
from .world import CollisionWorld

__all__ = [
    "ARIAC_GANTRY",
    "CHUNK",
    "RESOLUTION",
    "STANDING_SPEED",
    "AnyLaw",
    "Apart",
    "ApproachLaw",
    "Approaching",
    "AxisLimits",
    "AxisState",
    "Both",
    "Box",
    "Candidates",
    "CollisionWorld",
    "Company",
    "Condition",
    "Courses",
    "Cubic",
    "Cylinder",
    "Disc",
    "Enclosure",
    "Encounter",
    "FixedDistance",
    "Foresight",
    "GantryLimits",
    "GantryPath",
    "GantryPlanner",
    "IntegralLaw",
    "Law",
    "Legs",
    "Lookout",
    "Machine",
    "Motion",
    "MotionLaw",
    "Mover",
    "Movers",
    "Moving",
    "Narrows",
    "Nearest",
    "Not",
    "Odometer",
    "Overlapping",
    "Passage",
    "Path",
    "PathPlanner",
    "Piece",
    "PlannerChoice",
    "PlannerError",
    "PlannerInfo",
    "PlanningError",
    "Retreats",
    "Scaled",
    "SeparationLaw",
    "Shapes",
    "State",
    "Stop",
    "Stops",
    "Swath",
    "Throng",
    "TooClose",
    "Track",
    "Watch",
    "WaysRound",
    "agv_box",
    "agv_run",
    "agv_stop",
    "agv_stops",
    "can_go_on",
    "corner_speed",
    "first_conflict",
    "first_interval",
    "first_met",
    "first_time",
    "first_violation",
    "folded_arm",
    "followed",
    "gantry_limits",
    "gantry_move",
    "gantry_stop",
    "gantry_stops",
    "is_of_motions",
    "is_of_speeds",
    "join",
    "lane_state",
    "leg_to",
    "legs_of",
    "longest_stop",
    "middles",
    "minimum_margin",
    "minimum_separation",
    "most_remote",
    "nearest_on",
    "nearest_pair",
    "numbers",
    "pace",
    "paced",
    "plan_among",
    "planners",
    "remaining_path",
    "required_along",
    "required_at",
    "required_at_speeds",
    "requirement",
    "standing",
    "stop_walking",
    "swath",
    "torso_box",
    "touches",
    "violations",
    "walk",
    "walked",
    "walked_and_stood",
    "when",
    "within_bounds",
]
