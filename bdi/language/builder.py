"""Conversion of the parse tree of a clause to values of `program.py` and `body.py`."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any, TypeAlias

from lark import Token, Transformer_NonRecursive, v_args
from lark.tree import Meta

from .body import (
    Achieve,
    Act,
    Body,
    BodyFormula,
    BodyTerm,
    Constraint,
    For,
    ForkJoin,
    If,
    Place,
    Test,
    Update,
    While,
)
from .namespaces import THIS
from .operations import (
    Arithmetic,
    Conjunction,
    Disjunction,
    Function,
    Negation,
    Qualified,
    Relation,
    TriggerTerm,
)
from .program import Belief, Directive, Goal, Plan, Rule, Trigger
from .quoted import PlanTerm, RuleTerm, plan_change
from .substitution import is_function, sorted_annots
from .terms import (
    DEFAULT,
    EMPTY,
    FALSE,
    TRUE,
    AnnotatedVar,
    List,
    Literal,
    Nil,
    RestVar,
    Term,
    Var,
    atom,
    make_list,
    text,
)


class ClauseError(Exception):
    """Clause that the grammar allows but the language does not."""

    def __init__(self, meta: Meta, message: str) -> None:
        self.line, self.column = _at(meta)
        super().__init__(message)


def stray_message(character: str) -> str:
    """Return the message about an invalid character."""
    if character == '"':
        return "a string that does not end on its line"
    return f"'{character}' has no meaning here"


def _at(meta: Meta) -> tuple[int, int]:
    return getattr(meta, "line", 0), getattr(meta, "column", 0)


_Steps: TypeAlias = BodyFormula | Body
_Event: TypeAlias = Literal | Var | Qualified


@v_args(inline=True, meta=True)
class Builder(Transformer_NonRecursive[Token, Any]):
    """Transformer of a parse tree to a clause. Each method has the name of its grammar rule."""

    def __init__(self, file: str) -> None:
        super().__init__()
        self._file = file

    def _place(self, meta: Meta) -> Place:
        return Place(self._file, *_at(meta))

    # ---- clauses

    def stray(self, meta: Meta, character: Token) -> None:
        raise ClauseError(meta, stray_message(character))

    def directive(self, meta: Meta, name: Token, args: tuple[Term, ...] | None) -> Directive:
        return Directive(name=str(name), args=args or (), place=self._place(meta))

    def opening_directive(
        self, meta: Meta, begin: Token, name: Token, args: tuple[Term, ...] | None
    ) -> Directive:
        if begin != "begin":
            raise ClauseError(meta, f"a directive of two names is {{ begin {name} }}")
        return Directive(name=str(name), args=args or (), place=self._place(meta), opens=True)

    def belief(self, meta: Meta, head: Term, body: Term | None) -> Belief | Rule:
        if not isinstance(head, Literal):
            raise ClauseError(meta, "a variable cannot be a belief")
        if head.is_internal_action:
            raise ClauseError(meta, f"the internal action {head.functor} cannot be a belief")
        place = self._place(meta)
        return Belief(head, place) if body is None else Rule(head, body, place)

    def initial_goal(self, meta: Meta, goal: Term) -> Goal:
        if not isinstance(goal, Literal):
            raise ClauseError(meta, "a variable cannot be a goal")
        return Goal(goal, self._place(meta))

    def plan(self, meta: Meta, label: Literal | Var | None, *parts: Any) -> Plan:
        if isinstance(label, Var):
            raise ClauseError(meta, "only plans in braces may have a variable as label")
        return self._plan(meta, label, *parts)

    def _plan(
        self,
        meta: Meta,
        label: Literal | Var | None,
        trigger: Trigger,
        context: Term | None,
        until: Term | None,
        body: Body | None,
    ) -> Plan:
        return Plan(
            label=label,
            trigger=trigger,
            context=TRUE if context is None else context,
            body=_without_true(body or ()),
            place=self._place(meta),
            until=until,
        )

    def named_label(
        self,
        meta: Meta,
        qualifier: Term | None,
        name: Token,
        args: tuple[Term, ...] | None,
        annots: List | None,
    ) -> Literal:
        return Literal(_in(qualifier, name), args or (), _annots(annots))

    def unnamed_label(self, meta: Meta, annots: List) -> Literal:
        return Literal("", (), _annots(annots))

    def variable_label(self, meta: Meta, label: Var) -> Var:
        return label

    def trigger(self, meta: Meta, update: Token, kind: Token | None, literal: _Event) -> Trigger:
        if update not in ("+", "-", "^"):
            raise ClauseError(meta, f"a plan begins with '+' or '-', not with '{update}'")
        if isinstance(literal, Literal) and literal.is_internal_action:
            raise ClauseError(meta, f"there is no event of {literal.functor}")
        return Trigger(str(update), str(kind or ""), literal)

    # ---- bodies

    def body_end(self, meta: Meta, step: _Steps) -> Body:
        return _as_body(step)

    def body_more(self, meta: Meta, step: _Steps, rest: Body) -> Body:
        return (*_as_body(step), *rest)

    def achieve(self, meta: Meta, sign: Token, goal: _Event) -> Achieve:
        self._not_internal(meta, sign, goal)
        return Achieve(goal, sign == "!!", self._place(meta))

    def _not_internal(self, meta: Meta, operator: str, literal: Term) -> None:
        if isinstance(literal, Literal) and literal.is_internal_action:
            raise ClauseError(
                meta, f"'{operator}' cannot be applied to the internal action {literal.functor}"
            )

    def test(self, meta: Meta, formula: Term) -> Test:
        self._not_internal(meta, "?", formula)
        return Test(formula, self._place(meta))

    def update(self, meta: Meta, operator: Token, belief: Term) -> BodyFormula:
        if isinstance(belief, PlanTerm):
            action = plan_change(operator, belief)
            if action is None:
                raise ClauseError(meta, f"'{operator}' cannot be applied to a plan")
            return Act(action, self._place(meta))
        if isinstance(belief, RuleTerm) and operator == "-+":
            raise ClauseError(meta, "'-+' cannot be applied to a rule")
        if not isinstance(belief, Literal | Var | Qualified | RuleTerm):
            raise ClauseError(meta, f"'{operator}' is followed by a belief, not by {text(belief)}")
        self._not_internal(meta, operator, belief)
        return Update(str(operator), belief, self._place(meta))

    def act(self, meta: Meta, formula: Term) -> _Steps:
        if isinstance(formula, Literal | Var | Qualified):
            return Act(formula, self._place(meta))
        if isinstance(formula, BodyTerm):
            return formula.body
        if isinstance(formula, Relation):
            return Constraint(formula, self._place(meta))
        raise ClauseError(meta, f"{text(formula)} cannot be a step of a plan")

    def fork(self, meta: Meta, one: _Steps, sign: Token, other: _Steps) -> ForkJoin:
        all_of = sign == "|&|"
        is_more = isinstance(other, ForkJoin) and other.all_of == all_of
        others = other.branches if isinstance(other, ForkJoin) and is_more else (_as_body(other),)
        return ForkJoin(all_of, (_as_body(one), *others), self._place(meta))

    def if_(self, meta: Meta, conditional: If) -> If:
        return replace(conditional, place=self._place(meta))

    def conditional(self, meta: Meta, condition: Term, then: Body, otherwise: _Steps | None) -> If:
        return If(
            condition=condition,
            then=then,
            otherwise=_as_body(otherwise or ()),
            place=self._place(meta),
        )

    def while_(self, meta: Meta, condition: Term, body: Body) -> While:
        return While(condition, body, self._place(meta))

    def for_(self, meta: Meta, generator: Term, body: Body) -> For:
        return For(generator, body, self._place(meta))

    def block(self, meta: Meta, body: Body | None) -> Body:
        return body or ()

    # ---- formulas and terms

    def or_(self, meta: Meta, left: Term, right: Term) -> Disjunction:
        return Disjunction(left, right)

    def and_(self, meta: Meta, left: Term, right: Term) -> Conjunction:
        return Conjunction(left, right)

    def not_(self, meta: Meta, formula: Term) -> Negation:
        return Negation(formula)

    def relation(self, meta: Meta, left: Term, symbol: Token, right: Term) -> Relation:
        return Relation(str(symbol), left, right)

    def arithmetic(self, meta: Meta, left: Term, operator: Token, right: Term) -> Arithmetic:
        for operand in (left, right):
            self._numeric(meta, operator, operand)
        return Arithmetic(str(operator), left, right)

    def sign(self, meta: Meta, sign: Token, operand: Term) -> Term:
        if isinstance(operand, float):
            return -operand if sign == "-" else operand
        self._numeric(meta, sign, operand)
        return Function(str(sign), (operand,))

    def _numeric(self, meta: Meta, operator: str, operand: Term) -> None:
        # A custom function is a literal with a dot until an agent binds it.
        is_own = isinstance(operand, Literal) and operand.is_internal_action
        if not is_own and not isinstance(operand, float | Var | Arithmetic | Function):
            raise ClauseError(
                meta,
                f"'{operator}' takes numbers and variables, and {text(operand)} is neither",
            )

    def number(self, meta: Meta, token: Token) -> float:
        value = float(token)
        if math.isinf(value):
            raise ClauseError(meta, f"the number {token} is too large")
        return value

    def string(self, meta: Meta, token: Token) -> str:
        return string_value(token)

    def named_literal(
        self,
        meta: Meta,
        qualifier: Term | None,
        tilde: Token | None,
        name: Token,
        args: tuple[Term, ...] | None,
        annots: List | None,
    ) -> Term:
        negated = tilde is not None
        if not negated and annots is None and is_function(name, len(args or ())):
            return Function(str(name), args or ())
        functor, own = _in(qualifier, name), _annots(annots)
        is_atom = not (args or own or negated)
        literal = atom(functor) if is_atom else Literal(functor, args or (), own, negated=negated)
        if literal.is_internal_action and (negated or literal.annots):
            what = "be negated" if negated else "have annotations"
            raise ClauseError(meta, f"the internal action {name} cannot {what}")
        return Qualified(qualifier, literal) if isinstance(qualifier, Var) else literal

    def VAR(self, token: Token) -> Var:
        return Var(str(token))

    def ANONYMOUS(self, token: Token) -> Var:
        return Var(f"__{token.line}_{token.column}")

    def variable(
        self,
        meta: Meta,
        qualifier: Term | None,
        tilde: Token | None,
        variable: Var,
        annots: List | None,
    ) -> Var | Qualified:
        if kept := _annots(annots):
            variable = AnnotatedVar(variable.name, kept)
        if tilde is not None:
            return Qualified(qualifier or DEFAULT, variable, negated=True)
        return variable if qualifier is None else Qualified(qualifier, variable)

    def named_qualifier(self, meta: Meta, name: Token) -> Literal:
        return Literal(str(name))

    def own_qualifier(self, meta: Meta) -> Literal:
        return Literal(THIS)

    def true(self, meta: Meta) -> Literal:
        return TRUE

    def false(self, meta: Meta) -> Literal:
        return FALSE

    def terms(self, meta: Meta, *terms: Term) -> tuple[Term, ...]:
        return terms

    def list(self, meta: Meta, elements: tuple[Term, ...] | None, tail: Term | None) -> Term:
        return make_list(elements or (), EMPTY if tail is None else tail)

    elements = terms

    def empty_body_term(self, meta: Meta) -> BodyTerm:
        return BodyTerm(())

    def body_term(self, meta: Meta, body: Body) -> BodyTerm:
        return BodyTerm(body)

    def goal_trigger_term(self, meta: Meta, update: Token, literal: _Event) -> TriggerTerm:
        return TriggerTerm(f"{update}!", literal)

    def test_trigger_term(self, meta: Meta, update: Token, literal: _Event) -> TriggerTerm:
        return TriggerTerm(f"{update}?", literal)

    def plan_term(
        self,
        meta: Meta,
        label: Literal | Var | None,
        trigger: Trigger,
        context: Term,
        body: Body | None,
    ) -> PlanTerm:
        return PlanTerm(self._plan(meta, label, trigger, context, None, body))

    def short_plan_term(
        self, meta: Meta, label: Literal | Var | None, trigger: Trigger, body: Body
    ) -> PlanTerm:
        return PlanTerm(self._plan(meta, label, trigger, None, None, body))

    def rule_term(self, meta: Meta, head: _Event, body: Term) -> RuleTerm:
        if not isinstance(head, Literal):
            raise ClauseError(meta, "a variable cannot be the head of a rule")
        return RuleTerm(Rule(head, body, self._place(meta)))


def _in(qualifier: Term | None, name: str) -> str:
    return f"{qualifier.functor}::{name}" if isinstance(qualifier, Literal) else str(name)


def string_value(token: str) -> str:
    """Return the string of a token in quotes."""
    return token[1:-1].replace("\\n", "\n").replace('\\"', '"')


def _as_body(step: _Steps) -> Body:
    """Return a step, or steps in brackets, as a body."""
    return step if isinstance(step, tuple) else (step,)


def _without_true(body: Body) -> Body:
    """Return a body without an initial `true`."""
    first = body[0] if body else None
    return body[1:] if isinstance(first, Act) and first.action == TRUE else body


def _annots(annots: List | Var | None) -> tuple[Term, ...]:
    if annots is None or isinstance(annots, Nil):
        return ()
    if isinstance(annots, Var):  # [|R]
        return (RestVar(annots.name),)
    rest = annots.open_tail
    ordered = sorted_annots(tuple(annots))
    return ordered if rest is None else (*ordered, RestVar(rest.name))
