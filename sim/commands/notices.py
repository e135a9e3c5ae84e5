"""Notices on what files leave open, printed."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from .consoles import say

if TYPE_CHECKING:
    from floorplan import Floorplan, Problem
    from sim import Trial

MOST_NOTICES = 20
"""Number of notices of one kind that are shown."""


def print_notices(trial: Trial) -> None:
    """Print the notices on entries that make no difference, or may be meant otherwise."""
    _print(trial.name, trial.notices)


def count_floor_notices(plan: Floorplan, source: str) -> None:
    """Print how many notices there are on the drawing of a floor, and how `source` shows them."""
    if plan.notices:
        count = len(plan.notices)
        notices = f"{count:,} notice{'' if count == 1 else 's'}"
        say(
            f"{plan.name}: the drawing has {notices}; `floorwalker check {source}` lists them",
            err=True,
        )


def print_floor_notices(plan: Floorplan) -> None:
    """Print what was left out of the drawing of a floor, or taken for granted there."""
    _print(plan.name, plan.notices)


def _print(name: str, notices: Sequence[Problem]) -> None:
    for notice in notices[:MOST_NOTICES]:
        say(f"{name}: {notice}", err=True)
    if len(notices) > MOST_NOTICES:
        say(f"{name}: … and {len(notices) - MOST_NOTICES} notices more", err=True)
