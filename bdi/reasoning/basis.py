"""Basis of rules: the kinds of beliefs and rules from which their answers follow."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from ..language.program import Key, Rule, are_apart
from .shelves import Shelf

MOST_LAYERS = 12
"""Largest number of rules of which each asks the next."""


@dataclass(frozen=True)
class Basis:
    """Functors, arities and negations of what rules go back to; True if their answers last."""

    keys: frozenset[Key]
    lasts: bool


def basis_of(shelves: Mapping[Key, Shelf], key: Key) -> Basis | None:
    """Return what the rules of that key go back to; None where they are not plain throughout.

    Plain ones have values and variables for arguments, and ask each other no more than
    `MOST_LAYERS` times over, so that none goes back to itself.
    """
    found, lasts, asked = {key}, True, {key}
    for _ in range(MOST_LAYERS):
        there = [shelves[one] for one in asked if one in shelves]
        rules = [one for shelf in there for one in shelf.all() if isinstance(one, Rule)]
        if not all(are_apart(rule.head.args) for rule in rules):
            return None
        lasts = lasts and all(shelf.keeps_answers for shelf in there)
        lasts = lasts and all(rule.lasts for rule in rules)
        asked = {one for rule in rules for one in rule.asks}
        if not asked:
            return Basis(frozenset(found), lasts)
        found |= asked
    # Rules that go back to themselves are never through with asking, and end here as well.
    return None
