"""Machines with a controller: their sensors and commands, the same for every kind."""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import cached_property
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray
from simpy.events import Event, Process
from typing_extensions import override

from floorplan import UserError
from floorplan.files.dataclass import dataclass
from navigation import Motion, minimum_margin
from navigation.kernels.braking import Stops
from navigation.motion import State

from ..core.body import TRAFFIC, Machine, MachineShape, checked, commands
from ..core.clock import Turn
from ..core.entries import Pose
from ..core.events import EventKind
from ..core.recorder import Record
from ..core.stage import Stage
from ..safety.proximity import ApproachMonitor
from .arguments import instance, number, target
from .commanding import Drive, Steps
from .interrupts import Interruption, Interrupts
from .scan import Scanner

OBSERVATION_RATE = 10.0
"""Hz. Rate of the observations of people."""


@dataclass(frozen=True)
class Sighting:
    """Observation of a person: x, y in metres, velocity in m/s."""

    name: str
    at: tuple[float, float]
    velocity: tuple[float, float]

    @property
    def speed(self) -> float:
        """Speed, m/s."""
        return math.hypot(*self.velocity)


class CommandedMachine(Machine):
    """A machine that a controller commands.

    A controller yields the results of its methods: `yield machine.move_to(-2.5, 0.5)`. The machine
    carries out one command at a time: a new one replaces the current one. A stopped machine resumes
    the current command afterwards. `record(event)` records an event, which may be of a custom
    `EventKind`.
    """

    record: Record

    FOR_CONTROLLERS: ClassVar[frozenset[str]] = frozenset(
        {"name", "now", "state", "position", "people", "disabled", "rules", "human_speed", "record"}
        | {
            "look",
            "scan",
            "margin",
            "interrupt_on",
            "move_to",
            "preview",
            "follow",
            "stop",
            "resume",
            "stopping",
        }
        | {"wait", "until"}
    )
    """Names for controllers. All others are for the simulation."""

    def __dir__(self) -> list[str]:
        """Return the names for controllers, so that completion offers them alone."""
        return [*self.FOR_CONTROLLERS]

    def __init__(
        self,
        stage: Stage,
        shape: MachineShape,
        drive: Drive,
        controller: Callable[[Any], Steps],
    ) -> None:
        self.rules = stage.rules
        self.human_speed = stage.fastest
        self.shape = shape
        self.law = stage.rules.law_of(shape)
        self.shapes = stage.rules.shapes_of(shape, stage.widest)
        self._drive = drive
        self.body = drive.body
        self._stage = stage
        self._clock = stage.clock
        self._interrupts = Interrupts()
        self._proximity: ApproachMonitor | None = None
        self._controller = controller

    def begin(self) -> None:
        """Start the controller."""
        self._proximity = ApproachMonitor(self._stage, self, self._came_near)
        self.start(self._controller(self))

    # Sensors.

    @property
    def now(self) -> float:
        """Simulated time in seconds."""
        return self._clock.now

    @property
    def state(self) -> State:
        """Current pose and velocity."""
        return self.body.state

    @property
    def position(self) -> Pose:
        """Current pose: x and y in metres and rotation in radians."""
        return self.body.state.position

    @property
    def disabled(self) -> bool:
        """Whether the machine is disabled or in a protective stop."""
        return self._drive.disabled

    @property
    def people(self) -> tuple[Sighting, ...]:
        """People as the sensors see them now. None in a blackout."""
        return self._sightings()

    @property
    def margin(self) -> float:
        """Least distance minus required distance to a person now, in metres.

        It is infinite without people, and where the rules have no law for the machine.
        """
        law, now, motion = self.law, self.now, self.body.motion
        if law is None:
            return math.inf
        walks = [person.body.motion for person in self._stage.people if not person.away]
        return min(
            (minimum_margin(walk, motion, law, now, now, shapes=self.shapes)[1] for walk in walks),
            default=math.inf,
        )

    @checked
    def look(self, after: float = 0.0) -> Event:
        """Observe the people. The value of the event is a tuple of `Sighting`.

        Parameters
        ----------
        after : float, optional
            Minimum delay in seconds. The observation is the next one of `OBSERVATION_RATE` after
            it.

        Returns
        -------
        Event
            Event to yield: `people = yield machine.look()`.

        Raises
        ------
        ValueError
            If the delay is negative or infinite.
        """
        after = number("look(after)", after, 0.0)
        self._interrupts.command_given()
        earliest = (self.now + after) * OBSERVATION_RATE
        at = math.ceil(earliest - 1e-9) / OBSERVATION_RATE
        return self._clock.ask(at, self._sightings, Turn.NOTICE)

    @checked
    def scan(
        self, rays: int = 720, reach: float = 10.0, height: float = 0.2
    ) -> NDArray[np.float64]:
        """Return the distances that a laser scanner at the centre of the machine measures now.

        It sees the floor, other machines and people, whatever blackouts do to other sensors.

        Parameters
        ----------
        rays : int, optional
            Number of rays around the machine, counterclockwise. The first points backwards.
        reach : float, optional
            Range in metres.
        height : float, optional
            Height of the scanned plane in metres.

        Returns
        -------
        ndarray
            Distances in metres, of shape (rays,). It is `reach` where nothing is nearer.

        Raises
        ------
        ValueError
            If the number of rays or the range is invalid.
        """
        return self._scanner.ranges(rays, reach, height)

    @cached_property
    def _scanner(self) -> Scanner:
        return Scanner(self._stage, self)

    @checked
    def interrupt_on(self, reason: Interruption, distance: float = math.inf) -> None:
        """Interrupt the controller from now on when something happens while it waits.

        As in SimPy, the `yield` raises `simpy.Interrupt` with `reason` as its cause. The current
        motion continues until the next command. After an interrupt there is no other one until the
        controller gives a command outside the `except` block that handles it. Reasons that occur
        meanwhile interrupt it then, each once.

        Parameters
        ----------
        reason : {"person_close", "disabled", "enabled", "part_dropped", "contact"}
            A person is closer than `distance`, the referee stops the machine or releases it, the
            gripper drops the carried part, or the machine touches a person or the floor.
        distance : float, optional
            Distance in metres of a person from the axis of the machine.

        Raises
        ------
        ValueError
            If the reason is unknown or the distance invalid.
        """
        self._interrupts.request(reason, distance)
        if self._proximity is not None:
            self._proximity.near(self._interrupts.close_distance)

    # Commands.

    @commands
    def move_to(
        self,
        x: float,
        y: float,
        rotation: float | None = None,
        *,
        speed_share: float = 1.0,
        resume: bool = True,
    ) -> Event:
        """Start to move to a pose.

        Parameters
        ----------
        x, y : float
            Position in metres.
        rotation : float, optional
            Rotation in radians. By default it does not change.
        speed_share : float, optional
            Share of the top speeds to use.
        resume : bool, optional
            Whether the move continues after the machine was disabled.

        Returns
        -------
        Event
            Event to yield. It occurs when the move ends or another command replaces it.

        Raises
        ------
        ValueError
            If the pose is outside the range of the machine.
        PlanningError
            If there is no route.
        """
        pose = self._drive.destination(target("move_to", x, y, rotation, speed_share))
        move = self._drive.move(pose, speed_share, resume=resume)
        self._interrupts.command_given()
        return move

    @checked
    def preview(
        self, x: float, y: float, rotation: float | None = None, *, speed_share: float = 1.0
    ) -> Motion:
        """Return the motion that `move_to` would start now.

        Parameters
        ----------
        x, y, rotation, speed_share
            See `move_to`.
        """
        return self._drive.preview(target("preview", x, y, rotation, speed_share), speed_share)

    @commands
    def follow(self, motion: Motion) -> Event:
        """Start to follow a motion. It does not continue after the machine was disabled.

        A machine that waits for another one may follow a motion that leads elsewhere.

        Parameters
        ----------
        motion : Motion
            Motion that begins at the current time and pose.

        Returns
        -------
        Event
            Event to yield. It occurs when the motion ends or another command replaces it.

        Raises
        ------
        ValueError
            If the machine is stopped.
        """
        return self._follow(instance("follow(motion)", motion, Motion))

    @commands
    def stop(self) -> Process:
        """Start the fastest stop, and discard the current command.

        Returns
        -------
        Process
            Event to yield.
        """
        return self._command(self._drive.stop())

    @commands
    def resume(self) -> Event:
        """Start the last move again from here, for example after `stop`.

        Returns
        -------
        Event
            Event to yield. See `move_to`.

        Raises
        ------
        ValueError
            If the last command before `stop` was not a move.
        """
        if self._drive.last_move is None:
            raise UserError("there is no move to resume")
        pose, speed_share = self._drive.last_move
        return self.move_to(*pose, speed_share=speed_share)

    @property
    def stops(self) -> Stops:
        """Stops of the machine that begin during a motion."""
        return self._drive.stops

    @property
    def stopping_distance(self) -> float:
        """Longest distance of a stop within the limits of the machine, m."""
        return self._drive.stopping_distance

    def stopping(self, state: State, t: float) -> Motion:
        """Return the fastest stop without moving the machine.

        Parameters
        ----------
        state : State
            Initial pose and velocity.
        t : float
            Start time in seconds.
        """
        return self._drive.stopping(state, t)

    @checked
    def wait(self, seconds: float) -> Process:
        """Wait. Time in which the machine is stopped does not count.

        Parameters
        ----------
        seconds : float
            Duration in seconds.

        Returns
        -------
        Process
            Event to yield.
        """
        return self._command(self._drive.wait(seconds))

    @checked
    def until(self, t: float) -> Event:
        """Wait for an instant.

        Parameters
        ----------
        t : float
            Time in seconds.

        Returns
        -------
        Event
            Event to yield.
        """
        self._interrupts.command_given()
        return self._clock.at(number("until(t)", t), Turn.NOTICE)

    # For the simulation.

    def start(self, controller: Steps) -> None:
        """Start or replace the controller.

        Parameters
        ----------
        controller : generator
            Generator returned by a controller.
        """
        self._interrupts.start(self._clock, controller)

    def interrupt(self, reason: str) -> None:
        """Interrupt the controller as soon as possible if it has requested that.

        Parameters
        ----------
        reason : str
            Reason. See `interrupt_on`.
        """
        self._interrupts.happened(reason)

    @override
    def hold(self, stands: bool) -> None:
        self._drive.hold(stands)

    @commands
    @override
    def limit_speed(self, speed: float | None) -> bool:
        if speed is not None and not number("limit_speed(speed)", speed) > 0:
            raise UserError(f"limit_speed(speed) must be more than 0, not {speed}")
        self._drive.limit_speed(speed)
        return True

    def touched(self) -> None:
        """Interrupt the controller at the begin of a contact, if it has requested that."""
        self.interrupt("contact")

    def stopped_by_contact(self) -> None:
        """Do nothing, so that the controller can move away from the contact."""

    def close(self) -> None:
        """Finish at the end of the trial."""
        self._drive.close()

    def sight_changed(self) -> None:
        """Handle the begin or end of a blackout."""
        distance, here = self._interrupts.close_distance, self.body.at
        people = self._stage.people if distance is not None else ()
        if any(math.dist(person.body.at, here) < (distance or 0.0) for person in people):
            self._came_near()

    def _record_by_name(self, event: EventKind) -> None:
        """Record an event with the name of the machine, if it has a field for it."""
        if "machine" in getattr(event, "forms", ()):
            event = event.of({**event.fields, "machine": self.name})
        self._stage.record(event)

    def _follow(self, motion: Motion, again: Callable[[], Motion] | None = None) -> Event:
        """Follow a motion, which traffic checks for conflicts. See `Drive.follow`."""
        if self.only_waits:
            self.stand_for(TRAFFIC, False)
        move = self._drive.follow(motion, again)
        self._interrupts.command_given()
        return move

    def _idle_time(self, motion: Motion, now: float) -> float:
        """Return the time (s) in which it neither moved, worked nor was stopped.

        `motion` is its whole track.
        """
        drive = self._drive
        moving = sum(piece.end - piece.begin for piece in motion.pieces if not piece.stands)
        return max(0.0, now - moving - drive.working_time - drive.standing_time)

    def _came_near(self) -> None:
        if not self._stage.blind[self.name]:
            self.interrupt("person_close")

    def _command(self, steps: Steps) -> Process:
        self._interrupts.command_given()
        return self._clock.process(steps)

    def _sightings(self) -> tuple[Sighting, ...]:
        if self._stage.blind[self.name]:
            return ()
        sightings = []
        for person in self._stage.people:
            position, velocity, _ = person.body.state
            sightings.append(Sighting(person.name, position[:2], velocity[:2]))
        return tuple(sightings)
