"""Keys and values of trial files of the ARIAC competition (2023)."""

import math
import re
from typing import Annotated, Any, Literal

from pydantic import AfterValidator, BeforeValidator, Field, Strict, model_validator

from floorplan import UserError
from floorplan.files.fields import (
    LARGEST,
    Flag,
    NotNegative,
    Number,
    Positive,
    is_figure,
    whole,
)
from floorplan.files.models import Strictly
from floorplan.files.problems import shown

Text = Annotated[str, BeforeValidator(lambda v: str(v) if type(v) is int else v)]
"""Text that may look like a number: an order's id."""

Whole = Annotated[int, whole()]
Slot = Annotated[int, whole(1, 9)]
TraySlot = Annotated[int, whole(1, 6)]
TrayId = Annotated[int, whole(0, 9)]
Quadrant = Annotated[int, whole(1, 4)]
Offset = Annotated[float, Strict(), Field(ge=-1, le=1)]
Type = Literal["battery", "pump", "regulator", "sensor"]
Color = Literal["blue", "green", "orange", "purple", "red"]
Robot = Literal["ceiling_robot", "floor_robot"]
Sensor = Literal["break_beam", "proximity", "laser_profiler", "lidar", "camera", "logical_camera"]
SEE_PEOPLE = frozenset(("lidar", "camera", "logical_camera"))
"""Sensors that detect people."""

MOST_PARTS = 1000
"""Maximum number of parts of one kind on a conveyor."""

Vector = tuple[Number, Number, Number]


def _angle(value: object) -> object:
    if isinstance(value, bool) or not isinstance(value, int | float | str):
        raise UserError("expected radians, as a number or as text like 'pi/2'")
    radians = angle(value)
    if radians is not None and not is_figure(radians):
        raise UserError(f"expected radians, from -{LARGEST:g} to {LARGEST:g}, found {shown(value)}")
    return value


Angle = Annotated[Any, AfterValidator(_angle)]
"""Radians as a number, or as text such as 'pi/2' for `angle`."""

_ANGLE = r"(-?)\s*(?:(\d+(?:\.\d+)?)\s*\*?\s*)?pi(?:\s*/\s*(\d+(?:\.\d+)?))?"


def angle(value: float | str) -> float | None:
    """Return an angle in radians, or None for an invalid text."""
    if not isinstance(value, str):
        return value
    match = re.fullmatch(_ANGLE, value.strip())
    if match is not None:
        sign, factor, divisor = match.groups()
        size = math.pi * float(factor or 1.0) / (float(divisor or 1.0) or math.nan)
        return -size if sign else size
    try:
        return float(value)
    except ValueError:
        return None


def _limit(seconds: float) -> float:
    if seconds != -1 and seconds <= 0:
        raise UserError(f"expected -1 (no limit) or seconds, more than 0, found {seconds:g}")
    return seconds


TimeLimit = Annotated[Number, AfterValidator(_limit)]


class KittingTrays(Strictly):
    """Trays and their slots on the tray tables."""

    tray_ids: list[TrayId] = []
    slots: list[TraySlot] = []


class PartKeys(Strictly):
    """A kind of part."""

    type: Type
    color: Color


class Lot(PartKeys):
    """Parts of one kind in slots of a bin."""

    slots: list[Slot]
    rotation: Angle = 0.0
    flipped: Flag = False
    faulty: list[Slot] = []


class KitProduct(PartKeys):
    """A part of a kit."""

    quadrant: Quadrant


class AgvPart(KitProduct):
    """A part on an AGV."""

    rotation: Angle = 0.0
    flipped: Flag = False


class AgvLoad(Strictly):
    """Load of an AGV."""

    tray_id: TrayId = 0
    parts: list[AgvPart] | None = []


class ConveyorPart(PartKeys):
    """Parts of one kind on the conveyor."""

    number: Annotated[int, whole(0, MOST_PARTS)]
    offset: Offset = 0.0
    flipped: Flag = False
    rotation: Angle = 0.0


class ConveyorBelt(Strictly):
    """Parts on the conveyor."""

    active: Flag = False
    spawn_rate: Positive = 1.0
    order: Literal["sequential", "random"] = "sequential"
    parts_to_spawn: list[ConveyorPart] | None = []


class Parts(Strictly):
    """Parts and their places."""

    bins: dict[str, list[Lot] | None] | None = {}
    agvs: dict[str, AgvLoad | None] | None = {}
    conveyor_belt: ConveyorBelt | None = None


