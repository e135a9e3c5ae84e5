"""Plots of floors, paths and runs for publications, and films.

The methods of `run.plot` draw a run. These are the same functions, each with a matplotlib `Figure`
as its result. They need the extra `plot`.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import wraps
from typing import Concatenate, ParamSpec

from ...record.outcome import Outcome
from ..report_page import MissingExtraError

try:
    import matplotlib as matplotlib
except ImportError:
    raise MissingExtraError(
        "pictures need matplotlib, which is missing: pip install 'floorwalker[plot]'"
    ) from None

from matplotlib.figure import Figure

from ..film import ENDINGS, render, require_renderable
from .floor import floorplan
from .maps import density_map, heat_map, risk_map
from .paths import path, trails
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


_Arguments = ParamSpec("_Arguments")


def _of_run(
    draw: Callable[Concatenate[Outcome, _Arguments], Figure],
) -> Callable[Concatenate[RunPlots, _Arguments], Figure]:
    """Return a method that draws the run, with the documentation of the function."""

    @wraps(draw)
    def method(self: RunPlots, /, *args: _Arguments.args, **keys: _Arguments.kwargs) -> Figure:
        return draw(self._run, *args, **keys)

    return method


class RunPlots:
    """Plots of a run. Every method returns a matplotlib `Figure`.

    The arguments are those of the functions with the same names, without the run.

    Parameters
    ----------
    run : Run
        The run.
    """

    def __init__(self, run: Outcome) -> None:
        self._run = run

    separation = _of_run(separation)
    """Draw the distance of people to a machine over time, and the required distance."""

    space_time = _of_run(space_time)
    """Draw x and y of all people and machines over time."""

    trails = _of_run(trails)
    """Draw the paths of people and machines on the floor."""

    heat_map = _of_run(heat_map)
    """Draw the time for which each cell was occupied by people."""

    density_map = _of_run(density_map)
    """Draw the mean density or speed of people on the floor."""

    risk_map = _of_run(risk_map)
    """Draw the risk in each cell of the floor."""
