"""Substitution: unifiers applied to terms, with the order and the arithmetic of terms.

A unifier is a dict from names of variables to terms. It is triangular: a value may contain
variables that are bound in turn, and `substitute` follows them to the end. Binding a variable
therefore costs one entry for terms of any size (Baader and Snyder, "Unification theory", 2001).

`builder` compiles the frequent terms of programs.
"""

from __future__ import annotations

import math
import operator
import statistics
from collections.abc import Callable, Iterable, Mapping
from functools import cmp_to_key
from itertools import count
from types import MappingProxyType
from typing import NamedTuple, TypeAlias, overload

from .operations import (
    Arithmetic,
    Function,
    Operation,
    Qualified,
    Quoted,
    Relation,
    TriggerTerm,
    parts,
    rebuilt,
)
from .terms import (
    DEFAULT,
    ONLY_SELF,
    AnnotatedVar,
    Cons,
    Literal,
    Nil,
    RestVar,
    Term,
    Var,
    is_ground,
    make_list,
    placed,
    text,
)


def compare(one: Term, other: Term) -> int:
    """Return a negative number, 0 or a positive one if `one` sorts before, with or after `other`.

    The order is: numbers by value, strings by text including quotes, lists by elements and length,
    literals by functor, strong negation (negated last), arguments, arity and annotations. Unbound
    variables are last.
    """
    if isinstance(one, Var):
        return _sign(one.name, other.name) if isinstance(other, Var) else 1
    if isinstance(other, Var):
        return -1
    if isinstance(one, float):
        return _sign(one, other) if isinstance(other, float) else -1
    if isinstance(other, float):
        return 1
    if isinstance(one, str) or isinstance(other, str):
        if isinstance(one, str) and isinstance(other, str):
            return _sign(text(one), text(other))
        return -1 if isinstance(one, str) else 1
    if isinstance(one, Nil | Cons):
        if not isinstance(other, Nil | Cons):
            return -1
        return _compare_each(tuple(one), tuple(other))
    if isinstance(other, Nil | Cons):
        return 1
    return _compare_structures(one, other)


def _sign(one: float | str, other: float | str) -> int:
    return (one > other) - (one < other)  # type: ignore[operator]


def _compare_structures(one: Term, other: Term) -> int:
    # Terms without parts, such as plans, are sorted by their text.
    mine, theirs = _structure(one), _structure(other)
    if mine is None or theirs is None:
        return _sign(text(one), text(other))
    return (
        _sign(mine.functor, theirs.functor)
        or _sign(mine.negated, theirs.negated)
        or _compare_each(mine.args, theirs.args)
        or _compare_each(mine.annots, theirs.annots)
    )


class _Structure(NamedTuple):
    functor: str
    negated: bool
    args: tuple[Term, ...]
    annots: tuple[Term, ...]


def _structure(term: Term) -> _Structure | None:
    """Return the parts by which a structure is sorted, or None for other terms."""
    if isinstance(term, Literal):
        return _Structure(term.functor, term.negated, term.args, term.annots)
    if isinstance(term, Relation):
        return _Structure(f" {term.symbol} ", False, term.operands, ())
    if isinstance(term, Function | Arithmetic):
        return _Structure(term.symbol, False, term.operands, ())
    return None


def _compare_each(ones: tuple[Term, ...], others: tuple[Term, ...]) -> int:
    """Compare sequences by elements, then by length."""
    for one, other in zip(ones, others, strict=False):
        order = compare(one, other)
        if order:
            return order
    return _sign(len(ones), len(others))


standard_order = cmp_to_key(compare)


def distinct(terms: Iterable[Term]) -> list[Term]:
    """Return the terms in standard order without duplicates."""
    result: list[Term] = []
    for term in sorted(terms, key=standard_order):
        if not result or compare(result[-1], term) != 0:
            result.append(term)
    return result


def with_more_annots(literal: Literal, *annots: Term) -> Literal:
    """Return a literal with additional annotations."""
    return literal.with_annots(sorted_annots((*literal.annots, *annots)))


def sorted_annots(annots: tuple[Term, ...]) -> tuple[Term, ...]:
    """Return annotations in standard order without duplicates. An open tail stays last."""
    return annots if len(annots) < 2 else tuple(distinct(annots))


NAN = math.nan


def _divide(x: float, y: float) -> float:
    if y == 0.0:
        if x == 0.0 or math.isnan(x):
            return NAN
        return math.copysign(math.inf, x) * math.copysign(1.0, y)
    return x / y


def _to_int32(x: float) -> int:
    if math.isnan(x):
        return 0
    # Java converts to the nearest int towards zero, limited to its range.
    return int(max(-(2.0**31), min(2.0**31 - 1, x)))


