"""The belief base: beliefs and rules indexed by functor, arity and first argument.

Programs ask the same of the same beliefs again and again, as for the station after this one.

Beside them are live beliefs, which a source supplies whenever a query asks for them.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass
from operator import itemgetter
from types import MappingProxyType
from typing import TypeAlias

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
"""Values of the variables of a query, in one of its answers."""


class CachedAnswers:
    """Answers of a `source` to one question, found out as far as anybody has asked for them.

    `failures` is asked how many internal actions have failed.
    """

    def __init__(self, source: Iterator[Values], failures: Callable[[], int]) -> None:
        self.is_cacheable = True
        """False once it turns out that they have to be found out anew the next time."""
        self._source = source
        self._failures = failures
        self._found: list[Values] = []

    def __iter__(self) -> Iterator[Values]:
        at = 0
        while at < len(self._found) or self._find_another():
            yield self._found[at]
            at += 1

    def _find_another(self) -> bool:
        """Find the next answer; return whether there is one."""
        before, is_cacheable, self.is_cacheable = self._failures(), self.is_cacheable, False
        values = next(self._source, None)  # if this raises, they are not cacheable
        # A failure is reported each time, and variables are other ones each time.
        self.is_cacheable = is_cacheable and self._failures() == before
        if values is None:
            return False
        self.is_cacheable = self.is_cacheable and all(map(is_ground, values))
        self._found.append(values)
        return True


#: A rank and a belief or rule: the lower the rank, the earlier it is tried.
_Entry = tuple[int, "Literal | Rule"]

_by_rank = itemgetter(0)


class ClauseIndex:
    """The beliefs and rules of one functor and arity.

    Many are also indexed by their first argument, as clauses are in Prolog. Those whose first
    argument is not ground, and the rules, are `loose`: they may answer any query. What answers
    queries with one first argument is kept until something changes.
    """

    is_cacheable = True
    """False for an index in which each query may find other answers."""

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
        self.answers: dict[Question, CachedAnswers] | None = None
        """Cached answers of the rules by the values of the query; None if they cannot be cached."""
        self.readers: tuple[ClauseIndex, ...] = ()
        """Indexes with rules whose answers depend on the clauses here."""

    def collect(self, names: tuple[str, ...], answers: Term, goals: int) -> tuple[Term, int]:
        """Keep all answers to a query of these names until something changes."""
        if len(self.collected) >= self._MOST_COLLECTED:
            self.collected.clear()
        self.collected[names] = answers, goals
        return self.collected[names]

    def cache_answers(self, dependencies: Iterable[ClauseIndex]) -> None:
        """Cache the answers of the rules until something in one of these indexes changes."""
        self.answers = {}
        for index in dependencies:
            index.readers += (self,)

    def _changed(self) -> None:
        """Forget what followed from what was here."""
        self._ordered = None
        self.collected.clear()
        for index in self.readers:
            index.answers = {}

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
    # others: most indexes have nothing live, and every query comes here.
    candidates = kept
    everything = all


class LiveClauseIndex(ClauseIndex):
    """Clause index whose `source` each query calls. Its answers come before what is kept."""

    is_cacheable = False

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


MOST_LAYERS = 12
"""Largest number of rules of which each asks the next."""


@dataclass(frozen=True)
class Dependencies:
    """Keys of all that rules query, directly or through others; True if answers can be cached."""

    keys: frozenset[Key]
    is_cacheable: bool


def dependencies_of(clauses: Mapping[Key, ClauseIndex], key: Key) -> Dependencies | None:
    """Return what the rules of that key go back to; None where they are not plain throughout.

    Plain ones have values and variables for arguments, and ask each other no more than
    `MOST_LAYERS` times over, so that none goes back to itself.
    """
    found, is_cacheable, asked = {key}, True, {key}
    for _ in range(MOST_LAYERS):
        there = [clauses[one] for one in asked if one in clauses]
        rules = [one for index in there for one in index.all() if isinstance(one, Rule)]
        if not all(are_apart(rule.head.args) for rule in rules):
            return None
        is_cacheable = is_cacheable and all(index.is_cacheable for index in there)
        is_cacheable = is_cacheable and all(rule.is_cacheable for rule in rules)
        asked = {one for rule in rules for one in rule.queried_keys}
        if not asked:
            return Dependencies(frozenset(found), is_cacheable)
        found |= asked
    # Rules that go back to themselves are never through with asking, and end here as well.
    return None


LiveBeliefs: TypeAlias = Mapping[tuple[str, int], Callable[[], Iterable[tuple[Term, ...]]]]
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
    """Beliefs and rules. Live beliefs answer queries and are not counted among the others.

    `clauses` are the beliefs and rules by functor, arity and negation. `lost_percepts` are the
    beliefs that lost the source `percept` since the last update from percepts, by identity.
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
        """Iterate over the beliefs, without the rules."""
        for index in self.clauses.values():
            for clause in index.all():
                if isinstance(clause, Literal):
                    yield clause

    def __len__(self) -> int:
        return sum(len(index) - index.rules for index in self.clauses.values())

    def all_clauses(self) -> tuple[Literal | Rule, ...]:
        """Return all that may answer a query for anything."""
        return tuple(c for index in self.clauses.values() for c in index.everything())

    def find(self, literal: Literal) -> Literal | None:
        """Return the belief that equals a literal, annotations aside."""
        index = self.clauses.get(literal.key)
        return None if index is None else index.find(literal.args)

    def add_rule(self, rule: Rule, *, at_end: bool = False) -> None:
        """Add a rule before the clauses of its functor and arity, or after them."""
        self._index(rule.head.key).add(rule, at_end=at_end)
        self._find_out_anew()

    def remove_rule(self, rule: Rule) -> None:
        """Remove the first rule that is the same and has the annotations, if there is one."""
        index = self.clauses.get(rule.head.key)
        if index is None:
            return
        for known in index.all():
            if (
                isinstance(known, Rule)
                and known.is_same(rule)
                and _among(rule.head.annots, known.head.annots)
            ):
                index.remove_rule(known)
                self._find_out_anew()
                return

    def has_plain_rules(self, key: Key) -> bool:
        """Return whether the rules of that key and those that they query are plain.

        See `dependencies_of`.
        """
        if key not in self._dependencies:
            dependencies = self._dependencies[key] = dependencies_of(self.clauses, key)
            if dependencies is not None and dependencies.is_cacheable:
                read = [self.clauses[one] for one in dependencies.keys if one in self.clauses]
                self.clauses[key].cache_answers(read)
                self._read += read
        return self._dependencies[key] is not None

    def _find_out_anew(self) -> None:
        """Forget what rules go back to: there is another index, or another rule."""
        if not self._dependencies:
            return
        self._dependencies.clear()
        for index in self._read:
            index.answers, index.readers = None, ()
        self._read.clear()

    def _index(self, key: Key) -> ClauseIndex:
        """Return the index of a key, a new one if there is none yet."""
        index = self.clauses.get(key)
        if index is None:
            index = self.clauses[key] = ClauseIndex()
            self._find_out_anew()
        return index

    def rules(self) -> list[Rule]:
        """Return the rules."""
        clauses = self.clauses.values()
        return [clause for index in clauses for clause in index.all() if isinstance(clause, Rule)]

    def add(self, literal: Literal, *, at_end: bool = False) -> Literal | None:
        """Add a belief, or annotations to one. Return what is new of it, or None."""
        index = self._index(literal.key)
        known = index.find(literal.args)
        if known is None:
            index.add(literal, at_end=at_end)
            return literal
        # Only what is new makes an event, and the event has nothing else.
        added = tuple(annot for annot in literal.annots if annot not in known.annots)
        if not added:
            return None
        index.replace(with_more_annots(known, *added))
        return literal.with_annots(added)

    def perceive(self, percept: Literal) -> Literal | None:
        """Believe a percept. Return what is new, as `add`; None if it is believed as one."""
        index = self._index(percept.key)
        known = index.find(percept.args)
        if known is not None and FROM_PERCEPT in known.annots:
            return None
        if percept.annots:
            belief = with_more_annots(percept, FROM_PERCEPT)
        else:
            belief = percept.with_annots(ONLY_PERCEPT)
        if known is not None:
            return self.add(belief)
        index.add(belief)
        return belief

    def forget_percept(self, percept: Literal) -> Literal | None:
        """Stop believing a percept, unless it has other sources. Return as `remove`."""
        index = self.clauses.get(percept.key)
        known = None if index is None else index.find(percept.args)
        if index is None or known is None or FROM_PERCEPT not in known.annots:
            return None
        if known.annots is ONLY_PERCEPT:
            index.remove(known.args)
            return known
        removed = percept.with_annots(ONLY_PERCEPT)
        self._strip(index, known, ONLY_PERCEPT)
        del self.lost_percepts[known.identity]  # nothing that the program has done
        return removed

    def remove(self, literal: Literal, u: Unifier) -> Literal | None:
        """Take annotations off a belief, and remove it when it has no source left.

        A literal with variables that is not believed as it stands removes the first belief with
        which it unifies, and binds them in `u`. Return the literal removed, or None.
        """
        index = self.clauses.get(literal.key)
        if index is None:
            return None
        known = index.find(literal.args)
        if known is not None and _among(literal.annots, known.annots):
            if not literal.annots and has_source(known):
                return None
            self._strip(index, known, literal.annots)
            return literal
        if literal.ground:
            return None
        for belief in index.kept(literal, u):
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
        """Put a belief of the agent's own in the place of the only one of its functor and arity.

        Return the one that was there, or None if nothing has changed.
        """
        index = self.clauses.get(literal.key)
        return None if index is None or literal.annots is not ONLY_SELF else index.swap(literal)

    def remove_first(self, key: Key, annots: tuple[Term, ...]) -> Literal | None:
        """Take annotations off the first belief that has them all, whatever its arguments.

        Return what was removed, or None if there is no such belief or it has other sources.
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
        """Take annotations off; return True if the belief was removed with its last source."""
        if belief.annots is ONLY_SELF and annots is ONLY_SELF:
            index.remove(belief.args)
            return True
        # It still holds: the next update from percepts believes it anew.
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
        """Return the beliefs that unify with a pattern, each on its own."""
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
