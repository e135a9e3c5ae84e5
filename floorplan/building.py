"""Keys of a floorplan file in the YAML format, and the parts of a floor built from them."""

import math
from typing import Annotated, Any, Literal

from pydantic import (
    BeforeValidator,
    Field,
    ValidationInfo,
    field_validator,
    model_validator,
)
from pydantic_core import PydanticCustomError
from shapely.geometry import Polygon, box

from .files.fields import Angle, Flag, Number, Pair, Positive, Range, Strictly
from .files.problems import CALLED, UserError
from .model import (
    Axis,
    Concerns,
    Door,
    Gantry,
    Gate,
    Human,
    Lane,
    Name,
    Obstacle,
    SafeZone,
    Station,
    Zone,
)

Size = tuple[Positive, Positive]

Ring = Annotated[list[Pair], Field(min_length=3)]


class FootprintSchema(Strictly):
    """A footprint, in one of four forms."""

    x: Range | None = None
    y: Range | None = None
    center: Pair | None = None
    size: Size | None = None
    radius: Positive | None = None
    polygon: Ring | None = None
    holes: list[Ring] = []

    @model_validator(mode="after")
    def _one_footprint(self) -> "FootprintSchema":
        keys = ("x", "y", "center", "size", "radius", "polygon", "mask")
        given = {key for key in keys if getattr(self, key, None) is not None}
        forms = ({"x", "y"}, {"center", "size"}, {"center", "radius"}, {"polygon"}, {"mask"})
        if given not in forms:
            raise UserError(
                "give the footprint as x and y ranges, as center and size, as center and radius,"
                f" or as polygon; found {', '.join(sorted(given)) or 'none of them'}"
            )
        if self.holes and self.polygon is None:
            raise UserError("only a polygon has holes")
        return self


class ObstacleSchema(FootprintSchema):
    """A footprint and its heights."""

    z: Range

    def obstacle(self, name: str) -> Obstacle:
        """Return the obstacle called `name`."""
        return Obstacle(name=name, footprint=footprint(self), bottom=self.z[0], top=self.z[1])


class ZoneSchema(FootprintSchema):
    """An area, and the rule that holds in it for some."""

    mask: Name | None = None
    base: Number = 0.0
    multiplier: Number | None = None
    max_speed: Positive | None = None
    forbidden: Flag = Zone.forbidden
    one_way: Pair | None = None
    concerns: Concerns = Zone.concerns

    @model_validator(mode="after")
    def _one_rule(self) -> "ZoneSchema":
        if self.mask is not None:
            rules = [self.forbidden, self.max_speed is not None, self.multiplier is not None]
            if self.one_way is not None or sum(rules) > 1:
                raise UserError("a mask is forbidden, or give max_speed, or base and multiplier")
        elif self.multiplier is not None or self.base:
            raise UserError("base and multiplier belong to a mask")
        elif self.forbidden == (self.max_speed is not None or self.one_way is not None):
            raise UserError("give forbidden: true, or max_speed (m/s) and one_way (x, y)")
        return self


def _as_zone(value: Any) -> Any:
    return {"mask": value} if isinstance(value, str) else value


class LaneSchema(Strictly):
    """Keys of a single AGV. They take precedence over the keys that all AGVs share."""

    origin: Pair
    heading: Angle = 0.0
    start: str | None = None
    serves: dict[str, str] = {}
    size: Size | None = None
    height: Positive | None = None
    max_speed: Positive | None = None
    max_acceleration: Positive | None = None
    limits: Range | None = None
    locations: dict[str, Number] | None = None


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


METRE = {"m": 1.0, "cm": 0.01, "mm": 0.001, "in": 0.0254, "ft": 0.3048}
"""Length in metres of each unit that a file may give."""


def unit_name(metre: float) -> str:
    """Return the name of the unit of `metre` metres."""
    return next((name for name, length in METRE.items() if length == metre), f"{metre:g} m")


Unit = Literal["m", "cm", "mm", "in", "ft"]


class GroupSchema(Strictly):
    """The layers of one group of shapes, by patterns, and how they are drawn there."""

    layers: Annotated[list[Name], Field(min_length=1)]
    z: Range | None = None
    line_width: Positive | None = None
    hollow: Flag = False


def _as_group(value: Any) -> Any:
    return {"layers": value} if isinstance(value, list) else value


Group = Annotated[GroupSchema, BeforeValidator(_as_group)]
"""A group as keys, or only the list of its layers."""

OF_DRAWINGS = ("layers", "snap", "leave_out")
"""Keys of a floor that only say how the drawing below it is read."""

OF_BASES = (*OF_DRAWINGS, "remove", "move", "rename")
"""Keys of a floor that are about what lies below it."""


def _called(things: Any) -> Any:
    """Return the keys of things, each with the name that leads to them."""
    if not isinstance(things, dict):
        return things
    return {
        name: {**keys, CALLED: str(name)} if isinstance(keys, dict) else keys
        for name, keys in things.items()
    }


