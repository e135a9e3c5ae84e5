"""AGVs: machines that drive on a lane, and can yield to people."""

from __future__ import annotations

import math
from functools import partial

from floorplan import Lane, Point
from navigation import CollisionWorld, Motion, agv_run, join
from navigation.machines import lane_state
from navigation.separation import required_at_speeds

from ...core.body import CONTACT, Body, MachineShape, commands
from ...core.scenario import AgvMove
from ...core.stage import Stage
from ...safety.stopping_check import StoppingCheck
from ..commanded import CommandedMachine
from ..controllers import parked
from .drive import LaneDrive
from .yielding import RESUME, PedestrianWatch


class Agv(CommandedMachine):
    """An AGV on its lane, with the moves of the trial. It yields to people if it `yields`."""

    _drive: LaneDrive

    FOR_CONTROLLERS = CommandedMachine.FOR_CONTROLLERS - {"follow"} | {"drive", "lane_position"}

    def __init__(
        self,
        stage: Stage,
        lane: Lane,
        moves: tuple[AgvMove, ...] = (),
        *,
        yields: bool = False,
    ) -> None:
        self.lane = lane
        drive = LaneDrive(
            stage,
            lane,
            disabled_or_enabled=self.interrupt,
            rested=partial(stage.came_to_rest, self),
        )
        super().__init__(stage, agv_shape(lane), drive, parked)
        self.record = self._record_by_name
        check = StoppingCheck(self.law, lane.max_speed, self.shapes)
        # The centre is beyond the point, or the surface, to which distances are measured.
        self._beyond = math.hypot(*stage.rules.measured_at(self.shape)) + check.around
        self._moves = moves
        self._is_on_floor = any(lane is other for other in stage.floorplan.lanes)
        self._lookout = PedestrianWatch(stage, drive, self.shape, check) if yields else None

    def begin(self) -> None:
        """Schedule the moves."""
        super().begin()
        for move in self._moves:
            self._clock.call_at(move.time, partial(self.drive, move.to))

    @property
    def lane_position(self) -> float:
        """Position on the lane now (m)."""
        return self._drive.position

    @commands
    def drive(self, to: str | float) -> None:
        """Start to drive to a location or a lane position (m)."""
        self._drive.go(to)

    def hold(self, stands: bool) -> None:
        """Start or end a protective stop."""
        if stands and self._lookout is not None:
            self._lookout.cancel()
        super().hold(stands)
        self._react()

    @commands
    def limit_speed(self, speed: float | None) -> bool:
        """Limit the top speed (m/s), or end the limit."""
        limited = super().limit_speed(speed)
        self._react()
        return limited

    def _react(self) -> None:
        if self._lookout is not None:
            self._lookout.react()

    # The simulation's side of it.

    @property
    def centre(self) -> Point:
        """The middle of the AGV (x, y)."""
        return self.lane.position(self.lane_position)

    @property
    def goal(self) -> Point | None:
        """The position (x, y) to which it is under way."""
        return self._drive.goal

    @property
    def stands(self) -> bool:
        """Whether it is at rest without a target."""
        return self.body.motion.end <= self.now and self._drive.to is None

    @property
    def may_leave(self) -> bool:
        """Whether it is under way, or moves again in the trial."""
        return self._drive.to is not None or any(move.time >= self.now for move in self._moves)

    def foreseen(self, until: float) -> Motion:
        """Return its motion with the moves that begin by `until` (s).

        A yielding or held AGV may stop at any time, so only its current motion counts.
        """
        motion, now = self.body.motion, self.now
        if self._lookout is None and not self.is_held:
            for move in self._moves:
                if now <= move.time <= until:
                    at = lane_state(self.lane, motion.state(move.time))
                    motion = join([motion, agv_run(self.lane, at, move.to, move.time)])
        return motion

    def sets_out(self, after: float) -> float:
        """Return the begin of the next move later than `after` (s), or infinity."""
        if self._lookout is not None or self.is_held:
            return math.inf
        return min((move.time for move in self._moves if move.time > after), default=math.inf)

    def stand_in(self, world: CollisionWorld) -> None:
        """Place it in `world` at its present position."""
        if self._is_on_floor:
            world.move_agv(self.name, self.lane_position)
        else:
            super().stand_in(world)

    def look_out_for(self, person: Body, top_speed: float) -> None:
        """Yield to a person, who walks at `top_speed` (m/s) at most, if it yields."""
        if self._lookout is not None:
            self._lookout.add(person, top_speed)

    def zone(self, top_speed: float) -> float:
        """Return the distance from the centre (m) that must be free of people before departure."""
        fastest = self.lane.max_speed
        if self._lookout is None:
            return required_at_speeds(self.law, 0.0, fastest) + self._beyond
        # A person may walk towards it while it drives for `RESUME` and then brakes.
        stopping = fastest / self.lane.max_acceleration
        required = required_at_speeds(self.law, top_speed, fastest) + self._beyond
        return required + top_speed * (RESUME + stopping)

    def sight_changed(self) -> None:
        """Check the people again at the begin or end of a blackout."""
        super().sight_changed()
        if self._lookout is not None:
            self._lookout.look()

    def stopped_by_contact(self) -> None:
        """Stay stopped, because a command cannot lead it away from its lane."""
        self.stand_for(CONTACT, True)

    def contact_gone(self) -> None:
        """Continue after a contact."""
        self.stand_for(CONTACT, False)

    def floor_changed(self) -> None:
        """Continue or stop if a part of the lane has been opened or closed."""
        self._drive.floor_changed()
        self._react()


def agv_shape(lane: Lane) -> MachineShape:
    """Return the shape of the AGV on `lane`."""
    return MachineShape(
        name=lane.name,
        kind="agv",
        category="vehicle",
        length=lane.length,
        width=lane.width,
        top=lane.height,
        top_speed=lane.max_speed,
        course=(lane.position(lane.limits[0]), lane.position(lane.limits[1])),
        direction=lane.direction,
    )
