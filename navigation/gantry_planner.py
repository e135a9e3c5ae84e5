"""Path planning for the gantry of a floorplan."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

import numpy as np
import shapely

from floorplan import Floorplan, UserError

from .bodies import Disc
from .catalog import ROADMAP, Path, PlannerChoice, Setting
from .planner import PathPlanner
from .roadmap import HAIR
from .vehicles import Pose
from .world import CollisionWorld

BEND = math.radians(30.0)
"""Maximum turn per waypoint of a gantry's path in radians. The gantry stops at each waypoint."""

_LEAST = 1e-3
"""Minimum radius of a disc to keep out of, in metres."""


class GantryPath(Path):
    """Path of the gantry's axis with its rotation.

    `points` have the shape (N, 3): x and y in metres, and the rotation in radians.
    """


class GantryPlanner:
    """Planner of paths for the gantry of a floorplan, with its arm folded.

    Torso and folded arm count as a disc around the axis, so the rotation is free everywhere. Lower
    obstacles are crossed.

    Parameters
    ----------
    plan : Floorplan
        Floorplan with a gantry.
    agvs : mapping of str to float or str, optional
        AGVs that are obstacles, with lane positions in metres or locations. By default none,
        because the gantry works above them.

    Raises
    ------
    floorplan.UserError
        If the floorplan has no gantry.
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
                name=plan.name,
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
        """Return a path of the axis from `start` to `goal`.

        Parameters
        ----------
        start, goal : tuple of float
            x and y in metres, and the rotation in radians.
        keep_out : sequence of tuple of float, optional
            Discs (x, y, radius) in metres that the axis stays out of. It also keeps the arm's reach
            from their centres. From inside a disc, it comes no closer to the centre.
        planner, parameters, seed
            See `PathPlanner.plan`.

        Returns
        -------
        GantryPath
            Path with the rotation in proportion to the length.

        Raises
        ------
        PlanningError
            If there is no path, with the reason.
        floorplan.UserError
            If a pose is outside the range of an axis.
        """
        for pose, end in ((start, "start"), (goal, "goal")):
            self._check_range(pose, end)
        discs = {}
        for k, (x, y, radius) in enumerate(keep_out):
            # From inside a disc, plan with a smaller one that ends just before the start.
            away = math.dist((x, y), start[:2]) - 2 * HAIR
            # The planner adds its own radius to all obstacles.
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
            points=np.column_stack([path.points, turned]),
            clear=lambda: path.clearance,
            planner=path.planner,
        )

    def _range(self) -> shapely.Polygon:
        """Return the area that the envelope can cover: the axes' ranges with a margin."""
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