def _integer_divide(x: float, y: float) -> float:
    divisor = _to_int32(y)
    if divisor == 0:
        return NAN
    # Java rounds towards zero, Python down.
    quotient = abs(_to_int32(x)) // abs(divisor)
    return float(quotient if (x < 0) == (y < 0) else -quotient)


def _modulo(x: float, y: float) -> float:
    # The result has the sign of the first operand, as in Java, not that of the second.
    return NAN if y == 0.0 or math.isinf(x) else math.fmod(x, y)


def _power(x: float, y: float) -> float:
    try:
        return math.pow(x, y)
    except ValueError:
        return math.inf if x == 0.0 else NAN
    except OverflowError:
        return -math.inf if x < 0 and y % 2 == 1 else math.inf


OPERATORS: Mapping[str, Callable[[float, float], float]] = MappingProxyType(
    {
        "+": operator.add,
        "-": operator.sub,
        "*": operator.mul,
        "/": _divide,
        "div": _integer_divide,
        "mod": _modulo,
        "**": _power,
    }
)


def _round(x: float) -> float:
    """Round halves up, as `Math.round` of Java."""
    return x if math.isinf(x) or math.isnan(x) else float(math.floor(x + 0.5))


def _logarithm(x: float) -> float:
    return -math.inf if x == 0.0 else math.log(x)


_OF_A_NUMBER: Mapping[str, Callable[[float], float]] = MappingProxyType(
    {
        "+": operator.pos,
        "-": operator.neg,
        "math.abs": abs,
        "math.acos": math.acos,
        "math.asin": math.asin,
        "math.atan": math.atan,
        "math.ceil": math.ceil,
        "math.cos": math.cos,
        "math.floor": math.floor,
        "math.log": _logarithm,
        "math.round": _round,
        "math.sin": math.sin,
        "math.sqrt": math.sqrt,
        "math.tan": math.tan,
    }
)

#: Functions of a list of numbers. `math.max` and `math.min` also accept two numbers.
_OF_NUMBERS: Mapping[str, Callable[[list[float]], float]] = MappingProxyType(
    {
        "math.average": statistics.fmean,
        "math.max": max,
        "math.mean": statistics.fmean,
        "math.median": statistics.median,
        "math.min": min,
        "math.std_dev": statistics.stdev,
        "math.sum": math.fsum,
    }
)

_CONSTANTS: Mapping[str, float] = MappingProxyType({"math.e": math.e, "math.pi": math.pi})

#: Arities of the functions that depend on the run, its random numbers or its time.
RUN_FUNCTIONS: Mapping[str, tuple[int, ...]] = MappingProxyType(
    {"math.random": (0, 1), "system.time": (0,), ".count": (1,)}
)


def is_function(name: str, arity: int) -> bool:
    """Return True if `name` is an arithmetic function with that many arguments."""
    if name in RUN_FUNCTIONS:
        return arity in RUN_FUNCTIONS[name]
    if name in _CONSTANTS:
        return arity == 0
    if arity == 2:
        return name in ("math.max", "math.min")
    return arity == 1 and (name in _OF_A_NUMBER or name in _OF_NUMBERS or name == ".length")


def apply_function(
    name: str, args: tuple[Term, ...], calculate: Callable[..., float] | None = None
) -> float:
    """Return the value of a function of ground arguments, or NaN if it is undefined.

    `calculate` is set for RUN_FUNCTIONS and custom functions. A `TypeError` of such a function for
    numbers is raised.
    """
    try:
        if name in _OF_NUMBERS:
            numbers = _numbers(args)
            if name == "math.sum" and len(args) == 1 and isinstance(args[0], Nil):
                return 0.0
            return float(_OF_NUMBERS[name](numbers)) if numbers else NAN
        if name == ".length":
            return float(len(args[0]))  # type: ignore[arg-type]
        if name in _CONSTANTS:
            return _CONSTANTS[name]
        if calculate is not None:
            return float(calculate(*args))
        function: Callable[..., float] | None = _OF_A_NUMBER.get(name)
        if function is None or not all(isinstance(arg, float) for arg in args):
            return NAN
        return float(function(*args))
    except TypeError:
        if calculate is not None and all(isinstance(arg, float) for arg in args):
            raise
        return NAN
    except (ValueError, OverflowError):
        return NAN


def _numbers(args: tuple[Term, ...]) -> list[float]:
    """Return the elements of a list of numbers, or the numbers among several arguments."""
    values = args[0]
    if len(args) > 1 or not isinstance(values, Nil | Cons):
        return [arg for arg in args if isinstance(arg, float)]
    numbers = [value for value in values if isinstance(value, float)]
    return numbers if len(numbers) == len(values) else []


