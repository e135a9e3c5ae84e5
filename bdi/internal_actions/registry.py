"""The internal actions that every program can use: each is added where it is defined."""

from __future__ import annotations

from ..reasoning.actions import InternalActions

STANDARD = InternalActions()
