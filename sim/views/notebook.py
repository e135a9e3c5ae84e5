"""A run as a notebook shows it: its figures and its replay."""

from __future__ import annotations

import html

from ..record.outcome import Outcome
from ..record.summary import figures_in_words
from .replay import render
from .replay_data import replay_data

REPLAY_HEIGHT = 720
"""Pixels."""


def as_html(run: Outcome) -> str:
    """Return a table of the run's figures, and its replay page in a frame of its own."""
    return f"<div>{_table(run)}{_replay(run)}</div>"


def _table(run: Outcome) -> str:
    # A run that was broken off has no figures.
    figures = figures_in_words(run.summary) if run.summary else []
    rows = [("trial", run.scene.trial), ("duration", f"{run.duration:g} s"), *figures]
    lines = "".join(
        f'<tr><th scope="row" style="text-align:left">{html.escape(name)}</th>'
        f'<td style="text-align:left">{html.escape(value)}</td></tr>'
        for name, value in rows
    )
    return f"<table><tbody>{lines}</tbody></table>"


def _replay(run: Outcome) -> str:
    page = html.escape(render(replay_data(run)))
    style = f"width:100%;height:{REPLAY_HEIGHT}px;border:0"
    # In a sandbox the page runs its scripts, but can't reach the notebook around it.
    return (
        f'<iframe title="Replay" sandbox="allow-scripts" loading="lazy" style="{style}"'
        f' srcdoc="{page}"></iframe>'
    )
