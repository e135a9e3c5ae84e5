"""Faults and likely mistakes of the protective fields of a trial."""

from __future__ import annotations

from collections.abc import Iterator

from shapely.geometry import Polygon

from floorplan import UserError
from floorplan.files.problems import Fault
from floorplan.files.values import range_faults
from navigation import FieldGap, ProtectiveFields, short_fields

from ..core.fields import MachineFields
from ..core.scenario import Scenario
from ..core.stage import MachineModel
from ..machines.amr.model import AmrModel
from ..machines.field_limits import field_limits
from ..machines.gantry.model import GantryModel
from ..machines.kinds import models_of
from .names import machines, name_faults, zones

Range = tuple[float, float]

AT_REST = (0.0, 0.0)

SLIGHT = 1e-6
"""Metres. A warning field may be smaller than the protective field by no more than that."""


def field_faults(trial: Scenario) -> Iterator[Fault]:
    """Yield what can't be about the protective fields of a trial."""
    for name, fields in trial.fields.items():
        yield from name_faults(name, "machine", machines(trial), name)
        for message, place in (*range_faults(fields), *_set_faults(fields)):
            yield message, (name, *place)
        for k, zone in enumerate(fields.muting.zones):
            yield from name_faults(zone, "zone", zones(trial), name, "muting", "zones", k)


def _set_faults(fields: MachineFields) -> Iterator[Fault]:
    """Yield what can't be about the field sets and the times of muting."""
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
    """Yield why protective fields may not protect, or stop a machine for no person.

    Custom kinds of machines are left out: their code is not run for that.
    """
    models = models_of(trial, own=False) if trial.fields else {}
    for name, fields in trial.fields.items():
        if name in models:
            yield from ((said, (name, "sets")) for said in _gaps(fields, models[name], trial, name))
            yield from (
                (said, (name, *at)) for said, at in _short(fields, models[name], trial, name)
            )


def _gaps(fields: MachineFields, model: MachineModel, trial: Scenario, name: str) -> Iterator[str]:
    """Yield the speeds to which no field set applies, in words."""
    top = model.shape(name, trial.floorplan).top_speed
    has_directions = fields.sets[0].direction is not None
    linear = (0.0 if has_directions else -top, top)
    for loaded in _loads(model):
        sets = [one for one in fields.sets if one.fits_load(loaded)]
        of_load = " with load" if loaded else ""
        if not sets:
            yield f"no field set applies{of_load or ' without load'}, so the machine never moves"
            continue
        known = ProtectiveFields(sets=tuple(sets))
        gaps = [gap for gap in known.gaps(linear) if gap.loaded == loaded]
        if isinstance(model, AmrModel):
            turn = model.limits.turn_speed
            on_the_spot = known.gaps(AT_REST, (-turn, turn))
            gaps += [gap for gap in on_the_spot if gap.loaded == loaded and gap not in gaps]
        for gap in gaps:
            yield f"no field set applies to {_words(gap)}{of_load}, so the machine stops there"


def _short(
    fields: MachineFields, model: MachineModel, trial: Scenario, name: str
) -> Iterator[Fault]:
    """Yield the field sets that do not reach as far as the machine gets before it stands."""
    limits = field_limits(model, trial.floorplan)
    if limits is None:
        return
    footprint = model.shape(name, trial.floorplan).footprint((0.0, 0.0), 0.0)
    places = {one.name: k for k, one in enumerate(fields.sets)}
    for short in short_fields(fields.protective, footprint, limits):
        yield str(short), ("sets", places[short.set], "protective")


def _loads(model: MachineModel) -> tuple[bool, ...]:
    """Return whether a machine may be loaded, and whether it may not be."""
    if isinstance(model, AmrModel):
        return (model.load is not None,)
    return (False, True) if isinstance(model, GantryModel) else (False,)


def _words(gap: FieldGap) -> str:
    low, high = gap.linear
    speed = f"{low:g} m/s" if low == high else f"{low:g} to {high:g} m/s"
    if gap.theta != AT_REST:
        speed += f" at {gap.theta[0]:g} to {gap.theta[1]:g} rad/s"
    if gap.direction is not None:
        speed += f" in directions from {gap.direction[0]:.3g} to {gap.direction[1]:.3g}"
    return speed
