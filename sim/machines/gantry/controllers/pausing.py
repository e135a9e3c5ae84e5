"""Slows down and stops for people, and goes on when they are gone."""

from __future__ import annotations

from ..drive import Steps
from ..robot import GantryRobot
from .caution import Caution


def pausing(gantry: GantryRobot) -> Steps:
    """Do one task after the other, on the straight path to it, at the speed that people allow."""
    caution = Caution(gantry)
    while (task := (yield gantry.next_task())) is not None:
        while task.next_step is not None:
            yield from caution.go((yield gantry.locate(task)))
            yield gantry.handle(task)
