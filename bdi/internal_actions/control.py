"""Control structures as actions, for bodies that are terms: `.if_then_else(C, {a}, {b})`."""

from __future__ import annotations

from ..language.body import Act, Body, BodyFormula, BodyTerm, For, Fork, If, While
from ..language.terms import Literal, Term, Var, text
from ..reasoning.bodies import compile_body
from ..reasoning.calls import WAITING, Call, Waiting
from ..reasoning.execution import OPERATIONS
from .arguments import wrong
from .registry import STANDARD


def _body(name: str, term: Term) -> Body:
    if isinstance(term, BodyTerm):
        return term.body
    if isinstance(term, Literal | Var):
        return (Act(term),)
    raise wrong(name, f"'{text(term)}' is not the body of a plan.")


def _carry_out(call: Call, formula: BodyFormula) -> Waiting:
    """Carry a control structure out in place of the step that calls."""
    intention = call.intention
    assert intention is not None  # none of them is allowed in a context
    means = intention.top
    means.step = compile_body((formula,), None if means.step is None else means.step.next)
    assert means.step is not None  # it begins with the formula
    OPERATIONS[means.step.operation](call.agent, intention, means, means.step)
    return WAITING


@STANDARD.add(".if_then_else", least=2, most=3, in_context=False)
def if_then_else(call: Call, condition: Term, then: Term, *otherwise: Term) -> Waiting:
    """`.if_then_else(F, {a}, {b}?)`: carry out one body or the other."""
    bodies = [_body("if_then_else", term) for term in (then, *otherwise)]
    return _carry_out(call, If(condition, bodies[0], bodies[1] if otherwise else ()))


@STANDARD.add(".loop", least=2, most=2, in_context=False)
def loop(call: Call, condition: Term, body: Term) -> Waiting:
    """`.loop(F, {a})`: carry out a body as long as a formula holds."""
    return _carry_out(call, While(condition, _body("loop", body)))


@STANDARD.add(".foreach", least=2, most=2, in_context=False)
def foreach(call: Call, generator: Term, body: Term) -> Waiting:
    """`.foreach(F, {a})`: carry out a body for each answer of a formula."""
    return _carry_out(call, For(generator, _body("foreach", body)))


@STANDARD.add(".fork", least=2, in_context=False)
def fork(call: Call, kind: Term, *branches: Term) -> Waiting:
    """`.fork(and, {a}, {b})`: carry out bodies concurrently, until all or the first end."""
    name = text(kind)
    if name not in ("and", "or"):
        raise wrong("fork", "first argument must be 'and' or 'or'.")
    return _carry_out(call, Fork(name == "and", tuple(_body("fork", b) for b in branches)))
