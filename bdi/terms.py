"""Terms of AgentSpeak: what beliefs, goals, actions and formulas are made of.

Numbers are Python floats and strings are Python strs; everything else is one
of the classes below. Terms are values: nothing changes one after it is made.
`ground` says that substitution leaves a term as it is.

Terms share their parts: `X = f(Y, Y), Y = f(Z, Z)` … doubles with every step what there is to
print and to compare, and takes no time to make. So every term knows its `size`, in parts counted
as often as they stand in it, and its `depth`; one that is too large or too deep is not made.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator
from decimal import Decimal
from numbers import Real
from typing import TYPE_CHECKING, NoReturn, TypeAlias, cast

from .errors import TooDeepError

if TYPE_CHECKING:
    from .program import BodyTerm, PlanTerm, TriggerTerm


MAX_SIZE = 1_000_000
"""How many parts a term may have: seconds to print."""

MAX_DEPTH = 150
"""How many terms may stand within each other; it takes some calls to go one deeper."""


class Var:
    """A variable. Those made while a program runs are `fresh`: no clause names them."""

    __slots__ = ("fresh", "name")
    ground = False
    size = 1
    depth = 0

    def __init__(self, name: str, fresh: bool = False) -> None:
        self.name = name
        self.fresh = fresh

    def __str__(self) -> str:
        return "_" if self.name.startswith("__") else self.name

    def __repr__(self) -> str:
        return f"Var({self.name!r})"

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Var) and self.name == other.name

    def __hash__(self) -> int:
        return hash(self.name)


class AnnotatedVar(Var):
    """A variable with annotations, as in `+!Goal[source(Sender)]`."""

    __slots__ = ("annots", "depth", "size")

    def __init__(self, name: str, annots: tuple[Term, ...]) -> None:
        super().__init__(name)
        self.annots = annots
        self.size, self.depth = _measure(annots)

    def __str__(self) -> str:
        return super().__str__() + annots_text(self.annots)


class RestVar(Var):
    """The tail of a list of annotations: R in `p[a|R]`. Always the last annotation."""

    __slots__ = ()


class Literal:
    """A functor with arguments and annotations, perhaps strongly negated; an atom has neither.

    `annots` are sorted in standard order and without doubles. Numbers of any type are taken for
    floats; `TypeError` for an argument that is no term.
    """

    __slots__ = (
        *("_hash", "annots", "args", "depth", "functor", "ground", "key", "negated", "size"),
    )

    def __init__(
        self,
        functor: str,
        args: tuple[Term, ...] = (),
        annots: tuple[Term, ...] = (),
        negated: bool = False,
    ) -> None:
        self.functor = functor
        self.args = args
        self.annots = annots
        self.negated = negated
        #: What beliefs and plans are filed under: functor, arity, strong negation.
        self.key = (functor, len(args), negated)
        self._hash: int | None = None
        self.ground = True
        self.size = 1
        self.depth = 0
        try:
            self._weigh(args)
        except AttributeError:
            # Somebody's own numbers: whole ones, or NumPy's.
            self.args = tuple(map(_term, args))
            self.size, self.depth, self.ground = 1, 0, True
            self._weigh(self.args)
        if annots:
            self._weigh(annots)

    def _weigh(self, terms: tuple[Term, ...]) -> None:
        """Take the terms within it into account."""
        for term in terms:
            cls = term.__class__
            if cls is float:
                continue
            if cls is str:
                self.size += len(term) >> 6  # type: ignore[arg-type]
                continue
            if not term.ground:  # type: ignore[union-attr]
                self.ground = False
            self.size += term.size  # type: ignore[union-attr]
            if term.depth >= self.depth:  # type: ignore[union-attr]
                self.depth = term.depth + 1  # type: ignore[union-attr]
        if self.size > MAX_SIZE or self.depth > MAX_DEPTH:
            _refuse(self.size)

    def with_args(self, args: tuple[Term, ...]) -> Literal:
        """This literal, whose annotations are ground, with as many other arguments."""
        other = Literal.__new__(Literal)
        other.functor = self.functor
        other.args = args
        other.annots = self.annots
        other.negated = self.negated
        other.key = self.key
        other._hash = None
        other.ground = True
        other.size = 1
        other.depth = 0
        if args:
            other._weigh(args)
        return other

    def with_annots(self, annots: tuple[Term, ...]) -> Literal:
        """This literal with these annotations, which are sorted and without doubles."""
        other = self.with_args(self.args)
        other.annots = annots
        if annots:
            other._weigh(annots)
        return other

    def without_annots(self) -> Literal:
        """This literal without annotations."""
        return self.with_annots(()) if self.annots else self

    @property
    def is_atom(self) -> bool:
        """Whether it has no arguments or annotations, and is not negated."""
        return not (self.args or self.annots or self.negated)

    @property
    def is_internal_action(self) -> bool:
        """Whether it names an internal action, as `.print` or `floor.distance` do."""
        return "." in self.functor and self.functor[0] != "'"

    def __str__(self) -> str:
        parts = ["~" if self.negated else "", self.functor]
        if self.args:
            parts.append(f"({','.join(map(text, self.args))})")
        if self.annots:
            parts.append(annots_text(self.annots))
        return "".join(parts)

    def __repr__(self) -> str:
        return f"<{self}>"

    def __eq__(self, other: object) -> bool:
        if self is other:
            return True
        return (
            isinstance(other, Literal)
            and self.functor == other.functor
            and self.negated == other.negated
            and self.args == other.args
            and self.annots == other.annots
        )

    def __hash__(self) -> int:
        if self._hash is None:
            self._hash = hash((self.functor, self.args, self.negated))
        return self._hash


class Nil:
    """The empty list; there is one, EMPTY."""

    __slots__ = ()
    ground = True
    size = 1
    depth = 0

    def __iter__(self) -> Iterator[Term]:
        return iter(())

    def __len__(self) -> int:
        return 0

    def __str__(self) -> str:
        return "[]"

    __repr__ = __str__

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Nil)

    def __hash__(self) -> int:
        return 0


EMPTY = Nil()


class Cons:
    """A list that has elements: a head and a tail, which is a list or a variable."""

    __slots__ = ("depth", "ground", "head", "size", "tail")

    def __init__(self, head: Term, tail: Term) -> None:
        self.head = head
        self.tail = tail
        self.ground = is_ground(head) and is_ground(tail)
        self.size, self.depth = _measure((head,))
        if not isinstance(tail, float | str):
            # The elements of a list stand side by side: its tail is no deeper than it.
            self.size += tail.size
            self.depth = max(self.depth, tail.depth)
            if self.size > MAX_SIZE:
                _refuse(self.size)

    def cells(self) -> Iterator[Cons]:
        cell: Term = self
        while isinstance(cell, Cons):
            yield cell
            cell = cell.tail

    def __iter__(self) -> Iterator[Term]:
        """The elements; an open tail is left out."""
        return (cell.head for cell in self.cells())

    def __len__(self) -> int:
        return sum(1 for _ in self.cells())

    @property
    def open_tail(self) -> Var | None:
        rest: Term = self
        while isinstance(rest, Cons):
            rest = rest.tail
        return rest if isinstance(rest, Var) else None

    def __str__(self) -> str:
        rest = self.open_tail
        return f"[{','.join(map(text, self))}{'' if rest is None else f'|{rest}'}]"

    def __repr__(self) -> str:
        return str(self)

    def __eq__(self, other: object) -> bool:
        mine: Term = self
        theirs = other
        while isinstance(mine, Cons) and isinstance(theirs, Cons):
            if mine is theirs:
                return True
            if mine.head != theirs.head:
                return False
            mine, theirs = mine.tail, theirs.tail
        if isinstance(mine, Cons) or isinstance(theirs, Cons):
            return False
        return mine == theirs

    def __hash__(self) -> int:
        return hash(tuple(self))


class Arithmetic:
    """An operation that waits for its operands' values: `N-1`; `right` is None for a sign."""

    __slots__ = ("depth", "left", "operator", "right", "size")
    ground = False

    def __init__(self, operator: str, left: Term, right: Term | None = None) -> None:
        self.operator = operator
        self.left = left
        self.right = right
        self.size, self.depth = _measure((left,) if right is None else (left, right))

    def __str__(self) -> str:
        if self.right is None:
            return f"({self.operator}{text(self.left)})"
        spaced = f" {self.operator} " if self.operator.isalpha() else self.operator
        return f"({text(self.left)}{spaced}{text(self.right)})"

    def __eq__(self, other: object) -> bool:
        return (
            isinstance(other, Arithmetic)
            and self.operator == other.operator
            and self.left == other.left
            and self.right == other.right
        )

    def __hash__(self) -> int:
        return hash((self.operator, self.left, self.right))


