"""Stays where it is."""

from __future__ import annotations

from ..gantry import GantryRobot, Steps


def parked(gantry: GantryRobot) -> Steps:
    """Do nothing at all."""
    return
    yield
