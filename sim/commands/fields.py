"""`floorwalker fields`."""

from __future__ import annotations

import math
import textwrap
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated

import typer

from .arguments import NoOwnCode, complete_trial
from .terminal import say

if TYPE_CHECKING:
    from shapely.geometry import Polygon

    from navigation import FieldSet, FieldSupplements, ProtectiveFields
    from navigation.field_lengths import Limits

WIDTH = 80
"""Maximum columns of the output."""

RESPONSE_TIME = 0.2
"""Seconds. Default response time of sensor, control and brakes."""


def fields(
    trial: Annotated[
        str,
        typer.Argument(help="Trial: a name or a file.", autocompletion=complete_trial),
    ],
    machine: Annotated[
        str | None, typer.Option(help="Name of the machine (default: all of the trial).")
    ] = None,
    speeds: Annotated[
        str | None,
        typer.Option(
            metavar="V,V,...",
            help="Highest speed of each step, m/s (default: thirds of the machine's top speed).",
        ),
    ] = None,
    response_time: Annotated[
        float, typer.Option(help="Time from a contact to the begin of braking, s.")
    ] = RESPONSE_TIME,
    approach_speed: Annotated[
        float,
        typer.Option(help="Speed of a person towards the machine, m/s; 1.6 by ISO 13855."),
    ] = 0.0,
    measurement: Annotated[float, typer.Option(help="Supplement for the sensor's error, m.")] = 0.1,
    reflectors: Annotated[float, typer.Option(help="Supplement for reflectors, m.")] = 0.0,
    wear: Annotated[
        float, typer.Option(help="Supplement for worn brakes, as a share of the braking distance.")
    ] = 0.1,
    ground_clearance: Annotated[
        float, typer.Option(help="Supplement for a foot below the machine, m.")
    ] = 0.15,
    side: Annotated[float, typer.Option(help="Supplement on each side, m.")] = 0.1,
    warning_time: Annotated[
        float, typer.Option(min=0, help="Time by which the warning field is longer, s.")
    ] = 1.0,
    no_own_code: NoOwnCode = False,
) -> None:
    """Compute the protective fields that the machines of a trial need.

    Prints them as a section `fields` for the trial, with the lengths in comments.
    """
    from floorplan import UserError
    from navigation import FieldSupplements

    from ..machines.kinds import models_of
    from ..trials.names import checked_name
    from ..trials.trial import Trial

    read = Trial.load(trial, own_code=not no_own_code)
    models = models_of(read, own=not no_own_code)
    if machine is not None:
        checked_name(machine, "machine", list(models))
        models = {machine: models[machine]}
    supplements = FieldSupplements(
        measurement=measurement,
        reflectors=reflectors,
        wear=wear,
        ground_clearance=ground_clearance,
        approach_speed=approach_speed,
        side=side,
    )
    steps = None if speeds is None else _numbers(speeds)
    lines: list[str] = []
    for name, model in models.items():
        limits = model.field_limits(read.floorplan)
        if limits is None:
            if machine is not None:
                raise UserError(f"the limits of {name!r} are not known: its kind is custom")
            say(f"{name} is left out: the limits of a custom kind are not known", err=True)
            continue
        footprint = model.shape(name, read.floorplan).footprint((0.0, 0.0), 0.0)
        section = _Section(name, footprint, limits, response_time, supplements)
        lines += section.lines(steps, warning_time)
    if not lines:
        raise UserError(f"{trial} has no machine whose fields can be computed")
    say("\n".join(["fields:", *lines]))


