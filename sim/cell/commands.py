"""Commands: values that others may send to people and machines, without a result."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from functools import partial
from typing import Any

import bdi
from floorplan import UserError
from navigation.vehicles import Twist

from ..core.body import Machine, is_there
from ..machines.agv.agv import Agv
from ..machines.amr.amr import Amr
from ..machines.commanded import CommandedMachine
from ..machines.gantry.robot import GantryRobot
from ..people.person import Person
from ..simulation import BY_COMMAND, Simulation
from .admission import Admission
from .people import PersonRoute
from .trajectories import follow
from .values import Pose, target_of

TWIST_TIME = 0.5
"""Seconds that a machine follows a twist unless another one comes before."""

AT_POSE = 0.1
"""Metres and radians. An initial pose must be this close to the pose of the machine."""


class CellCommand:
    """Command to a person or machine.

    Parameters
    ----------
    name : str
        Name, such as "machines/bot/twist".
    admission : Admission
        Check of values.
    perform : callable
        Function that carries out a value. It raises a `ValueError` or `PlanningError` for values
        that are impossible now.
    """

    def __init__(self, name: str, admission: Admission, perform: Callable[[Any], object]) -> None:
        self.name = name
        self._admission = admission
        self.perform = perform

    def take(self, value: Any, source: str = "") -> None:
        """Carry out a value and record it in the commands of the trial.

        Parameters
        ----------
        value : object
            The value. See the table of commands in the documentation.
        source : str, optional
            Name of the client.

        Raises
        ------
        Rejected
            If the value must not enter, or is impossible now.
        """
        self._admission.carry_out(self.name, value, source, self.perform)


def commands_of(
    simulation: Simulation, admission: Admission, interrupt: Callable[[str], None]
) -> Iterator[CellCommand]:
    """Yield all commands. `interrupt(name)` ends the task of a person or machine."""

    def command(body: str, name: str, carry_out: Callable[[Any], object]) -> CellCommand:
        def interrupted(value: Any) -> object:
            outcome = carry_out(value)
            interrupt(body)
            return outcome

        return CellCommand(f"{body}/{name}", admission, interrupted)

    for person in simulation.people:
        body, route = f"people/{person.name}", PersonRoute(simulation, person)
        yield CellCommand(f"{body}/start", admission, partial(_start, person))
        if person.is_recorded:
            continue
        yield command(body, "goal", partial(_send, route))
        yield command(body, "stop", partial(_stop, route))
        if route.is_external:
            yield command(body, "act", partial(_act, route))
    for machine in simulation.machines.values():
        body = f"machines/{machine.name}"
        yield CellCommand(f"{body}/hold", admission, partial(_hold, machine))
        for name, carry_out in _of_machine(machine):
            yield command(body, name, carry_out)


def _of_machine(machine: Machine) -> Iterator[tuple[str, Callable[[Any], object]]]:
    """Yield the names of the commands of a machine, and the functions that carry them out."""
    if isinstance(machine, CommandedMachine):
        yield "stop", partial(_stop, machine)
        yield "pose", partial(_require_pose, machine)
    if isinstance(machine, Amr):
        yield "twist", partial(_twist, machine)
    if isinstance(machine, GantryRobot):
        yield "joints", partial(follow, machine)
    if isinstance(machine, Agv):
        yield "drive", machine.drive


def _start(person: Person, _: object) -> None:
    person.start()


def _stop(one: PersonRoute | CommandedMachine, _: object) -> None:
    one.stop()


def _send(route: PersonRoute, goal: Pose | Sequence[float]) -> None:
    target = target_of(goal)
    if route.is_external:
        route.require_on_floor(target)  # whether there is a path is a percept
    else:
        route.require(target)
    route.go(target)


def _act(route: PersonRoute, action: str | bdi.Literal) -> None:
    if isinstance(action, str):
        try:
            action = bdi.parse_literal(action)
        except bdi.ProgramError as why:
            raise UserError(f"is no action: {why}") from why
    route.person.act(action)


def _hold(machine: Machine, hold: bool) -> None:
    machine.stand_for(BY_COMMAND, bool(hold))


def _twist(machine: Amr, twist: Sequence[float]) -> None:
    machine.twist(Twist.of(twist), TWIST_TIME)


def _require_pose(machine: CommandedMachine, pose: Pose) -> None:
    """Check an initial pose. The simulation knows where the machine is."""
    if not is_there(machine.position, target_of(pose), AT_POSE):
        x, y, heading = machine.position
        raise UserError(
            f"{machine.name} is at ({x:g}, {y:g}, {heading:g}); set its key `at` in the trial"
        )
