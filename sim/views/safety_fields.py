"""Protective fields in safety reports: field sets of machines, lengths and supervision."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from typing import Any

from shapely.geometry import Polygon

from floorplan.files.dataclass import dataclass
from navigation import FieldSet, ShortField, VehicleLimits, short_fields
from navigation.machines import AxisLimits

from ..core.body import MachineShape
from ..core.fields import MachineFields, Muting
from ..core.recorder import Scene
from ..core.schedule import as_given
from ..core.stage import MachineModel
from ..core.wording import listed, minus

Row = tuple[str, ...]

HEADS = (
    "set",
    "speed, m/s",
    "turn rate, rad/s",
    "direction, °",
    "load",
    "ahead, m",
    "behind, m",
    "beside, m",
    "warning, m",
    "too short",
)
"""Columns of the table of field sets."""

NOT_CHECKED = "not checked"


@dataclass(frozen=True)
class FieldTable:
    """Fields of the `machines` that share them: `facts`, and the field sets as a table."""

    machines: str
    facts: tuple[tuple[str, str], ...]
    heads: Row
    rows: tuple[Row, ...]
    figures: tuple[int, ...]


def field_tables(scene: Scene, models: Mapping[str, MachineModel] | None) -> list[FieldTable]:
    """Return the fields of the machines of a scene, one table for those with the same fields.

    `models` are the machines of the trial, or None for a recording, whose fields cannot be checked.
    """
    tables: dict[tuple[tuple[tuple[str, str], ...], tuple[Row, ...]], list[str]] = {}
    checked: dict[Any, tuple[ShortField, ...] | None] = {}
    for machine in scene.machines:
        if machine.name in scene.fields:
            fields = scene.fields[machine.name]
            model = None if models is None else models.get(machine.name)
            limits = None if model is None else model.field_limits(scene.floorplan)
            footprint = machine.footprint((0.0, 0.0), 0.0)
            alike = fields.protective, footprint.wkb, limits
            if alike not in checked:
                checked[alike] = _short(fields, footprint, limits)
            short = checked[alike]
            key = (tuple(_facts(fields)), tuple(_rows(fields, machine, short)))
            tables.setdefault(key, []).append(machine.name)
    return [_table(listed(names), *key) for key, names in tables.items()]


def _table(machines: str, facts: tuple[tuple[str, str], ...], rows: tuple[Row, ...]) -> FieldTable:
    """Return a table without its empty columns."""
    used = [k for k in range(len(HEADS)) if {row[k] for row in rows} != {"–"}]
    heads = tuple(HEADS[k] for k in used)
    figures = tuple(i for i, k in enumerate(used) if HEADS[k].endswith(", m"))
    shown = tuple(tuple(row[k] for k in used) for row in rows)
    return FieldTable(machines, facts, heads, shown, figures)


def _short(
    fields: MachineFields, footprint: Polygon, limits: VehicleLimits | AxisLimits | None
) -> tuple[ShortField, ...] | None:
    """Return the sets that are too short, or None if the limits of the machine are unknown."""
    return None if limits is None else short_fields(fields.protective, footprint, limits)


def _facts(fields: MachineFields) -> Iterator[tuple[str, str]]:
    yield "response time", f"{fields.response_time:g} s, from the intrusion to the begin of braking"
    yield "restart", f"when the fields have been free for {fields.restart_delay:g} s"
    if any(one.warning for one in fields.sets):
        yield "warning field", f"slows the machine to {fields.warning_speed:g} m/s"
    yield "muting", _muting(fields.muting)


def _muting(muting: Muting) -> str:
    parts = []
    if muting.zones:
        parts.append(f"in {', '.join(muting.zones)}")
    parts += [f"from {as_given(begin)} to {as_given(end)} s" for begin, end in muting.times]
    return "; ".join(parts) or "never"


def _rows(
    fields: MachineFields, machine: MachineShape, short: tuple[ShortField, ...] | None
) -> Iterator[Row]:
    west, south, east, north = machine.footprint((0.0, 0.0), 0.0).bounds
    for one in fields.sets:
        x, y = zip(*one.protective, strict=True)
        along = [x for x, _ in one.warning]
        warned = f"{max(max(along) - east, west - min(along)):.2f}" if along else "–"
        yield (
            one.name,
            _range(one.linear),
            _range(one.theta),
            "–" if one.direction is None else _range(tuple(map(math.degrees, one.direction))),
            {None: "–", True: "loaded", False: "not loaded"}[one.load],
            f"{max(x) - east:.2f}",
            f"{west - min(x):.2f}",
            f"{min(max(y) - north, south - min(y)):.2f}",
            warned,
            NOT_CHECKED if short is None else _missing(one, short),
        )


def _missing(one: FieldSet, short: tuple[ShortField, ...]) -> str:
    """Return the missing length of a field set in words."""
    mine = [f"{each.missing:.2f} m {each.travel}" for each in short if each.set == one.name]
    return ", ".join(mine) or "no"


def _range(values: tuple[float, ...]) -> str:
    low, high = values
    if not (math.isfinite(low) or math.isfinite(high)):
        return "any"
    return minus(f"{low:.3g} … {high:.3g}").replace("inf", "∞")
