"""Faults and likely mistakes of the protective fields of a trial."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace
from typing import NamedTuple

from shapely.geometry import Polygon

from floorplan import UserError
from floorplan.files.problems import Fault
from navigation import FieldGap, ProtectiveFields, VehicleLimits, short_fields
from navigation.field_lengths import directions, limits_along, velocities
from navigation.machines import AxisLimits

from ..core.fields import MachineFields
from ..core.scenario import Scenario
from ..core.stage import MachineModel
from ..machines.kinds import models_of
from .names import machines, name_faults, zones

Range = tuple[float, float]

AT_REST = (0.0, 0.0)

SLIGHT = 1e-6
"""Metres. Tolerance within which a warning field contains the protective field."""


def field_faults(trial: Scenario) -> Iterator[Fault]:
    """Yield the faults of the protective fields of a trial."""
    for name, fields in trial.fields.items():
        yield from name_faults(name, "machine", machines(trial), name)
        for message, place in _set_faults(fields):
            yield message, (name, *place)
        for k, zone in enumerate(fields.muting.zones):
            yield from name_faults(zone, "zone", zones(trial), name, "muting", "zones", k)


def _set_faults(fields: MachineFields) -> Iterator[Fault]:
    """Yield the faults of the field sets and of the times of muting."""
    try:
        fields.protective  # noqa: B018 - refuses sets that don't fit together
    except UserError as why:
        yield str(why), ("sets",)
    for k, one in enumerate(fields.sets):
        inner, outer = Polygon(one.protective), Polygon(one.warning)
        if one.warning and not outer.buffer(SLIGHT).covers(inner):
            message = "does not contain the protective field; it must, to slow first"
            yield message, ("sets", k, "warning")
    for k, (begin, end) in enumerate(fields.muting.times):
        if begin >= end:
            yield f"ends before it begins: {begin:g} to {end:g} s", ("muting", "times", k)


def field_slips(trial: Scenario) -> Iterator[Fault]:
    """Yield why protective fields may not protect, or stop a machine without a person.

    Custom kinds of machines are skipped, because their code is not run for checks.
    """
    models = models_of(trial, own=False) if trial.fields else {}
    for name, fields in trial.fields.items():
        if name not in models or (limits := models[name].field_limits(trial.floorplan)) is None:
            continue
        model, shape = models[name], models[name].shape(name, trial.floorplan)
        # A gantry drives along the axes of the floor, so that its heading may be any diagonal.
        top = shape.top_speed if model.category == "robot" else None
        machine = _Machine(model, limits, shape.footprint((0.0, 0.0), 0.0), top)
        for message, place in (*machine.gaps(fields), *machine.faulty_sets(fields)):
            yield message, (name, "sets", *place)


class _Machine(NamedTuple):
    """Machine with fields. `diagonal` is its top speed (m/s) if it is omnidirectional."""

    model: MachineModel
    limits: VehicleLimits | AxisLimits
    footprint: Polygon
    diagonal: float | None

    @property
    def directions(self) -> tuple[float, ...] | None:
        """Directions of travel (rad), or None for all."""
        holonomic = isinstance(self.limits, VehicleLimits) and self.limits.holonomic
        return None if holonomic else (0.0, math.pi)

    def ranges(self, fields: MachineFields) -> tuple[Range, Range]:
        """Return the machine's speeds and turn rates, as the field sets measure them."""
        (low, high), theta = velocities(self.limits, fields.sets[0])
        if self.diagonal is not None:
            low, high = math.copysign(self.diagonal, low) if low else 0.0, self.diagonal
        return (low, high), theta

    def gaps(self, fields: MachineFields) -> Iterator[Fault]:
        """Yield the velocities to which no field set applies, in words."""
        linear, theta = self.ranges(fields)
        for loaded in self.model.loads:
            sets = [one for one in fields.sets if one.fits_load(loaded)]
            of_load = " with load" if loaded else ""
            if not sets:
                words = of_load or " without load"
                yield f"no field set applies{words}, so the machine never moves", ()
                continue
            protective = ProtectiveFields(sets=tuple(sets))
            gaps = [*protective.gaps(linear, directions=self.directions)]
            if isinstance(self.limits, VehicleLimits) and self.diagonal is None:
                gaps += [gap for gap in protective.gaps(AT_REST, theta) if gap not in gaps]
            for gap in map(self.possible, gaps):
                if gap is not None and gap.loaded == loaded:
                    words = _words(gap) + of_load
                    yield f"no field set applies to {words}, so the machine stops there", ()

    def possible(self, gap: FieldGap) -> FieldGap | None:
        """Return the velocities of a gap that the machine has in its directions, if any."""
        if gap.direction is None or self.diagonal is not None:
            return gap
        axes = [limits_along(self.limits, a) for a in directions(self.limits, *gap.direction)]
        top = max((axis.max_speed for axis in axes if axis is not None), default=0.0)
        (low, high) = gap.linear
        return None if low >= top else gap._replace(linear=(low, min(high, top)))

    def faulty_sets(self, fields: MachineFields) -> Iterator[Fault]:
        """Yield the sets that never apply, and those too short for the machine's stops."""
        ranges = self.ranges(fields)
        for k, each in enumerate(fields.sets):
            alone = ProtectiveFields(sets=(each,)).remaining(each.name, *ranges, self.model.loads)
            if alone and not fields.protective.remaining(each.name, *ranges, self.model.loads):
                yield f"the set {each.name!r} never applies: sets before it fit first", (k,)
        sets = {each.name: k for k, each in enumerate(fields.sets)}
        fit = tuple(one for one in fields.sets if any(map(one.fits_load, self.model.loads)))
        protective = replace(fields.protective, sets=fit) if fit else None
        for short in short_fields(protective, self.footprint, self.limits) if protective else ():
            yield str(short), (sets[short.set], "protective")


def _words(gap: FieldGap) -> str:
    low, high = gap.linear
    speed = f"{low:g} m/s" if low == high else f"{low:g} to {high:g} m/s"
    if gap.theta != AT_REST:
        speed += f" at {gap.theta[0]:g} to {gap.theta[1]:g} rad/s"
    if gap.direction is not None:
        first, last = gap.direction
        among = f"s from {first:.3g} to {last:.3g}" if first < last else f" {first:.3g}"
        speed += f" in direction{among}"
    return speed
