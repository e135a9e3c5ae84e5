"""The public names of `floorplan`, each loaded with its module when it is first used."""

from .checks import check
from .files.problems import (
    FloorplanError,
    InputError,
    Problem,
    UserError,
)
from .formats.movingai import load_movingai
from .loading import builtin, load, parse
from .model import (
    Axis,
    Door,
    Gantry,
    Gate,
    Human,
    Lane,
    Obstacle,
    Point,
    SafeZone,
    Station,
    Zone,
    rectangle,
)
from .plan import Floorplan

__all__ = [
    "Axis",
    "Door",
    "Floorplan",
    "FloorplanError",
    "Gantry",
    "Gate",
    "Human",
    "InputError",
    "Lane",
    "Obstacle",
    "Point",
    "Problem",
    "SafeZone",
    "Station",
    "UserError",
    "Zone",
    "builtin",
    "check",
    "load",
    "load_movingai",
    "parse",
    "rectangle",
]
