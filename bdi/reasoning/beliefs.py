"""The belief base: beliefs and rules, indexed by functor, arity and first argument.

Answers of rules are cached, because programs repeat their queries. A source supplies live beliefs
for each query.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass
from operator import itemgetter
from types import MappingProxyType
from typing import Protocol, TypeAlias

from ..language.operations import Qualified
from ..language.program import Key, Rule, are_apart
from ..language.substitution import Unifier, substitute, substitute_literal, with_more_annots
from ..language.terms import (
    FROM_PERCEPT,
    FROM_SELF,
    ONLY_PERCEPT,
    ONLY_SELF,
    Literal,
    Term,
    Var,
    is_ground,
)
from ..language.unification import matched, unified, unify

Question: TypeAlias = tuple[Term | None, ...]
"""Arguments of a query: values without variables, and None for each variable."""

Values: TypeAlias = tuple[Term, ...]
"""Values of the variables of a query in one answer."""


class CountsFailures(Protocol):
    """Evaluator with the number of failures of internal actions."""

    failures: int


class CachedAnswers:
    """Answers from a `source` to one question, cached as far as they were requested."""

    def __init__(self, source: Iterator[Values], logic: CountsFailures) -> None:
        self.is_cacheable = True
        """False if the answers must be computed again for the next query."""
        self._source = source
        self._logic = logic
        self._rows: list[Values] = []

    def __iter__(self) -> Iterator[Values]:
        at, rows = 0, self._rows
        while at < len(rows) or self._fetch():
            yield rows[at]
            at += 1

    def _fetch(self) -> bool:
        """Request the next answer. Return whether there is one."""
        before, is_cacheable, self.is_cacheable = self._logic.failures, self.is_cacheable, False
        values = next(self._source, None)  # not cacheable if this raises
        # Failures must be reported, and variables renamed, for each query.
        self.is_cacheable = is_cacheable and self._logic.failures == before
        if values is None:
            return False
        self.is_cacheable = self.is_cacheable and all(map(is_ground, values))
        self._rows.append(values)
        return True


#: Rank and clause. Lower ranks are tried first.
_Entry = tuple[int, "Literal | Rule"]

_by_rank = itemgetter(0)


class ClauseIndex:
    """Beliefs and rules of one functor, arity and negation.

    Larger indexes also use the first argument, as Prolog does. Rules, and beliefs whose first
    argument is not ground, are `loose`, because they may answer any query. The candidates for each
    first argument are cached until a clause changes.
    """

    is_cacheable = True
    """Whether the answers only change with the clauses."""

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
        self._candidates: dict[Term, tuple[Literal | Rule, ...]] = {}
        self.collected: dict[tuple[str, ...], tuple[Term, int]] = {}
        """Lists of all answers by the names in the query, with the number of goals tried."""
        self.answers: dict[Question, CachedAnswers] | None = None
        """Cached answers of the rules by question, or None if they cannot be cached."""
        self.readers: tuple[ClauseIndex, ...] = ()
        """Indexes whose cached answers depend on these clauses."""

    def collect(self, names: tuple[str, ...], answers: Term, goals: int) -> tuple[Term, int]:
        """Cache the list of all answers to a query until a clause changes."""
        if len(self.collected) >= self._MOST_COLLECTED:
            self.collected.clear()
        self.collected[names] = answers, goals
        return self.collected[names]

    def cache_answers(self, dependencies: Iterable[ClauseIndex]) -> None:
        """Cache the answers of the rules until a clause of these indexes changes."""
        self.answers = {}
        for index in dependencies:
            index.readers += (self,)

    def _changed(self) -> None:
        """Clear the caches after a change."""
        self._ordered = None
        self.collected.clear()
        for index in self.readers:
            index.answers = {}

    def __len__(self) -> int:
        return len(self._entries)

    def all(self) -> tuple[Literal | Rule, ...]:
        """Return all clauses in order."""
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
            # Equal rules are kept separately, equal beliefs once.
            key = rank
            self.rules += 1
        else:
            key = clause.args
        self._entries[key] = (rank, clause)
        self._changed()
        if self._by_first is not None:
            self._candidates.clear()
            self._file(key, (rank, clause))
        # The index by first argument costs more than it saves for fewer clauses.
        elif len(self._entries) > self._MANY:
            self._by_first = {}
            for filed, entry in self._entries.items():
                self._file(filed, entry)

    def replace(self, belief: Literal) -> None:
        """Replace a belief by one with other annotations, at the same rank."""
        rank, _ = self._entries[belief.args]
        self._entries[belief.args] = (rank, belief)
        self._changed()
        if self._by_first is not None:
            self._candidates.clear()
            self._file(belief.args, (rank, belief))

    def swap(self, belief: Literal) -> Literal | None:
        """Replace the only belief by another one with the same annotations.

        Return the replaced belief, or None if this is not possible.
        """
        if len(self._entries) != 1:
            return None
        ((rank, previous),) = self._entries.values()
        if isinstance(previous, Rule) or previous.annots is not belief.annots:
            return None
        self._entries = {belief.args: (rank, belief)}
        self._changed()
        self._ordered = (belief,)
        if self._by_first is not None:
            self._by_first, self._loose, self._candidates = None, {}, {}
        return previous

    def remove(self, args: tuple[Term, ...]) -> None:
        """Remove the belief with these arguments."""
        del self._entries[args]
        self._changed()
        if self._by_first is None:
            return
        self._candidates.clear()
        if args and is_ground(args[0]):
            bucket = self._by_first[args[0]]
            del bucket[args]
            if not bucket:
                del self._by_first[args[0]]
        else:
            del self._loose[args]

    def remove_rule(self, rule: Rule) -> None:
        """Remove this rule object."""
        key = next(key for key, (_, clause) in self._entries.items() if clause is rule)
        del self._entries[key]
        self.rules -= 1
        self._changed()
        if self._by_first is not None:
            self._candidates.clear()
            del self._loose[key]

    def _file(self, key: object, entry: _Entry) -> None:
        _, clause = entry
        if isinstance(clause, Literal) and clause.args and is_ground(clause.args[0]):
            self._by_first.setdefault(clause.args[0], {})[key] = entry  # type: ignore[union-attr]
        else:
            self._loose[key] = entry

    def stored(self, query: Literal, u: Unifier) -> tuple[Literal | Rule, ...]:
        """Return the stored clauses that may answer a query, in order."""
        if self._by_first is None or not query.args:
            return self._ordered or self.all()
        first = query.args[0]
        if first.__class__ is Var:
            first = u.get(first.name, first)
        candidates = self._candidates.get(first)
        if candidates is not None:
            return candidates
        first = substitute(first, u)
        if not is_ground(first):
            return self._ordered or self.all()
        bucket = self._by_first.get(first, {})
        candidates = _in_order({**bucket, **self._loose} if self._loose else bucket)
        if bucket:
            self._candidates[first] = candidates
        return candidates

    # Aliases instead of methods that call the others, because every query uses them.
    candidates = stored
    everything = all


class LiveClauseIndex(ClauseIndex):
    """Clause index with a `source` that each query calls. Its beliefs precede the stored ones."""

    is_cacheable = False

    def __init__(
        self, functor: str, arity: int, source: Callable[[], Iterable[tuple[Term, ...]]]
    ) -> None:
        super().__init__()
        self._functor = functor
        self._arity = arity
        self._source = source

    def candidates(self, query: Literal, u: Unifier) -> tuple[Literal | Rule, ...]:
        """Return the clauses that may answer a query, in order."""
        return (*self._live(), *self.stored(query, u))

    def everything(self) -> tuple[Literal | Rule, ...]:
        """Return all clauses in order, with the live beliefs."""
        return (*self._live(), *self.all())

    def _live(self) -> Iterator[Literal]:
        for values in self._source():
            args = tuple([float(arg) if isinstance(arg, int | float) else arg for arg in values])
            if len(args) != self._arity:
                taken = f"{self._functor} takes {self._arity} arguments"
                raise ValueError(f"{taken}, and its source gave {len(args)}")
            yield Literal(self._functor, args, ONLY_PERCEPT)


def _in_order(entries: dict[object, _Entry]) -> tuple[Literal | Rule, ...]:
    if len(entries) == 1:
        for _, clause in entries.values():
            return (clause,)
    return tuple([clause for _, clause in sorted(entries.values(), key=_by_rank)])


MOST_LAYERS = 12
"""Maximum number of rules that query each other in a chain."""


@dataclass(frozen=True)
class Dependencies:
    """Keys that rules query, directly or through other rules, and whether answers can be cached."""

    keys: frozenset[Key]
    is_cacheable: bool


def dependencies_of(clauses: Mapping[Key, ClauseIndex], key: Key) -> Dependencies | None:
    """Return the dependencies of the rules of a key, or None if one of the rules is not plain.

    The arguments of plain rules are values and distinct variables. Chains of plain rules have at
    most `MOST_LAYERS` rules, so that no rule depends on itself.
    """
    keys, is_cacheable, layer = {key}, True, {key}
    for _ in range(MOST_LAYERS):
        indexes = [clauses[one] for one in layer if one in clauses]
        rules = [one for index in indexes for one in index.all() if isinstance(one, Rule)]
        if not all(are_apart(rule.head.args) for rule in rules):
            return None
        is_cacheable = is_cacheable and all(index.is_cacheable for index in indexes)
        is_cacheable = is_cacheable and all(rule.is_cacheable for rule in rules)
        layer = {one for rule in rules for one in rule.queried_keys}
        if not layer:
            return Dependencies(frozenset(keys), is_cacheable)
        keys |= layer
    return None  # also for recursive rules, which have endless chains


LiveBeliefs: TypeAlias = Mapping[tuple[str, int], Callable[[], Iterable[tuple[Term, ...]]]]
"""Functions by functor and arity, which return the arguments of the current beliefs."""


def has_source(literal: Literal) -> bool:
    """Return whether the literal has a source."""
    return any(isinstance(annot, Literal) and annot.functor == "source" for annot in literal.annots)


def with_source(literal: Literal) -> Literal:
    """Return the literal with its source, by default `self`."""
    if not literal.annots:
        return literal.with_annots(ONLY_SELF)
    if literal.annots is ONLY_SELF or has_source(literal):
        return literal
    return with_more_annots(literal, FROM_SELF)


def _among(some: tuple[Term, ...], others: tuple[Term, ...]) -> bool:
    return some is others or all(annot in others for annot in some)


class BeliefBase:
    """Beliefs and rules. Iteration yields the beliefs, without live beliefs.

    Attributes
    ----------
    clauses
        Beliefs and rules by functor, arity and negation.
    lost_percepts
        Beliefs that lost the source `percept` since the last update from percepts, by identity.
    """

    def __init__(self, live: LiveBeliefs = MappingProxyType({})) -> None:
        self.clauses: dict[Key, ClauseIndex] = {
            (functor, arity, False): LiveClauseIndex(functor, arity, source)
            for (functor, arity), source in live.items()
        }
        self.lost_percepts: dict[object, Literal] = {}
        self._dependencies: dict[Key, Dependencies | None] = {}
        self._read: list[ClauseIndex] = []

    def __iter__(self) -> Iterator[Literal]:
        """Iterate over the stored beliefs."""
        for index in self.clauses.values():
            for clause in index.all():
                if isinstance(clause, Literal):
                    yield clause

    def __len__(self) -> int:
        return sum(len(index) - index.rules for index in self.clauses.values())

    def all_clauses(self) -> tuple[Literal | Rule, ...]:
        """Return all beliefs and rules, with the live beliefs."""
        return tuple(c for index in self.clauses.values() for c in index.everything())

    def find(self, literal: Literal) -> Literal | None:
        """Return the belief that equals a literal except for annotations, or None."""
        index = self.clauses.get(literal.key)
        return None if index is None else index.find(literal.args)

    def add_rule(self, rule: Rule, *, at_end: bool = False) -> None:
        """Add a rule before the clauses of its functor and arity, or after them."""
        self._index(rule.head.key).add(rule, at_end=at_end)
        self._forget_dependencies()

    def remove_rule(self, rule: Rule) -> None:
        """Remove the first equal rule that has the annotations of `rule`, if any."""
        index = self.clauses.get(rule.head.key)
        if index is None:
            return
        for stored in index.all():
            if (
                isinstance(stored, Rule)
                and stored.is_same(rule)
                and _among(rule.head.annots, stored.head.annots)
            ):
                index.remove_rule(stored)
                self._forget_dependencies()
                return

    def has_plain_rules(self, key: Key) -> bool:
        """Return whether a key has plain rules only, as defined in `dependencies_of`."""
        if key not in self._dependencies:
            dependencies = self._dependencies[key] = dependencies_of(self.clauses, key)
            if dependencies is not None and dependencies.is_cacheable:
                read = [self.clauses[one] for one in dependencies.keys if one in self.clauses]
                self.clauses[key].cache_answers(read)
                self._read += read
        return self._dependencies[key] is not None

    def _forget_dependencies(self) -> None:
        """Clear the dependencies after a change of rules, or for a new index."""
        if not self._dependencies:
            return
        self._dependencies.clear()
        for index in self._read:
            index.answers, index.readers = None, ()
        self._read.clear()

    def _index(self, key: Key) -> ClauseIndex:
        """Return the index of a key, created if necessary."""
        index = self.clauses.get(key)
        if index is None:
            index = self.clauses[key] = ClauseIndex()
            if any(one is not None and key in one.keys for one in self._dependencies.values()):
                self._forget_dependencies()
        return index

    def rules(self) -> list[Rule]:
        """Return the rules."""
        clauses = self.clauses.values()
        return [clause for index in clauses for clause in index.all() if isinstance(clause, Rule)]

    def add(self, literal: Literal, *, at_end: bool = False) -> Literal | None:
        """Add a belief, or annotations to one. Return it with the new annotations, or None."""
        index = self._index(literal.key)
        belief = index.find(literal.args)
        if belief is None:
            index.add(literal, at_end=at_end)
            return literal
        added = tuple(annot for annot in literal.annots if annot not in belief.annots)
        if not added:
            return None
        index.replace(with_more_annots(belief, *added))
        return literal.with_annots(added)

    def perceive(self, percept: Literal) -> Literal | None:
        """Add a percept. Return as `add`, or None if it is already believed as a percept."""
        index = self._index(percept.key)
        previous = index.find(percept.args)
        if previous is not None and FROM_PERCEPT in previous.annots:
            return None
        if percept.annots:
            belief = with_more_annots(percept, FROM_PERCEPT)
        else:
            belief = percept.with_annots(ONLY_PERCEPT)
        if previous is not None:
            return self.add(belief)
        index.add(belief)
        return belief

    def forget_percept(self, percept: Literal) -> Literal | None:
        """Remove the source `percept` from a belief. Return as `remove`."""
        index = self.clauses.get(percept.key)
        belief = None if index is None else index.find(percept.args)
        if index is None or belief is None or FROM_PERCEPT not in belief.annots:
            return None
        if belief.annots is ONLY_PERCEPT:
            index.remove(belief.args)
            return belief
        removed = percept.with_annots(ONLY_PERCEPT)
        self._strip(index, belief, ONLY_PERCEPT)
        del self.lost_percepts[belief.identity]  # because the program did not remove it
        return removed

    def remove(self, literal: Literal, u: Unifier) -> Literal | None:
        """Remove annotations from a belief, and the belief with its last source.

        A literal with variables removes the first belief with which it unifies, unless it is itself
        believed. Its variables are bound in `u`. Return the removed literal, or None.
        """
        index = self.clauses.get(literal.key)
        if index is None:
            return None
        stored = index.find(literal.args)
        if stored is not None and _among(literal.annots, stored.annots):
            if not literal.annots and has_source(stored):
                return None
            self._strip(index, stored, literal.annots)
            return literal
        if literal.ground:
            return None
        for belief in index.stored(literal, u):
            if isinstance(belief, Rule):
                continue
            if literal.annots is belief.annots is ONLY_SELF:
                solution = matched(literal, belief, u)
            else:
                solution = unified(literal, belief, u)
            if solution is not None:
                u.update(solution)
                removed = substitute_literal(literal, u)
                return removed if self._strip(index, belief, removed.annots) else None
        return None

    def swap(self, literal: Literal) -> Literal | None:
        """Replace the only belief of a key by another one, both with the source `self` alone.

        Return the replaced belief, or None if this is not possible.
        """
        index = self.clauses.get(literal.key)
        return None if index is None or literal.annots is not ONLY_SELF else index.swap(literal)

    def remove_first(self, key: Key, annots: tuple[Term, ...]) -> Literal | None:
        """Remove annotations from the first belief of a key that has all of them.

        Return the removed belief, or None if there is no such belief or it has other sources.
        """
        index = self.clauses.get(key)
        if index is None:
            return None
        for belief in index.all():
            if isinstance(belief, Rule):
                continue
            if belief.annots is annots is ONLY_SELF:
                index.remove(belief.args)
                return belief
            if _among(annots, belief.annots):
                removed = belief if belief.annots is annots else belief.with_annots(annots)
                return removed if self._strip(index, belief, annots) else None
        return None

    def _strip(self, index: ClauseIndex, belief: Literal, annots: tuple[Term, ...]) -> bool:
        """Remove annotations. Return whether the belief was removed with its last source."""
        if belief.annots is ONLY_SELF and annots is ONLY_SELF:
            index.remove(belief.args)
            return True
        # The percept may still hold, so the next update adds the belief again.
        if FROM_PERCEPT in belief.annots and FROM_PERCEPT in annots:
            self.lost_percepts[belief.identity] = belief
        if belief.annots is annots:
            index.remove(belief.args)
            return True
        left = belief.with_annots(tuple(a for a in belief.annots if a not in annots))
        if has_source(left):
            index.replace(left)
            return False
        index.remove(belief.args)
        return True

    def matching(self, pattern: Literal | Var | Qualified, u: Unifier) -> list[Literal]:
        """Return the beliefs that unify with a pattern."""
        clauses: tuple[Literal | Rule, ...]
        if isinstance(pattern, Literal):
            index = self.clauses.get(pattern.key)
            clauses = () if index is None else index.candidates(pattern, u)
        else:
            clauses = self.all_clauses()
        return [
            clause
            for clause in clauses
            if isinstance(clause, Literal) and unify(pattern, clause, dict(u))
        ]
