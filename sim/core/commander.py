"""Carries out what somebody outside wants done in a run."""

from __future__ import annotations

from functools import partial
from typing import Any

from shapely.geometry import Polygon

from floorplan import Obstacle

from .clock import Turn
from .commands import Command
from .events import Commanded
from .recorder import rounded
from .scenario import spot
from .stage import Stage

BY_COMMAND = "command"
"""The reason for which a machine is held by command."""


class Commander:
    """Carries out commands on a stage, each at its time; it records each of them.

    What it does is what it records: figures count to nine decimals.
    """

    def __init__(self, stage: Stage) -> None:
        self._stage = stage

    def give(self, command: Command) -> None:
        """Let `command` be carried out at its time, after all else of that instant."""
        carry_out = partial(self._carry_out, command)
        self._stage.clock.call_at(rounded(float(command.time)), carry_out, Turn.COMMAND)

    def _carry_out(self, command: Command) -> None:
        stage = self._stage
        to = None if command.to is None else rounded(spot(stage.floorplan, command.to))
        one = None if command.block is None else _as_recorded(command.block)
        stage.record(
            Commanded(
                send=command.send,
                to=to,
                block=None if one is None else one.name,
                footprint=None if one is None else _corners(one),
                bottom=None if one is None else one.bottom,
                top=None if one is None else one.top,
                clear=command.clear,
                hold=command.hold,
                release=command.release,
            )
        )
        if to is not None:
            for person in stage.people:
                if person.name == command.send:
                    person.send((to[0], to[1]))
        if one is not None:
            stage.put_down(one)
        if command.clear is not None:
            stage.take_up(command.clear)
        if command.hold is not None:
            stage.machines[command.hold].stand_for(BY_COMMAND, True)
        if command.release is not None:
            stage.machines[command.release].stand_for(BY_COMMAND, False)


def _corners(one: Obstacle) -> list[Any]:
    return [*one.footprint.exterior.coords[:-1]]


def _as_recorded(one: Obstacle) -> Obstacle:
    """Return an obstacle as it is read again from what is recorded of it."""
    corners = [tuple(map(float, rounded(corner))) for corner in _corners(one)]
    bottom, top = rounded((float(one.bottom), float(one.top)))
    return Obstacle(one.name, Polygon(corners), bottom, top)
