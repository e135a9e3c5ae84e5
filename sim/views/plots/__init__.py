"""Pictures of floors, paths and runs, ready to be printed; and films.

`run.plot` draws a run; here are the same functions by themselves, each with a matplotlib `Figure`
as its result. Importing this needs the extra `plot`: `MissingExtraError` without it.
"""

from ..extras import MissingExtraError

try:
    import matplotlib as matplotlib
except ImportError:
    raise MissingExtraError(
        "pictures need matplotlib, which is missing: pip install 'floorwalker[plot]'"
    ) from None

from .density_map import density_map
from .film import ENDINGS, render, require_renderable
from .floor import floorplan
from .heat_map import heat_map
from .of_run import RunPlots
from .path import path
from .risk_map import risk_map
from .separation import separation
from .space_time import space_time
from .style import FORMATS, Width, require_savable, save
from .trails import trails

__all__ = [
    "ENDINGS",
    "FORMATS",
    "MissingExtraError",
    "RunPlots",
    "Width",
    "density_map",
    "floorplan",
    "heat_map",
    "path",
    "render",
    "require_renderable",
    "require_savable",
    "risk_map",
    "save",
    "separation",
    "space_time",
    "trails",
]
