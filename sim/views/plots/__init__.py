"""Pictures of floors, ways and runs, ready to be printed; and moving ones.

`run.plot` draws a run; here are the same functions by themselves, each with a matplotlib `Figure`
as its result. Needs the extra `plot`.
"""

from .floor import floorplan
from .heat_map import heat_map
from .of_run import RunPlots
from .path import path
from .rendering import ENDINGS, render, require_renderable
from .saving import FORMATS, require_savable, save
from .separation import separation
from .space_time import space_time
from .style import MissingExtraError, Width
from .trails import trails

__all__ = [
    "ENDINGS",
    "FORMATS",
    "MissingExtraError",
    "RunPlots",
    "Width",
    "floorplan",
    "heat_map",
    "path",
    "render",
    "require_renderable",
    "require_savable",
    "save",
    "separation",
    "space_time",
    "trails",
]
