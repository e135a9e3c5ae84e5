"""Does its jobs as if it were alone."""

from __future__ import annotations

from ..gantry import GantryRobot, Steps


def oblivious(gantry: GantryRobot) -> Steps:
    """One job after the other, again and again if the trial says so."""
    while True:
        begin = gantry.now
        for job in gantry.jobs:
            yield gantry.do(job)
        if not gantry.repeat or gantry.now == begin:
            return
