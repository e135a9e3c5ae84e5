"""Does its tasks as if it were alone."""

from __future__ import annotations

from ..drive import Steps
from ..robot import GantryRobot


def oblivious(gantry: GantryRobot) -> Steps:
    """Do one task after the other, on the straight path to it."""
    while (task := (yield gantry.next_task())) is not None:
        yield gantry.do(task)