Unifier: TypeAlias = dict[str, Term]


class Names:
    """Source of fresh variables, which appear in no clause."""

    def __init__(self) -> None:
        self._numbers = count(1)

    def fresh(self, hint: str = "") -> Var:
        """Return a new variable whose name ends with `hint`."""
        return Var(f"_{next(self._numbers)}{hint.lstrip('_')}", fresh=True)


def walk(term: Term, u: Unifier) -> Term:
    """Return the term to which a variable is bound, and other terms unchanged."""
    while isinstance(term, Var):
        value = u.get(term.name)
        if value is None:
            return term
        term = value
    return term


def substitute(term: Term, u: Unifier) -> Term:
    """Return the term with values in place of variables, and with arithmetic evaluated."""
    if term.__class__ is float or term.__class__ is str:
        return term
    if term.__class__ is Var:
        value = u.get(term.name)
        if value is None:
            return term
        if value.__class__ is float:
            return value
        value = walk(value, u)
        return value if isinstance(value, Var) or is_ground(value) else substitute(value, u)
    if term.__class__ is Literal:
        return term if term.ground else substitute_literal(term, u)
    if term.__class__ is Arithmetic:
        return _calculate(term, u)
    return _substitute_other(term, u)


def substitute_literal(literal: Literal, u: Unifier) -> Literal:
    """Return the literal with values in place of variables, and with sorted annotations."""
    annots = literal.annots
    if not annots or annots is ONLY_SELF:
        return literal.with_args(tuple([value_of(arg, u) for arg in literal.args]))
    annots = _substitute_annots(annots, u)
    return Literal(
        literal.functor,
        tuple([substitute(arg, u) for arg in literal.args]),
        annots,
        negated=literal.negated,
    )


def _substitute_annots(annots: tuple[Term, ...], u: Unifier) -> tuple[Term, ...]:
    """Return sorted annotations with values in place of variables, an open tail last."""
    if all(map(is_ground, annots)):
        return annots
    values: list[Term] = []
    rest: tuple[Term, ...] = ()
    for annot in annots:
        value = substitute(annot, u)
        if isinstance(annot, RestVar) and isinstance(value, Nil | Cons):
            values.extend(value)
        elif isinstance(annot, RestVar) and isinstance(value, Var):
            rest = (RestVar(value.name, value.fresh),)
        else:
            values.append(value)
    return sorted_annots(tuple(values)) + rest


def _calculate(term: Arithmetic, u: Unifier) -> Term:
    left, right = term.operands
    left, right = substitute(left, u), substitute(right, u)
    if left.__class__ is float and right.__class__ is float:
        return OPERATORS[term.symbol](left, right)
    if is_ground(left) and is_ground(right):
        return NAN
    return Arithmetic(term.symbol, left, right)


def _substitute_other(term: Term, u: Unifier) -> Term:
    if isinstance(term, Cons):
        return term if term.ground else _substitute_list(term, u)
    if isinstance(term, Function):
        # `.count` evaluates the formula itself, so its variables are not replaced.
        if term.counts and term.calculate is not None:
            return term.calculate(term.operands[0], u)
        args = tuple(substitute(arg, u) for arg in term.operands)
        if not all(map(is_ground, args)):
            return term.with_operands(args)
        return apply_function(term.symbol, args, term.calculate)
    if isinstance(term, Qualified):
        return _substitute_qualified(term, u)
    if isinstance(term, Operation):
        return rebuilt(term, lambda part: substitute(part, u))
    if isinstance(term, AnnotatedVar):
        return _substitute_annotated(term, u)
    if isinstance(term, Var):
        return substitute(Var(term.name), u)
    if isinstance(term, TriggerTerm):
        return rebuilt(term, lambda part: substitute(part, u))
    if isinstance(term, Quoted):
        return term if term.ground else term.changed(lambda part: _inside_quoted(part, u))
    return term


def _inside_quoted(part: object, u: Unifier) -> Term | None:
    """Return the value of a variable or of arithmetic, or None for other parts."""
    if isinstance(part, Var | Arithmetic | Qualified):
        return substitute(part, u)
    return None


def _substitute_qualified(term: Qualified, u: Unifier) -> Term:
    namespace, inner = (substitute(part, u) for part in term.operands)
    if isinstance(inner, Literal) and isinstance(namespace, Literal):
        if namespace == DEFAULT:
            negated = inner.negated or term.negated
            return Literal(inner.functor, inner.args, inner.annots, negated=negated)
        return placed(inner, namespace.functor, True if term.negated else None)
    if isinstance(inner, Literal | Var | Qualified):
        return Qualified(namespace, inner, term.negated)
    return inner