class PartPlace(PartKeys):
    """Condition: a part is placed on an AGV."""

    agv: Whole | None = None


class Submission(Strictly):
    """Condition: an order is submitted."""

    order_id: Text


class StartCondition(Strictly):
    """Start condition: one of the three."""

    time_condition: NotNegative | None = None
    part_place_condition: PartPlace | None = None
    submission_condition: Submission | None = None

    @model_validator(mode="after")
    def _one_of_them(self) -> "StartCondition":
        conditions = [self.time_condition, self.part_place_condition, self.submission_condition]
        if sum(condition is not None for condition in conditions) != 1:
            raise UserError(
                "give one of time_condition, part_place_condition, submission_condition"
            )
        return self


class HumanChallenge(StartCondition):
    """A person on the floor."""

    behavior: Literal["indifferent", "antagonistic", "helpful"]


class MalfunctionChallenge(StartCondition):
    """Robots that are disabled for a time."""

    duration: Positive
    robots_to_disable: list[Robot]


class BlackoutChallenge(StartCondition):
    """Sensors that are blind for a time."""

    duration: NotNegative
    sensors_to_disable: list[Sensor]

    @property
    def is_of_people(self) -> bool:
        """True if one of the sensors detects people. The others detect parts."""
        return not SEE_PEOPLE.isdisjoint(self.sensors_to_disable)


class FaultyPartChallenge(Strictly):
    """The first parts in these quadrants are faulty."""

    order_id: Text
    quadrant1: Flag = False
    quadrant2: Flag = False
    quadrant3: Flag = False
    quadrant4: Flag = False


class DroppedPartChallenge(Strictly):
    """A gripper that loses a part."""

    robot: Robot
    type: Type
    color: Color
    drop_after: Annotated[int, whole(0)]
    delay: NotNegative


class Challenge(Strictly):
    """One challenge, whose kind is its key."""

    human: HumanChallenge | None = None
    human_operator: HumanChallenge | None = None
    robot_malfunction: MalfunctionChallenge | None = None
    sensor_blackout: BlackoutChallenge | None = None
    faulty_part: FaultyPartChallenge | None = None
    dropped_part: DroppedPartChallenge | None = None

    @model_validator(mode="after")
    def _one_kind(self) -> "Challenge":
        if len(self.model_fields_set) != 1 or getattr(self, self.kind) is None:
            raise UserError(
                f"a challenge has one of the keys {', '.join(type(self).model_fields)},"
                " and its figures, indented, below"
            )
        return self

    @property
    def kind(self) -> str:
        """Key of the challenge."""
        return min(self.model_fields_set, default="human")


class InsertPose(Strictly):
    """Pose of a part in the insert: metres, and roll, pitch, yaw."""

    xyz: Vector
    rpy: tuple[Angle, Angle, Angle]


class AssemblyProduct(PartKeys):
    """A part to be inserted."""

    assembled_pose: InsertPose | None = None
    assembly_direction: Vector | None = None


class Kitting(Strictly):
    """A kitting task."""

    agv_number: Whole
    tray_id: TrayId
    destination: str
    products: Annotated[list[KitProduct], Field(min_length=1)]


class Assembly(Strictly):
    """An assembly task."""

    agv_number: list[Whole]
    station: str
    products: Annotated[list[AssemblyProduct], Field(min_length=1)]


class Combined(Strictly):
    """A combined task."""

    station: str
    products: Annotated[list[AssemblyProduct], Field(min_length=1)]


class OrderEntry(Strictly):
    """An order."""

    id: Text
    type: Literal["kitting", "assembly", "combined"]
    announcement: StartCondition
    priority: Flag = False
    kitting_task: Kitting | None = None
    assembly_task: Assembly | None = None
    combined_task: Combined | None = None

    @model_validator(mode="after")
    def _its_task(self) -> "OrderEntry":
        keys = ("kitting_task", "assembly_task", "combined_task")
        if [key for key in keys if getattr(self, key) is not None] != [f"{self.type}_task"]:
            raise UserError(f"an order of the type {self.type} has a {self.type}_task, no other")
        return self


class AriacTrialFile(Strictly):
    """A whole trial file. `assembly_inserts` is a key since ARIAC 2024."""

    time_limit: TimeLimit = -1.0
    kitting_trays: KittingTrays | None = None
    assembly_inserts: dict[str, Angle] | None = None
    parts: Parts | None = None
    challenges: list[Challenge] | None = None
    orders: Annotated[list[OrderEntry], Field(min_length=1)]
