"""Pictures of floors, paths and runs, ready to be printed; and films.

`run.plot` draws a run; here are the same functions by themselves, each with a matplotlib `Figure`
as its result. Importing this needs the extra `plot`: `MissingExtraError` without it.
"""

from ..report_page import MissingExtraError

try:
    import matplotlib as matplotlib
except ImportError:
    raise MissingExtraError(
        "pictures need matplotlib, which is missing: pip install 'floorwalker[plot]'"
    ) from None

from ..film import ENDINGS, render, require_renderable
from .floor import floorplan
from .maps import density_map, heat_map, risk_map
from .paths import path, trails
from .run_plots import RunPlots
from .style import FORMATS, Width, require_savable, save
from .time_series import separation, space_time

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
