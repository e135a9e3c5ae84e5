"""Machines of a trial before they move: a model of each, by kind."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from typing import Any, ClassVar

from pydantic import BaseModel, ConfigDict, TypeAdapter
from typing_extensions import Self

from floorplan import Fault, Floorplan
from navigation import Stop

from .machine import Category, Machine, MachineShape
from .stage import Stage


class MachineModel(ABC):
    """Description of one machine in a trial; the model of a kind is a frozen dataclass.

    Its fields are the keys in a trial file. The name of the machine is given where it is asked.
    """

    __pydantic_config__: ClassVar[ConfigDict] = ConfigDict(extra="forbid", allow_inf_nan=False)

    category: ClassVar[Category | None] = None
    """Category of every machine of the kind; None if that is known once it has its shape."""

    key_schema: ClassVar[type[BaseModel] | None] = None
    """Model of its keys in a trial file, if these are not its fields."""

    @classmethod
    def read(cls, name: str, keys: Mapping[str, Any]) -> Self:
        """Return the model of the machine `name` with these keys of a trial file.

        `pydantic.ValidationError` if there is something wrong with them.
        """
        return TypeAdapter(cls).validate_python(dict(keys))

    @abstractmethod
    def shape(self, name: str, plan: Floorplan) -> MachineShape:
        """Return the shape of the machine `name` on this floor, as others see it."""

    @abstractmethod
    def make(self, name: str, stage: Stage) -> Machine:
        """Return the machine `name`, which does nothing until `begin`."""

    def faults(self, plan: Floorplan, vehicles: Iterable[str]) -> Iterable[Fault]:
        """Return the faults it has on this floor, each with its place among the keys.

        `vehicles` are the names of those in the trial.
        """
        return ()

    def longest_stop(self, plan: Floorplan) -> Stop | None:
        """Return the longest and farthest stop that its limits leave it; None if not known."""
        return None


@dataclass(frozen=True)
class MachineEntry:
    """A machine of a trial: its kind, and what that kind's keys are for it.

    `kind` is the name of a kind, a `MachineModel`, or `package.module:Class`, a model of one's own
    that stands beside the trial.
    """

    kind: str | type[MachineModel]
    keys: dict[str, Any] = field(default_factory=dict)
