"""Scene of a run: the floor, the rules, and who and what is there as it begins."""

from __future__ import annotations

from dataclasses import dataclass

from floorplan import Floorplan, Obstacle

from .body import PERSON
from .machine import MachineShape
from .rules import RuleSet

Pose = tuple[float, float, float]
"""x, y in metres, rotation in radians."""


@dataclass(frozen=True)
class Figure:
    """A person as others see them: a name, a personality, and a size (metres).

    `personality` is as the trial gives it: a built-in name, or the path of an .asl file.
    """

    name: str
    personality: str
    radius: float
    height: float


@dataclass(frozen=True)
class Scene:
    """All that stays the same during a run, but is needed to draw or to judge it.

    `starts` has the pose of every body at the beginning, people first, then `machines`. Obstacles
    in `passing` come and go: events say when. `controller` is the name of the gantry's, empty where
    there is no gantry or it is not known.
    """

    trial: str
    seed: int
    floorplan: Floorplan
    rules: RuleSet
    people: tuple[Figure, ...]
    starts: dict[str, Pose]
    machines: tuple[MachineShape, ...] = ()
    passing: tuple[Obstacle, ...] = ()
    controller: str = ""

    def kind(self, body: str) -> str:
        """Return the kind of the body named `body`; `KeyError` if there is none."""
        if body not in self.starts:
            raise KeyError(f"no body is called {body!r} (there are: {', '.join(self.starts)})")
        if any(person.name == body for person in self.people):
            return PERSON
        return self.machine(body).kind

    def machine(self, name: str) -> MachineShape:
        """Return the machine `name`; `KeyError` if there is none."""
        for machine in self.machines:
            if machine.name == name:
                return machine
        raise KeyError(f"no machine is called {name!r}")
