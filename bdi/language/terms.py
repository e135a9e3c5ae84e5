"""Terms of AgentSpeak: the values in beliefs, goals, actions and formulas.

Numbers are Python floats and strings are Python strs. All other terms are instances of the classes
below. Terms are immutable. A term is `ground` if substitution leaves it unchanged.

Terms share their parts, so that `X = f(Y, Y), Y = f(Z, Z)` … doubles the number of parts with each
step. Each term therefore stores its `size`, with repeated parts, and its `depth`. Terms beyond the
limits are rejected.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from decimal import Decimal
from functools import lru_cache, partial
from numbers import Real
from typing import Any, NoReturn, TypeAlias, cast

from ..errors import TooDeepError

MAX_SIZE = 1_000_000
"""Maximum number of parts of a term. Printing a term of this size takes seconds."""

MAX_DEPTH = 150
"""Maximum nesting of terms. Each level takes several nested Python calls."""


class Var:
    """Variable.

    Parameters
    ----------
    name : str
        Name. Anonymous variables have names that begin with two underscores.
    fresh : bool, optional
        Whether the variable was created at run time, so that no clause names it.
    """

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
    """Variable with annotations, as in `+!Goal[source(Sender)]`."""

    __slots__ = ("annots", "depth", "size")

    def __init__(self, name: str, annots: tuple[Term, ...]) -> None:
        super().__init__(name)
        self.annots = annots
        self.size, self.depth = measure(annots)

    def __str__(self) -> str:
        return super().__str__() + _annots_text(self.annots)


class RestVar(Var):
    """Tail of a list of annotations, such as R in `p[a|R]`. It is always the last annotation."""

    __slots__ = ()


class Literal:
    """Functor with arguments and annotations, optionally negated.

    Literals are immutable and are compared by value. Use `bdi.parse_literal` to create one from a
    text.

    Parameters
    ----------
    functor : str
        Name.
    args : tuple of Term, optional
        Arguments. Numbers of any type become floats, and Python lists and tuples become lists.
    annots : tuple of Term, optional
        Annotations in standard order, without duplicates.
    negated : bool, optional
        Whether the literal has a strong negation, `~p`.

    Attributes
    ----------
    key : tuple
        Functor, arity and negation, under which beliefs and plans are indexed.
    ground : bool
        Whether the literal contains no variables.
    size : int
        Number of parts.
    depth : int
        Nesting of terms.

    Raises
    ------
    TypeError
        If an argument is not a term.
    """

    __slots__ = (
        *("_hash", "annots", "args", "depth", "functor", "ground", "key", "negated", "size"),
    )

    def __init__(
        self,
        functor: str,
        args: tuple[Term, ...] = (),
        annots: tuple[Term, ...] = (),
        *,
        negated: bool = False,
    ) -> None:
        self.functor = functor
        self.args = args
        self.annots = annots
        self.negated = negated
        self.key = (functor, len(args), negated)
        self._hash: int | None = None
        self.ground = True
        self.size = 1
        self.depth = 0
        for arg in args:
            if arg.__class__ is not float:
                self._weigh_args()
                break
        if annots:
            self._weigh(annots)

    def _weigh_args(self) -> None:
        """Add the arguments to size and depth, with numbers of other types as floats."""
        try:
            self._weigh(self.args)
        except AttributeError:
            # An argument is a list, or a number of another type: an int, or one of NumPy's.
            self.args = tuple(map(make_term, self.args))
            self.size, self.depth, self.ground = 1, 0, True
            self._weigh(self.args)

    def _weigh(self, terms: tuple[Term, ...]) -> None:
        """Add terms to size and depth."""
        term: Any  # numbers and strings have no size
        for term in terms:
            cls = term.__class__
            if cls is float:
                continue
            if cls is str:
                self.size += len(term) >> 6
                continue
            if not term.ground:
                self.ground = False
            self.size += term.size
            if term.depth >= self.depth:
                self.depth = term.depth + 1
        if self.size > MAX_SIZE or self.depth > MAX_DEPTH:
            _refuse(self.size)

    def with_args(self, args: tuple[Term, ...]) -> Literal:
        """Return this literal with as many other arguments.

        Parameters
        ----------
        args : tuple of Term
            Arguments.

        Returns
        -------
        Literal
            Copy. The annotations of this literal must be ground.
        """
        other = Literal.__new__(Literal)
        other.functor = self.functor
        other.args = args
        other.annots = self.annots
        other.negated = self.negated
        other.key = self.key
        other._hash = None
        # `_weigh`, repeated here for speed.
        ground, size, depth = True, 1, 0
        term: Any
        for term in args:
            cls = term.__class__
            if cls is float:
                continue
            if cls is str:
                size += len(term) >> 6
                continue
            if not term.ground:
                ground = False
            size += term.size
            if term.depth >= depth:
                depth = term.depth + 1
        if size > MAX_SIZE or depth > MAX_DEPTH:
            _refuse(size)
        other.ground = ground
        other.size = size
        other.depth = depth
        return other

    def with_annots(self, annots: tuple[Term, ...]) -> Literal:
        """Return this literal with other annotations.

        Parameters
        ----------
        annots : tuple of Term
            Annotations in standard order, without duplicates.

        Returns
        -------
        Literal
            Copy.
        """
        other = Literal.__new__(Literal)
        other.functor = self.functor
        other.args = self.args
        other.annots = annots
        other.negated = self.negated
        other.key = self.key
        other._hash = self._hash  # independent of annotations
        if self.annots:
            other.ground = True
            other.size = 1
            other.depth = 0
            other._weigh(self.args)
        else:
            other.ground = self.ground
            other.size = self.size
            other.depth = self.depth
        if annots is ONLY_SELF or annots is ONLY_PERCEPT:
            # The frequent annotations have known sizes.
            other.size += 2
            other.depth = max(other.depth, 2)
        elif annots:
            other._weigh(annots)
        return other

    def without_annots(self) -> Literal:
        """Return this literal without annotations."""
        return self.with_annots(()) if self.annots else self

    @property
    def identity(self) -> tuple[object, ...]:
        """Functor, negation and arguments, which are equal if only the annotations differ."""
        return self.key, self.args

    @property
    def is_atom(self) -> bool:
        """Whether the literal has no arguments, annotations or negation."""
        return not (self.args or self.annots or self.negated)

    @property
    def is_internal_action(self) -> bool:
        """Whether the functor names an internal action, such as `.print` or `floor.distance`."""
        return "." in self.functor and self.functor[0] != "'"

    def __str__(self) -> str:
        parts = [self.functor]
        if self.negated:
            prefix, separator, bare = self.functor.rpartition("::")
            parts = [f"{prefix}{separator}~{bare}"]
        if self.args:
            parts.append(f"({','.join(map(text, self.args))})")
        if self.annots:
            parts.append(_annots_text(self.annots))
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

    def __reduce__(self) -> str | tuple[object, ...]:
        """Return how to copy the literal without its hash, which differs between processes.

        Atoms and constants such as `TRUE` become the shared instances of the other process.
        """
        if self is TRUE or self is FALSE:
            return self.functor.upper()
        if self.is_atom:
            return atom, (self.functor,)
        made = partial(Literal, negated=True) if self.negated else Literal
        return made, (self.functor, self.args, self.annots)


class Nil:
    """Empty list, with the instance EMPTY."""

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

    def __reduce__(self) -> str:
        return "EMPTY"

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Nil)

    def __hash__(self) -> int:
        return 0


EMPTY = Nil()


class Cons:
    """List with elements: a head and a tail, which is a list or a variable."""

    __slots__ = ("depth", "ground", "head", "size", "tail")
    depth: int
    ground: bool
    size: int

    def __init__(self, head: Term, tail: Term) -> None:
        self.head = head
        self.tail = tail
        ground: bool = True
        size: int = 1
        depth: int = 0
        if isinstance(head, str):
            size += len(head) >> 6
        elif not isinstance(head, float):
            ground = head.ground
            size += head.size
            depth = head.depth + 1
        if not isinstance(tail, float | str):
            # The tail of a list is at the same level as the list.
            ground = ground and tail.ground
            size += tail.size
            depth = max(depth, tail.depth)
        if size > MAX_SIZE or depth > MAX_DEPTH:
            _refuse(size)
        self.ground = ground
        self.size = size
        self.depth = depth

    def cells(self) -> Iterator[Cons]:
        """Iterate over the cells, each with one element and its tail."""
        cell: Term = self
        while isinstance(cell, Cons):
            yield cell
            cell = cell.tail

    def __iter__(self) -> Iterator[Term]:
        """Iterate over the elements, without an open tail."""
        cell: Term = self
        while cell.__class__ is Cons:
            yield cell.head
            cell = cell.tail

    def __len__(self) -> int:
        length, cell = 1, self.tail
        while cell.__class__ is Cons:
            length, cell = length + 1, cell.tail
        return length

    @property
    def open_tail(self) -> Var | None:
        """Variable at the end of an open list, or None."""
        rest: Term = self
        while isinstance(rest, Cons):
            rest = rest.tail
        return rest if isinstance(rest, Var) else None

    def __str__(self) -> str:
        rest = self.open_tail
        return f"[{','.join(map(text, self))}{'' if rest is None else f'|{rest}'}]"

    __repr__ = __str__

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


class Compound:
    """Base of operations, and of parts of programs as terms."""

    __slots__ = ()

    @property
    def ground(self) -> bool:
        """Whether substitution leaves the term unchanged."""
        raise NotImplementedError

    @property
    def size(self) -> int:
        """Number of parts."""
        raise NotImplementedError

    @property
    def depth(self) -> int:
        """Nesting of terms."""
        raise NotImplementedError


Term: TypeAlias = float | str | Literal | Var | Nil | Cons | Compound
"""Argument of a literal or part of a context."""
List: TypeAlias = Nil | Cons


# ---- structure

_PLAIN = (float, str)


def is_ground(term: Term) -> bool:
    """Return whether substitution leaves the term unchanged."""
    return isinstance(term, _PLAIN) or term.ground


def measure(terms: tuple[Term, ...]) -> tuple[int, int]:
    """Return size and depth of a term with these parts. Raises `TooDeepError` over the limits."""
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
    raise TooDeepError(f"terms nested more than {MAX_DEPTH} deep")


# ---- namespaces

DEFAULT = Literal("default")
"""Default namespace."""


def namespace_of(functor: str) -> str:
    """Return the namespace of a functor, by default `default`."""
    prefix, separator, _ = functor.rpartition("::")
    return prefix if separator else "default"


def is_placed(term: Term) -> bool:
    """Return whether a term is a literal in a namespace, which plain variables do not match."""
    return term.__class__ is Literal and "::" in term.functor


def placed(literal: Literal, namespace: str, negated: bool | None = None) -> Literal:
    """Return a literal in another namespace. `negated` replaces its negation."""
    bare = literal.functor.rpartition("::")[2]
    functor = bare if namespace == "default" else f"{namespace}::{bare}"
    sign = literal.negated if negated is None else negated
    return Literal(functor, literal.args, literal.annots, negated=sign)


# ---- making terms


@lru_cache(maxsize=4096)
def atom(name: str) -> Literal:
    """Return the atom of a name, shared because identical atoms are compared faster."""
    return Literal(name)


TRUE = Literal("true")
FALSE = Literal("false")
FROM_SELF = Literal("source", (Literal("self"),))
#: Annotations of most beliefs and goals.
ONLY_SELF: tuple[Term, ...] = (FROM_SELF,)
FROM_PERCEPT = Literal("source", (Literal("percept"),))
ONLY_PERCEPT: tuple[Term, ...] = (FROM_PERCEPT,)


def make_list(elements: Iterable[Term], tail: Term = EMPTY) -> Term:
    """Return the list of `elements` with a tail."""
    result = tail
    for element in reversed(list(elements)):
        result = Cons(element, result)
    return result


def make_term(value: object) -> Term:
    """Return the term for a Python number, str, bool, list or tuple, and terms unchanged."""
    if isinstance(value, Literal | Cons) or value.__class__ in _PLAIN:
        return cast(Term, value)
    if isinstance(value, str):
        return str(value)
    if isinstance(value, bool):
        return TRUE if value else FALSE
    if isinstance(value, Real):
        return float(value)
    if isinstance(value, list | tuple):
        return make_list(make_term(element) for element in value)
    if hasattr(value, "depth"):  # another term
        return cast(Term, value)
    raise TypeError(f"a term must be a number, a text, a list or a term, not {value!r}")


# ---- printing


def text(term: Term) -> str:
    """Return a term as printed by Jason, with strings in quotes and integers without `.0`."""
    if isinstance(term, str):
        return f'"{term}"'
    if isinstance(term, float):
        return number_text(term)
    return str(term)


def plain_text(term: Term) -> str:
    """Return a string unchanged, and the `text` of other terms."""
    return term if isinstance(term, str) else text(term)


def _annots_text(annots: tuple[Term, ...]) -> str:
    if isinstance(annots[-1], RestVar):
        return f"[{','.join(map(text, annots[:-1]))}|{annots[-1]}]"
    return f"[{','.join(map(text, annots))}]"


def number_text(value: float) -> str:
    """Return a double as printed by Jason: as an integer of 64 bits if possible, or as in Java.

    `Double.toString` of Java writes decimals from 1e-3 up to 1e7, and `1.5E10` outside.
    """
    if math.isnan(value):
        return "NaN"
    if math.isinf(value):
        return "Infinity" if value > 0 else "-Infinity"
    if value.is_integer() and -(2.0**63) <= value <= 2.0**63:
        return str(min(int(value), 2**63 - 1))
    if 1e-3 <= abs(value) < 1e7:
        return repr(value)
    # The shortest digits that identify the double, as in `repr`.
    sign, digits, exponent = Decimal(repr(value)).normalize().as_tuple()
    first, rest = str(digits[0]), "".join(map(str, digits[1:]))
    power = int(exponent) + len(digits) - 1
    return f"{'-' if sign else ''}{first}.{rest or '0'}E{power}"
