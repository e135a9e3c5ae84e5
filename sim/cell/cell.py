"""The cell: signals, commands and tasks of a running simulation by name."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any

from ..people.minds import Outside
from ..simulation import Simulation
from .admission import Admission
from .machines import commands_of_machine, tasks_of_machine
from .pace import Pace
from .people import commands_of_person, tasks_of_person
from .signals import Signal, signals_of
from .tasks import BEGUN_AGAIN, OVER, REPLACED, CellCommand, CellTask, Running

INDEPENDENT = ("start", "hold")
"""Commands that leave a task under way."""


class Cell:
    """A running simulation for other systems, without a protocol.

    Parameters
    ----------
    simulation : Simulation
        The simulation. It is started unless it has been.
    pace : Pace, optional
        Pace of the simulation. By default time advances in steps.
    notice : callable, optional
        Function for lines that the user should read, such as rejected values.

    Attributes
    ----------
    signals : dict of str to Signal
        Values to read.
    commands : dict of str to CellCommand
        Values to send.
    tasks : dict of str to CellTask
        Goals with feedback, cancellation and a result.
    pace : Pace
        Pace of the simulation.
    admission : Admission
        Check of values from outside.

    Examples
    --------
    >>> cell = Cell(sim.Simulation(sim.Trial.load("ariac2023")))
    >>> cell.pace.step(5.0)
    >>> cell.signals["clock"].read()
    5.0
    """

    def __init__(
        self,
        simulation: Simulation,
        pace: Pace | None = None,
        *,
        notice: Callable[[str], None] = lambda text: None,
    ) -> None:
        self.has_decision = False
        """Whether an external person has something to decide on now."""
        self.signals: dict[str, Signal] = {}
        self._running: dict[str, Running] = {}
        """Task under way of each person and machine."""
        self._bind(simulation)
        self.pace = pace or Pace(simulation, step=True)
        self.pace.enough = lambda: self.has_decision
        self.pace.after.append(self.update)
        self.admission = Admission(self.pace, notice)
        self.commands = {name: CellCommand(name, self._carry_out) for name in self._commands}
        self.tasks = {name: CellTask(name, self._carry_out) for name in self._tasks}
        self._states = [one for name, one in self.signals.items() if name.endswith("/state")]
        self._events = len(simulation.events)

    def _bind(self, simulation: Simulation) -> None:
        """Read and command a simulation, which is started."""
        simulation.start()
        self.simulation = simulation
        for signal in signals_of(simulation):
            self.signals.setdefault(signal.name, signal).read = signal.read
        self._commands: dict[str, Callable[[Any], object]] = {}
        self._tasks: dict[str, Callable[[Any], Running]] = {}
        self._outside: dict[str, Outside] = {}
        for person in simulation.people:
            self._commands |= commands_of_person(simulation, person)
            self._tasks |= tasks_of_person(simulation, person)
            if isinstance(person.mind, Outside):
                self._outside[person.name] = person.mind
                person.mind.on_decision.append(self._decide)
        for machine in simulation.machines.values():
            self._commands |= commands_of_machine(machine)
            self._tasks |= tasks_of_machine(machine)

    def continue_with(self, simulation: Simulation) -> None:
        """Continue with another simulation of the same trial.

        Tasks under way fail. Signals, commands and tasks keep their names and those who watch them.
        `events` sends the events of the other simulation from its start.

        Parameters
        ----------
        simulation : Simulation
            The simulation. It is started unless it has been.
        """
        for running in self._running.values():
            running.end(BEGUN_AGAIN)
        self._running.clear()
        self._bind(simulation)
        self.pace.continue_with(simulation)
        self._events = 0
        self.update()

    @property
    def now(self) -> float:
        """Simulated time in seconds."""
        return self.simulation.clock.now

    def update(self) -> None:
        """Send new values of signals on change, and continue tasks. `Pace` calls this.

        Call it after each advance if you advance the simulation yourself.
        """
        self.has_decision = False
        events = self.simulation.events
        while self._events < len(events):
            event = events[self._events]
            self._events += 1
            for running in tuple(self._running.values()):
                running.see(event)
            self.signals["events"].send(event)
        for name, mind in self._outside.items():
            for percept in mind.take():
                self.signals[f"people/{name}/percept"].send(percept.functor)
        for body, running in tuple(self._running.items()):
            running.update()
            if self.pace.over:
                running.end(OVER)
            if running.ended and self._running.get(body) is running:
                del self._running[body]
        for signal in self._states:
            signal.refresh()

    def _decide(self) -> None:
        self.has_decision = True

    def _carry_out(self, name: str, value: Any, source: str) -> Any:
        """Admit a value for a command or task, and carry it out."""
        action = self._begin if name in self._tasks else self._perform
        return self.admission.carry_out(name, value, source, partial(action, name))

    def _perform(self, name: str, value: Any) -> None:
        self._commands[name](value)
        body, _, command = name.rpartition("/")
        if command not in INDEPENDENT:
            self._interrupt(body)

    def _begin(self, name: str, goal: Any) -> Running:
        self.update()
        running = self._tasks[name](goal)
        running.refresh = self.update
        running.begin()
        body = name.rpartition("/")[0]
        self._interrupt(body)
        self._running[body] = running
        return running

    def _interrupt(self, body: str) -> None:
        """End the task of a person or machine, because something else replaces it."""
        if (running := self._running.pop(body, None)) is not None:
            running.end(REPLACED)
