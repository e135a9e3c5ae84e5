"""Machines of a trial before they move: what it says of each, by kind."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterable

from floorplan import Fault, Floorplan
from navigation import Stop

from .machine import Machine, MachineShape
from .stage import Stage


class MachineModel(ABC):
    """What a trial says of one machine; the model of a kind is a frozen dataclass.

    The name of the machine is given where it is asked: a model may be that of several.
    """

    @abstractmethod
    def shape(self, name: str, plan: Floorplan) -> MachineShape:
        """Return what others know of the machine called `name` on this floor."""

    @abstractmethod
    def make(self, name: str, stage: Stage) -> Machine:
        """Return the machine called `name`, which does nothing until it is to `begin`."""

    def faults(self, name: str, plan: Floorplan) -> Iterable[Fault]:
        """Return what can't be about it on this floor, each with its place in the model."""
        return ()

    def longest_stop(self, plan: Floorplan) -> Stop | None:
        """Return the longest and farthest stop that its limits leave it; None if not known."""
        return None