class FloorplanSchema(Strictly):
    """A whole floorplan file."""

    name: str | None = None
    title: str = ""
    source: str = ""
    base: Name | None = None
    units: Unit | None = None
    origin: Pair = (0.0, 0.0)
    rotation: Angle = 0.0
    layers: Annotated[dict[str, Group], Field(min_length=1)] | None = None
    snap: Positive | None = None
    leave_out: list[str] = []
    remove: list[str] = []
    move: dict[str, Pair] = {}
    rename: dict[str, Name] = {}
    boundary: Ring | None = Field(None, validate_default=True)
    holes: list[Ring] = []
    obstacles: dict[str, ObstacleSchema] = {}
    stations: dict[str, Pair] = {}
    patrol: list[str] | None = None
    safe_zone: SafeZone | None = None
    human: Human = Human()
    agvs: AgvsSchema | None = None
    gantry: GantrySchema | None = None
    doors: Annotated[dict[str, Door], BeforeValidator(_called)] = {}
    zones: dict[str, Annotated[ZoneSchema, BeforeValidator(_as_zone)]] = {}
    gates: Annotated[dict[str, Gate], BeforeValidator(_called)] = {}

    @field_validator("boundary")
    @classmethod
    def _there(cls, value: Any, info: ValidationInfo) -> Any:
        # Where `base` itself is unfit, it is not in the data.
        if value is None and info.data.get("base", "") is None:
            raise PydanticCustomError("missing", "is missing")
        return value

    @field_validator(*OF_BASES)
    @classmethod
    def _of_a_base(cls, value: Any, info: ValidationInfo) -> Any:
        if info.data.get("base", "") is None:
            raise UserError("belongs to a floor on top of another; give its base")
        return value

    @property
    def metre(self) -> float:
        """The length in metres of the unit of this file."""
        return METRE[self.units or "m"]


_CORNERS = 32
"""Corners of the polygon that stands for a disc."""


def parts(schema: FloorplanSchema) -> dict[str, Any]:
    """Return what stands on the floor of a file, by the names of a floor's fields."""
    agvs = schema.agvs
    return {
        "obstacles": [one.obstacle(name) for name, one in schema.obstacles.items()],
        "stations": [Station(name, at) for name, at in schema.stations.items()],
        "patrol": None if schema.patrol is None else tuple(schema.patrol),
        "safe_zone": schema.safe_zone,
        "human": schema.human,
        "lanes": [_lane(name, lane, agvs) for name, lane in agvs.lanes.items()] if agvs else (),
        "gantry": _gantry(schema.gantry) if schema.gantry else None,
        "doors": [*schema.doors.values()],
        "zones": [
            Zone(name=name, area=footprint(one), **{key: getattr(one, key) for key in _RULE})
            for name, one in schema.zones.items()
            if one.mask is None
        ],
        "gates": [*schema.gates.values()],
    }


_RULE = ("max_speed", "forbidden", "one_way", "concerns")
"""Keys of a zone that are not about its area."""


def _lane(name: str, lane: LaneSchema, agvs: AgvsSchema) -> Lane:
    keys = agvs.model_dump(exclude={"lanes"}) | lane.model_dump(exclude_none=True)
    length, width = keys.pop("size")
    keys["start"] = lane.start or agvs.start
    return Lane(name=name, length=length, width=width, **keys)


def _gantry(entry: GantrySchema) -> Gantry:
    return Gantry(
        x=_axis(entry.x),
        y=_axis(entry.y),
        rotation=_axis(entry.rotation),
        start=entry.start,
        torso=(*entry.torso.size, *entry.torso.z),
        arm_mount=entry.arm.mount,
        arm_reach=entry.arm.reach,
        arm_bottom=entry.arm.bottom,
        rail_height=entry.rail_height,
        tray_height=entry.tray_height,
    )


def footprint(entry: FootprintSchema) -> Polygon:
    """Return the polygon of a footprint."""
    if entry.polygon is not None:
        return Polygon(entry.polygon, entry.holes)
    if entry.x is not None and entry.y is not None:
        return box(entry.x[0], entry.y[0], entry.x[1], entry.y[1])
    assert entry.center is not None  # the schema has seen to it
    cx, cy = entry.center
    if entry.size is not None:
        half_x, half_y = entry.size[0] / 2, entry.size[1] / 2
        return box(cx - half_x, cy - half_y, cx + half_x, cy + half_y)
    assert entry.radius is not None
    return _round(cx, cy, entry.radius)


def _round(x: float, y: float, radius: float) -> Polygon:
    """Return the regular polygon around a disc: it covers all of the disc."""
    outer = radius / math.cos(math.pi / _CORNERS)
    angles = [2 * math.pi * (k + 0.5) / _CORNERS for k in range(_CORNERS)]
    return Polygon([(x + outer * math.cos(a), y + outer * math.sin(a)) for a in angles])


def _axis(entry: AxisSchema) -> Axis:
    low, high = entry.range
    return Axis(low=low, high=high, **entry.model_dump(exclude={"range"}))
