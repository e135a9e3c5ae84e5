"""Shelves of the belief base: the beliefs and rules of one functor and arity, in order."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from operator import itemgetter

from ..language.program import Rule
from ..language.substitution import Unifier, substitute
from ..language.terms import ONLY_PERCEPT, Literal, Term, Var, is_ground
from .lasting import KeptAnswers, Question

#: A rank and a belief or rule: the lower the rank, the earlier it is tried.
_Entry = tuple[int, "Literal | Rule"]

_by_rank = itemgetter(0)


class Shelf:
    """The beliefs and rules of one functor and arity.

    Many are also indexed by their first argument, as clauses are in Prolog. Those whose first
    argument is not ground, and the rules, are `loose`: they may answer any query. What answers
    queries with one first argument is kept until something changes.
    """

    keeps_answers = True
    """False of a shelf of which each query may get other answers."""

    _MANY = 2
    _MOST_COLLECTED = 16

    def __init__(self) -> None:
        self.rules = 0
        self._entries: dict[object, _Entry] = {}
        self._by_first: dict[Term, dict[object, _Entry]] | None = None
        self._loose: dict[object, _Entry] = {}
        self._front = 0
        self._back = 0
        self._ordered: tuple[Literal | Rule, ...] | None = None
        self._known: dict[Term, tuple[Literal | Rule, ...]] = {}
        self.collected: dict[tuple[str, ...], tuple[Term, int]] = {}
        """Lists of all answers to a query of these names, with the goals they took, as they are."""
        self.answers: dict[Question, KeptAnswers] | None = None
        """Answers of the rules to queries with these values, where they last; None: not kept."""
        self.readers: tuple[Shelf, ...] = ()
        """Shelves with rules of which the answers follow from what is here."""

    def collect(self, names: tuple[str, ...], answers: Term, goals: int) -> tuple[Term, int]:
        """Keep all answers to a query of these names until something changes."""
        if len(self.collected) >= self._MOST_COLLECTED:
            self.collected.clear()
        self.collected[names] = answers, goals
        return self.collected[names]

    def keep_answers(self, basis: Iterable[Shelf]) -> None:
        """Keep the answers of the rules until something on the shelves of their `basis` changes."""
        self.answers = {}
        for shelf in basis:
            shelf.readers += (self,)

    def _changed(self) -> None:
        """Forget what followed from what was here."""
        self._ordered = None
        self.collected.clear()
        for shelf in self.readers:
            shelf.answers = {}

    def __len__(self) -> int:
        return len(self._entries)

    def all(self) -> tuple[Literal | Rule, ...]:
        """Return all that is kept, in order."""
        if self._ordered is None:
            self._ordered = _in_order(self._entries)
        return self._ordered

    def find(self, args: tuple[Term, ...]) -> Literal | None:
        """Return the belief with these arguments."""
        entry = self._entries.get(args)
        return None if entry is None else entry[1]  # type: ignore[return-value]

    def add(self, clause: Literal | Rule, *, at_end: bool = False) -> None:
        """Add a belief or rule before the others, or after them."""
        if at_end:
            self._back = rank = self._back + 1
        else:
            self._front = rank = self._front - 1
        key: object
        if isinstance(clause, Rule):
            # Rules may be equal and still be two; a belief is kept once, under its arguments.
            key = rank
            self.rules += 1
        else:
            key = clause.args
        self._entries[key] = (rank, clause)
        self._changed()
        if self._by_first is not None:
            self._known.clear()
            self._file(key, (rank, clause))
        # An index costs more than it saves until there are a few to choose from.
        elif len(self._entries) > self._MANY:
            self._by_first = {}
            for known, entry in self._entries.items():
                self._file(known, entry)

    def replace(self, belief: Literal) -> None:
        """Put a belief with other annotations in its old place."""
        rank, _ = self._entries[belief.args]
        self._entries[belief.args] = (rank, belief)
        self._changed()
        if self._by_first is not None:
            self._known.clear()
            self._file(belief.args, (rank, belief))

    def swap(self, belief: Literal) -> Literal | None:
        """Put a belief in the place of the only one there is, if that has the same annotations.

        Return the one that was there, or None if nothing has changed.
        """
        if len(self._entries) != 1:
            return None
        ((rank, known),) = self._entries.values()
        if isinstance(known, Rule) or known.annots is not belief.annots:
            return None
        self._entries = {belief.args: (rank, belief)}
        self._changed()
        self._ordered = (belief,)
        if self._by_first is not None:
            self._by_first, self._loose, self._known = None, {}, {}
        return known

    def remove(self, args: tuple[Term, ...]) -> None:
        """Remove the belief with these arguments."""
        del self._entries[args]
        self._changed()
        if self._by_first is None:
            return
        self._known.clear()
        if args and is_ground(args[0]):
            bucket = self._by_first[args[0]]
            del bucket[args]
            if not bucket:
                del self._by_first[args[0]]
        else:
            del self._loose[args]

    def remove_rule(self, rule: Rule) -> None:
        """Remove a rule, the very one."""
        key = next(key for key, (_, clause) in self._entries.items() if clause is rule)
        del self._entries[key]
        self.rules -= 1
        self._changed()
        if self._by_first is not None:
            self._known.clear()
            del self._loose[key]

    def _file(self, key: object, entry: _Entry) -> None:
        _, clause = entry
        if isinstance(clause, Literal) and clause.args and is_ground(clause.args[0]):
            self._by_first.setdefault(clause.args[0], {})[key] = entry  # type: ignore[union-attr]
        else:
            self._loose[key] = entry

    def kept(self, query: Literal, u: Unifier) -> tuple[Literal | Rule, ...]:
        """Return what is kept and may answer a query, in order."""
        if self._by_first is None or not query.args:
            return self._ordered or self.all()
        first = query.args[0]
        if first.__class__ is Var:
            first = u.get(first.name, first)
        known = self._known.get(first)
        if known is not None:
            return known
        first = substitute(first, u)
        if not is_ground(first):
            return self._ordered or self.all()
        bucket = self._by_first.get(first, {})
        known = _in_order({**bucket, **self._loose} if self._loose else bucket)
        if bucket:
            self._known[first] = known
        return known

    # What may answer a query, and all that can, in order. Aliases, not methods that call the
    # others: most shelves have nothing live, and every query comes here.
    candidates = kept
    everything = all


class LiveShelf(Shelf):
    """Shelf whose `source` is asked by each query; its answers come before what is kept."""

    keeps_answers = False

    def __init__(
        self, functor: str, arity: int, source: Callable[[], Iterable[tuple[Term, ...]]]
    ) -> None:
        super().__init__()
        self._functor = functor
        self._arity = arity
        self._source = source

    def candidates(self, query: Literal, u: Unifier) -> tuple[Literal | Rule, ...]:
        """Return what may answer a query, in order."""
        return (*self._live(), *self.kept(query, u))

    def everything(self) -> tuple[Literal | Rule, ...]:
        """Return all that may answer a query for anything, in order."""
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
