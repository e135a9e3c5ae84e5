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
    print_floor_notices(trial.floorplan)
    _print(trial.name, trial.notices)


def print_floor_notices(plan: Floorplan) -> None:
    """Print what was left out of the drawing of a floor, or taken for granted there."""
    _print(plan.name, plan.notices)


def _print(name: str, notices: Sequence[Problem]) -> None:
    for notice in notices[:MOST_NOTICES]:
        say(f"{name}: {notice}", err=True)
    if len(notices) > MOST_NOTICES:
        say(f"{name}: … and {len(notices) - MOST_NOTICES} notices more", err=True)
