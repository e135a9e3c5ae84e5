"""Runs that can be looked at: a recorded one, and one of a trial that is at hand."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

from ..record.outcome import Outcome
from ..trials.comparison import Verdict
from ..trials.expectations import verdicts
from ..trials.trial import Trial
from ..views.notebook import as_html

if TYPE_CHECKING:
    from ..views.plots import RunPlots


@dataclass(frozen=True, repr=False)
class Recorded(Outcome):
    """A run that happened, with its pictures."""

    @property
    def plot(self) -> RunPlots:
        """Pictures of it: `run.plot.separation()` and others, each a matplotlib `Figure`.

        `ImportError` without matplotlib.
        """
        from ..views.plots import RunPlots

        return RunPlots(self)

    def _repr_html_(self) -> str:
        """The run in a notebook: its figures, and the replay."""
        return as_html(self)


@dataclass(frozen=True, kw_only=True, repr=False)
class Run(Recorded):
    """A run of a trial that is at hand."""

    trial: Trial

    @cached_property
    def verdicts(self) -> list[Verdict]:
        """Verdicts on the trial's expectations."""
        return verdicts(self.trial, self)

    @property
    def unmet(self) -> list[str]:
        """The trial's expectations that this run does not meet, in words."""
        return [str(verdict) for verdict in self.verdicts if not verdict.met]