class Function:
    """A call of an arithmetic function: `math.abs(X)`.

    `calculate` is there for a function of the run, as `math.random`.
    """

    __slots__ = ("args", "calculate", "depth", "name", "size")
    ground = False

    def __init__(
        self, name: str, args: tuple[Term, ...], calculate: Callable[..., float] | None = None
    ) -> None:
        self.name = name
        self.args = args
        self.calculate = calculate
        self.size, self.depth = _measure(args)

    def __str__(self) -> str:
        return f"{self.name}({','.join(map(text, self.args))})" if self.args else self.name

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Function) and (self.name, self.args) == (other.name, other.args)

    def __hash__(self) -> int:
        return hash((self.name, self.args))


class _Binary:
    """What the formulas of two operands have in common."""

    __slots__ = ("depth", "ground", "left", "right", "size")
    symbol = ""

    def __init__(self, left: Term, right: Term) -> None:
        self.left = left
        self.right = right
        self.ground = is_ground(left) and is_ground(right)
        self.size, self.depth = _measure((left, right))

    def __str__(self) -> str:
        return f"({text(self.left)} {self.symbol} {text(self.right)})"

    def __eq__(self, other: object) -> bool:
        return (
            isinstance(other, _Binary)
            and self.symbol == other.symbol
            and self.left == other.left
            and self.right == other.right
        )

    def __hash__(self) -> int:
        return hash((self.symbol, self.left, self.right))


