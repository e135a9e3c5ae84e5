"""The internal actions that every program can use; each module here adds its own."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType

from ..reasoning.actions import InternalAction
from . import (  # noqa: F401 - imported for what they add
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
    registry,
    strings,
    suspension,
    time,
)

#: All of them; an agent may be given more.
STANDARD: Mapping[str, InternalAction] = MappingProxyType(registry.STANDARD)

__all__ = ["STANDARD"]
