"""The public names of `floorplan`, each loaded with its module when it is first used."""

from .checks import check as check
from .files.problems import (
    FloorplanError as FloorplanError,
    InputError as InputError,
    Problem as Problem,
    UserError as UserError,
)
from .formats.movingai import load_movingai as load_movingai
from .loading import builtin as builtin, load as load, parse as parse
from .model import (
    Axis as Axis,
    Door as Door,
    Gantry as Gantry,
    Gate as Gate,
    Human as Human,
    Lane as Lane,
    Obstacle as Obstacle,
    Point as Point,
    SafeZone as SafeZone,
    Station as Station,
    Zone as Zone,
    rectangle as rectangle,
)
from .plan import Floorplan as Floorplan
