"""Steerings by the names that a trial gives: baselines, and those of the user's own."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Mapping, Sequence
from math import dist

from floorplan import Problem, UserError
from floorplan.files.values import require
from navigation import Motion

from ...core.custom_code import CodeFolder, Kind, argument_fault, in_words, own_line
from ...core.scenario import TrialError
from ...core.stage import Stage
from ..steering_baselines.orca import Orca
from ..steering_baselines.scene import VelocityModel
from ..steering_baselines.social_force import SocialForce
from .crowd import Crowd
from .observe import Outlook
from .propose import Steering
from .sampled import SampledCrowd
from .traveller import Traveller

NEAR = 1e-6
"""Maximum distance from a person at which a new motion begins, m."""

ALIKE = 1e-3
"""Maximum difference between the speed of a person and that at which a new motion begins, m/s."""


class SteeringError(UserError):
    """A steering of the user's own goes wrong."""


BASELINES: Mapping[str, Callable[[int], VelocityModel]] = {
    "orca": lambda seed: Orca(),
    "social_force": SocialForce,
}
"""Sampled baselines of the literature by name. Each is made from the seed of the trial."""

STEERING = Kind(
    noun="steering",
    words="steering: a steering is a class that has replan(body, neighbours, outlook)",
    accepts=lambda found: inspect.isclass(found) and callable(getattr(found, "replan", None)),
    error=SteeringError,
    builtin=BASELINES,
)
"""The kind of class that a trial names as its steering."""


def make_crowd(stage: Stage, name: str | None, seed: int) -> Crowd:
    """Return the crowd of a stage with the steering `name`, or the built-in one without a name.

    `seed` is that of the trial. `TrialError` if there is no such steering.
    """
    if name is None:
        return Crowd(stage)
    if name in BASELINES:
        return SampledCrowd(stage, BASELINES[name](seed))
    return Crowd(stage, find_steering(name, stage.code_folder))


def find_steering(name: str, folder: CodeFolder) -> Steering:
    """Return a new steering of the class `name`; `TrialError` if there is none."""
    try:
        made = folder.find(name, STEERING).load()
    except SteeringError as why:
        raise TrialError("steering", [Problem(str(why))]) from why
    if fault := argument_fault(made, {}):
        message = f"the steering {name} can't be made without arguments: {fault}"
        raise TrialError("steering", [Problem(message)])
    return _Held(name, made())


class _Held:
    """A steering of the user's own, held to what it promises."""

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
