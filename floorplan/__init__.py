"""Floorplans: the floor, and what stands on it."""

from .checks import LARGEST, check, size_fault, standing_fault, starting_fault
from .document import (
    Document,
    Fault,
    Place,
    field_name,
    misfits,
    parse_yaml,
    read_yaml,
    refuse,
)
from .kinds import require, require_fields
from .loading import build, builtin, load, parse
from .model import (
    Axis,
    Gantry,
    Human,
    Lane,
    Obstacle,
    Point,
    SafeZone,
    Station,
    rectangle,
)
from .movingai import CELL, load_movingai
from .named import Named
from .plan import Floorplan
from .problems import FloorplanError, InputError, Problem, suggestion
from .reading import (
    LARGEST_RECORDED,
    is_there,
    read_bytes,
    read_lines,
    read_text,
    require_readable,
)
from .schema import NotNegative, Number, Pair, Positive, Range, Strictly
from .writing import floor_keys, lost
from .yaml_writing import yaml_text

__all__ = [
    "CELL",
    "LARGEST",
    "LARGEST_RECORDED",
    "Axis",
    "Document",
    "Fault",
    "Floorplan",
    "FloorplanError",
    "Gantry",
    "Human",
    "InputError",
    "Lane",
    "Named",
    "NotNegative",
    "Number",
    "Obstacle",
    "Pair",
    "Place",
    "Point",
    "Positive",
    "Problem",
    "Range",
    "SafeZone",
    "Station",
    "Strictly",
    "build",
    "builtin",
    "check",
    "field_name",
    "floor_keys",
    "is_there",
    "load",
    "load_movingai",
    "lost",
    "misfits",
    "parse",
    "parse_yaml",
    "read_bytes",
    "read_lines",
    "read_text",
    "read_yaml",
    "rectangle",
    "refuse",
    "require",
    "require_fields",
    "require_readable",
    "size_fault",
    "standing_fault",
    "starting_fault",
    "suggestion",
    "yaml_text",
]
