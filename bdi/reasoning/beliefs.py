"""The belief base: beliefs and rules, in order, found by functor and first argument.

Beside them are live beliefs, which a source supplies whenever a query asks for them.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from types import MappingProxyType
from typing import TypeAlias

from ..language.order import with_more_annots
from ..language.program import Key, Rule
from ..language.substitution import Unifier, substitute_literal
from ..language.terms import (
    FROM_PERCEPT,
    FROM_SELF,
    ONLY_PERCEPT,
    ONLY_SELF,
    Literal,
    Qualified,
    Term,
    Var,
)
from ..language.unification import matched, unified, unify
from .basis import Basis, basis_of
from .shelves import LiveShelf, Shelf

LiveBeliefs: TypeAlias = "Mapping[tuple[str, int], Callable[[], Iterable[tuple[Term, ...]]]]"
"""By functor and arity: a function that returns the arguments of each belief that holds now."""


def has_source(literal: Literal) -> bool:
    """Return True if an annotation says where the literal comes from."""
    return any(isinstance(annot, Literal) and annot.functor == "source" for annot in literal.annots)


def with_source(literal: Literal) -> Literal:
    """Return the literal with a source: its own, or else the agent itself."""
    if not literal.annots:
        return literal.with_annots(ONLY_SELF)
    if literal.annots is ONLY_SELF or has_source(literal):
        return literal
    return with_more_annots(literal, FROM_SELF)


def _among(some: tuple[Term, ...], others: tuple[Term, ...]) -> bool:
    return some is others or all(annot in others for annot in some)


class BeliefBase:
    """Beliefs and rules; `live` beliefs answer queries, and are not counted among the others.

    Attributes:
        shelves: what it holds, by functor, arity and negation.
        lost_percepts: by their identity, the beliefs that the program has taken the source
            `percept` off since the base was last updated from percepts.
    """

    def __init__(self, live: LiveBeliefs = MappingProxyType({})) -> None:
        self.shelves: dict[Key, Shelf] = {
            (functor, arity, False): LiveShelf(functor, arity, source)
            for (functor, arity), source in live.items()
        }
        self.lost_percepts: dict[object, Literal] = {}
        self._bases: dict[Key, Basis | None] = {}
        self._read: list[Shelf] = []

    def __iter__(self) -> Iterator[Literal]:
        """Iterate over the beliefs, without the rules."""
        for shelf in self.shelves.values():
            for clause in shelf.all():
                if isinstance(clause, Literal):
                    yield clause

    def __len__(self) -> int:
        return sum(len(shelf) - shelf.rules for shelf in self.shelves.values())

    def all_clauses(self) -> tuple[Literal | Rule, ...]:
        """Return all that may answer a query for anything."""
        return tuple(c for shelf in self.shelves.values() for c in shelf.everything())

    def find(self, literal: Literal) -> Literal | None:
        """Return the belief that equals a literal, annotations aside."""
        shelf = self.shelves.get(literal.key)
        return None if shelf is None else shelf.find(literal.args)

    def add_rule(self, rule: Rule, *, at_end: bool = False) -> None:
        """Add a rule before the clauses of its functor and arity, or after them."""
        self._shelf(rule.head.key).add(rule, at_end=at_end)
        self._find_out_anew()

    def remove_rule(self, rule: Rule) -> None:
        """Remove the first rule that is the same and has the annotations, if there is one."""
        shelf = self.shelves.get(rule.head.key)
        if shelf is None:
            return
        for known in shelf.all():
            if (
                isinstance(known, Rule)
                and known.is_same(rule)
                and _among(rule.head.annots, known.head.annots)
            ):
                shelf.remove_rule(known)
                self._find_out_anew()
                return

    def has_plain_rules(self, key: Key) -> bool:
        """Return whether the rules of that key are plain, and those that they ask (`basis_of`)."""
        if key not in self._bases:
            basis = self._bases[key] = basis_of(self.shelves, key)
            if basis is not None and basis.lasts:
                read = [self.shelves[one] for one in basis.keys if one in self.shelves]
                self.shelves[key].keep_answers(read)
                self._read += read
        return self._bases[key] is not None

    def _find_out_anew(self) -> None:
        """Forget what rules go back to: there is another shelf, or another rule."""
        if not self._bases:
            return
        self._bases.clear()
        for shelf in self._read:
            shelf.answers, shelf.readers = None, ()
        self._read.clear()

    def _shelf(self, key: Key) -> Shelf:
        """Return the shelf of a key, a new one if there is none yet."""
        shelf = self.shelves.get(key)
        if shelf is None:
            shelf = self.shelves[key] = Shelf()
            self._find_out_anew()
        return shelf

    def rules(self) -> list[Rule]:
        """Return the rules."""
        shelves = self.shelves.values()
        return [clause for shelf in shelves for clause in shelf.all() if isinstance(clause, Rule)]

    def add(self, literal: Literal, *, at_end: bool = False) -> Literal | None:
        """Add a belief, or annotations to one. Return what is new of it, or None."""
        shelf = self._shelf(literal.key)
        known = shelf.find(literal.args)
        if known is None:
            shelf.add(literal, at_end=at_end)
            return literal
        # Only what is new makes an event, and the event has nothing else.
        added = tuple(annot for annot in literal.annots if annot not in known.annots)
        if not added:
            return None
        shelf.replace(with_more_annots(known, *added))
        return literal.with_annots(added)

    def perceive(self, percept: Literal) -> Literal | None:
        """Believe a percept. Return what is new, as `add`; None if it is believed as one."""
        shelf = self._shelf(percept.key)
        known = shelf.find(percept.args)
        if known is not None and FROM_PERCEPT in known.annots:
            return None
        if percept.annots:
            belief = with_more_annots(percept, FROM_PERCEPT)
        else:
            belief = percept.with_annots(ONLY_PERCEPT)
        if known is not None:
            return self.add(belief)
        shelf.add(belief)
        return belief

    def forget_percept(self, percept: Literal) -> Literal | None:
        """Stop believing a percept, unless it has other sources. Return as `remove`."""
        shelf = self.shelves.get(percept.key)
        known = None if shelf is None else shelf.find(percept.args)
        if shelf is None or known is None or FROM_PERCEPT not in known.annots:
            return None
        if known.annots is ONLY_PERCEPT:
            shelf.remove(known.args)
            return known
        removed = percept.with_annots(ONLY_PERCEPT)
        self._strip(shelf, known, ONLY_PERCEPT)
        del self.lost_percepts[known.identity]  # nothing that the program has done
        return removed

    def remove(self, literal: Literal, u: Unifier) -> Literal | None:
        """Take annotations off a belief, and remove it when it has no source left.

        A literal with variables that is not believed as it stands removes the first belief with
        which it unifies, and binds them in `u`. Return the literal removed, or None.
        """
        shelf = self.shelves.get(literal.key)
        if shelf is None:
            return None
        known = shelf.find(literal.args)
        if known is not None and _among(literal.annots, known.annots):
            if not literal.annots and has_source(known):
                return None
            self._strip(shelf, known, literal.annots)
            return literal
        if literal.ground:
            return None
        for belief in shelf.kept(literal, u):
            if isinstance(belief, Rule):
                continue
            if literal.annots is belief.annots is ONLY_SELF:
                solution = matched(literal, belief, u)
            else:
                solution = unified(literal, belief, u)
            if solution is not None:
                u.update(solution)
                removed = substitute_literal(literal, u)
                return removed if self._strip(shelf, belief, removed.annots) else None
        return None

    def swap(self, literal: Literal) -> Literal | None:
        """Put a belief of the agent's own in the place of the only one of its functor and arity.

        Return the one that was there, or None if nothing has changed.
        """
        shelf = self.shelves.get(literal.key)
        return None if shelf is None or literal.annots is not ONLY_SELF else shelf.swap(literal)

    def remove_first(self, key: Key, annots: tuple[Term, ...]) -> Literal | None:
        """Take annotations off the first belief that has them all, whatever its arguments.

        Return what was removed, or None if there is no such belief or it has other sources.
        """
        shelf = self.shelves.get(key)
        if shelf is None:
            return None
        for belief in shelf.all():
            if isinstance(belief, Rule):
                continue
            if belief.annots is annots is ONLY_SELF:
                shelf.remove(belief.args)
                return belief
            if _among(annots, belief.annots):
                removed = belief if belief.annots is annots else belief.with_annots(annots)
                return removed if self._strip(shelf, belief, annots) else None
        return None

    def _strip(self, shelf: Shelf, belief: Literal, annots: tuple[Term, ...]) -> bool:
        """Take annotations off; return True if the belief was removed with its last source."""
        if belief.annots is ONLY_SELF and annots is ONLY_SELF:
            shelf.remove(belief.args)
            return True
        # It still holds: the next update from percepts believes it anew.
        if FROM_PERCEPT in belief.annots and FROM_PERCEPT in annots:
            self.lost_percepts[belief.identity] = belief
        if belief.annots is annots:
            shelf.remove(belief.args)
            return True
        left = belief.with_annots(tuple(a for a in belief.annots if a not in annots))
        if has_source(left):
            shelf.replace(left)
            return False
        shelf.remove(belief.args)
        return True

    def matching(self, pattern: Literal | Var | Qualified, u: Unifier) -> list[Literal]:
        """Return the beliefs that unify with a pattern, each on its own."""
        clauses: tuple[Literal | Rule, ...]
        if isinstance(pattern, Literal):
            shelf = self.shelves.get(pattern.key)
            clauses = () if shelf is None else shelf.candidates(pattern, u)
        else:
            clauses = self.all_clauses()
        return [
            clause
            for clause in clauses
            if isinstance(clause, Literal) and unify(pattern, clause, dict(u))
        ]
