"""Missions of vehicles: to go to a place, to turn, to wait."""

from __future__ import annotations

import math

from pydantic import model_validator
from typing_extensions import Self

from floorplan import Floorplan, UserError
from floorplan.files.dataclass import dataclass
from floorplan.files.fields import Angle, Keyed, Number, Positive
from floorplan.files.problems import suggestion

from ..tasks import Step, Task


@dataclass(frozen=True, kw_only=True)
class Mission(Keyed):
    """One mission: `go` to a station or a pose, `turn` (radians) or `wait` (s)."""

    go: str | tuple[Number, ...] | None = None
    turn: Angle | None = None
    wait: Positive | None = None

    @model_validator(mode="after")
    def _one_kind(self) -> Self:
        if sum(value is not None for value in vars(self).values()) != 1:
            raise UserError("a mission is one of go, turn, wait")
        if isinstance(self.go, tuple) and len(self.go) not in (2, 3):
            raise UserError(f"go is a station, [x, y] or [x, y, rotation], not {[*self.go]}")
        return self

    def goal(self, plan: Floorplan) -> tuple[float, ...] | None:
        """Return its goal: x, y, and the rotation if required. None if it has no goal.

        `UserError` if there is no such station.
        """
        if not isinstance(self.go, str):
            return self.go
        stations = {station.name: station.position for station in plan.stations}
        if self.go not in stations:
            hint = suggestion(self.go, stations) if stations else "the floor has none"
            raise UserError(f"no station is called {self.go!r}; {hint}")
        return stations[self.go]


def task_of(mission: Mission, plan: Floorplan) -> Task:
    """Return the task of a mission."""
    if mission.wait is not None:
        return Task("wait", [Step("wait", seconds=mission.wait)])
    if mission.turn is not None:
        return Task("turn", [Step("turn", target=(0.0, 0.0, mission.turn))])
    goal = mission.goal(plan)
    assert goal is not None
    x, y, rotation = (*goal, math.nan)[:3]
    fields = {"to": mission.go} if isinstance(mission.go, str) else {}
    return Task("go", [Step("go", target=(x, y, rotation))], fields=fields)
