"""Internal actions: definition, registration, and the check of a program's calls."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass
from difflib import get_close_matches
from typing import Any, NamedTuple, TypeAlias

from .errors import ProgramError, ProgramProblem
from .language.body import (
    Act,
    Body,
    BodyTerm,
    Constraint,
    For,
    If,
    Place,
    Test,
    While,
    steps_of,
)
from .language.operations import Arithmetic, Conjunction, Disjunction, Function, Negation, Relation
from .language.program import Plan, Program, Rule, all_plans, made_once
from .language.quoted import PlanTerm
from .language.terms import Cons, Literal, Term

#: Takes a `Call` and the arguments. Returns a bool, None, a unifier or an iterator of unifiers.
InternalFunction: TypeAlias = Callable[..., Any]


def error_annots(error: str, message: str) -> tuple[Term, ...]:
    """Return the annotations of a failure event with the error and its message."""
    return (Literal("error", (Literal(error),)), Literal("error_msg", (message,)))


class ActionError(Exception):
    """Failure of an internal action. `annots` are the annotations of its `-!g` event."""

    def __init__(
        self, message: str, error: str = "internal_action", annots: tuple[Term, ...] = ()
    ) -> None:
        self.message = message
        self.annots = (*error_annots(error, message), *annots)
        super().__init__(message)


@dataclass(frozen=True)
class InternalAction:
    """Internal action of a program.

    `function` is called with a `Call` and the arguments. It returns whether the action holds, a
    unifier, or an iterator of unifiers. `least` and `most` limit the number of arguments, and
    `in_context` allows the action in contexts and queries.
    """

    function: InternalFunction
    least: int = 0
    most: int | None = None
    in_context: bool = True

    def check(self, name: str, count: int) -> None:
        """Check the number of arguments of a call. Raises `ActionError` if it is invalid."""
        if self.least <= count and (self.most is None or count <= self.most):
            return
        if self.least != self.most:
            most = 2**31 - 1 if self.most is None else self.most
            wanted = f"From {self.least} to {most} arguments are"
        else:
            wanted = "One argument is" if self.least == 1 else f"{self.least} arguments are"
        raise ActionError(
            f"The internal action '{name.lstrip('.')}' has not received the required number"
            f" of argument(s). {wanted} expected.",
            "wrong_arguments",
        )


class InternalActions(dict[str, InternalAction]):
    """Custom internal actions, passed to agents as `actions`.

    Parameters
    ----------
    *mappings : mapping, optional
        Initial actions by name.

    Attributes
    ----------
    functions : dict
        Arithmetic functions by name.

    Examples
    --------
    >>> import math
    >>> actions = bdi.InternalActions()
    >>> @actions.add("floor.distance")
    ... def distance(call, x, y, result):
    ...     return call.unify(result, math.hypot(x, y))
    """

    def __init__(self, *mappings: Mapping[str, InternalAction]) -> None:
        super().__init__(*mappings)
        self.functions: dict[str, Callable[..., float]] = {}

    def __repr__(self) -> str:
        return f"<InternalActions {', '.join([*self, *self.functions]) or 'none'}>"

    def function(self, name: str) -> Callable[[Callable[..., float]], Callable[..., float]]:
        """Register an arithmetic function for terms and comparisons, such as `my.half(X)`.

        Parameters
        ----------
        name : str
            Name in programs. It must contain a dot.

        Returns
        -------
        callable
            Decorator for a function that takes and returns numbers.

        Raises
        ------
        ValueError
            If the name contains no dot or is taken.
        """
        if "." not in name:
            raise ValueError(f"the name of a function must contain a dot, not '{name}'")
        if name in self or name in self.functions:
            raise ValueError(f"a function or internal action '{name}' exists already")

        def register(function: Callable[..., float]) -> Callable[..., float]:
            self.functions[name] = function
            return function

        return register

    def add(
        self, name: str, *, least: int = 0, most: int | None = None, in_context: bool = True
    ) -> Callable[[InternalFunction], InternalFunction]:
        """Register an internal action, such as `floor.distance`.

        The function is called with a `Call` and the arguments. It returns True, False, None, a
        unifier or an iterator of unifiers.

        Parameters
        ----------
        name : str
            Name in programs. It must contain a dot.
        least : int, optional
            Minimum number of arguments.
        most : int, optional
            Maximum number of arguments. The default is no limit.
        in_context : bool, optional
            Whether contexts and queries may use the action.

        Returns
        -------
        callable
            Decorator for the function.

        Raises
        ------
        ValueError
            If the name contains no dot or is taken.
        """
        if "." not in name:
            raise ValueError(f"the name of an internal action must contain a dot, not '{name}'")
        if name in self:
            raise ValueError(f"an internal action '{name}' exists already")

        def register(function: InternalFunction) -> InternalFunction:
            self[name] = InternalAction(function, least, most, in_context)
            return function

        return register


# ---- the calls in a program


def check_actions(
    program: Program, actions: Mapping[str, object], *, strict: bool
) -> tuple[ProgramProblem, ...]:
    """Return a problem for each call of an unknown internal action.

    Raises `ProgramError` with all problems if a call is not allowed in its place, or if an action
    is unknown and `strict` is True.
    """
    problems: dict[ProgramProblem, None] = {}
    unknown: dict[ProgramProblem, None] = {}
    for place, action, in_context in _calls(program):
        name = action.functor
        if name not in actions:
            near = get_close_matches(name, actions, n=1)
            hint = f"; did you mean {near[0]}?" if near else ""
            unknown[place.problem(f"there is no internal action {name}{hint}")] = None
        elif in_context and not getattr(actions[name], "in_context", True):
            problems[place.problem(f"{name} cannot be used in a context or query")] = None
    if strict:
        problems |= unknown
    if problems:
        raise ProgramError(list(problems))
    return tuple(unknown)


class ActionCall(NamedTuple):
    """Call of an internal action in a program."""

    place: Place
    action: Literal
    in_context: bool
    """Whether the call is in a context or query."""


@made_once
def _calls(program: Program) -> tuple[ActionCall, ...]:
    """Return all calls in a program."""
    rules = (clause for clause in program.beliefs if isinstance(clause, Rule))
    in_rules = (call for rule in rules for call in _at(rule.place, rule.body))
    return (*in_rules, *_in_plans(program.plans))


def _in_plans(plans: Iterable[Plan]) -> Iterator[ActionCall]:
    for plan in all_plans(plans):
        yield from _at(plan.place, plan.context)
        if plan.until is not None:
            yield from _at(plan.place, plan.until)
        yield from _in_body(plan.body)


def _at(place: Place, formula: Term) -> Iterator[ActionCall]:
    return (ActionCall(place, action, within) for action, within in _in_formula(formula))


def _in_body(body: Body) -> Iterator[ActionCall]:
    for step in steps_of(body):
        if isinstance(step, Act):
            if isinstance(step.action, Literal) and step.action.is_internal_action:
                yield ActionCall(step.place, step.action, in_context=False)
                # The arguments may contain bodies and plans with further calls.
                for arg in step.action.args:
                    yield from _at(step.place, arg)
        elif isinstance(step, Test):
            yield from _at(step.place, step.formula)
        elif isinstance(step, Constraint):
            yield from _at(step.place, step.relation)
        elif isinstance(step, If | While):
            yield from _at(step.place, step.condition)
        elif isinstance(step, For):
            yield from _at(step.place, step.generator)


def _in_formula(formula: Term) -> Iterator[tuple[Literal, bool]]:
    """Yield each call in a formula, and False for those inside a body in braces."""
    pending = [formula]
    while pending:
        part = pending.pop()
        if isinstance(part, Literal) and part.is_internal_action:
            yield part, True
            pending.extend(part.args)
        elif isinstance(part, Conjunction | Disjunction | Negation):
            pending.extend(reversed(part.operands))
        elif isinstance(part, Relation):
            kinds = Cons | PlanTerm | BodyTerm | Arithmetic | Function
            pending.extend(e for e in part.operands if isinstance(e, kinds))
        elif isinstance(part, Arithmetic | Function):
            pending.extend(part.operands)
        elif isinstance(part, Cons):
            pending.extend(e for e in part if isinstance(e, PlanTerm | BodyTerm))
        elif isinstance(part, PlanTerm):
            yield from ((call.action, call.in_context) for call in _in_plans((part.plan,)))
        elif isinstance(part, BodyTerm):
            yield from ((call.action, call.in_context) for call in _in_body(part.body))
