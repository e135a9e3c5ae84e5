"""Operations as terms, parts of programs as terms, and the traversal of all terms."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

from .terms import (
    DEFAULT,
    EMPTY,
    AnnotatedVar,
    Compound,
    Cons,
    Literal,
    Term,
    Var,
    is_ground,
    make_list,
    measure,
    text,
)


class Operation(Compound):
    """Base of expressions and formulas: a symbol with operands."""

    __slots__ = ("depth", "ground", "operands", "size", "symbol")
    ground: bool
    size: int
    depth: int

    is_replaced = False
    """Whether substitution replaces the operation by a value, so that it is never ground."""

    def __init__(self, symbol: str, *operands: Term) -> None:
        self.symbol = symbol
        self.operands = operands
        self.ground = not self.is_replaced and all(map(is_ground, operands))
        self.size, self.depth = measure(operands)

    def with_operands(self, operands: tuple[Term, ...]) -> Operation:
        """Return the operation with other operands."""
        other = object.__new__(type(self))
        Operation.__init__(other, self.symbol, *operands)
        for name in type(self).__slots__:
            setattr(other, name, getattr(self, name))
        return other

    def __str__(self) -> str:
        left, right = self.operands
        return f"({text(left)} {self.symbol} {text(right)})"

    def __repr__(self) -> str:
        return f"<{self}>"

    def __eq__(self, other: object) -> bool:
        return (
            isinstance(other, Operation)
            and self.symbol == other.symbol
            and self.operands == other.operands
        )

    def __hash__(self) -> int:
        return hash((self.symbol, self.operands))


class Relation(Operation):
    """Comparison (`<`, `==`, …), unification (`=`) or decomposition (`=..`)."""

    __slots__ = ()


class Conjunction(Operation):
    """Conjunction."""

    __slots__ = ()

    def __init__(self, left: Term, right: Term) -> None:
        super().__init__("&", left, right)


class Disjunction(Operation):
    """Disjunction."""

    __slots__ = ()

    def __init__(self, left: Term, right: Term) -> None:
        super().__init__("|", left, right)


class Negation(Operation):
    """Negation as failure."""

    __slots__ = ()

    def __init__(self, formula: Term) -> None:
        super().__init__("not", formula)

    def __str__(self) -> str:
        return f"not ({text(self.operands[0])})"


class Arithmetic(Operation):
    """Arithmetic operation, such as `N-1`. It is never ground."""

    __slots__ = ()
    is_replaced = True

    def __str__(self) -> str:
        left, right = map(text, self.operands)
        spaced = f" {self.symbol} " if self.symbol.isalpha() else self.symbol
        return f"({left}{spaced}{right})"


class Function(Operation):
    """Call of an arithmetic function, such as `math.abs(X)`, or a sign, `-X`. It is never ground.

    `calculate` is set for functions of a run, such as `math.random`.
    """

    __slots__ = ("calculate",)
    is_replaced = True

    def __init__(
        self, name: str, args: tuple[Term, ...], calculate: Callable[..., float] | None = None
    ) -> None:
        super().__init__(name, *args)
        self.calculate = calculate

    @property
    def counts(self) -> bool:
        """Whether it is `.count(Formula)`, whose argument is a query."""
        return self.symbol == ".count"

    def __str__(self) -> str:
        args = ",".join(map(text, self.operands))
        if self.symbol in ("+", "-"):
            return f"({self.symbol}{args})"
        return f"{self.symbol}({args})" if args else self.symbol


class Qualified(Operation):
    """Literal or variable with an open namespace or negation: `NS::b(X)`, `ns::X`, `~X`.

    It is never ground, because substitution replaces it by a literal.
    """

    __slots__ = ("negated",)
    is_replaced = True

    def __init__(self, namespace: Term, inner: Term, negated: bool = False) -> None:
        super().__init__("::", namespace, inner)
        self.negated = negated

    def __str__(self) -> str:
        namespace, inner = self.operands
        prefix = "" if namespace == DEFAULT else f"{namespace}::"
        return f"{prefix}{'~' if self.negated else ''}{inner}"

    def __eq__(self, other: object) -> bool:
        return (
            isinstance(other, Qualified)
            and self.negated == other.negated
            and self.operands == other.operands
        )

    def __hash__(self) -> int:
        return hash((self.symbol, self.operands))


@dataclass(frozen=True)
class TriggerTerm(Compound):
    """Event as an argument, such as `{+!g(X)}`, whose `sort` is `+!`.

    `bare` is True for the event of a plan, which is printed without braces.
    """

    sort: str
    literal: Literal | Var | Qualified
    bare: bool = field(default=False, compare=False)

    @property
    def ground(self) -> bool:
        """Whether substitution leaves the term unchanged."""
        return is_ground(self.literal)

    @property
    def size(self) -> int:
        """Number of parts."""
        return self.literal.size

    @property
    def depth(self) -> int:
        """Nesting of terms."""
        return self.literal.depth

    def __str__(self) -> str:
        event = f"{self.sort}{self.literal}"
        return event if self.bare else f"{{ {event} }}"


class Quoted(Compound):
    """Base of plans, rules and bodies as arguments (`body.py`, `quoted.py`)."""

    size = 1
    depth = 1

    @property
    def ground(self) -> bool:
        """Whether it contains no variables."""
        return True

    def changed(self, change: Callable[[Any], Any]) -> Quoted:
        """Return the term with all parts replaced for which `change` returns not None."""
        return self

    def annotated(self, annots: tuple[Term, ...]) -> Quoted:
        """Return the term with additional annotations, if it can have any."""
        return self


def parts(term: Term) -> tuple[Term, ...]:
    """Return the direct parts of a term, or the variables of a quoted term."""
    if isinstance(term, Literal):
        return (*term.args, *term.annots)
    if isinstance(term, Cons):
        rest = term.open_tail
        return tuple(term) if rest is None else (*term, rest)
    if isinstance(term, Operation):
        return term.operands
    if isinstance(term, TriggerTerm):
        return (term.literal,)
    if isinstance(term, Quoted):
        return tuple(_variables_in(term))
    return term.annots if isinstance(term, AnnotatedVar) else ()


def _variables_in(quoted: Quoted) -> list[Var]:
    variables: dict[Var, None] = {}

    def collect(part: Any) -> None:
        if isinstance(part, Var):
            variables[part] = None

    quoted.changed(collect)
    return list(variables)


def rebuilt(term: Term, change: Callable[[Term], Term]) -> Term:
    """Return the term with `change` applied to each of its `parts`."""
    if isinstance(term, Literal):
        args, annots = tuple(map(change, term.args)), tuple(map(change, term.annots))
        return Literal(term.functor, args, annots, negated=term.negated)
    if isinstance(term, Cons):
        elements, rest = list(map(change, term)), term.open_tail
        return make_list(elements, EMPTY if rest is None else change(rest))
    if isinstance(term, Operation):
        return term.with_operands(tuple(map(change, term.operands)))
    if isinstance(term, AnnotatedVar):
        return AnnotatedVar(term.name, tuple(map(change, term.annots)))
    if isinstance(term, TriggerTerm):
        literal = change(term.literal)
        if isinstance(literal, Literal | Var | Qualified):
            return TriggerTerm(term.sort, literal, term.bare)
        return term
    if isinstance(term, Quoted):
        return term.changed(lambda part: change(part) if isinstance(part, Var) else None)
    return term
