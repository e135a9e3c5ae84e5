"""Does its tasks as if it were alone."""

from __future__ import annotations

from ..drive import Steps
from ..robot import GantryRobot


def oblivious(gantry: GantryRobot) -> Steps:
    """One task after the other, straight to where it is."""
    while (task := (yield gantry.next_task())) is not None:
        yield gantry.do(task)
