"""Gantry controllers: the system under test, and baselines to beat.

A controller is a callable of one argument, the `GantryRobot`, that returns a generator of
things to wait for. Copy one of these files to write your own, and name it in a trial as
`package.module:name`.
"""

from .avoiding import avoiding
from .caution import Caution
from .finding import CONTROLLERS, Controller, ControllerError, controller_source, find_controller
from .oblivious import oblivious
from .parked import parked
from .pausing import pausing
from .supervision import supervised

__all__ = [
    "CONTROLLERS",
    "Caution",
    "Controller",
    "ControllerError",
    "avoiding",
    "controller_source",
    "find_controller",
    "oblivious",
    "parked",
    "pausing",
    "supervised",
]
