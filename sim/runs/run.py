"""Runs as values: a recorded one, and one of a loaded trial, with its view in a notebook."""

from __future__ import annotations

import html
from functools import cached_property
from typing import TYPE_CHECKING, Any

from floorplan.files.dataclass import dataclass

from ..record.notebook import html_table
from ..record.outcome import Outcome
from ..record.summary import figures_in_words
from ..trials.expectations import verdicts
from ..trials.timeline import Verdict
from ..trials.trial import Trial
from ..views.replay import render
from ..views.replay_data import replay_data

if TYPE_CHECKING:
    from ..views.plots import RunPlots
else:
    RunPlots = Any  # matplotlib is imported when a run is drawn


REPLAY_HEIGHT = 720
"""Pixels."""


def as_html(run: Outcome) -> str:
    """Return a table of the values of a run, and its replay page in a frame."""
    # An interrupted run has no summary.
    figures = figures_in_words(run.summary) if run.summary else []
    rows = [("trial", run.scene.trial), ("duration", f"{run.duration:g} s"), *figures]
    return f"<div>{html_table(rows)}{_replay(run)}</div>"


def _replay(run: Outcome) -> str:
    page = html.escape(render(replay_data(run)))
    style = f"width:100%;height:{REPLAY_HEIGHT}px;border:0"
    # The sandbox keeps the scripts of the page from the notebook around it.
    return (
        f'<iframe title="Replay" sandbox="allow-scripts" loading="lazy" style="{style}"'
        f' srcdoc="{page}"></iframe>'
    )


class Recorded(Outcome):
    """A finished or recorded run, with its pictures."""

    @property
    def plot(self) -> RunPlots:
        """Pictures of the run: `run.plot.separation()` and others, each a matplotlib `Figure`.

        `ImportError` without matplotlib.
        """
        from ..views.plots import RunPlots

        return RunPlots(self)

    def _repr_html_(self) -> str:
        """Return the view in a notebook: a table and the replay."""
        return as_html(self)


@dataclass(frozen=True, kw_only=True, repr=False)
class Run(Recorded):
    """Finished run of a loaded trial.

    Parameters
    ----------
    scene : Scene
        Initial state.
    duration : float
        Duration in seconds.
    summary : dict
        Summary as in `summary.json`.
    events : tuple of dict
        Events as in `events.jsonl`, in order of time.
    motions : dict of str to Motion
        Motion of each body during the whole run.
    violations : dict
        Intervals in seconds in which the rules were violated, by (person, machine).
    thoughts : tuple of dict, optional
        Thoughts of people, if a listener wanted them.
    requirements : dict, optional
        Required distance over time, by (person, machine), for laws that depend on more than speeds.
    trial : Trial
        The trial.
    """

    trial: Trial

    @cached_property
    def verdicts(self) -> list[Verdict]:
        """Results of the trial's expectations."""
        return verdicts(self.trial, self)

    @property
    def unmet(self) -> list[str]:
        """Expectations of the trial that this run does not meet, as messages."""
        return [str(verdict) for verdict in self.verdicts if not verdict.met]
