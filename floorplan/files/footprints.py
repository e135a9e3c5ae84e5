"""Shapes in a floorplan file: fields of a floor that are given by several keys, or by one pair."""

import math
from dataclasses import make_dataclass
from typing import Annotated, Any

from pydantic import model_validator
from shapely.geometry import Polygon, box
from typing_extensions import Self

from .dataclass import dataclass
from .fields import Constrained, Pair, Positive, Range
from .forms import KEYS, Alias, Composed, Data, plain
from .problems import UserError

Size = tuple[Positive, Positive]

Ring = Annotated[list[Pair], Constrained(min_length=3)]

_CORNERS = 32
"""Number of corners of the polygon that replaces a disc."""


@dataclass(frozen=True, kw_only=True)
class FootprintKeys:
    """Keys of a footprint, in one of four forms."""

    __pydantic_config__ = KEYS

    x: Range | None = None
    y: Range | None = None
    center: Pair | None = None
    size: Size | None = None
    radius: Positive | None = None
    polygon: Ring | None = None
    holes: tuple[Ring, ...] = ()

    @model_validator(mode="after")
    def _one_footprint(self) -> Self:
        keys = ("x", "y", "center", "size", "radius", "polygon")
        present = {key for key in keys if getattr(self, key) is not None}
        if present not in ({"x", "y"}, {"center", "size"}, {"center", "radius"}, {"polygon"}):
            raise UserError(
                "give the footprint as x and y ranges, as center and size, as center and radius,"
                f" or as polygon; found {', '.join(sorted(present)) or 'none of them'}"
            )
        if self.holes and self.polygon is None:
            raise UserError("only a polygon has holes")
        return self

    def shape(self) -> Polygon:
        """Return the polygon of the footprint."""
        if self.polygon is not None:
            return Polygon(self.polygon, self.holes)
        if self.x is not None and self.y is not None:
            return box(self.x[0], self.y[0], self.x[1], self.y[1])
        assert self.center is not None
        cx, cy = self.center
        if self.size is not None:
            half_x, half_y = self.size[0] / 2, self.size[1] / 2
            return box(cx - half_x, cy - half_y, cx + half_x, cy + half_y)
        assert self.radius is not None
        return _round(cx, cy, self.radius)


def _round(x: float, y: float, radius: float) -> Polygon:
    """Return the regular polygon around a disc, so that it covers the disc."""
    outer = radius / math.cos(math.pi / _CORNERS)
    angles = [2 * math.pi * (k + 0.5) / _CORNERS for k in range(_CORNERS)]
    return Polygon([(x + outer * math.cos(a), y + outer * math.sin(a)) for a in angles])


def footprint_keys(footprint: Polygon) -> dict[str, Any]:
    """Return the keys of a footprint: ranges of a rectangle along the axes, otherwise corners."""
    west, south, east, north = footprint.bounds
    if footprint == box(west, south, east, north):
        return {"x": [west, east], "y": [south, north]}
    holes = [ring_keys(ring) for ring in footprint.interiors]
    return {"polygon": ring_keys(footprint.exterior), **({"holes": holes} if holes else {})}


def ring_keys(ring: Any) -> list[list[float]]:
    """Return the corners of a ring (x, y in metres) without the repeated first one."""
    return [plain(at[:2]) for at in ring.coords[:-1]]


Footprint = Annotated[
    Polygon,
    Alias("\0footprint"),
    Composed(FootprintKeys, FootprintKeys.shape, lambda owner: footprint_keys(owner.footprint)),
]
"""Footprint of an obstacle (metres)."""

Area = Annotated[
    Polygon,
    Alias("\0area"),
    Composed(FootprintKeys, FootprintKeys.shape, lambda owner: footprint_keys(owner.area)),
]
"""Area of a zone (metres)."""


def _one_key(key: str, kind: Any) -> type:
    """Return a form with one key."""
    return make_dataclass("OneKey", [(key, kind)], namespace={"__pydantic_config__": KEYS})


def _of_pair(key: str, kind: Any, names: tuple[str, str]) -> tuple[Composed, Composed]:
    """Return the annotations of two fields that are given together by a `key`."""
    form = _one_key(key, kind)

    def written(owner: Any) -> Data:
        return {key: plain([getattr(owner, name) for name in names])}

    def end(k: int) -> Composed:
        return Composed(form, lambda keys: getattr(keys, key)[k], written)

    return end(0), end(1)


_BOTTOM, _TOP = _of_pair("z", Range, ("bottom", "top"))

Bottom = Annotated[float, Alias("\0bottom"), _BOTTOM]
Top = Annotated[float, Alias("\0top"), _TOP]

_LOW, _HIGH = _of_pair("range", Range, ("low", "high"))

Low = Annotated[float, Alias("\0low"), _LOW]
High = Annotated[float, Alias("\0high"), _HIGH]

_LENGTH, _WIDTH = _of_pair("size", Size, ("length", "width"))

Length = Annotated[Positive, Alias("\0length"), _LENGTH]
Width = Annotated[Positive, Alias("\0width"), _WIDTH]


@dataclass(frozen=True, kw_only=True)
class TorsoBox:
    """Box around the gantry's axis."""

    __pydantic_config__ = KEYS

    size: Size
    z: Range


@dataclass(frozen=True, kw_only=True)
class ArmEnvelope:
    """Envelope of the gantry's folded arm."""

    __pydantic_config__ = KEYS

    mount: Pair
    reach: Positive
    bottom: Positive


_TORSO, _ARM = _one_key("torso", TorsoBox), _one_key("arm", ArmEnvelope)


def _torso_keys(gantry: Any) -> Data:
    length, width, bottom, top = gantry.torso
    return {"torso": {"size": plain((length, width)), "z": plain((bottom, top))}}


def _arm_keys(gantry: Any) -> Data:
    mount, reach, bottom = gantry.arm_mount, gantry.arm_reach, gantry.arm_bottom
    return {"arm": {"mount": plain(mount), "reach": plain(reach), "bottom": plain(bottom)}}


Torso = Annotated[
    tuple[float, float, float, float],
    Alias("\0torso"),
    Composed(_TORSO, lambda keys: (*keys.torso.size, *keys.torso.z), _torso_keys),
]
ArmMount = Annotated[
    tuple[float, float],
    Alias("\0arm_mount"),
    Composed(_ARM, lambda keys: keys.arm.mount, _arm_keys),
]
ArmReach = Annotated[
    Positive,
    Alias("\0arm_reach"),
    Composed(_ARM, lambda keys: keys.arm.reach, _arm_keys),
]
ArmBottom = Annotated[
    Positive,
    Alias("\0arm_bottom"),
    Composed(_ARM, lambda keys: keys.arm.bottom, _arm_keys),
]
