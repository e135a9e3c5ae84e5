"""Signals: values of a simulation that others may read."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import field
from functools import partial
from typing import Any

from floorplan.files.dataclass import dataclass

from ..core.body import Body, Machine
from ..core.recorder import Event
from ..machines.amr.amr import Amr
from ..machines.commanded import CommandedMachine
from ..people.minds import Outside
from ..people.person import Person
from ..safety.monitors import SeparationMonitor
from ..simulation import Simulation
from .values import MonitorState, Pose, Scan, Velocity

POSES, SCANS, STATES = 50.0, 10.0, 10.0
"""Usual rates of signals in Hz."""

REACH = 10.0
"""Range of scans in metres."""


@dataclass(eq=False)
class Signal:
    """Value of a simulation that others may read.

    Attributes
    ----------
    name : str
        Name, such as "machines/bot/pose".
    read : callable
        Function that returns the present value.
    rate : float or None
        Usual rate in Hz. None for a signal that is sent on change (see `watch`).
    latched : bool
        Whether new readers get the last value.
    """

    name: str
    read: Callable[[], Any]
    rate: float | None = None
    latched: bool = False
    _watchers: list[Callable[[Any], None]] = field(default_factory=list)
    _last: Any = None

    def watch(self, changed: Callable[[Any], None]) -> None:
        """Call a function with each new value."""
        self._watchers.append(changed)
        if self.latched:
            self._last = self.read()

    def send(self, value: Any) -> None:
        """Notify those who watch of a new value."""
        for changed in self._watchers:
            changed(value)

    def refresh(self) -> None:
        """Send the present value if it differs from the last one."""
        if self._watchers and (value := self.read()) != self._last:
            self._last = value
            self.send(value)


def signals_of(simulation: Simulation) -> Iterator[Signal]:
    """Yield all signals of a simulation."""
    clock, events = simulation.clock, simulation.events
    yield Signal("clock", lambda: clock.now, POSES)
    yield Signal("floor", lambda: simulation.trial.floorplan, latched=True)
    yield Signal("events", lambda: last(events))
    for person in simulation.people:
        yield from _of_person(person)
    for machine in simulation.machines.values():
        yield from _of_machine(machine)
    for watch in simulation.referee.watches:
        pair = watch.pair
        name = f"monitor/{pair.person.name}/{pair.machine.name}"
        yield Signal(name, partial(_monitor, watch), STATES)


def last(events: list[Event]) -> Event | None:
    """Return the last event."""
    return events[-1] if events else None


def _of_person(person: Person) -> Iterator[Signal]:
    """Yield the signals of a person. Pose and velocity are None while they are absent."""
    name, body = f"people/{person.name}", person.body
    yield Signal(f"{name}/pose", lambda: None if person.away else Pose.of(body.state), POSES)
    yield Signal(f"{name}/velocity", lambda: None if person.away else _velocity(body), POSES)
    if isinstance(person.mind, Outside):
        yield Signal(f"{name}/percept", lambda: None)


def _of_machine(machine: Machine) -> Iterator[Signal]:
    name, body = f"machines/{machine.name}", machine.body
    yield Signal(f"{name}/pose", lambda: Pose.of(body.state), POSES)
    yield Signal(f"{name}/velocity", lambda: _velocity(body), POSES)
    yield Signal(f"{name}/state", lambda: state_of(machine), latched=True)
    if isinstance(machine, Amr):
        yield Signal(f"{name}/twist", lambda: machine.twist_now, POSES)
    if isinstance(machine, CommandedMachine):
        yield Signal(f"{name}/scan", lambda: Scan(machine.scan(reach=REACH), REACH), SCANS)


def _velocity(body: Body) -> Velocity:
    return Velocity(*body.state.velocity)


def state_of(machine: Machine) -> str:
    """Return "waiting" (for a machine), "stopped", "moving" or "idle"."""
    if machine.only_waits:
        return "waiting"
    if machine.is_held or getattr(machine, "disabled", False):
        return "stopped"
    return "moving" if machine.body.motion.end > machine.body.clock.now else "idle"


def _monitor(watch: SeparationMonitor) -> MonitorState:
    return MonitorState(watch.pair.distance(), watch.pair.required(watch.law))
