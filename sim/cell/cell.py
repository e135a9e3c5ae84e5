"""The cell: signals, commands and tasks of a running simulation by name."""

from __future__ import annotations

from collections.abc import Callable

from ..people.minds import Outside
from ..simulation import Simulation
from .admission import Admission
from .commands import CellCommand, commands_of
from .journeys import journeys_of
from .pace import Pace
from .signals import Signal, signals_of
from .tasks import BEGUN_AGAIN, OVER, REPLACED, CellTask, Running


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
        self.admission = Admission(simulation, notice)
        self.has_decision = False
        """Whether an external person has something to decide on now."""
        self.signals: dict[str, Signal] = {}
        self.commands: dict[str, CellCommand] = {}
        self.tasks: dict[str, CellTask] = {}
        self._running: dict[str, Running] = {}
        """Task under way of each person and machine."""
        self._bind(simulation)
        self.follow(pace or Pace(simulation, step=True))
        self._states = [one for name, one in self.signals.items() if name.endswith("/state")]
        self._sent = {one: one.read() for one in self._states}
        self._events = len(simulation.events)

    def _bind(self, simulation: Simulation) -> None:
        """Read and command a simulation, which is started."""
        simulation.start()
        self.simulation = simulation
        for signal in signals_of(simulation):
            self.signals.setdefault(signal.name, signal).read = signal.read
        for command in commands_of(simulation, self.admission, self._interrupt):
            self.commands.setdefault(command.name, command).perform = command.perform
        for name, make in journeys_of(simulation):
            task = CellTask(name, self.admission, make, self.update, self._begin)
            self.tasks.setdefault(name, task).make = make
        self._outside = {
            person.name: person.mind
            for person in simulation.people
            if isinstance(person.mind, Outside)
        }
        for mind in self._outside.values():
            mind.on_decision.append(self._decide)

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
        self.admission.continue_with(simulation)
        self._events = 0
        self.update()

    def follow(self, pace: Pace) -> None:
        """Change the pace, which is then interrupted at each decision of an external person."""
        self.pace = pace
        self.admission.is_open = lambda: not pace.over
        self.admission.catch_up = pace.catch_up
        pace.enough = lambda: self.has_decision
        if self.update not in pace.after:
            pace.after.append(self.update)

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
            if signal.is_watched and (state := signal.read()) != self._sent[signal]:
                self._sent[signal] = state
                signal.send(state)

    def _decide(self) -> None:
        self.has_decision = True

    def _begin(self, body: str, running: Running) -> None:
        self._interrupt(body)
        self._running[body] = running

    def _interrupt(self, body: str) -> None:
        """End the task of a person or machine, because something else replaces it."""
        if (running := self._running.pop(body, None)) is not None:
            running.end(REPLACED)
