"""Steerings of the user's own, by the names that a trial gives."""

from __future__ import annotations

import ast
import inspect
from collections.abc import Sequence
from math import dist
from pathlib import Path

from floorplan import Problem, UserError
from floorplan.files.values import require
from navigation import Motion

from ...core.custom_code import (
    REFUSED,
    CodeLocation,
    Definition,
    Kind,
    OwnCodeError,
    find_source,
    import_own,
    in_words,
    is_plain,
    methods,
    own_line,
)
from ...core.scenario import TrialError
from .outlook import Outlook
from .steering import Steering
from .traveller import Traveller

NEAR = 1e-6
"""Metres. So near to where somebody is, a motion of theirs begins."""


class SteeringError(UserError):
    """A steering of the user's own goes wrong."""


def _has_replan(definition: Definition) -> bool:
    if not isinstance(definition, ast.ClassDef):
        return False
    return not is_plain(definition) or "replan" in methods(definition)


STEERING = Kind(
    words="steering: a steering is a class that has replan(body, neighbours, outlook)",
    written=_has_replan,
    made=lambda found: inspect.isclass(found) and callable(getattr(found, "replan", None)),
)
"""The kind of class that a trial names as its steering."""


def steering_source(name: str, folder: Path, *, own_code: bool = True) -> CodeLocation:
    """Return the source of the steering `name`, a class beside the trial; it is not imported.

    `OwnCodeError` says what is missing; without `own_code` it is refused.
    """
    if not own_code:
        raise OwnCodeError(f"{name!r}: {REFUSED}")
    return find_source(name, folder, STEERING)


def find_steering(name: str, folder: Path, *, own_code: bool = True) -> Steering:
    """Return a new steering of the class `name`; `TrialError` if there is none."""
    try:
        made = import_own(steering_source(name, folder, own_code=own_code))
    except OwnCodeError as why:
        raise TrialError("steering", [Problem(f"the steering {why}")]) from why
    try:
        return _Held(name, made())
    except TypeError as why:
        message = f"the steering {name} can't be made without arguments: {why}"
        raise TrialError("steering", [Problem(message)]) from why


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
            parted = dist(motion.state(outlook.now).at, body.body.at)
        except Exception as why:
            raise SteeringError(f"{where}{own_line(why)}: {in_words(why)}") from why
        if parted > NEAR:
            raise SteeringError(f"{where}: its motion begins {parted:.3g} m from where they are")
        return motion
