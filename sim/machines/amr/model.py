"""Vehicle of a trial: its keys and its model."""

from __future__ import annotations

import itertools
from collections.abc import Iterable, Iterator
from typing import Literal

import shapely
from shapely.geometry import Polygon

from floorplan import Floorplan, UserError
from floorplan.files.dataclass import dataclass
from floorplan.files.fields import Flag, Pair, Positive
from floorplan.files.problems import Fault
from navigation import PlanningError, VehicleLimits, VehiclePlanner
from navigation.machines import Stop
from navigation.vehicle_planner import footprint_fault

from ...core.body import MachineShape, OnContact
from ...core.custom_code import CodeFolder
from ...core.entries import Pose
from ...core.scenario import Controller
from ...core.stage import MachineModel, Stage
from ..controllers import STAY
from ..rated import find_program, program, rate_faults
from ..supervision import ControllerError
from .amr import Amr
from .controllers import VEHICLE_CONTROLLER
from .drive import floor_of
from .missions import Mission
from .shape import Chassis


@dataclass(frozen=True, kw_only=True)
class AmrModel(MachineModel):
    """A vehicle that drives freely. Its fields are the keys in a trial file (m, s, radians)."""

    at: Pose
    size: tuple[Positive, Positive] = (1.2, 0.8)
    footprint: tuple[Pair, ...] = ()
    height: Positive = 0.4
    load: tuple[Positive, Positive, Positive] | None = None
    drive: Literal["differential", "holonomic"] = "differential"
    max_speed: Positive = 1.5
    max_acceleration: Positive = 0.7
    max_jerk: Positive = 3.0
    max_side_speed: Positive | None = None
    max_turn_speed: Positive = 1.0
    max_turn_acceleration: Positive = 1.5
    max_turn_jerk: Positive = 6.0
    controller: Controller = "oblivious"
    rate: Positive | None = None
    missions: tuple[Mission, ...] = ()
    every: Positive | None = None
    priority: int = 0
    repeat: Flag = False
    on_contact: OnContact = "stop"

    category = "vehicle"

    @property
    def limits(self) -> VehicleLimits:
        """Limits of the vehicle."""
        side_speed = self.max_speed if self.max_side_speed is None else self.max_side_speed
        return VehicleLimits(
            speed=self.max_speed,
            acceleration=self.max_acceleration,
            jerk=self.max_jerk,
            turn_speed=self.max_turn_speed,
            turn_acceleration=self.max_turn_acceleration,
            turn_jerk=self.max_turn_jerk,
            side_speed=side_speed if self.drive == "holonomic" else 0.0,
        )

    @property
    def vehicle(self) -> Chassis:
        """Chassis with the load. `UserError` if the footprint is invalid."""
        footprint = self._footprint()
        if fault := footprint_fault(footprint):
            raise UserError(fault)
        top = self.height
        if self.load is not None:
            length, width, height = self.load
            around = shapely.box(-length / 2, -width / 2, length / 2, width / 2)
            footprint = footprint.union(around).convex_hull
            top += height
        loaded = self.load is not None
        return Chassis(footprint=footprint, top=top, limits=self.limits, loaded=loaded)

    def shape(self, name: str, plan: Floorplan) -> MachineShape:
        """Return its shape."""
        return self.vehicle.shape(name)

    def make(self, name: str, stage: Stage) -> Amr:
        """Return the vehicle. `ControllerError` if there is no such controller."""
        return Amr(
            stage,
            name,
            self.vehicle,
            self.at,
            missions=self.missions,
            every=self.every,
            repeat=self.repeat,
            priority=self.priority,
            makes_way=self.controller not in STAY,
            on_contact=self.on_contact,
            controller=program(self.controller, self.rate, VEHICLE_CONTROLLER, stage.code_folder),
        )

    def code_faults(self, folder: CodeFolder) -> Iterator[Fault]:
        """Yield the fault of its controller, if there is one."""
        try:
            find_program(self.controller, self.rate, VEHICLE_CONTROLLER, folder)
        except ControllerError as why:
            yield str(why), ("controller",)

    def stands_at_start(self, name: str, plan: Floorplan) -> Polygon | None:
        """Return the area that it covers at the start."""
        if footprint_fault(self._footprint()):
            return None
        x, y, rotation = self.at
        return self.shape(name, plan).footprint((x, y), rotation)

    def longest_stop(self, plan: Floorplan) -> Stop | None:
        """Return time and distance of its longest stop."""
        return self.limits.longest_stop

    def field_limits(self, plan: Floorplan) -> VehicleLimits:
        """Return the limits of the vehicle."""
        return self.limits

    @property
    def loads(self) -> tuple[bool, ...]:
        """One value, because its load does not change."""
        return (self.load is not None,)

    def faults(self, plan: Floorplan, vehicles: Iterable[str]) -> Iterator[Fault]:
        """Yield faults of its footprint and rates."""
        if fault := footprint_fault(self._footprint()):
            yield fault, ("footprint",)
            return
        if self.footprint and self.size != type(self).size:
            yield "give size or footprint, not both", ("size",)
        if self.max_side_speed is not None and self.drive != "holonomic":
            yield "only a holonomic drive has one", ("max_side_speed",)
        yield from rate_faults(self.rate)
        if self.every is not None and self.repeat:
            yield "give every or repeat, not both", ("every",)

    def place_faults(self, name: str, plan: Floorplan) -> Iterator[Fault]:
        """Yield faults of places that the footprint does not fit, or cannot reach."""
        if footprint_fault(self._footprint()):
            return
        world = floor_of(self.vehicle, name, plan)
        empty = world.as_if(away=[lane.name for lane in plan.lanes])
        planner = VehiclePlanner(empty, self.vehicle.footprint, limits=self.limits)
        here: tuple[float, ...] = self.at
        if not planner.fits(here):
            yield planner.what_is_in_the_way(self.at), ("at",)
            return
        for k, mission in enumerate(self.missions):
            try:
                goal = mission.goal(plan)
                if mission.turn is not None:
                    goal = (here[0], here[1], mission.turn)
                if goal is not None:
                    here = planner.plan(here, goal).poses[-1].tolist()
            except UserError as why:
                yield str(why), ("missions", k, "go")
            except PlanningError as why:
                yield why.message, ("missions", k, "go" if mission.turn is None else "turn")

    def _footprint(self) -> Polygon:
        if not self.footprint:
            length, width = self.size
            return shapely.box(-length / 2, -width / 2, length / 2, width / 2)
        if len(self.footprint) < 3:
            return Polygon()
        return Polygon(self.footprint)


def overlaps(stand: Iterable[tuple[str, Polygon]]) -> Iterator[tuple[str, str]]:
    """Yield the names of each pair of vehicles whose areas overlap."""
    for (one, area), (other, other_area) in itertools.combinations(stand, 2):
        if area.intersection(other_area).area > 0:
            yield one, other
