"""The AGVs of a trial file: a list of moves for each, or its moves and whether it yields."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, Any

from pydantic import Discriminator, Field, Strict, Tag

from floorplan import NotNegative, Number, Strictly

from ..core.scenario import AgvMove


class _Move(Strictly):
    time: NotNegative
    to: str | Number


class _Keys(Strictly):
    moves: list[_Move] = []
    yields: Annotated[bool, Strict()] = Field(default=False, alias="yield")


def _form(value: object) -> str:
    return "moves" if isinstance(value, list) else "keys"


AgvKeys = Annotated[
    Annotated[list[_Move], Tag("moves")] | Annotated[_Keys, Tag("keys")], Discriminator(_form)
]
"""What stands at the name of an AGV."""


def agv_moves(keys: AgvKeys) -> tuple[AgvMove, ...]:
    """The moves of one AGV."""
    moves = keys if isinstance(keys, list) else keys.moves
    return tuple(AgvMove(move.time, move.to) for move in moves)


def yielding(agvs: Mapping[str, AgvKeys]) -> frozenset[str]:
    """The names of the AGVs that yield to people."""
    return frozenset(
        name for name, keys in agvs.items() if not isinstance(keys, list) and keys.yields
    )


def written_agv(moves: tuple[AgvMove, ...], yields: bool) -> Any:
    """An AGV as a file has it."""
    written = [{"time": move.time, "to": move.to} for move in moves]
    return {"yield": True, "moves": written} if yields else written
