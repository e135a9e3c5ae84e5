"""Blackouts: times in which a machine does not see people."""

from __future__ import annotations

from collections.abc import Iterable
from functools import partial

from ..core.blackout import Blackout
from ..core.events import BlackoutBegan, BlackoutEnded
from ..core.stage import Stage


def begin(stage: Stage, blackouts: Iterable[Blackout]) -> None:
    """Let the blackouts of a trial happen, each when its start lets it."""
    for blackout in blackouts:
        stage.triggers.add(blackout.start, partial(_begin, stage, blackout))


def _begin(stage: Stage, blackout: Blackout) -> None:
    name, clock = blackout.machine, stage.clock
    stage.blind[name] += 1
    if stage.blind[name] == 1:
        stage.record(BlackoutBegan(machine=name))
        stage.machines[name].sight_changed()
    clock.call_at(clock.now + blackout.seconds, partial(_end, stage, name))


def _end(stage: Stage, name: str) -> None:
    stage.blind[name] -= 1
    if stage.blind[name] == 0:
        stage.record(BlackoutEnded(machine=name))
        stage.machines[name].sight_changed()