def _substitute_list(cell: Cons, u: Unifier) -> Term:
    elements: list[Term] = []
    rest: Term = cell
    while isinstance(rest, Cons):
        if rest.ground:
            break
        elements.append(substitute(rest.head, u))
        rest = walk(rest.tail, u)
    return make_list(elements, rest)


def _substitute_annotated(term: AnnotatedVar, u: Unifier) -> Term:
    annots = _substitute_annots(term.annots, u)
    value = substitute(Var(term.name), u)
    if isinstance(value, Literal):
        rest = annots[-1:] if annots and isinstance(annots[-1], RestVar) else ()
        own = annots[: len(annots) - len(rest)]
        return Literal(
            value.functor,
            value.args,
            (*sorted_annots(value.annots + own), *rest),
            negated=value.negated,
        )
    if isinstance(value, Var):
        return AnnotatedVar(value.name, annots) if annots else value
    return value.annotated(annots) if isinstance(value, Quoted) else value


def value_of(term: Term, u: Unifier) -> Term:
    """Return `substitute` of a term, faster for variables with atoms as values."""
    if term.__class__ is Var:
        value = u.get(term.name)
        if value is None:
            return term
        term = value
    if term.__class__ is Literal and term.ground:
        return term
    return substitute(term, u)


@overload
def rename(term: Literal, names: Names, renamed: dict[str, Var]) -> Literal: ...
@overload
def rename(term: Term, names: Names, renamed: dict[str, Var]) -> Term: ...
def rename(term: Term, names: Names, renamed: dict[str, Var]) -> Term:
    """Return the term with a fresh variable for each variable of a clause.

    Two uses of a clause then share no variables, as resolution requires (Robinson 1965). `renamed`
    contains the fresh variables by name, and is extended.
    """

    def inside(part: Term) -> Term:
        if isinstance(part, Var):
            new = part
            if not part.fresh:
                new = renamed.get(part.name) or names.fresh(part.name)
                renamed[part.name] = new
            if isinstance(part, AnnotatedVar):
                return AnnotatedVar(new.name, tuple(map(inside, part.annots)))
            return RestVar(new.name, fresh=True) if isinstance(part, RestVar) else new
        return part if is_ground(part) else rebuilt(part, inside)

    return term if is_ground(term) else inside(term)


def variable_names(term: Term) -> tuple[str, ...]:
    """Return the names of the variables in a term without duplicates."""
    names: dict[str, None] = {}
    pending: list[Term] = [term]
    while pending:
        part = pending.pop()
        if part.__class__ is Var:
            names[part.name] = None
        elif not is_ground(part):
            if isinstance(part, Var):
                names[part.name] = None
            pending.extend(parts(part))
    return tuple(names)


Build: TypeAlias = Callable[[Unifier], Term]


def builder(term: Term) -> Build:
    """Return `substitute` for a term, compiled for the frequent kinds of terms."""
    if is_ground(term):
        return lambda u: term
    if term.__class__ is Var:
        return _build_variable(term)
    if isinstance(term, Arithmetic):
        return _build_arithmetic(term)
    if isinstance(term, Literal) and all(map(is_ground, term.annots)):
        return _build_literal(term)
    return lambda u: substitute(term, u)


def _build_variable(variable: Var) -> Build:
    name = variable.name

    def build(u: Unifier) -> Term:
        value = u.get(name)
        if value is None:
            return variable
        if value.__class__ is Literal:
            return value if value.ground else substitute(value, u)
        return value if value.__class__ is float else substitute(value, u)

    return build


def _build_arithmetic(term: Arithmetic) -> Build:
    left, right = term.operands
    calculate = OPERATORS[term.symbol]
    left_of = builder(left)
    if right.__class__ is float:

        def build_with_constant(u: Unifier) -> Term:
            left = left_of(u)
            if left.__class__ is float:
                return calculate(left, right)
            return substitute(term, u)

        return build_with_constant
    right_of = builder(right)

    def build(u: Unifier) -> Term:
        left, right = left_of(u), right_of(u)
        if left.__class__ is float and right.__class__ is float:
            return calculate(left, right)
        return substitute(term, u)

    return build


def _build_literal(literal: Literal) -> Build:
    build_args = [builder(arg) for arg in literal.args]
    if len(build_args) == 1:
        (only,) = build_args
        return lambda u: literal.with_args((only(u),))
    return lambda u: literal.with_args(tuple([build(u) for build in build_args]))
