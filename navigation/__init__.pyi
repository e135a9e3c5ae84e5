"""The public names of `navigation`, each loaded with its module when it is first used."""

from .bodies import Disc
from .catalog import Path, PlannerError, PlanningError, planners
from .encounter import Box, Cylinder, Prism, Shapes
from .field_design import needed_fields
from .field_intrusions import FieldEntry, Intrusion, first_intrusion, intrusions
from .field_lengths import FieldSupplements, ShortField, short_fields, stopping_reach
from .fields import FieldGap, FieldSet, FieldSpan, ProtectiveFields
from .gantry_planner import GantryPath, GantryPlanner
from .kernels.encounter import Encounter
from .kernels.results import Enclosure
from .kernels.watch import Apart, Approaching, Condition, Moving, Overlapping, TooClose
from .machines import agv_run, agv_stop, gantry_move, gantry_stop
from .monitor import (
    first_time,
    first_violation,
    minimum_margin,
    minimum_separation,
    violations,
    when,
)
from .motion import Motion, Piece, join, standing
from .moving_obstacles import Mover, plan_among
from .planner import PathPlanner
from .separation import (
    ApproachLaw,
    FixedDistance,
    IntegralLaw,
    Law,
    MotionLaw,
    Scaled,
    SeparationLaw,
)
from .vehicle_planner import VehiclePath, VehiclePlanner
from .vehicles import (
    VehicleLimits,
    vehicle_path,
    vehicle_segment,
    vehicle_stop,
    vehicle_turn,
    vehicle_twist,
)
from .walking import remaining_path, stop_walking, walk
from .world import CollisionWorld

__all__ = [
    "Apart",
    "ApproachLaw",
    "Approaching",
    "Box",
    "CollisionWorld",
    "Condition",
    "Cylinder",
    "Disc",
    "Enclosure",
    "Encounter",
    "FieldEntry",
    "FieldGap",
    "FieldSet",
    "FieldSpan",
    "FieldSupplements",
    "FixedDistance",
    "GantryPath",
    "GantryPlanner",
    "IntegralLaw",
    "Intrusion",
    "Law",
    "Motion",
    "MotionLaw",
    "Mover",
    "Moving",
    "Overlapping",
    "Path",
    "PathPlanner",
    "Piece",
    "PlannerError",
    "PlanningError",
    "Prism",
    "ProtectiveFields",
    "Scaled",
    "SeparationLaw",
    "Shapes",
    "ShortField",
    "TooClose",
    "VehicleLimits",
    "VehiclePath",
    "VehiclePlanner",
    "agv_run",
    "agv_stop",
    "first_intrusion",
    "first_time",
    "first_violation",
    "gantry_move",
    "gantry_stop",
    "intrusions",
    "join",
    "minimum_margin",
    "minimum_separation",
    "needed_fields",
    "plan_among",
    "planners",
    "remaining_path",
    "short_fields",
    "standing",
    "stop_walking",
    "stopping_reach",
    "vehicle_path",
    "vehicle_segment",
    "vehicle_stop",
    "vehicle_turn",
    "vehicle_twist",
    "violations",
    "walk",
    "when",
]
