"""Keys of a floorplan file in the YAML format, and the parts of a floor built from them."""

from typing import Annotated, Any, Literal

from pydantic import (
    BeforeValidator,
    Field,
    TypeAdapter,
    ValidationInfo,
    create_model,
    field_validator,
    model_validator,
)
from pydantic_core import PydanticCustomError
from typing_extensions import Self

from .files.fields import Angle, Flag, Number, Pair, Position, Positive, Range
from .files.footprints import FootprintKeys, Ring
from .files.forms import CALLED, Tagged, Written, called, fields_of, form_keys
from .files.models import Strictly
from .files.problems import UserError
from .model import (
    OF_ONE_LANE,
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


class MaskKeys(Strictly):
    """A map of zones, and their speeds by the values of its cells."""

    name: Annotated[str, Field(alias=CALLED)] = ""
    mask: Name
    base: Number = 0.0
    multiplier: Number | None = None

    @model_validator(mode="after")
    def _one_rule(self) -> Self:
        rule = self.rule
        limits = [rule["forbidden"], rule["max_speed"] is not None, self.multiplier is not None]
        if rule["one_way"] is not None or sum(limits) > 1:
            raise UserError("a mask is forbidden, or give max_speed, or base and multiplier")
        return self

    @property
    def rule(self) -> dict[str, Any]:
        """Fields of the zones that are the same for all."""
        return {key: getattr(self, key) for key in _RULE}


_RULE: dict[str, Any] = {
    key.name: (key.kind, key.default)
    for key in fields_of(Zone)
    if key.composed is None and key.name != CALLED
}

MaskForm = create_model("MaskForm", __base__=MaskKeys, **_RULE)
"""Keys of a mask, and those of a zone without its area."""


_SHAPE = {key for key, _ in form_keys(FootprintKeys)}


def _as_zone(value: Any) -> Any:
    keys = {"mask": value} if isinstance(value, str) else value
    if isinstance(keys, dict) and "mask" not in keys and keys.keys() & {"base", "multiplier"}:
        raise UserError("base and multiplier belong to a mask")
    if isinstance(keys, dict) and "mask" in keys and (shape := keys.keys() & _SHAPE):
        raise UserError(f"a mask has the footprints of its zones; omit {', '.join(sorted(shape))}")
    return keys


def _tag(keys: Any) -> str:
    """Return whether the keys are those of a mask or a zone, by a word that is none of them."""
    return "\0mask" if isinstance(keys, dict) and "mask" in keys else "\0zone"


_ZoneOrMask = Annotated[
    Zone | MaskKeys,
    Tagged(_tag, {"\0zone": Zone, "\0mask": MaskForm}),
    BeforeValidator(_as_zone),
]


_LANE_KEYS: dict[str, Any] = dict(form_keys(Lane))

_OWN_KEYS: dict[str, Any] = {
    key: (kind, OF_ONE_LANE[key]) if key in OF_ONE_LANE else (kind | None, None)
    for key, kind in _LANE_KEYS.items()
}
_LaneForm: Any = create_model("LaneForm", __base__=Strictly, **_OWN_KEYS)

_SHARED_KEYS: dict[str, Any] = {
    key: (kind, ...) for key, kind in _LANE_KEYS.items() if key not in OF_ONE_LANE
}
AgvsForm = create_model(
    "AgvsForm", __base__=Strictly, **_SHARED_KEYS, lanes=(dict[str, _LaneForm], ...)
)
"""Keys that all AGVs share, and those of the lane of each, which take precedence."""


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
    obstacles: Annotated[dict[str, Obstacle], BeforeValidator(called)] = {}
    stations: dict[str, Position] = {}
    patrol: list[str] | None = None
    safe_zone: SafeZone | None = None
    human: Human = Human()
    agvs: Annotated[Any, Written(AgvsForm | None)] = None
    gantry: Gantry | None = None
    doors: Annotated[dict[str, Door], BeforeValidator(called)] = {}
    zones: Annotated[dict[str, _ZoneOrMask], BeforeValidator(called)] = {}
    gates: Annotated[dict[str, Gate], BeforeValidator(called)] = {}

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


def parts(schema: FloorplanSchema) -> dict[str, Any]:
    """Return the contents of a floor by the names of its fields."""
    return {
        "obstacles": [*schema.obstacles.values()],
        "stations": [Station(name, at) for name, at in schema.stations.items()],
        "patrol": None if schema.patrol is None else tuple(schema.patrol),
        "safe_zone": schema.safe_zone,
        "human": schema.human,
        "lanes": () if schema.agvs is None else _lanes(schema.agvs),
        "gantry": schema.gantry,
        "doors": [*schema.doors.values()],
        "zones": [zone for zone in schema.zones.values() if isinstance(zone, Zone)],
        "gates": [*schema.gates.values()],
    }


def _lanes(agvs: Any) -> list[Lane]:
    shared = agvs.model_dump(exclude={"lanes"})
    lanes = {name: shared | own.model_dump(exclude_none=True) for name, own in agvs.lanes.items()}
    return [*map(TypeAdapter(Lane).validate_python, called(lanes).values())]
