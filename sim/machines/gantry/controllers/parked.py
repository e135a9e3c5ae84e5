"""Stays where it is."""

from __future__ import annotations

from ..drive import Steps
from ..robot import GantryRobot


def parked(gantry: GantryRobot) -> Steps:
    """Do nothing at all."""
    return
    yield
