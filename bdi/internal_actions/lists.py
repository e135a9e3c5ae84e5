"""Internal actions on lists, tests of the kind of a term, and random choices."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from itertools import count

from ..actions import ActionError
from ..language.body import BodyTerm
from ..language.operations import (
    Conjunction,
    Disjunction,
    Negation,
    Operation,
    Relation,
    TriggerTerm,
)
from ..language.quoted import PlanTerm, RuleTerm
from ..language.substitution import Unifier, compare, distinct, standard_order
from ..language.terms import (
    EMPTY,
    Cons,
    Literal,
    Nil,
    Term,
    Var,
    is_ground,
    make_list,
    plain_text,
    text,
)
from ..language.unification import unified, unify
from ..reasoning.execution import Call
from .beliefs import answers
from .containers import Container
from .registry import STANDARD, a_list, a_number, wrong


@STANDARD.add(".length", least=2, most=2)
def length(call: Call, value: Term, result: Term) -> object:
    """`.length(L, N)`: number of elements or characters."""
    if not isinstance(value, str | Nil | Cons | Container):
        return False
    return call.unify(result, len(value))


MAX_LENGTH = 100_000
"""Maximum number of elements or characters of a result of `.concat`."""


@STANDARD.add(".member", least=2, most=2)
def member(call: Call, element: Term, elements: Term) -> Iterator[Unifier]:
    """`.member(E, L)`: an answer for each element that unifies."""
    items = elements if isinstance(elements, Container) else a_list("member", elements, "second")
    yield from call.each(element, list(items))


@STANDARD.add(".concat", least=2)
def concat(call: Call, *terms: Term) -> object:
    """Join lists, or the texts of other terms. The last argument is the result."""
    *parts, result = terms
    if isinstance(parts[0], Nil | Cons):
        if not isinstance(result, Var | Nil | Cons):
            raise ActionError(
                f"Last argument of concat '{text(result)}'is not a list nor a variable."
            )
        joined: list[Term] = []
        for position, part in enumerate(parts):
            if not isinstance(part, Nil | Cons):
                raise wrong("concat", f"arg[{position}] is not a list")
            joined.extend(part)
            _limit(len(joined), "list")
        last = parts[-1]
        rest = last.open_tail if isinstance(last, Cons) else None
        return call.unify(make_list(joined, EMPTY if rest is None else rest), result)
    whole = "".join(map(_bare, parts))
    _limit(len(whole), "text")
    if not isinstance(result, Var | str):
        result = text(result)
    return call.unify(whole, result)


def _limit(length: int, what: str) -> None:
    if length > MAX_LENGTH:
        raise ActionError(f"concat makes a {what} of more than {MAX_LENGTH:,} parts")


def _bare(term: Term) -> str:
    word = plain_text(term)
    is_quoted = not isinstance(term, str) and len(word) > 1 and word[0] == word[-1] == "'"
    return word[1:-1] if is_quoted else word


@STANDARD.add(".nth", least=3, most=3)
def nth(call: Call, index: Term, elements: Term, element: Term) -> object:
    """`.nth(I, L, E)`: the element at position I from 0, or all positions if I is unbound."""
    if not isinstance(index, float | Var):
        raise wrong(
            "nth", f"the first argument should be numeric or a variable -- not '{text(index)}'."
        )
    if not isinstance(elements, str | Nil | Cons):
        raise wrong(
            "nth", f"the second argument should be a list or string and not '{text(elements)}'."
        )
    items = list(elements)
    if isinstance(index, float):
        position = int(index)
        if not 0 <= position < len(items):
            raise ActionError(f"nth: index {position} is out of bounds ({len(items)})")
        return call.unify(element, items[position])
    return _positions(call, index, items, element)


def _positions(call: Call, index: Var, items: list[Term], element: Term) -> Iterator[Unifier]:
    u = call.unifier
    for position, item in enumerate(items):
        if is_ground(element) and is_ground(item):  # nothing to bind
            solution = u if element is item or unify(element, item, {}) else None
        else:
            solution = unified(element, item, u)
        if solution is not None:
            solution = unified(index, float(position), solution)
        if solution is not None:
            yield solution


def _extreme(name: str, better: Callable[[int], bool]) -> Callable[..., object]:
    def extreme(call: Call, what: Term, *more: Term) -> object:
        if len(more) == 2:
            items = answers(call, what, more[0])
        else:
            items = list(a_list(name, what, "first"))
        if not items:
            return False
        best = items[0]
        for item in items[1:]:
            if better(compare(best, item)):
                best = item
        return call.unify(best, more[-1])

    return extreme


@STANDARD.add(".sort", least=2, most=2)
def sort(call: Call, elements: Term, result: Term) -> object:
    """`.sort(L, S)`: the elements in standard order."""
    ordered = sorted(a_list("sort", elements, "first"), key=standard_order)
    return call.unify(ordered, result)


@STANDARD.add(".reverse", least=2, most=2)
def reverse(call: Call, value: Term, result: Term) -> object:
    """`.reverse(L, R)`: a list or a string in reverse order."""
    if isinstance(value, Nil | Cons):
        rest = value.open_tail if isinstance(value, Cons) else None
        backwards = make_list(reversed(list(value)), EMPTY if rest is None else rest)
        return call.unify(backwards, result)
    return call.unify(plain_text(value)[::-1], result)


@STANDARD.add(".delete", least=3, most=4)
def delete(call: Call, what: Term, where: Term, *more: Term) -> object:
    """Delete elements by position, range or value, or a part of a string."""
    if isinstance(what, float):
        begin, finish, rest = int(what), int(what) + 1, (where, *more)
        if len(more) == 2 and isinstance(where, float):
            finish, rest = int(where), more
        if isinstance(rest[0], str):
            whole = rest[0]
            if not 0 <= begin <= len(whole) or finish > len(whole):
                return call.unify(rest[1], whole)
            return call.unify(rest[1], whole[:begin] + whole[finish:])
        if isinstance(rest[0], Nil | Cons):
            remaining = [item for i, item in enumerate(rest[0]) if i < begin or i >= finish]
            return call.unify(rest[1], remaining)
    if isinstance(what, str):
        return call.unify(more[0], plain_text(where).replace(what, ""))
    if isinstance(where, Nil | Cons):
        remaining = [item for item in where if call.unify(what, item) is None]
        return call.unify(more[0], remaining)
    raise ActionError("Incorrect use of the internal action '.delete' (see documentation).")


def _set_operation(
    name: str, operation: Callable[[list[Term], list[Term]], list[Term]]
) -> Callable[..., object]:
    def operate(call: Call, one: Term, other: Term, result: Term) -> object:
        ones, others = list(a_list(name, one, "first")), list(a_list(name, other, "second"))
        return call.unify(distinct(operation(ones, others)), result)

    return operate


def _is_among(term: Term, others: list[Term]) -> bool:
    return any(compare(term, other) == 0 for other in others)


def _common(ones: list[Term], others: list[Term]) -> list[Term]:
    return [term for term in others if _is_among(term, ones)]


def _without(ones: list[Term], others: list[Term]) -> list[Term]:
    return [term for term in ones if not _is_among(term, others)]


def _prefixes(items: list[Term]) -> Iterator[Term]:
    for end in range(len(items), 0, -1):
        yield make_list(items[:end])


@STANDARD.add(".prefix", least=2, most=2)
def prefix(call: Call, part: Term, whole: Term) -> Iterator[Unifier]:
    """`.prefix(P, L)`: an answer for each beginning, the longest first."""
    if isinstance(whole, str):
        return call.each(part, (whole[:end] for end in range(len(whole), -1, -1)))
    items = list(a_list("prefix", whole, "second"))
    return call.each(part, (*_prefixes(items), EMPTY))


@STANDARD.add(".suffix", least=2, most=2)
def suffix(call: Call, part: Term, whole: Term) -> Iterator[Unifier]:
    """`.suffix(S, L)`: an answer for each end, the longest first."""
    if isinstance(whole, str):
        return call.each(part, (whole[begin:] for begin in range(len(whole) + 1)))
    items = list(a_list("suffix", whole, "second"))
    return call.each(part, (make_list(items[begin:]) for begin in range(len(items) + 1)))


@STANDARD.add(".sublist", least=2, most=2)
def sublist(call: Call, part: Term, whole: Term) -> Iterator[Unifier]:
    """`.sublist(S, L)`: an answer for each part, by begin, the longest first."""
    items = list(a_list("sublist", whole, "second"))

    def parts() -> Iterator[Term]:
        for begin in range(len(items)):
            yield from _prefixes(items[begin:])
        yield EMPTY

    return call.each(part, parts())


@STANDARD.add(".range", least=3, most=4)
def range_(call: Call, number: Term, first: Term, last: Term, *step: Term) -> object:
    """`.range(I, From, To, Step?)`: an answer for each number, To included."""
    begin = int(a_number("range", first, "second"))
    end = int(a_number("range", last, "third"))
    by = int(a_number("range", step[0], "fourth")) if step else 1
    if isinstance(number, float):
        return begin <= int(number) <= end
    if by == 0:
        raise wrong("range", "the step must not be 0")
    return call.each(number, range(begin, end + (1 if by > 0 else -1), by))


@STANDARD.add(".empty", least=1, most=1)
def empty(call: Call, value: Term) -> bool:
    """`.empty(L)`: whether a list, string or container has no elements."""
    return len(value) == 0 if isinstance(value, str | Nil | Cons | Container) else False


STANDARD.add(".max", least=2, most=3)(_extreme("max", lambda order: order < 0))
STANDARD.add(".min", least=2, most=3)(_extreme("min", lambda order: order > 0))
STANDARD.add(".union", least=3, most=3)(_set_operation("union", lambda a, b: b + a))
STANDARD.add(".intersection", least=3, most=3)(_set_operation("intersection", _common))
STANDARD.add(".difference", least=3, most=3)(_set_operation("difference", _without))


def _kind(test: Callable[[Term], bool]) -> Callable[..., bool]:
    return lambda call, term: test(term)


def _is_structure(term: Term) -> bool:
    if isinstance(term, Literal):
        return not term.is_atom
    return isinstance(term, Nil | Cons | TriggerTerm | PlanTerm | RuleTerm | BodyTerm | Operation)


def _is_literal(term: Term) -> bool:
    formulas = Conjunction | Disjunction | Negation | Relation
    return isinstance(term, Literal | TriggerTerm | PlanTerm | RuleTerm | BodyTerm | formulas)


def _kinds(term: Term) -> list[str]:
    """Return the kinds of a term, the narrowest first."""
    if isinstance(term, Container):
        return [term.kind, "ground"]
    return [name for name, test in _KINDS.items() if test(term)]


@STANDARD.add(".type", least=2, most=2)
def kind_of(call: Call, term: Term, kind: Term) -> Iterator[Unifier]:
    """`.type(T, Kind)`: an answer for each kind of a term."""
    return call.each(kind, map(Literal, _kinds(term)))


_KINDS: Mapping[str, Callable[[Term], bool]] = {
    "number": lambda term: isinstance(term, float),
    "atom": lambda term: isinstance(term, Literal) and term.is_atom,
    "literal": _is_literal,
    "string": lambda term: isinstance(term, str),
    "list": lambda term: isinstance(term, Nil | Cons),
    "structure": _is_structure,
    "rule": lambda term: isinstance(term, RuleTerm),
    "plan": lambda term: isinstance(term, BodyTerm),
    # Variables of rules are not counted.
    "ground": lambda term: is_ground(term) and not isinstance(term, RuleTerm),
    "free": lambda term: isinstance(term, Var),
}
"""Kinds of `.type` in order. A body in braces is a plan, a whole plan is a structure."""

for _name in ("number", "atom", "literal", "string", "list", "structure", "ground"):
    STANDARD.add(f".{_name}", least=1, most=1)(_kind(_KINDS[_name]))
STANDARD.add(".var", least=1, most=1)(_kind(_KINDS["free"]))


@STANDARD.add(".random", least=1, most=3)
def random(call: Call, what: Term, *more: Term) -> object:
    """`.random(X)` or `.random(List, X)`, with an optional number of answers, 0 for endless."""
    numbers = call.agent.random
    if isinstance(what, Nil | Cons):
        items = list(what)
        if not more or not isinstance(more[0], Var):
            raise wrong("random", "second argument must be a variable.")
        if not items:
            return False
        chosen = (items[int(numbers.random() * len(items))] for _ in _times(more[1:]))
        return call.each(more[0], chosen)
    if not isinstance(what, Var):
        raise wrong("random", "first argument must be a variable.")
    return call.each(what, (numbers.random() for _ in _times(more)))


def _times(limit: tuple[Term, ...]) -> Iterator[int]:
    most = int(a_number("random", limit[0], "last")) if limit else 1
    return iter(count()) if most == 0 else iter(range(most))


@STANDARD.add(".shuffle", least=2, most=2)
def shuffle(call: Call, elements: Term, result: Term) -> object:
    """`.shuffle(L, R)`: the elements in random order."""
    items = list(a_list("shuffle", elements, "first"))
    call.agent.random.shuffle(items)
    return call.unify(result, make_list(items))


@STANDARD.add(".set_random_seed", least=1, most=1)
def set_random_seed(call: Call, seed: Term) -> bool:
    """`.set_random_seed(N)`: restart the random numbers with a seed."""
    call.agent.random.seed(int(a_number("set_random_seed", seed, "first")))
    return True
