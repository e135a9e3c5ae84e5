"""OMPL's search for a path of a vehicle in SE(2), by RRT-Connect."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable
from typing import Any

import ompl.base as ob
import ompl.geometric as og

from floorplan import Point

from .sampling import Motions, Places
from .vehicles import Pose

_LINKS = 10_000
"""Maximum number of links of a search."""

_RANGE = 6.0
"""Metres. Maximum step of OMPL's trees."""


class PoseSearch:
    """OMPL's objects for one query."""

    def __init__(
        self,
        low: Point,
        high: Point,
        link: Callable[[Pose, Pose], bool],
        fits: Callable[[Pose], bool],
    ) -> None:
        bounds = ob.RealVectorBounds(2)
        for axis in (0, 1):
            bounds.setLow(axis, low[axis])
            bounds.setHigh(axis, high[axis])
        self._space: Any = ob.SE2StateSpace()
        self._space.setBounds(bounds)
        self._information: Any = ob.SpaceInformation(self._space)
        # OMPL's pointers do not keep these objects alive.
        self._links: Any = Motions(self._information, link, _LINKS, _pose_of)
        self._poses: Any = Places(self._information, lambda pose, _: fits(pose), math.inf, _pose_of)
        self._information.setMotionValidator(self._links)
        self._information.setStateValidityChecker(self._poses)
        self._setup: Any = og.SimpleSetup(self._information)

    def run(self, begin: Pose, end: Pose, iterations: int) -> list[Pose] | None:
        """Return the states of a path from `begin` to `end`, or None."""
        self._setup.setStartAndGoalStates(self._state(begin), self._state(end))
        planner = og.RRTConnect(self._information)
        planner.setRange(_RANGE)
        self._setup.setPlanner(planner)
        self._setup.setup()
        count = itertools.count(1)
        self._setup.solve(ob.PlannerTerminationCondition(lambda: next(count) > iterations))
        if not self._setup.haveExactSolutionPath():
            return None
        states = [*map(_pose_of, self._setup.getSolutionPath().getStates())]
        return [begin, *states[1:-1], end]

    def release(self) -> None:
        """Release OMPL's objects in a safe order."""
        self._setup = None
        self._links = None
        self._poses = None
        self._information = None
        self._space = None

    def _state(self, pose: Pose) -> Any:
        state = self._information.allocState()
        state.setXY(pose[0], pose[1])
        yaw = math.remainder(pose[2], math.tau)
        state.setYaw(yaw if yaw < math.pi else -math.pi)  # OMPL's range ends below π
        return state


def _pose_of(state: Any) -> Pose:
    return (float(state.getX()), float(state.getY()), float(state.getYaw()))
