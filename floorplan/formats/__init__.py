"""Formats of floors: suffixes of files, readers and writers, and parts that files cannot hold.

Readers and writers are imported when they are used, because most runs need one of them.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import field
from importlib import import_module
from typing import Any

from ..files.dataclass import dataclass
from ..model import Floor, Human

_Parts = Mapping[str, Callable[[Floor], object]]

_BEYOND_SHAPES: _Parts = {
    "AGVs": lambda plan: plan.lanes,
    "the gantry": lambda plan: plan.gantry is not None,
    "the patrol": lambda plan: plan.patrol is not None,
    "measures of people": lambda plan: plan.human != Human(),
    "doors": lambda plan: plan.doors,
    "zones": lambda plan: plan.zones,
    "one-way gates": lambda plan: plan.gates,
}
"""Functions that return whether a floor has a part, by the name of the part."""

_BEYOND_ITS_AREA: _Parts = {
    **_BEYOND_SHAPES,
    "names and heights of obstacles": lambda plan: plan.obstacles,
    "stations": lambda plan: plan.stations,
    "the safe zone": lambda plan: plan.safe_zone is not None,
}


@dataclass(frozen=True, kw_only=True)
class FloorFormat:
    """Format of floors, with the suffixes of its files."""

    suffixes: tuple[str, ...]
    reader: str = ""
    """Function that reads a drawing at a path. `loading` distinguishes YAML files."""
    writer: str = ""
    """Function that writes a floor to a path."""
    has_layers: bool = False
    left_out: _Parts = field(default_factory=dict)
    """Parts of a floor that its files cannot hold."""

    def lost(self, plan: Floor) -> list[str]:
        """Return the parts of `plan` that files of this format cannot hold."""
        return [part for part, has in self.left_out.items() if has(plan)]


FORMATS = (
    FloorFormat(suffixes=(".yaml", ".yml"), writer="plan.write_yaml"),
    FloorFormat(suffixes=(".dxf",), reader="formats.dxf.load_dxf", has_layers=True),
    FloorFormat(
        suffixes=(".geojson", ".json"),
        reader="formats.geojson.load_geojson",
        writer="formats.geojson.write_geojson",
        has_layers=True,
        left_out=_BEYOND_SHAPES,
    ),
    FloorFormat(
        suffixes=(".wkt",),
        reader="formats.wkt.load_wkt",
        writer="formats.wkt.write_wkt",
        left_out=_BEYOND_ITS_AREA,
    ),
    FloorFormat(suffixes=(".map",), reader="formats.movingai.load_drawn_map"),
    FloorFormat(suffixes=(".pgm",), writer="formats.ros_map.write_map", left_out=_BEYOND_ITS_AREA),
)
"""All formats. A ROS map is listed with the suffix of its image."""

YAML, ROS_MAP = FORMATS[0], FORMATS[-1]

OF_SUFFIX = {suffix: one for one in FORMATS for suffix in one.suffixes}
"""Formats by the suffixes of their files."""

READ = tuple(suffix for suffix, one in OF_SUFFIX.items() if one.reader or one is YAML)
WRITTEN = tuple(suffix for suffix, one in OF_SUFFIX.items() if one.writer)
LAYERED = tuple(suffix for suffix, one in OF_SUFFIX.items() if one.has_layers)
"""Suffixes of files that are read, that are written, and that have layers."""


def function(name: str) -> Any:
    """Return the reader or writer of this name."""
    module, _, function_name = name.rpartition(".")
    return getattr(import_module(f"floorplan.{module}"), function_name)
