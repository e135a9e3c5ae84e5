"""The internal actions every program can use, by name."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType

from . import beliefs, chance, goals, kinds, lists, messages, output, plans, queries, strings, time
from .call import Call, InternalAction, InternalActions

#: All of them. A program can use these and those its agents are given besides.
STANDARD: Mapping[str, InternalAction] = MappingProxyType(
    {
        **output.ACTIONS,
        **time.ACTIONS,
        **goals.ACTIONS,
        **beliefs.ACTIONS,
        **plans.ACTIONS,
        **queries.ACTIONS,
        **lists.ACTIONS,
        **strings.ACTIONS,
        **kinds.ACTIONS,
        **chance.ACTIONS,
        **messages.ACTIONS,
    }
)

__all__ = ["STANDARD", "Call", "InternalAction", "InternalActions"]