class Relation(_Binary):
    """A comparison (`<`, `==`, …), a unification (`=`) or a taking apart (`=..`)."""

    __slots__ = ("symbol",)
    symbol: str

    def __init__(self, symbol: str, left: Term, right: Term) -> None:
        super().__init__(left, right)
        self.symbol = symbol


class And(_Binary):
    __slots__ = ()
    symbol = "&"


class Or(_Binary):
    __slots__ = ()
    symbol = "|"


class Not:
    """Negation as failure."""

    __slots__ = ("depth", "formula", "ground", "size")

    def __init__(self, formula: Term) -> None:
        self.formula = formula
        self.ground = is_ground(formula)
        self.size, self.depth = _measure((formula,))

    def __str__(self) -> str:
        return f"not ({text(self.formula)})"

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Not) and self.formula == other.formula

    def __hash__(self) -> int:
        return hash(("not", self.formula))


def _term(value: object) -> Term:
    """`value` as a term: what was put together in Python may have other numbers than floats."""
    if isinstance(value, Real):
        return float(value)
    if not isinstance(value, str) and not hasattr(value, "ground"):
        raise TypeError(f"an argument is a number, a text or a term, not {value!r}")
    return value  # type: ignore[return-value]


Term: TypeAlias = (
    "float | str | Literal | Var | Nil | Cons | Arithmetic | Function"
    " | Relation | And | Or | Not | PlanTerm | BodyTerm | TriggerTerm"
)
"""Whatever can stand in a literal or a context; numbers and strings are Python's own."""
List: TypeAlias = "Nil | Cons"


