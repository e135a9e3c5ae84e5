"""The belief base: beliefs and rules, in order, found by functor and first argument.

Beside them stand live beliefs, which a source gives whenever a query comes to them.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from operator import itemgetter
from types import MappingProxyType
from typing import TypeAlias

from .order import sorted_annots
from .program import Rule
from .terms import FROM_PERCEPT, ONLY_PERCEPT, ONLY_SELF, Literal, Term, Var, is_ground
from .unify import Unifier, substitute, substitute_literal, unify

Key = tuple[str, int, bool]

LiveBeliefs: TypeAlias = "Mapping[tuple[str, int], Callable[[], Iterable[tuple[Term, ...]]]]"
"""By functor and arity, what returns the arguments of each belief that holds when it is called."""


def has_source(literal: Literal) -> bool:
    return any(isinstance(annot, Literal) and annot.functor == "source" for annot in literal.annots)


def _among(some: tuple[Term, ...], others: tuple[Term, ...]) -> bool:
    return some is others or all(annot in others for annot in some)


#: A rank and a belief or rule: the lower the rank, the earlier it is tried.
_Entry = tuple[int, "Literal | Rule"]

_by_rank = itemgetter(0)


class Shelf:
    """The beliefs and rules of one functor and arity.

    When there are many, they are also filed under their first argument; those
    whose first argument is not ground, and the rules, are `loose`.
    """

    _MANY = 8

    def __init__(self) -> None:
        self.rules = 0
        self._entries: dict[object, _Entry] = {}
        self._by_first: dict[Term, dict[object, _Entry]] | None = None
        self._loose: dict[object, _Entry] = {}
        self._front = 0
        self._back = 0
        self._ordered: tuple[Literal | Rule, ...] | None = None

    def __len__(self) -> int:
        return len(self._entries)

    def all(self) -> tuple[Literal | Rule, ...]:
        """Everything, in order."""
        if self._ordered is None:
            self._ordered = _in_order(self._entries)
        return self._ordered

    def find(self, args: tuple[Term, ...]) -> Literal | None:
        entry = self._entries.get(args)
        return None if entry is None else entry[1]  # type: ignore[return-value]

    def add(self, clause: Literal | Rule, *, at_end: bool = False) -> None:
        if at_end:
            self._back = rank = self._back + 1
        else:
            self._front = rank = self._front - 1
        key: object
        if clause.__class__ is Rule:
            key = (None, rank)
            self.rules += 1
        else:
            key = clause.args  # type: ignore[union-attr]
        self._entries[key] = (rank, clause)
        self._ordered = None
        if self._by_first is not None:
            self._file(key, (rank, clause))
        elif len(self._entries) > self._MANY:
            self._by_first = {}
            for known, entry in self._entries.items():
                self._file(known, entry)

    def replace(self, belief: Literal) -> None:
        """The belief with other annotations, in its place."""
        rank, _ = self._entries[belief.args]
        self._entries[belief.args] = (rank, belief)
        self._ordered = None
        if self._by_first is not None:
            self._file(belief.args, (rank, belief))

    def remove(self, args: tuple[Term, ...]) -> None:
        del self._entries[args]
        self._ordered = None
        if self._by_first is None:
            return
        if args and is_ground(args[0]):
            bucket = self._by_first[args[0]]
            del bucket[args]
            if not bucket:
                del self._by_first[args[0]]
        else:
            del self._loose[args]

    def _file(self, key: object, entry: _Entry) -> None:
        _, clause = entry
        if isinstance(clause, Literal) and clause.args and is_ground(clause.args[0]):
            self._by_first.setdefault(clause.args[0], {})[key] = entry  # type: ignore[union-attr]
        else:
            self._loose[key] = entry

    def kept(self, query: Literal, u: Unifier) -> tuple[Literal | Rule, ...]:
        """What of it may answer a query, in order."""
        if self._by_first is not None and query.args:
            first = substitute(query.args[0], u)
            if is_ground(first):
                bucket = self._by_first.get(first, {})
                return _in_order({**bucket, **self._loose} if self._loose else bucket)
        return self.all()

    # What may answer a query, and everything that does, in order. An alias, not a call: most
    # shelves have nothing that is live, and each query comes here.
    candidates = kept
    everything = all


class LiveShelf(Shelf):
    """A shelf whose `source` is asked by each query, and answers before what is kept here."""

    def __init__(
        self, functor: str, arity: int, source: Callable[[], Iterable[tuple[Term, ...]]]
    ) -> None:
        super().__init__()
        self._functor = functor
        self._arity = arity
        self._source = source

    def candidates(self, query: Literal, u: Unifier) -> tuple[Literal | Rule, ...]:
        return (*self._live(), *self.kept(query, u))

    def everything(self) -> tuple[Literal | Rule, ...]:
        return (*self._live(), *self.all())

    def _live(self) -> Iterator[Literal]:
        for given in self._source():
            args = tuple([float(arg) if isinstance(arg, int | float) else arg for arg in given])
            if len(args) != self._arity:
                taken = f"{self._functor} takes {self._arity} arguments"
                raise ValueError(f"{taken}, and its source gave {len(args)}")
            yield Literal(self._functor, args, ONLY_PERCEPT)


def _in_order(entries: dict[object, _Entry]) -> tuple[Literal | Rule, ...]:
    if len(entries) == 1:
        for _, clause in entries.values():
            return (clause,)
    return tuple([clause for _, clause in sorted(entries.values(), key=_by_rank)])


class BeliefBase:
    """Beliefs and rules; `live` answers queries too, but is nowhere else counted among them."""

    def __init__(self, live: LiveBeliefs = MappingProxyType({})) -> None:
        self._shelves: dict[Key, Shelf] = {
            (functor, arity, False): LiveShelf(functor, arity, source)
            for (functor, arity), source in live.items()
        }
        self.percepts: dict[Literal, Literal] = {}
        #: Percepts that are no longer believed, since somebody last looked.
        self.lost_percepts: dict[Literal, None] = {}

    def __iter__(self) -> Iterator[Literal]:
        """The beliefs, without the rules."""
        for shelf in self._shelves.values():
            for clause in shelf.all():
                if isinstance(clause, Literal):
                    yield clause

    def __len__(self) -> int:
        return sum(len(shelf) - shelf.rules for shelf in self._shelves.values())

    def shelf(self, key: Key) -> Shelf | None:
        return self._shelves.get(key)

    def all_clauses(self) -> tuple[Literal | Rule, ...]:
        """All that may answer a query of anything."""
        return tuple(c for shelf in self._shelves.values() for c in shelf.everything())

    def find(self, literal: Literal) -> Literal | None:
        """The belief that equals a literal but for annotations, with all of its own."""
        shelf = self._shelves.get(literal.key)
        return None if shelf is None else shelf.find(literal.args)

    def add_rule(self, rule: Rule) -> None:
        self._shelves.setdefault(rule.head.key, Shelf()).add(rule)

    def add(self, literal: Literal, *, at_end: bool = False) -> Literal | None:
        """Adds a belief, or annotations to one. What is new of it, or None when nothing is."""
        shelf = self._shelves.get(literal.key)
        if shelf is None:
            shelf = self._shelves[literal.key] = Shelf()
        known = shelf.find(literal.args)
        if known is None:
            shelf.add(literal, at_end=at_end)
            if literal.annots is not ONLY_SELF and FROM_PERCEPT in literal.annots:
                self.percepts[literal.without_annots()] = literal
            return literal
        added = tuple(annot for annot in literal.annots if annot not in known.annots)
        if not added:
            return None
        shelf.replace(known.with_annots(sorted_annots(known.annots + added)))
        if FROM_PERCEPT in added:
            self.percepts[literal.without_annots()] = literal
        return literal.with_annots(added)

    def perceive(self, key: Literal, percept: Literal) -> Literal | None:
        """Believes a percept; `key` is it without annotations. What is new, as `add`."""
        if percept.annots:
            annots = sorted_annots((*percept.annots, FROM_PERCEPT))
            return self.add(percept.with_annots(annots))
        shelf = self._shelves.get(key.key)
        if shelf is None:
            shelf = self._shelves[key.key] = Shelf()
        literal = key.with_annots(ONLY_PERCEPT)
        if shelf.find(key.args) is not None:
            return self.add(literal)
        shelf.add(literal)
        self.percepts[key] = literal
        return literal

    def forget_percept(self, key: Literal) -> Literal | None:
        """Stops believing a percept, unless it has other sources. What was removed, as `remove`."""
        shelf = self._shelves[key.key]
        belief = shelf.find(key.args)
        if belief is not None and belief.annots is ONLY_PERCEPT:
            shelf.remove(key.args)
            del self.percepts[key]
            return belief
        return self.remove(key.with_annots(ONLY_PERCEPT), {})

    def remove(self, literal: Literal, u: Unifier) -> Literal | None:
        """Takes annotations off a belief, and the belief when no source is left.

        A literal that is not believed as it stands but has variables takes the
        first belief it unifies with, and binds them in `u`. The literal that
        was removed, or None when nothing was.
        """
        shelf = self._shelves.get(literal.key)
        if shelf is None:
            return None
        known = shelf.find(literal.args)
        if known is not None and _among(literal.annots, known.annots):
            if not literal.annots:
                return None
            self._strip(shelf, known, literal.annots)
            return literal
        if literal.ground:
            return None
        for belief in shelf.kept(literal, u):
            if not isinstance(belief, Literal):
                continue
            attempt = dict(u)
            if unify(literal, belief, attempt):
                u.update(attempt)
                removed = substitute_literal(literal, u)
                return removed if self._strip(shelf, belief, removed.annots) else None
        return None

    def remove_first(self, key: Key, annots: tuple[Term, ...]) -> Literal | None:
        """Takes annotations off the first belief that has them all, whatever its arguments.

        Returns what was removed, or None when there is no such belief or it
        has other sources.
        """
        shelf = self._shelves.get(key)
        if shelf is None:
            return None
        for belief in shelf.all():
            if isinstance(belief, Literal) and _among(annots, belief.annots):
                removed = belief if belief.annots is annots else belief.with_annots(annots)
                return removed if self._strip(shelf, belief, annots) else None
        return None

    def _strip(self, shelf: Shelf, belief: Literal, annots: tuple[Term, ...]) -> bool:
        """Takes annotations off; whether the belief went with its last source."""
        if belief.annots is ONLY_SELF and annots is ONLY_SELF:
            shelf.remove(belief.args)
            return True
        if FROM_PERCEPT in belief.annots and FROM_PERCEPT in annots:
            key = belief.without_annots()
            self.percepts.pop(key, None)
            self.lost_percepts[key] = None
        if belief.annots is annots:
            shelf.remove(belief.args)
            return True
        left = belief.with_annots(tuple(a for a in belief.annots if a not in annots))
        if has_source(left):
            shelf.replace(left)
            return False
        shelf.remove(belief.args)
        return True

    def matching(self, pattern: Literal | Var, u: Unifier) -> list[Literal]:
        """The beliefs that unify with a pattern; no pattern's bindings bear on another's."""
        clauses: tuple[Literal | Rule, ...]
        if isinstance(pattern, Literal):
            shelf = self._shelves.get(pattern.key)
            clauses = () if shelf is None else shelf.candidates(pattern, u)
        else:
            clauses = self.all_clauses()
        return [
            clause
            for clause in clauses
            if isinstance(clause, Literal) and unify(pattern, clause, dict(u))
        ]
