"""Gantry of a trial: its keys and its model."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import field, fields, replace
from typing import Any

from pydantic import TypeAdapter

from floorplan import Floorplan, Gantry, Point
from floorplan.files.dataclass import dataclass
from floorplan.files.fields import Range, size_fault
from floorplan.files.problems import Fault, suggestion
from navigation import VehicleLimits
from navigation.machines import Stop, gantry_limits, longest_stop

from ...core.body import MachineShape
from ...core.entries import Pose
from ...core.scenario import GantryEntry, Job
from ...core.stage import MachineModel, Stage
from ..rated import program, rate_faults
from .controllers import CONTROLLER
from .robot import GantryRobot, gantry_shape
from .tasks import fixed_places


@dataclass(frozen=True, kw_only=True)
class BridgeKeys(GantryEntry):
    """Keys of another gantry on the rails of the floor, with ranges `x` and `y` (m)."""

    at: Pose
    x: Range | None = None
    y: Range | None = None


@dataclass(frozen=True)
class GantryModel(MachineModel):
    """A gantry with its controller and jobs, on the rails of the floor.

    Its ranges `x` and `y` (metres) default to those of the rails.
    """

    entry: GantryEntry = field(default_factory=GantryEntry)
    x: tuple[float, float] | None = None
    y: tuple[float, float] | None = None

    category = "robot"
    key_schema = BridgeKeys

    @classmethod
    def read(cls, name: str, keys: Mapping[str, Any]) -> GantryModel:
        """Return the model with these keys of a trial file."""
        checked = TypeAdapter(BridgeKeys).validate_python(dict(keys))
        entry = {field.name: getattr(checked, field.name) for field in fields(GantryEntry)}
        return cls(GantryEntry(**entry), checked.x, checked.y)

    def shape(self, name: str, plan: Floorplan) -> MachineShape:
        """Return its shape, as others see it."""
        return gantry_shape(self._on(plan), name)

    def make(self, name: str, stage: Stage) -> GantryRobot:
        """Return the robot. `ControllerError` if there is no such controller."""
        entry = self.entry
        controller = program(entry.controller, entry.rate, CONTROLLER, stage.code_folder)
        return GantryRobot(stage, self._on(stage.floorplan), entry, name, controller=controller)

    def faults(self, plan: Floorplan, vehicles: Iterable[str]) -> Iterator[Fault]:
        """Yield faults of places that are out of its range or do not exist."""
        if plan.gantry is None:
            if self.entry != GantryEntry():
                yield "the floorplan has no gantry", ()
            return
        gantry, entry = self._on(plan), self.entry
        if entry.at is not None:
            for fault in gantry.faults(entry.at):
                yield fault, ("at",)
        yield from rate_faults(entry.rate)
        fixed = fixed_places(plan)
        names = {*fixed, *vehicles}
        for k, job in enumerate(entry.jobs):
            for fault, place in _job_faults(job, gantry, names, fixed):
                yield fault, ("jobs", k, *place)
        carried = [job.part for job in entry.jobs if job.kind == "pick_place"]
        for k, drop in enumerate(entry.drops):
            if carried and drop.part not in carried:
                hint = suggestion(drop.part, carried)
                yield f"no job carries a part called {drop.part!r}; {hint}", ("drops", k, "part")

    def longest_stop(self, plan: Floorplan) -> Stop | None:
        """Return time and distance of its longest stop."""
        return longest_stop(self._on(plan))

    def field_limits(self, plan: Floorplan) -> VehicleLimits | None:
        """Return its limits as those of a holonomic drive.

        They are the higher speed of both axes, and the lower acceleration and jerk.
        """
        if plan.gantry is None:
            return None
        x, y, rotation = gantry_limits(plan.gantry)
        speed = max(x.max_speed, y.max_speed)
        return VehicleLimits(
            speed=speed,
            acceleration=min(x.max_acceleration, y.max_acceleration),
            jerk=min(x.max_jerk, y.max_jerk),
            turn_speed=rotation.max_speed,
            turn_acceleration=rotation.max_acceleration,
            turn_jerk=rotation.max_jerk,
            side_speed=speed,
        )

    @property
    def loads(self) -> tuple[bool, ...]:
        """Both, because its load changes."""
        return (False, True)

    def _on(self, plan: Floorplan) -> Gantry:
        rails = plan.gantry
        assert rails is not None  # checked with the trial
        x, y = (
            axis if ends is None else replace(axis, low=ends[0], high=ends[1])
            for axis, ends in ((rails.x, self.x), (rails.y, self.y))
        )
        return replace(rails, x=x, y=y)


def _job_faults(
    job: Job, gantry: Gantry, names: set[str], fixed: Mapping[str, Point]
) -> Iterator[Fault]:
    if job.kind == "move":
        for fault in gantry.faults(job.target):
            yield fault, ("move",)
    elif job.kind == "wait":
        if fault := size_fault(job.seconds):
            yield fault, ("wait",)
    elif job.kind == "pick_place":
        for key, place in (("pick", job.pick), ("place", job.place)):
            if place not in names:
                yield f"no obstacle, station or AGV is called {place!r}", (key,)
            elif place in fixed:
                for fault in gantry.faults((*fixed[place], gantry.start[2])):
                    yield f"the gantry can't get to {place!r}: {fault}", (key,)
    elif job.kind != "submit":
        yield f"a job is one of move, wait, pick_place, submit, not {job.kind!r}", ()
