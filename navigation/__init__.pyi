"""The public names of `navigation`, each loaded with its module when it is first used."""

from .bodies import Disc as Disc
from .catalog import (
    Path as Path,
    PlannerError as PlannerError,
    PlanningError as PlanningError,
    planners as planners,
)
from .encounter import (
    Box as Box,
    Cylinder as Cylinder,
    Enclosure as Enclosure,
    Encounter as Encounter,
    Shapes as Shapes,
    agv_box as agv_box,
    folded_arm as folded_arm,
    torso_box as torso_box,
)
from .machines import (
    ARIAC_GANTRY as ARIAC_GANTRY,
    AxisState as AxisState,
    GantryLimits as GantryLimits,
    agv_run as agv_run,
    agv_stop as agv_stop,
    gantry_move as gantry_move,
    gantry_stop as gantry_stop,
    lane_state as lane_state,
    longest_stop as longest_stop,
)
from .monitor import (
    Apart as Apart,
    Approaching as Approaching,
    Both as Both,
    Condition as Condition,
    Moving as Moving,
    Not as Not,
    Overlapping as Overlapping,
    TooClose as TooClose,
    first_time as first_time,
    first_violation as first_violation,
    minimum_margin as minimum_margin,
    minimum_separation as minimum_separation,
    violations as violations,
    when as when,
)
from .motion import Motion as Motion, Piece as Piece, join as join, standing as standing
from .moving_obstacles import Mover as Mover, plan_among as plan_among
from .planner import (
    GantryPath as GantryPath,
    GantryPlanner as GantryPlanner,
    PathPlanner as PathPlanner,
)
from .separation import (
    ApproachLaw as ApproachLaw,
    FixedDistance as FixedDistance,
    IntegralLaw as IntegralLaw,
    Law as Law,
    MotionLaw as MotionLaw,
    Scaled as Scaled,
    SeparationLaw as SeparationLaw,
    required_at as required_at,
    required_at_speeds as required_at_speeds,
)
from .walking import remaining_path as remaining_path, stop_walking as stop_walking, walk as walk
from .world import CollisionWorld as CollisionWorld
