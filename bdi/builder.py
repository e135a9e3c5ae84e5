"""From the parse tree of a clause to the values of program.py."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any, TypeAlias

from lark import Token, Transformer_NonRecursive, v_args
from lark.tree import Meta

from .arithmetic import is_function
from .order import sorted_annots
from .program import (
    Achieve,
    Act,
    Belief,
    Body,
    BodyFormula,
    BodyTerm,
    Constraint,
    For,
    Fork,
    Goal,
    If,
    Place,
    Plan,
    PlanTerm,
    Rule,
    Test,
    Trigger,
    TriggerTerm,
    Update,
    While,
)
from .terms import (
    EMPTY,
    FALSE,
    TRUE,
    And,
    AnnotatedVar,
    Arithmetic,
    Function,
    List,
    Literal,
    Nil,
    Not,
    Or,
    Relation,
    RestVar,
    Term,
    Var,
    make_list,
    text,
)

Clause: TypeAlias = "Belief | Rule | Goal | Plan | Directive"


class Directive:
    """`{ include("file.asl") }`: something to do while a program is read."""

    def __init__(self, name: str, args: tuple[Term, ...], place: Place) -> None:
        self.name = name
        self.args = args
        self.place = place


class RefusedError(Exception):
    """What the grammar allows but the language does not."""

    def __init__(self, line: int, column: int, message: str) -> None:
        self.line = line
        self.column = column
        self.message = message
        super().__init__(message)


def stray_message(character: str) -> str:
    """What is wrong with a character that no token begins with."""
    if character == '"':
        return "a string that does not end on its line"
    return f"'{character}' has no meaning here"


def _at(meta: Meta) -> tuple[int, int]:
    return getattr(meta, "line", 0), getattr(meta, "column", 0)


@v_args(inline=True, meta=True)
class Builder(Transformer_NonRecursive[Token, Any]):
    """Makes the values of program.py of a parsed clause."""

    def __init__(self, file: str) -> None:
        super().__init__()
        self._file = file

    def _place(self, meta: Meta) -> Place:
        return Place(self._file, *_at(meta))

    # ---- clauses

    def clause(self, meta: Meta, clause: Clause) -> Clause:
        return clause

    def stray(self, meta: Meta, character: Token) -> None:
        raise RefusedError(*_at(meta), stray_message(character))

    def directive(self, meta: Meta, name: Token, args: tuple[Term, ...] | None) -> Directive:
        return Directive(str(name), args or (), self._place(meta))

    def belief(self, meta: Meta, head: Term, body: Term | None) -> Belief | Rule:
        if not isinstance(head, Literal):
            raise RefusedError(*_at(meta), "a variable cannot be a belief")
        if head.is_internal_action:
            raise RefusedError(*_at(meta), f"the internal action {head.functor} cannot be a belief")
        if body is None:
            return Belief(head, self._place(meta))
        return Rule(head, body, self._place(meta))

    def initial_goal(self, meta: Meta, goal: Term) -> Goal:
        if not isinstance(goal, Literal):
            raise RefusedError(*_at(meta), "a variable cannot be a goal")
        return Goal(goal, self._place(meta))

    def plan(
        self,
        meta: Meta,
        label: Literal | None,
        trigger: Trigger,
        context: Term | None,
        body: Body | None,
    ) -> Plan:
        return Plan(
            label,
            trigger,
            TRUE if context is None else context,
            _without_true(body or ()),
            self._place(meta),
        )

    def named_label(self, meta: Meta, name: Token, annots: List | None) -> Literal:
        return Literal(str(name), (), _annots(annots))

    def unnamed_label(self, meta: Meta, annots: List) -> Literal:
        return Literal("", (), _annots(annots))

    def belief_trigger(self, meta: Meta, update: Token, literal: Literal | Var) -> Trigger:
        return self._trigger(meta, update, "", literal)

    def goal_trigger(self, meta: Meta, update: Token, literal: Literal | Var) -> Trigger:
        return self._trigger(meta, update, "!", literal)

    def test_trigger(self, meta: Meta, update: Token, literal: Literal | Var) -> Trigger:
        return self._trigger(meta, update, "?", literal)

    def _trigger(self, meta: Meta, update: Token, kind: str, literal: Literal | Var) -> Trigger:
        if update not in ("+", "-"):
            raise RefusedError(*_at(meta), f"a plan begins with '+' or '-', not with '{update}'")
        if isinstance(literal, Literal) and literal.is_internal_action:
            raise RefusedError(*_at(meta), f"there is no event of {literal.functor}")
        return Trigger(str(update), kind, literal)

    # ---- bodies

    def body_end(self, meta: Meta, step: BodyFormula | Body) -> Body:
        return _as_body(step)

    def body_more(self, meta: Meta, step: BodyFormula | Body, rest: Body) -> Body:
        return (*_as_body(step), *rest)

    def achieve(self, meta: Meta, goal: Literal | Var) -> Achieve:
        self._not_internal(meta, "!", goal)
        return Achieve(goal, False, self._place(meta))

    def achieve_new(self, meta: Meta, goal: Literal | Var) -> Achieve:
        self._not_internal(meta, "!!", goal)
        return Achieve(goal, True, self._place(meta))

    def _not_internal(self, meta: Meta, operator: str, literal: Term) -> None:
        if isinstance(literal, Literal) and literal.is_internal_action:
            raise RefusedError(
                *_at(meta), f"'{operator}' and the internal action {literal.functor} do not combine"
            )

    def test(self, meta: Meta, formula: Term) -> Test:
        self._not_internal(meta, "?", formula)
        return Test(formula, self._place(meta))

    def update(self, meta: Meta, operator: Token, belief: Term) -> BodyFormula:
        if isinstance(belief, PlanTerm):
            return self._plan_update(meta, operator, belief)
        if not isinstance(belief, Literal | Var):
            raise RefusedError(
                *_at(meta), f"'{operator}' is followed by a belief, not by {text(belief)}"
            )
        self._not_internal(meta, operator, belief)
        return Update(str(operator), belief, self._place(meta))

    def _plan_update(self, meta: Meta, operator: Token, plan: PlanTerm) -> Act:
        me = Literal("self")
        actions = {
            "+": Literal(".add_plan", (plan, me, Literal("begin"))),
            "+<": Literal(".add_plan", (plan, me, Literal("begin"))),
            "+>": Literal(".add_plan", (plan, me, Literal("end"))),
            "-": Literal(".remove_plan", (plan,)),
        }
        if operator not in actions:
            raise RefusedError(*_at(meta), f"'{operator}' and a plan do not combine")
        return Act(actions[str(operator)], self._place(meta))

    def act(self, meta: Meta, formula: Term) -> BodyFormula:
        if isinstance(formula, Literal | Var):
            return Act(formula, self._place(meta))
        if isinstance(formula, Relation):
            return Constraint(formula, self._place(meta))
        raise RefusedError(*_at(meta), f"{text(formula)} is nothing a plan can do")

    def group(self, meta: Meta, body: Body) -> Body:
        return body

    def fork_and(self, meta: Meta, one: BodyFormula | Body, other: BodyFormula | Body) -> Fork:
        return self._fork(meta, True, one, other)

    def fork_or(self, meta: Meta, one: BodyFormula | Body, other: BodyFormula | Body) -> Fork:
        return self._fork(meta, False, one, other)

    def _fork(
        self, meta: Meta, all_of: bool, one: BodyFormula | Body, other: BodyFormula | Body
    ) -> Fork:
        branches: tuple[Body, ...] = (_as_body(one),)
        if isinstance(other, Fork) and other.all_of == all_of:
            branches += other.branches
        else:
            branches += (_as_body(other),)
        return Fork(all_of, branches, self._place(meta))

    def if_(self, meta: Meta, conditional: If) -> If:
        return replace(conditional, place=self._place(meta))

    def if_then(self, meta: Meta, condition: Term, then: Body) -> If:
        return If(condition, then, (), self._place(meta))

    def if_else(self, meta: Meta, condition: Term, then: Body, otherwise: Body) -> If:
        return If(condition, then, otherwise, self._place(meta))

    def if_elif(self, meta: Meta, condition: Term, then: Body, otherwise: If) -> If:
        return If(condition, then, (otherwise,), self._place(meta))

    def while_(self, meta: Meta, condition: Term, body: Body) -> While:
        return While(condition, body, self._place(meta))

    def for_(self, meta: Meta, generator: Term, body: Body) -> For:
        return For(generator, body, self._place(meta))

    def block(self, meta: Meta, body: Body | None) -> Body:
        return body or ()

    # ---- formulas and terms

    def or_(self, meta: Meta, left: Term, right: Term) -> Or:
        return Or(left, right)

    def and_(self, meta: Meta, left: Term, right: Term) -> And:
        return And(left, right)

    def not_(self, meta: Meta, formula: Term) -> Not:
        return Not(formula)

    def relation(self, meta: Meta, left: Term, symbol: Token, right: Term) -> Relation:
        return Relation(str(symbol), left, right)

    def plus(self, meta: Meta, left: Term, right: Term) -> Arithmetic:
        return self._arithmetic(meta, "+", left, right)

    def minus(self, meta: Meta, left: Term, right: Term) -> Arithmetic:
        return self._arithmetic(meta, "-", left, right)

    def times(self, meta: Meta, left: Term, right: Term) -> Arithmetic:
        return self._arithmetic(meta, "*", left, right)

    def divide(self, meta: Meta, left: Term, right: Term) -> Arithmetic:
        return self._arithmetic(meta, "/", left, right)

    def div(self, meta: Meta, left: Term, right: Term) -> Arithmetic:
        return self._arithmetic(meta, "div", left, right)

    def mod(self, meta: Meta, left: Term, right: Term) -> Arithmetic:
        return self._arithmetic(meta, "mod", left, right)

    def raised(self, meta: Meta, left: Term, right: Term) -> Arithmetic:
        return self._arithmetic(meta, "**", left, right)

    def positive(self, meta: Meta, operand: Term) -> Term:
        return self._sign(meta, "+", operand)

    def negative(self, meta: Meta, operand: Term) -> Term:
        return self._sign(meta, "-", operand)

    def _arithmetic(self, meta: Meta, operator: str, left: Term, right: Term) -> Arithmetic:
        for operand in (left, right):
            self._numeric(meta, operator, operand)
        return Arithmetic(operator, left, right)

    def _sign(self, meta: Meta, operator: str, operand: Term) -> Term:
        if isinstance(operand, float):
            return -operand if operator == "-" else operand
        self._numeric(meta, operator, operand)
        return Arithmetic(operator, operand)

    def _numeric(self, meta: Meta, operator: str, operand: Term) -> None:
        if not isinstance(operand, float | Var | Arithmetic | Function):
            raise RefusedError(
                *_at(meta),
                f"'{operator}' takes numbers and variables, and {text(operand)} is neither",
            )

    def number(self, meta: Meta, token: Token) -> float:
        value = float(token)
        if math.isinf(value):
            raise RefusedError(*_at(meta), f"the number {token} is too large")
        return value

    def string(self, meta: Meta, token: Token) -> str:
        return string_value(token)

    def positive_literal(
        self, meta: Meta, name: Token, args: tuple[Term, ...] | None, annots: List | None
    ) -> Term:
        if annots is None and is_function(name, len(args or ())):
            return Function(str(name), args or ())
        return self._literal(meta, name, args, annots, False)

    def negative_literal(
        self, meta: Meta, name: Token, args: tuple[Term, ...] | None, annots: List | None
    ) -> Literal:
        return self._literal(meta, name, args, annots, True)

    def _literal(
        self,
        meta: Meta,
        name: Token,
        args: tuple[Term, ...] | None,
        annots: List | None,
        negated: bool,
    ) -> Literal:
        literal = Literal(str(name), args or (), _annots(annots), negated)
        if literal.is_internal_action and (negated or literal.annots):
            what = "be negated" if negated else "have annotations"
            raise RefusedError(*_at(meta), f"the internal action {name} cannot {what}")
        return literal

    def variable(self, meta: Meta, name: Token, annots: List | None) -> Var:
        return _variable(str(name), annots)

    def anonymous(self, meta: Meta, token: Token, annots: List | None) -> Var:
        return _variable(_anonymous(token), annots)

    def true(self, meta: Meta) -> Literal:
        return TRUE

    def false(self, meta: Meta) -> Literal:
        return FALSE

    def terms(self, meta: Meta, *terms: Term) -> tuple[Term, ...]:
        return terms

    def list(self, meta: Meta, elements: tuple[Term, ...] | None, tail: Term | None) -> Term:
        return make_list(elements or (), EMPTY if tail is None else tail)

    def elements(self, meta: Meta, *elements: Term) -> tuple[Term, ...]:
        return elements

    def tail_variable(self, meta: Meta, name: Token) -> Var:
        return Var(str(name))

    def tail_anonymous(self, meta: Meta, token: Token) -> Var:
        return Var(_anonymous(token))

    def tail_list(self, meta: Meta, tail: Term) -> Term:
        return tail

    def empty_body_term(self, meta: Meta) -> BodyTerm:
        return BodyTerm(())

    def body_term(self, meta: Meta, body: Body) -> BodyTerm:
        return BodyTerm(body)

    def goal_trigger_term(self, meta: Meta, update: Token, literal: Literal | Var) -> TriggerTerm:
        return TriggerTerm(f"{update}!", literal)

    def test_trigger_term(self, meta: Meta, update: Token, literal: Literal | Var) -> TriggerTerm:
        return TriggerTerm(f"{update}?", literal)

    def plan_term(
        self,
        meta: Meta,
        label: Literal | None,
        trigger: Trigger,
        context: Term,
        body: Body | None,
    ) -> PlanTerm:
        return PlanTerm(self.plan(meta, label, trigger, context, body))

    def short_plan_term(
        self, meta: Meta, label: Literal | None, trigger: Trigger, body: Body
    ) -> PlanTerm:
        return PlanTerm(self.plan(meta, label, trigger, None, body))


def string_value(token: str) -> str:
    """What a string in quotes stands for."""
    return token[1:-1].replace("\\n", "\n").replace('\\"', '"')


def _anonymous(token: Token) -> str:
    return f"__{token.line}_{token.column}"


def _as_body(step: BodyFormula | Body) -> Body:
    """A step as a body; what stands in brackets is one already."""
    return step if isinstance(step, tuple) else (step,)


def _without_true(body: Body) -> Body:
    """A body that begins with `true` is the rest of it."""
    first = body[0] if body else None
    return body[1:] if isinstance(first, Act) and first.action == TRUE else body


def _variable(name: str, written: List | None) -> Var:
    annots = _annots(written)
    return AnnotatedVar(name, annots) if annots else Var(name)


def _annots(annots: List | None) -> tuple[Term, ...]:
    if annots is None or isinstance(annots, Nil):
        return ()
    rest = annots.open_tail
    ordered = sorted_annots(tuple(annots))
    return ordered if rest is None else (*ordered, RestVar(rest.name))
