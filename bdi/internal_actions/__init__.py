"""Standard internal actions, registered by the modules of this package."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType

from ..actions import InternalAction
from . import (  # noqa: F401 - each adds its actions to the registry
    beliefs,
    containers,
    goals,
    lists,
    messages,
    registry,
    strings,
    time,
)

STANDARD: Mapping[str, InternalAction] = MappingProxyType(registry.STANDARD)

__all__ = ["STANDARD"]
