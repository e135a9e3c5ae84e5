"""Trials that wait for actions at the ticks of some machines."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import partial
from typing import Any

from simpy.events import Event

from floorplan import UserError
from floorplan.files.problems import suggestion

from ..core.recorder import Event as Recorded, Listener
from ..machines.gantry.robot import GANTRY
from ..machines.kinds import with_controller
from ..machines.policy import Interface, driven
from ..machines.policy_driven import PolicyDriven
from ..runs.run import Run
from ..simulation import Simulation
from ..trials.trial import Trial


class Ticks:
    """A run that waits for an action at each tick of some machines.

    The machine waits within its own tick, so that the run is the same as with a controller that
    chooses these actions.

    Parameters
    ----------
    trial : Trial
        The trial.
    names : sequence of str
        Names of the machines.
    interface : Interface
        Interface between the machines and their policies.
    *listeners : Listener
        Listeners for events and motions.
    """

    def __init__(
        self, trial: Trial, names: Sequence[str], interface: Interface, *listeners: Listener
    ) -> None:
        self._earlier = 0
        self._waiting: dict[str, Event] = {}
        self._actions: dict[str, Any] = {}
        controller = partial(driven, self._wait, interface)
        self.simulation = Simulation(
            with_controllers(trial, dict.fromkeys(names, controller)), *listeners
        )
        machines = self.simulation.machines
        self.machines = {name: _commanded(machines[name]) for name in names}

    def advance(self, actions: Mapping[str, Any]) -> None:
        """Carry out the actions, and simulate until the next tick or the end."""
        self._earlier = len(self.simulation.events)
        self._actions = dict(actions)
        self.simulation.advance(self.simulation.trial.duration, enough=self._waits)

    @property
    def events(self) -> tuple[Recorded, ...]:
        """Events since the last tick."""
        return tuple(self.simulation.events[self._earlier :])

    @property
    def over(self) -> bool:
        """Whether the trial has reached its end."""
        return self.simulation.over

    def finish(self) -> Run:
        """Return the run up to the current time."""
        return self.simulation.finish()

    def _wait(self, machine: PolicyDriven) -> Event:
        event = self._waiting[machine.name] = Event(machine.body.clock)
        return event

    def _waits(self) -> bool:
        """Resume machines that have an action. Return whether a machine waits for its action."""
        for name in [name for name in self._waiting if name in self._actions]:
            self.simulation.clock.occur(self._waiting.pop(name), self._actions.pop(name))
        return bool(self._waiting)


def with_controllers(trial: Trial, controllers: Mapping[str, Any]) -> Trial:
    """Return the trial with these controllers. `ValueError` if there is no such machine."""
    known = {*trial.machines, *([GANTRY] if trial.floorplan.gantry is not None else [])}
    for name, controller in controllers.items():
        if name not in known:
            hint = suggestion(name, names_of(trial))
            raise UserError(f"machine: {trial.name} has no vehicle or gantry {name!r}; {hint}")
        trial = with_controller(trial, controller, name)
    return trial


def names_of(trial: Trial) -> list[str]:
    """Return the names of the machines that a policy can drive."""
    own = [GANTRY] if trial.floorplan.gantry is not None else []
    kinds = ("amr", "gantry")
    return [*(name for name, one in trial.machines.items() if one.kind in kinds), *own]


def _commanded(machine: Any) -> PolicyDriven:
    assert isinstance(machine, PolicyDriven)
    return machine