def is_ground(term: Term) -> bool:
    """Whether substitution leaves the term as it is."""
    return isinstance(term, float | str) or term.ground


def _measure(terms: tuple[Term, ...]) -> tuple[int, int]:
    """Size and depth of a term of these; TooDeepError if it must not be made."""
    size, depth = 1, 0
    for term in terms:
        if isinstance(term, str):
            size += len(term) >> 6
        elif not isinstance(term, float):
            size += term.size
            depth = max(depth, term.depth + 1)
    if size > MAX_SIZE or depth > MAX_DEPTH:
        _refuse(size)
    return size, depth


def _refuse(size: int) -> NoReturn:
    if size > MAX_SIZE:
        raise TooDeepError(f"a term of more than {MAX_SIZE:,} parts")
    raise TooDeepError(f"terms within terms, more than {MAX_DEPTH} deep")


TRUE = Literal("true")
FALSE = Literal("false")
FROM_SELF = Literal("source", (Literal("self"),))
#: The annotations of most beliefs and goals.
ONLY_SELF: tuple[Term, ...] = (FROM_SELF,)
FROM_PERCEPT = Literal("source", (Literal("percept"),))
ONLY_PERCEPT: tuple[Term, ...] = (FROM_PERCEPT,)


def make_list(elements: Iterable[Term], tail: Term = EMPTY) -> Term:
    """The list of `elements`, followed by `tail`."""
    result = tail
    for element in reversed(list(elements)):
        result = Cons(element, result)
    return result


def make_term(value: object) -> Term:
    """The term for a Python value: numbers, strs, lists and tuples, and terms themselves."""
    if isinstance(value, bool):
        return TRUE if value else FALSE
    if isinstance(value, int | float):
        return float(value)
    if isinstance(value, list | tuple):
        return make_list(make_term(element) for element in value)
    if isinstance(value, str) or hasattr(value, "depth"):  # as all other terms have
        return cast(Term, value)
    raise TypeError(f"{type(value).__name__} cannot be made a term: {value!r}")


def text(term: Term) -> str:
    """The term as Jason prints it inside others: strings in quotes, whole numbers without `.0`."""
    if isinstance(term, str):
        return f'"{term}"'
    if isinstance(term, float):
        return number_text(term)
    return str(term)


def display(term: Term) -> str:
    """The term as `.print` shows it: a string bare, an unbound variable marked as such."""
    if isinstance(term, str):
        return term
    if isinstance(term, Var):
        return f"{term}<no-value>"
    return text(term)


def annots_text(annots: tuple[Term, ...]) -> str:
    if isinstance(annots[-1], RestVar):
        return f"[{','.join(map(text, annots[:-1]))}|{annots[-1]}]"
    return f"[{','.join(map(text, annots))}]"


def number_text(value: float) -> str:
    """A double as Java prints it, whole numbers as integers.

    Whole numbers are those equal to their rounding to 64 bits; others are
    written like `Double.toString`: plain from 1e-3 up to 1e7, else as `1.5E10`.
    """
    if math.isnan(value):
        return "NaN"
    if math.isinf(value):
        return "Infinity" if value > 0 else "-Infinity"
    if value.is_integer() and -(2.0**63) <= value <= 2.0**63:
        return str(min(int(value), 2**63 - 1))
    if 1e-3 <= abs(value) < 1e7:
        return repr(value)
    return _scientific(value)


def _scientific(value: float) -> str:
    """With as few digits as tell the double from its neighbours: `1.5E10`."""
    sign, digits, exponent = Decimal(repr(value)).normalize().as_tuple()
    first, rest = str(digits[0]), "".join(map(str, digits[1:]))
    power = int(exponent) + len(digits) - 1
    return f"{'-' if sign else ''}{first}.{rest or '0'}E{power}"
