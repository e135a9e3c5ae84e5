"""The internal actions that every program can use, by name."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType

from ..reasoning.actions import InternalAction
from . import (
    beliefs,
    chance,
    containers,
    control,
    goals,
    kinds,
    lists,
    literals,
    messages,
    output,
    plans,
    strings,
    suspension,
    time,
)

#: All of them; an agent may be given more.
STANDARD: Mapping[str, InternalAction] = MappingProxyType(
    {
        **output.ACTIONS,
        **time.ACTIONS,
        **goals.ACTIONS,
        **suspension.ACTIONS,
        **beliefs.ACTIONS,
        **plans.ACTIONS,
        **control.ACTIONS,
        **lists.ACTIONS,
        **literals.ACTIONS,
        **containers.ACTIONS,
        **strings.ACTIONS,
        **kinds.ACTIONS,
        **chance.ACTIONS,
        **messages.ACTIONS,
    }
)

__all__ = ["STANDARD"]
