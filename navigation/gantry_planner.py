"""Paths for an overhead gantry: straight where free, round walls and people otherwise."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

import numpy as np
import shapely

from floorplan import Floorplan, UserError

from .bodies import Disc
from .catalog import ROADMAP, Setting
from .choice import PlannerChoice
from .path import Path
from .planner import PathPlanner
from .roadmap import HAIR
from .world import CollisionWorld

Pose = tuple[float, float, float]
"""x, y in metres, rotation in radians."""

BEND = math.radians(30.0)
"""Radians. Largest bend of a gantry's path: it stops at every bend."""

_LEAST = 1e-3
"""Metres. Radius of the smallest disc to keep out of."""


class GantryPath(Path):
    """A path of the gantry's axis, whose rotation goes along in step with it.

    `points` are (N, 3): x, y in metres and the rotation in radians.
    """


class GantryPlanner:
    """Finds paths for the gantry of a floorplan, with its arm folded.

    Torso and folded arm together are taken as a disc about the axis, so the rotation is free
    everywhere: its radius is the arm's reach or, if that is more, half the torso's diagonal, and it
    begins at the lower of the two bottoms. What is not as tall is passed over. `agvs` gives AGVs
    that count as obstacles, by name, and where they stand (a location or a lane position, metres);
    by default none does, since the gantry works above them.

    `ValueError` if the floorplan has no gantry.
    """

    def __init__(self, plan: Floorplan, *, agvs: Mapping[str, float | str] | None = None) -> None:
        if plan.gantry is None:
            raise UserError(f"{plan.name} has no gantry")
        self.gantry = plan.gantry
        length, width = plan.gantry.torso[:2]
        self.radius = max(plan.gantry.arm_reach, math.hypot(length, width) / 2)
        counted = dict(agvs or {})
        self._world = CollisionWorld(
            Floorplan(
                plan.name,
                boundary=self._range(),
                obstacles=plan.obstacles,
                lanes=tuple(lane for lane in plan.lanes if lane.name in counted),
            ),
            bottom=min(plan.gantry.torso[2], plan.gantry.arm_bottom),
            top=plan.gantry.torso[3],
        )
        for name, at in counted.items():
            self._world.move_agv(name, at)
        self._paths = PathPlanner(self._world, self.radius, step=BEND)

    def plan(
        self,
        start: Pose,
        goal: Pose,
        *,
        keep_out: Sequence[tuple[float, float, float]] = (),
        planner: PlannerChoice | str = ROADMAP,
        parameters: Mapping[str, Setting] | None = None,
        seed: int = 0,
    ) -> GantryPath:
        """Return a path of the axis from `start` to `goal` (x, y in metres, rotation in radians).

        It keeps the arm's reach from what is tall, and the axis out of the discs `keep_out`
        (x, y, radius in metres), or out of the arm's reach of their centres where that is more.
        Of a disc that it stands in at the start it comes no nearer to the centre.
        `PlanningError` says why there is no path; `ValueError` if a pose is beyond an axis's range.
        """
        for pose, end in ((start, "start"), (goal, "goal")):
            self._check_range(pose, end)
        discs = {}
        for k, (x, y, radius) in enumerate(keep_out):
            # Who stands in a disc plans with one that ends just before where they stand.
            away = math.dist((x, y), start[:2]) - 2 * HAIR
            # The planner adds its own radius to everything, which is taken off here.
            solid = max(min(radius, away) - self.radius, _LEAST)
            discs[f"keep out {k}"] = Disc((x, y), solid)
        try:
            for name, disc in discs.items():
                self._world.place(name, disc)
            path = self._paths.plan(
                start[:2], goal[:2], planner=planner, parameters=parameters, seed=seed
            )
        finally:
            for body in self._world.bodies:
                if body.name in discs:
                    self._world.remove(body.name)
        so_far = np.append(0.0, np.cumsum(np.hypot(*np.diff(path.points, axis=0).T)))
        share = so_far / so_far[-1] if so_far[-1] > 0 else np.array([0.0, 1.0])
        turned = start[2] + share * (goal[2] - start[2])
        return GantryPath(
            np.column_stack([path.points, turned]),
            lambda: path.clearance,
            path.planner,
            path.checks,
        )

    def _range(self) -> shapely.Polygon:
        """All that the envelope can cover: the axes' ranges, and the radius around them."""
        x, y = self.gantry.x, self.gantry.y
        room = self.radius + 2 * HAIR
        return shapely.box(x.low - room, y.low - room, x.high + room, y.high + room)

    def _check_range(self, pose: Pose, end: str) -> None:
        if len(pose) != 3:
            raise UserError(f"the {end} must be x, y and a rotation, found {pose!r}")
        for name, axis, at in zip(("x", "y", "rotation"), self.gantry.axes, pose, strict=True):
            if not axis.low - HAIR <= at <= axis.high + HAIR:
                raise UserError(
                    f"the {end}'s {name} = {at:g} is outside the gantry's range"
                    f" {axis.low:g} … {axis.high:g}"
                )
