"""Custom steerings by the names that a trial gives."""

from __future__ import annotations

import inspect
from collections.abc import Sequence
from functools import partial
from math import dist
from typing import Any

import numpy as np

from floorplan import Problem, UserError
from floorplan.files.values import require
from navigation import Motion

from ...core.custom_code import CodeFolder, Kind, argument_fault, in_words, own_line
from ...core.scenario import TrialError
from ...core.stage import Stage
from .crowd import Crowd
from .observe import Outlook
from .propose import Steering
from .sampled import SampledCrowd
from .sampled_scene import Floats, SampledScene, SampledSteering
from .traveller import Traveller

NEAR = 1e-6
"""Maximum distance from a person at which a new motion begins, m."""

ALIKE = 1e-3
"""Maximum difference between the speed of a person and that at which a new motion begins, m/s."""

METHODS = ("replan", "velocities")
"""Methods of a steering. It needs one of them."""


class SteeringError(UserError):
    """A custom steering fails."""


STEERING = Kind(
    noun="steering",
    words="steering: a steering has replan(body, neighbours, outlook) or velocities(scene)",
    accepts=lambda value: inspect.isclass(value) and any(map(partial(_has, value), METHODS)),
    error=SteeringError,
)
"""The kind of class that a trial names as its steering."""


def make_crowd(stage: Stage, name: str | None, seed: int) -> Crowd:
    """Return the crowd of a stage with the steering `name`, or the built-in one without a name.

    `seed` is that of the trial. `TrialError` if there is no such steering.
    """
    if name is None:
        return Crowd(stage)
    steering = _new_steering(name, stage.code_folder)
    if _has(steering, "replan"):
        return Crowd(stage, _Checked(name, steering))
    return SampledCrowd(stage, _CheckedVelocities(name, steering), seed)


def _has(value: object, method: str) -> bool:
    """Return whether a class or an object has a method of that name."""
    return callable(getattr(value, method, None))


def _new_steering(name: str, folder: CodeFolder) -> Any:
    """Return a new steering of the class `name`; `TrialError` if there is none."""
    try:
        made = folder.find(name, STEERING).load()
    except SteeringError as why:
        raise TrialError("steering", [Problem(str(why))]) from why
    if fault := argument_fault(made, {}):
        message = f"the steering {name} can't be made without arguments: {fault}"
        raise TrialError("steering", [Problem(message)])
    return made()


class _Checked:
    """Custom steering whose motions are checked."""

    def __init__(self, name: str, steering: Steering) -> None:
        self._name = name
        self._steering = steering

    def replan(
        self, body: Traveller, neighbours: Sequence[Traveller], outlook: Outlook
    ) -> Motion | None:
        """See `Steering`; `SteeringError` if it goes wrong."""
        where = f"the steering {self._name}, for {body.name} at t = {outlook.now:g} s"
        try:
            motion = self._steering.replan(body, neighbours, outlook)
            if motion is None:
                return None
            require(motion, Motion)
            begin, state = motion.state(outlook.now), body.body.state
        except Exception as why:
            raise SteeringError(f"{where}{own_line(why)}: {in_words(why)}") from why
        if (parted := dist(begin.at, state.at)) > NEAR:
            raise SteeringError(f"{where}: its motion begins {parted:.3g} m from where they are")
        if abs(begin.speed - state.speed) > ALIKE:
            speeds = f"{state.speed:.3g} m/s, not {begin.speed:.3g} m/s"
            raise SteeringError(f"{where}: its motion must begin at {speeds}")
        return motion


class _CheckedVelocities:
    """Custom steering whose velocities are checked."""

    def __init__(self, name: str, steering: SampledSteering) -> None:
        self._name = name
        self._steering = steering

    def velocities(self, scene: SampledScene) -> Floats:
        """See `SampledSteering`; `SteeringError` if it fails or returns other values."""
        try:
            velocity = np.asarray(self._steering.velocities(scene), dtype=float)
            if velocity.shape != scene.at.shape:
                raise ValueError(f"it must return shape {scene.at.shape}, not {velocity.shape}")
            if not np.isfinite(velocity[scene.steered]).all():
                raise ValueError("it returned a velocity that is not finite")
        except Exception as why:
            raise SteeringError(
                f"the steering {self._name}{own_line(why)}: {in_words(why)}"
            ) from why
        return velocity
