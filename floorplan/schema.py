"""The keys and values of a floorplan file in Floorwalker's own YAML format."""

from __future__ import annotations

import math
from typing import Annotated

from pydantic import AfterValidator, BaseModel, ConfigDict, Field, Strict, model_validator

from .checks import LARGEST, size_fault


def _checked_size(value: float) -> float:
    if fault := size_fault(value):
        raise ValueError(fault)
    return value


Number = Annotated[float, Strict(), Field(ge=-LARGEST, le=LARGEST, allow_inf_nan=False)]
"""A field of a file: a number from -1e9 to 1e9."""

Positive = Annotated[
    float, Strict(), Field(gt=0, le=LARGEST, allow_inf_nan=False), AfterValidator(_checked_size)
]
"""A field of a file: a number from 1e-6 to 1e9."""

NotNegative = Annotated[float, Strict(), Field(ge=0, le=LARGEST, allow_inf_nan=False)]
"""A field of a file: a number from 0 to 1e9."""

Pair = tuple[Number, Number]
"""A field of a file: two numbers from -1e9 to 1e9."""

Size = tuple[Positive, Positive]


def _rising(pair: tuple[float, float]) -> tuple[float, float]:
    if pair[0] >= pair[1]:
        raise ValueError(f"must be [low, high] with low < high, found {list(pair)}")
    return pair


Range = Annotated[Pair, AfterValidator(_rising)]
"""A field of a file: [low, high] with low < high, from -1e9 to 1e9."""


class Strictly(BaseModel):
    """A part of a file in which unknown keys are refused."""

    model_config = ConfigDict(extra="forbid", frozen=True, str_strip_whitespace=True)


class ObstacleSchema(Strictly):
    """A footprint, in one of four forms, and its heights."""

    z: Range
    x: Range | None = None
    y: Range | None = None
    center: Pair | None = None
    size: Size | None = None
    radius: Positive | None = None
    polygon: Annotated[list[Pair], Field(min_length=3)] | None = None

    @model_validator(mode="after")
    def _one_footprint(self) -> ObstacleSchema:
        keys = ("x", "y", "center", "size", "radius", "polygon")
        given = {key for key in keys if getattr(self, key) is not None}
        if given not in ({"x", "y"}, {"center", "size"}, {"center", "radius"}, {"polygon"}):
            raise ValueError(
                "give the footprint as x and y ranges, as center and size, as center and radius,"
                f" or as polygon; found {', '.join(sorted(given)) or 'none of them'}"
            )
        return self


class HumanSchema(Strictly):
    """The measures of people."""

    radius: Positive = 0.3
    height: Positive = 1.75
    max_speed: Positive = 1.0
    max_acceleration: Positive = 2.5
    goal_tolerance: Positive = 0.25


class SafeZoneSchema(Strictly):
    """Start of people."""

    at: Pair
    heading: Number = 0.0


class LaneSchema(Strictly):
    """Keys of a single AGV."""

    origin: Pair
    heading: Number = 0.0
    start: str | None = None
    serves: dict[str, str] = {}


class AgvsSchema(Strictly):
    """Keys that all AGVs share, and the lane of each."""

    size: Size
    height: Positive
    max_speed: Positive
    max_acceleration: Positive
    limits: Range
    locations: dict[str, Number]
    start: str
    lanes: dict[str, LaneSchema]


class AxisSchema(Strictly):
    """One axis of the gantry."""

    range: Range
    max_speed: Positive
    max_acceleration: Positive
    max_jerk: Positive = 2.0


class TorsoSchema(Strictly):
    """The box around the gantry's axis."""

    size: Size
    z: Range


class ArmSchema(Strictly):
    """The folded arm's envelope."""

    mount: Pair
    reach: Positive
    bottom: Positive


class GantrySchema(Strictly):
    """The overhead robot."""

    x: AxisSchema
    y: AxisSchema
    rotation: AxisSchema = AxisSchema(
        range=(-2 * math.pi, 2 * math.pi), max_speed=math.pi / 4, max_acceleration=0.5
    )
    start: tuple[Number, Number, Number]
    torso: TorsoSchema
    arm: ArmSchema
    rail_height: Positive
    tray_height: Positive


class FloorplanSchema(Strictly):
    """A whole floorplan file."""

    name: str | None = None
    title: str = ""
    source: str = ""
    boundary: Annotated[list[Pair], Field(min_length=3)]
    obstacles: dict[str, ObstacleSchema] = {}
    stations: dict[str, Pair] = {}
    patrol: list[str] | None = None
    safe_zone: SafeZoneSchema | None = None
    human: HumanSchema = HumanSchema()
    agvs: AgvsSchema | None = None
    gantry: GantrySchema | None = None