@dataclass(frozen=True)
class _Section:
    """Output for one machine."""

    name: str
    footprint: Polygon
    limits: Limits
    response_time: float
    supplements: FieldSupplements

    def lines(self, steps: Sequence[float] | None, warning_time: float) -> Iterator[str]:
        """Yield the lines of the machine in the section `fields`."""
        from floorplan import UserError
        from navigation import VehicleLimits, needed_fields

        limits = self.limits
        top = limits.top_speed if isinstance(limits, VehicleLimits) else limits.max_speed
        speeds = steps or [round(share * top / 3, 2) for share in (1, 2)] + [top]
        needed = needed_fields(
            self.footprint,
            limits,
            speeds,
            response_time=self.response_time,
            supplements=self.supplements,
            warning_time=warning_time,
        )
        if speeds[-1] > top:
            raise UserError(f"{self.name}: {speeds[-1]:g} m/s is above its top speed, {top:g} m/s")
        if speeds[-1] < top:
            say(f"{self.name}: no set applies above {speeds[-1]:g} m/s", err=True)
        yield from self._table(needed)
        yield from self._sets(needed)

    def _table(self, needed: ProtectiveFields) -> Iterator[str]:
        """Yield the length of each set as comments, as the sum of its terms."""
        yield f"  # {self.name}: length of the protective fields from the edge of the machine, m"
        heads = "response", "braking", "person", "Z", "side", "outline", "length"
        yield "  #   m/s           " + "".join(f"{head:>8}" for head in heads)
        for each in needed.sets:
            speed = each.linear[1] if each.linear[1] > 0 else each.linear[0]
            kind = "turning" if each.name.endswith("turning") else "straight"
            terms = "".join(f"{term:8.3f}" for term in self._terms(each, speed))
            yield f"  # {speed:5.2f} {kind:10}{terms}"

    def _terms(self, each: FieldSet, speed: float) -> Iterator[float]:
        """Yield the terms of the length of a field in the direction of travel, and the length."""
        from navigation import VehicleLimits, stopping_reach
        from navigation.field_lengths import limits_along

        limits, sizes = self.limits, self.supplements
        angle = 0.0 if speed > 0 else math.pi
        if isinstance(limits, VehicleLimits) and speed > limits.speed:
            angle = math.atan2(limits.side_speed, limits.speed)
        axis = limits_along(limits, angle)
        assert axis is not None  # a drive that is not holonomic has two directions
        reach = stopping_reach(axis, abs(speed), self.response_time)
        person = sizes.approach_speed * reach.time
        z = sizes.length(reach) - person
        terms = [round(term, 3) for term in (*reach[:2], person, z, sizes.side)]
        field, edge = (
            max(x * math.cos(angle) + y * math.sin(angle) for x, y in corners)
            for corners in (each.protective, self.footprint.exterior.coords)
        )
        length = round(field - edge, 3)
        yield from (*terms, length - sum(terms), length)

    def _sets(self, needed: ProtectiveFields) -> Iterator[str]:
        """Yield the section of the machine."""
        yield f"  {self.name}:"
        yield f"    response_time: {needed.response_time:g}"
        yield "    sets:"
        for each in needed.sets:
            yield f"    - name: {each.name}"
            for key, value in _ranges(each):
                yield f"      {key}: [{value[0]:.6g}, {value[1]:.6g}]"
            for key, corners in (("protective", each.protective), ("warning", each.warning)):
                pairs = ", ".join(f"[{x:g},_{y:g}]" for x, y in corners)
                first = f"      {key}: "
                wrapped = textwrap.wrap(
                    f"[{pairs}]",
                    WIDTH,
                    initial_indent=first,
                    subsequent_indent=" " * (len(first) + 1),
                    break_on_hyphens=False,
                )
                yield from (line.replace("_", " ") for line in wrapped)


def _ranges(each: FieldSet) -> Iterator[tuple[str, tuple[float, float]]]:
    """Yield the ranges of a set that are bounded."""
    from navigation.fields import UNBOUNDED

    if each.linear != UNBOUNDED:
        yield "linear", each.linear
    if each.theta != UNBOUNDED:
        yield "theta", each.theta
    if each.direction is not None:
        yield "direction", each.direction


def _numbers(text: str) -> list[float]:
    try:
        return [float(part) for part in text.split(",")]
    except ValueError:
        raise typer.BadParameter(
            f"expected numbers with commas between them, found {text!r}", param_hint="--speeds"
        ) from None
