"""Programs: beliefs, rules, goals and plans, with their locations in the source.

`str` of each of them is AgentSpeak.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from functools import cached_property, partial, wraps
from pathlib import Path
from typing import Any, TypeAlias, TypeVar

from .body import NOWHERE, Body, BodyTerm, Place, all_parts, body_text, transformed
from .operations import Conjunction, Disjunction, Function, Negation, Qualified, TriggerTerm
from .substitution import RUN_FUNCTIONS, is_function
from .terms import TRUE, Literal, Term, Var, is_ground, text


@dataclass(frozen=True)
class Trigger:
    """Event of a plan: an operator, a kind ("" belief, "!" goal, "?" test) and a literal.

    The operator is + or -, or ^ for a new state of a goal.
    """

    operator: str
    kind: str
    literal: Literal | Var | Qualified

    @property
    def sort(self) -> str:
        """Operator and kind together, such as `+!`, `-` or `+?`."""
        return self.operator + self.kind

    def __str__(self) -> str:
        return f"{self.operator}{self.kind}{self.literal}"


_ATOMIC = Literal("atomic")
Condition: TypeAlias = Term | None


Key: TypeAlias = tuple[str, int, bool]
"""Functor, arity and negation of a literal."""


CACHEABLE = frozenset({".findall", ".length", ".nth", ".member"})
"""Internal actions whose answers depend only on their arguments and queries."""


def are_apart(args: Iterable[Term]) -> bool:
    """Return whether all arguments are ground values or distinct variables."""
    names: list[str] = []
    for arg in args:
        if arg.__class__ is Var:
            names.append(arg.name)
        elif not is_ground(arg):
            return False
    return len(set(names)) == len(names)


# ---- clauses


@dataclass(frozen=True, repr=False)
class _Picklable:
    """Base of values that cache derived values."""

    def __getstate__(self) -> dict[str, object]:
        """Return the fields without cached values, which may be functions or hashes."""
        return {name: vars(self)[name] for name in self.__dataclass_fields__}


@dataclass(frozen=True, repr=False)
class Clause(_Picklable):
    """Base of the parts of a program."""

    def __repr__(self) -> str:
        return f"<{type(self).__name__} {self}>"

    @cached_property
    def functions(self) -> frozenset[str]:
        """Names of the arithmetic functions that the clause calls.

        They are cached, because all agents that run a program share its clauses.
        """
        names = set()
        for part in all_parts(self):
            if isinstance(part, Function):
                names.add(part.symbol)
            elif isinstance(part, Literal) and part.is_internal_action and _is_own(part):
                names.add(part.functor)
        return frozenset(names)


@dataclass(frozen=True, repr=False)
class Rule(Clause):
    """Rule `head :- body`: the head is believed if the body holds.

    Parameters
    ----------
    head : Literal
        Conclusion.
    body : Term
        Condition.
    place : Place, optional
        Location in the source.
    """

    head: Literal
    body: Term
    place: Place = field(default=NOWHERE, compare=False)

    def is_same(self, other: Rule) -> bool:
        """Return whether the rules differ only in names of variables and in annotations.

        Parameters
        ----------
        other : Rule
            Rule to compare with.
        """
        return _numbered(self) == _numbered(other)

    @cached_property
    def parameters(self) -> tuple[str, ...] | None:
        """Names of the arguments of the head if they are distinct variables, otherwise None."""
        names = tuple(arg.name for arg in self.head.args if arg.__class__ is Var)
        return names if len(set(names)) == len(self.head.args) else None

    @cached_property
    def queried_keys(self) -> frozenset[Key]:
        """Keys of the literals that the body queries, also by `.findall`."""
        return frozenset(part.key for part in self._formulas if isinstance(part, Literal))

    @cached_property
    def is_cacheable(self) -> bool:
        """Whether the answers depend only on the answers to the queries of the body.

        The body then calls only `CACHEABLE` actions, and none of its formulas is a variable.
        """
        is_open = any(isinstance(part, Var | Qualified) for part in self._formulas)
        return self.functions <= CACHEABLE and not is_open

    @property
    def _formulas(self) -> list[Term]:
        """Parts of the body and of its `.findall` queries that are not operations."""
        found: list[Term] = []
        pending = [self.body]
        while pending:
            part = pending.pop()
            if isinstance(part, Conjunction | Disjunction | Negation):
                pending.extend(part.operands)
                continue
            found.append(part)
            if isinstance(part, Literal) and part.functor == ".findall":
                pending.extend(part.args[1:2])
        return found

    def __str__(self) -> str:
        return f"{self.head} :- {text(self.body)}"


def _numbered(rule: Rule) -> object:
    """Return the head and body of a rule, with its variables numbered in order."""
    names: dict[str, Var] = {}

    def number(part: Any) -> Any:
        if part.__class__ is not Var:
            return None
        return names.setdefault(part.name, Var(f"_{len(names)}"))

    return transformed((rule.head.without_annots(), rule.body), number)


@dataclass(frozen=True, repr=False, kw_only=True)
class Plan(Clause):
    """Plan of a program, written `@label[annotations] trigger : context <- body.`.

    Parameters
    ----------
    label : Literal, Var or None
        Name and annotations. In a term it may be a variable.
    trigger : Trigger
        Event for which the plan is relevant.
    context : Term
        Formula under which the plan is applicable. The default in programs is `true`.
    body : tuple
        Steps in order.
    place : Place, optional
        Location in the source.
    until : Term, optional
        Formula under which the goal is achieved, written after `<:`.
    subplans : tuple of Plan, optional
        Plans that exist while this one is carried out.
    """

    label: Literal | Var | None
    trigger: Trigger
    context: Term
    body: Body
    place: Place = field(default=NOWHERE, compare=False)
    until: Condition = None
    subplans: tuple[Plan, ...] = ()

    @property
    def atomic(self) -> bool:
        """Whether the label has the annotation `atomic`, so that other intentions wait."""
        return isinstance(self.label, Literal) and _ATOMIC in self.label.annots

    @property
    def name(self) -> str:
        """Functor of the label, empty without a label."""
        return self.label.functor if isinstance(self.label, Literal) else ""

    def is_same(self, other: Plan) -> bool:
        """Return whether the plans differ only in label and place.

        Parameters
        ----------
        other : Plan
            Plan to compare with.
        """
        return (self.trigger, self.context, self.body) == (
            other.trigger,
            other.context,
            other.body,
        )

    @property
    def parts(self) -> tuple[Term, ...]:
        """Label, event, context and body as terms, as `=..` returns them."""
        label = Literal("nolabel") if self.label is None else self.label
        event = TriggerTerm(self.trigger.sort, self.trigger.literal, bare=True)
        return label, event, self.context, BodyTerm(self.body, bare=True)

    def __str__(self) -> str:
        label = "" if self.label is None else f"@{self.label} "
        context = "" if self.context == TRUE else f" : {text(self.context)}"
        until = "" if self.until is None else f" <: {text(self.until)}"
        body = f" <- {body_text(self.body)}" if self.body else ""
        inside = " ".join(f"{plan}." for plan in self.subplans)
        # The full stop of the last subplan is that of the plan.
        more = f". {{ {inside} }}" if inside else ""
        return f"{label}{self.trigger}{context}{until}{body}{more}"


def all_plans(plans: Iterable[Plan]) -> Iterator[Plan]:
    """Yield plans, each followed by its subplans."""
    for plan in plans:
        yield plan
        yield from all_plans(plan.subplans)


@dataclass(frozen=True, repr=False)
class Goal(Clause):
    """Initial goal of a program.

    Parameters
    ----------
    goal : Literal
        Goal to achieve.
    place : Place, optional
        Location in the source.
    """

    goal: Literal
    place: Place = field(default=NOWHERE, compare=False)

    def __str__(self) -> str:
        return f"!{self.goal}"


@dataclass(frozen=True, repr=False)
class Belief(Clause):
    """Initial belief of a program.

    Parameters
    ----------
    belief : Literal
        Belief.
    place : Place, optional
        Location in the source.
    """

    belief: Literal
    place: Place = field(default=NOWHERE, compare=False)

    @property
    def functions(self) -> frozenset[str]:
        """Names of the arithmetic functions that the belief calls."""
        belief = self.belief
        if belief.annots or "." in belief.functor or not all(map(_is_plain, belief.args)):
            return super().functions
        return frozenset()

    def __str__(self) -> str:
        return str(self.belief)


def _is_plain(term: Term) -> bool:
    """Return whether a term is a number, a string or a plain atom."""
    if term.__class__ is Literal:
        return not (term.args or term.annots or "." in term.functor)
    return term.__class__ is float or term.__class__ is str


@dataclass(frozen=True, repr=False, kw_only=True)
class Directive(Clause):
    """Directive such as `{ include("file.asl") }`, carried out while a program is read."""

    name: str
    args: tuple[Term, ...]
    place: Place
    opens: bool = False
    """Whether it is `{ begin name }`, which `{ end }` closes."""


@dataclass(frozen=True, repr=False, kw_only=True)
class Program(_Picklable):
    """Program of an agent. Converting it to str returns its source in a standard layout.

    Parameters
    ----------
    source : str
        File, or name of the text.
    beliefs : tuple of Belief or Rule, optional
        Initial beliefs and rules in order.
    goals : tuple of Goal, optional
        Initial goals in order.
    plans : tuple of Plan, optional
        Plans in order.
    folder : Path, optional
        Folder from which `.include` may read. By default it can only read built-in programs.
    """

    source: str
    beliefs: tuple[Belief | Rule, ...] = ()
    goals: tuple[Goal, ...] = ()
    plans: tuple[Plan, ...] = ()
    folder: Path | None = None

    def __str__(self) -> str:
        clauses = (*self.beliefs, *self.goals, *self.plans)
        return "".join(
            f"{clause}\n" if isinstance(clause, Plan) and clause.subplans else f"{clause}.\n"
            for clause in transformed(clauses, _escaped)
        )

    def __hash__(self) -> int:
        return self._hash

    @cached_property
    def _hash(self) -> int:
        # Cached, because programs are long and shared.
        return hash((self.source, self.beliefs, self.goals, self.plans, self.folder))

    def __repr__(self) -> str:
        counts = f"{len(self.beliefs)} beliefs, {len(self.goals)} goals, {len(self.plans)} plans"
        return f"<Program {self.source}: {counts}>"


def _escaped(part: object) -> str | None:
    """Return a string as it is written in a program, or None for other values."""
    if not isinstance(part, str):
        return None
    return part.replace('"', '\\"').replace("\n", "\\n")


# ---- values shared by all runs, and values of one run


_Shared = TypeVar("_Shared", bound=Clause | Program)
_Made = TypeVar("_Made")
_Clause = TypeVar("_Clause", bound=Clause)


def made_once(make: Callable[[_Shared], _Made]) -> Callable[[_Shared], _Made]:
    """Cache the results of `make` for each clause or program, in its instance dictionary."""
    name = make.__name__

    @wraps(make)
    def cached(shared: _Shared) -> _Made:
        value: _Made | None = shared.__dict__.get(name)
        if value is None:
            value = shared.__dict__[name] = make(shared)
        return value

    return cached


def _is_own(literal: Literal) -> bool:
    """Return whether a literal may be a function of a run, not an action like `.count(F, N)`."""
    count = len(literal.args)
    return literal.functor not in RUN_FUNCTIONS or is_function(literal.functor, count)


def with_run_functions(
    clauses: tuple[_Clause, ...], functions: Mapping[str, Callable[..., float]]
) -> tuple[_Clause, ...]:
    """Return clauses with functions of one run, such as `math.random`, bound to `functions`.

    Agents share clauses, so each agent binds copies of those that call such functions. Other
    clauses are returned unchanged. Bodies of rules are bound on first use.
    """

    def bind(part: Any) -> Any:
        if isinstance(part, Function) and part.symbol in functions:
            args = transformed(part.operands, bind)
            return Function(part.symbol, args, functions[part.symbol])
        if isinstance(part, Literal) and part.functor in functions and _is_own(part):
            args = transformed(part.args, bind)
            return Function(part.functor, args, functions[part.functor])
        return None

    def bound(clause: Any) -> Any:
        return _RuleOfRun(clause, bind) if isinstance(clause, Rule) else transformed(clause, bind)

    return tuple([one if one.functions.isdisjoint(functions) else bound(one) for one in clauses])


class _RuleOfRun(Rule):
    """Rule that calls functions of one run, which `bind` inserts into the body on first use."""

    _bound: Callable[[], Term]

    def __init__(self, rule: Rule, bind: Callable[[Any], Any]) -> None:
        bound = partial(transformed, rule.body, bind)
        vars(self).update(head=transformed(rule.head, bind), place=rule.place, _bound=bound)

    @cached_property
    def body(self) -> Term:
        """Condition of the rule."""
        return self._bound()
