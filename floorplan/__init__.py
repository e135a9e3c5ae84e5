"""Floorplans: the floor, and what stands on it."""

from .building import footprint
from .checks import (
    LARGEST,
    SMALLEST,
    check,
    height_fault,
    polygon_fault,
    size_fault,
    standing_fault,
    starting_fault,
    time_fault,
)
from .document import Document, parse_yaml, read_yaml, refuse
from .fields import Angle, Flag, NotNegative, Number, Pair, Positive, Range, Strictly, whole
from .kinds import require, require_fields
from .loading import build, builtin, load, parse
from .map_writing import map_files
from .model import (
    EVERYBODY,
    LEFT_OUT_IF_EMPTY,
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
    free_area,
    rectangle,
)
from .movingai import CELL, load_movingai
from .named import Named
from .plan import Floorplan
from .problems import FloorplanError, InputError, Problem, UserError, shown, suggestion
from .reading import (
    LARGEST_RECORDED,
    is_file,
    is_there,
    no_garbage,
    read_bytes,
    read_lines,
    read_text,
    require_readable,
)
from .schema import ObstacleSchema
from .validation import Fault, Place, field_name, misfits
from .writing import floor_keys, lost, obstacle_keys
from .yaml_writing import yaml_text

__all__ = [
    "CELL",
    "EVERYBODY",
    "LARGEST",
    "LARGEST_RECORDED",
    "LEFT_OUT_IF_EMPTY",
    "SMALLEST",
    "Angle",
    "Axis",
    "Document",
    "Door",
    "Fault",
    "Flag",
    "Floorplan",
    "FloorplanError",
    "Gantry",
    "Gate",
    "Human",
    "InputError",
    "Lane",
    "Named",
    "NotNegative",
    "Number",
    "Obstacle",
    "ObstacleSchema",
    "Pair",
    "Place",
    "Point",
    "Positive",
    "Problem",
    "Range",
    "SafeZone",
    "Station",
    "Strictly",
    "UserError",
    "Zone",
    "build",
    "builtin",
    "check",
    "field_name",
    "floor_keys",
    "footprint",
    "free_area",
    "height_fault",
    "is_file",
    "is_there",
    "load",
    "load_movingai",
    "lost",
    "map_files",
    "misfits",
    "no_garbage",
    "obstacle_keys",
    "parse",
    "parse_yaml",
    "polygon_fault",
    "read_bytes",
    "read_lines",
    "read_text",
    "read_yaml",
    "rectangle",
    "refuse",
    "require",
    "require_fields",
    "require_readable",
    "shown",
    "size_fault",
    "standing_fault",
    "starting_fault",
    "suggestion",
    "time_fault",
    "whole",
    "yaml_text",
]
