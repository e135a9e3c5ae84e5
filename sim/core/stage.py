"""The stage of a trial: everything that people and machines share while it runs."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Protocol

from floorplan import Floorplan
from navigation import CollisionWorld

from .body import Body
from .clock import Clock
from .machine import Machine
from .recorder import Record
from .rules import RuleSet
from .triggers import Triggers


class Bystander(Protocol):
    """A person as the referee and machines know them."""

    @property
    def name(self) -> str:
        """Their name."""
        ...

    @property
    def body(self) -> Body:
        """Their body."""
        ...

    @property
    def is_recorded(self) -> bool:
        """True of somebody who walks as they were measured: nobody can put them elsewhere."""
        ...

    @property
    def away(self) -> bool:
        """Whether they are not on the floor: not yet, or not any more."""
        ...

    def warn(self, percept: str, machine: Machine) -> None:
        """Perceive `percept` about a machine, and go home for a violation."""
        ...

    def floor_changed(self) -> None:
        """Take note that a machine has come to rest on the floor."""
        ...


@dataclass(eq=False, kw_only=True)
class Stage:
    """State that everybody in a simulation shares.

    `people` and `machines` are there from the beginning, each complete before anybody acts;
    `fastest` (m/s) is the highest speed of people. Machines that come to rest say so by
    `came_to_rest`.
    """

    floorplan: Floorplan
    rules: RuleSet
    folder: Path
    end: float
    clock: Clock
    record: Record
    triggers: Triggers
    world: CollisionWorld
    fastest: float
    own_code: bool = True
    people: Sequence[Bystander] = ()
    machines: dict[str, Machine] = field(default_factory=dict)
    on_rest: list[Callable[[Machine], None]] = field(default_factory=list)
    """Called whenever a machine has come to rest, after people and before machines take note."""

    @property
    def vehicles(self) -> Iterable[Machine]:
        """The machines that drive on the floor, and can block people's paths."""
        return (m for m in self.machines.values() if m.shape.category == "vehicle")

    @property
    def robots(self) -> Iterable[Machine]:
        """The machines that work above the floor."""
        return (m for m in self.machines.values() if m.shape.category == "robot")

    def came_to_rest(self, machine: Machine) -> None:
        """Let everybody see that a machine has come to rest on the floor."""
        self.place_machines()
        for person in self.people:
            person.floor_changed()
        for notified in self.on_rest:
            notified(machine)
        for other in self.machines.values():
            other.floor_changed()

    def place_machines(self) -> None:
        """Put the machines of the collision world where they are now."""
        for machine in self.vehicles:
            machine.stand_in(self.world)
