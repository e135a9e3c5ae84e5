"""Plots of floors, paths and runs for publications, and films.

The methods of `run.plot` draw a run. These are the same functions, each with a matplotlib `Figure`
as its result. They need the extra `plot`.
"""

from __future__ import annotations

from collections.abc import Sequence

from ...record.incidents import Risk
from ...record.outcome import Outcome
from ...record.sampling import Span
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
from .maps import Of, density_map, heat_map, risk_map
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


class RunPlots:
    """Plots of a run. Every method returns a matplotlib `Figure`.

    Parameters
    ----------
    run : Run
        The run.
    """

    def __init__(self, run: Outcome) -> None:
        self._run = run

    def separation(
        self,
        person: str | Sequence[str] | None = None,
        machine: str | None = None,
        *,
        within: Span | None = None,
        width: Width = "double",
    ) -> Figure:
        """Draw the distance of people to a machine over time, and the required distance.

        Parameters
        ----------
        person : str or sequence of str, optional
            Names of people. By default all are drawn, or those with the least margin if there are
            many.
        machine : str, optional
            Name of the machine. See `plots.separation` for the default.
        within : (float, float), optional
            Begin and end in seconds. Defaults to the whole run.
        width : {"single", "double"}, optional
            Number of columns of a paper.
        """
        return separation(self._run, person, machine, within=within, width=width)

    def space_time(self, *, within: Span | None = None, width: Width = "double") -> Figure:
        """Draw x and y of all people and machines over time.

        Parameters
        ----------
        within, width
            See `separation`.
        """
        return space_time(self._run, within=within, width=width)

    def trails(self, *, within: Span | None = None, width: Width = "double") -> Figure:
        """Draw the paths of people and machines on the floor.

        Parameters
        ----------
        within, width
            See `separation`.
        """
        return trails(self._run, within=within, width=width)

    def heat_map(self, *, width: Width = "double") -> Figure:
        """Draw the time for which each cell was occupied by people.

        Parameters
        ----------
        width
            See `separation`.
        """
        return heat_map(self._run, width=width)

    def density_map(
        self, *, of: Of = "density", within: Span | None = None, width: Width = "double"
    ) -> Figure:
        """Draw the mean density or speed of people on the floor.

        Parameters
        ----------
        of : {"density", "speed"}, optional
            Quantity.
        within, width
            See `separation`.
        """
        return density_map(self._run, of=of, within=within, width=width)

    def risk_map(self, *, of: Risk = "margin", width: Width = "double") -> Figure:
        """Draw the risk in each cell of the floor.

        Parameters
        ----------
        of : {"margin", "time", "severity"}, optional
            Quantity. See `plots.risk_map`.
        width
            See `separation`.
        """
        return risk_map(self._run, of=of, width=width)
