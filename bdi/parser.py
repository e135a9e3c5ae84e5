"""From text to a program. Every clause that is wrong is told of, each with its place."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any, TypeAlias

from lark import Lark, Token, Transformer_NonRecursive, Tree, v_args
from lark.exceptions import UnexpectedInput, UnexpectedToken, VisitError
from lark.tree import Meta

from .arithmetic import is_function
from .errors import Problem, ProgramError
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
    Program,
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
from .tokens import clauses, grammar, tokenize

Clause: TypeAlias = "Belief | Rule | Goal | Plan | Directive"

_NAMES = {
    "ATOM": "a name",
    "VAR": "a variable",
    "ANONYMOUS": "'_'",
    "NUMBER": "a number",
    "STRING": "a string",
    "RELATION": "a comparison",
    "UPDATE": "'+' or '-'",
}


class Directive:
    """`{ include("file.asl") }`: something to do while a program is read."""

    def __init__(self, name: str, args: tuple[Term, ...], place: Place) -> None:
        self.name = name
        self.args = args
        self.place = place


class _RefusedError(Exception):
    """What the grammar allows but the language does not."""

    def __init__(self, line: int, column: int, message: str) -> None:
        self.line = line
        self.column = column
        self.message = message
        super().__init__(message)


def _at(meta: Meta) -> tuple[int, int]:
    return getattr(meta, "line", 0), getattr(meta, "column", 0)


@v_args(inline=True, meta=True)
class _Builder(Transformer_NonRecursive[Token, Any]):
    """Makes the values of program.py of a parsed clause."""

    def __init__(self, file: str) -> None:
        super().__init__()
        self._file = file

    def _place(self, meta: Meta) -> Place:
        return Place(self._file, *_at(meta))

    # ---- clauses

    def clause(self, meta: Meta, clause: Clause) -> Clause:
        return clause

    def directive(self, meta: Meta, name: Token, args: tuple[Term, ...] | None) -> Directive:
        return Directive(str(name), args or (), self._place(meta))

    def belief(self, meta: Meta, head: Term, body: Term | None) -> Belief | Rule:
        if not isinstance(head, Literal):
            raise _RefusedError(*_at(meta), "a variable cannot be a belief")
        if head.is_internal_action:
            raise _RefusedError(
                *_at(meta), f"the internal action {head.functor} cannot be a belief"
            )
        if body is None:
            return Belief(head, self._place(meta))
        return Rule(head, body, self._place(meta))

    def initial_goal(self, meta: Meta, goal: Term) -> Goal:
        if not isinstance(goal, Literal):
            raise _RefusedError(*_at(meta), "a variable cannot be a goal")
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
            raise _RefusedError(*_at(meta), f"a plan begins with '+' or '-', not with '{update}'")
        if isinstance(literal, Literal) and literal.is_internal_action:
            raise _RefusedError(*_at(meta), f"there is no event of {literal.functor}")
        return Trigger(str(update), kind, literal)

    # ---- bodies

    def body_end(self, meta: Meta, step: BodyFormula) -> Body:
        return (step,)

    def body_more(self, meta: Meta, step: BodyFormula, rest: Body) -> Body:
        return (step, *rest)

    def achieve(self, meta: Meta, goal: Literal | Var) -> Achieve:
        self._not_internal(meta, "!", goal)
        return Achieve(goal, False, self._place(meta))

    def achieve_new(self, meta: Meta, goal: Literal | Var) -> Achieve:
        self._not_internal(meta, "!!", goal)
        return Achieve(goal, True, self._place(meta))

    def _not_internal(self, meta: Meta, operator: str, literal: Term) -> None:
        if isinstance(literal, Literal) and literal.is_internal_action:
            raise _RefusedError(
                *_at(meta), f"'{operator}' and the internal action {literal.functor} do not combine"
            )

    def test(self, meta: Meta, formula: Term) -> Test:
        self._not_internal(meta, "?", formula)
        return Test(formula, self._place(meta))

    def update(self, meta: Meta, operator: Token, belief: Term) -> BodyFormula:
        if isinstance(belief, PlanTerm):
            return self._plan_update(meta, operator, belief)
        if not isinstance(belief, Literal | Var):
            raise _RefusedError(
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
            raise _RefusedError(*_at(meta), f"'{operator}' and a plan do not combine")
        return Act(actions[str(operator)], self._place(meta))

    def act(self, meta: Meta, formula: Term) -> BodyFormula:
        if isinstance(formula, Literal | Var):
            return Act(formula, self._place(meta))
        if isinstance(formula, Relation):
            return Constraint(formula, self._place(meta))
        raise _RefusedError(*_at(meta), f"{text(formula)} is nothing a plan can do")

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
            raise _RefusedError(
                *_at(meta),
                f"'{operator}' takes numbers and variables, and {text(operand)} is neither",
            )

    def number(self, meta: Meta, token: Token) -> float:
        return float(token)

    def string(self, meta: Meta, token: Token) -> str:
        return token[1:-1].replace("\\n", "\n").replace('\\"', '"')

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
            raise _RefusedError(*_at(meta), f"the internal action {name} cannot {what}")
        return literal

    def variable(self, meta: Meta, name: Token, annots: List | None) -> Var:
        return Var(str(name)) if annots is None else AnnotatedVar(str(name), _annots(annots))

    def anonymous(self, meta: Meta, token: Token, annots: List | None) -> Var:
        name = _anonymous(token)
        return Var(name) if annots is None else AnnotatedVar(name, _annots(annots))

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


def _anonymous(token: Token) -> str:
    return f"__{token.line}_{token.column}"


def _as_body(step: BodyFormula | Body) -> Body:
    return step if isinstance(step, tuple) else (step,)


def _without_true(body: Body) -> Body:
    """A body that begins with `true` is the rest of it."""
    first = body[0] if body else None
    return body[1:] if isinstance(first, Act) and first.action == TRUE else body


def _annots(annots: List | None) -> tuple[Term, ...]:
    if annots is None or isinstance(annots, Nil):
        return ()
    rest = annots.open_tail
    ordered = sorted_annots(tuple(annots))
    return ordered if rest is None else (*ordered, RestVar(rest.name))


# ---- reading clauses


def _parse_clause(tokens: Sequence[Token], file: str) -> Any:
    parser = grammar().parse_interactive()
    for token in tokens:
        parser.feed_token(token)
    tree: Tree[Token] = parser.feed_eof(tokens[-1] if tokens else None)  # type: ignore[no-untyped-call]
    return _Builder(file).transform(tree)


def _problem(error: Exception, tokens: Sequence[Token], file: str) -> Problem:
    """What a clause that could not be read has wrong with it."""
    if isinstance(error, VisitError) and isinstance(error.orig_exc, _RefusedError):
        refused = error.orig_exc
        return Problem(file, refused.line, refused.column, refused.message)
    if isinstance(error, RecursionError):
        return Problem(file, tokens[0].line or 0, tokens[0].column or 0, "too deeply nested")
    if isinstance(error, UnexpectedToken):
        token = error.token
        expected = _expected(error.accepts or error.expected)
        if token.type == "$END":
            last = tokens[-1]
            found, line, column = "the end", last.end_line or 0, last.end_column or 0
        else:
            found, line, column = f"'{token}'", token.line or 0, token.column or 0
        if token.type == "STRAY" and token == '"':
            return Problem(file, line, column, "a string that does not end on its line")
        if token.type == "STRAY":
            return Problem(file, line, column, f"{found} has no meaning here")
        return Problem(file, line, column, f"found {found}, expected {expected}")
    raise error


def _expected(names: Sequence[str] | set[str]) -> str:
    parser: Lark = grammar()
    words = set()
    for name in names:
        if name in _NAMES:
            words.add(_NAMES[name])
        elif name not in ("$END", "STRAY"):
            words.add(f"'{parser.get_terminal(name).pattern.value}'")
    ordered = sorted(words, key=lambda word: (word.startswith("'"), word))
    if len(ordered) > 12:
        ordered = [*ordered[:12], "…"]
    if len(ordered) < 2:
        return "".join(ordered) or "nothing more"
    return f"{', '.join(ordered[:-1])} or {ordered[-1]}"


def read_clauses(source: str, file: str) -> tuple[list[Clause], list[Problem]]:
    """The clauses of a text, in order, and what is wrong with those that cannot be read."""
    found: list[Clause] = []
    problems: list[Problem] = []
    for tokens in clauses(tokenize(source)):
        try:
            found.append(_parse_clause(tokens, file))
        except (UnexpectedInput, VisitError, RecursionError) as error:
            problems.append(_problem(error, tokens, file))
    return found, problems


def _parse_one(source: str, before: str, after: str, file: str) -> Any:
    """The clause that a part of one makes when it is completed before and after."""
    tokens = [*tokenize(before), *tokenize(source), *tokenize(after)]
    try:
        return _parse_clause(tokens, file)
    except (UnexpectedInput, VisitError, RecursionError) as error:
        raise ProgramError([_problem(error, tokens, file)]) from None


def parse_literal(source: str) -> Literal:
    """A belief, goal or percept, as `gantry_detected(3)[source(percept)]`."""
    clause = _parse_one(source, "", ".", source)
    if not isinstance(clause, Belief):
        raise ProgramError([Problem(source, 0, 0, "a literal is expected")])
    return clause.belief


def parse_term(source: str) -> Term:
    """Any term or formula."""
    clause = _parse_one(source, "term :- ", ".", source)
    if not isinstance(clause, Rule):
        raise ProgramError([Problem(source, 0, 0, "a term is expected")])
    return clause.body


def parse_trigger(source: str) -> TriggerTerm:
    """An event, as `+work_completed(_)`."""
    clause = _parse_one(source, "", ".", source)
    if not isinstance(clause, Plan):
        raise ProgramError([Problem(source, 0, 0, "an event is expected, as +b or +!g")])
    return TriggerTerm(clause.trigger.sort, clause.trigger.literal)


def parse_plan(source: str) -> Plan:
    clause = _parse_one(source, "", "" if source.rstrip().endswith(".") else ".", source)
    if not isinstance(clause, Plan):
        raise ProgramError([Problem(source, 0, 0, "a plan is expected")])
    return clause


# ---- reading programs

Include: TypeAlias = Callable[[str, Place], "tuple[str, str] | Problem"]


def parse_clauses(
    source: str, file: str, include: Include, including: tuple[str, ...] = ()
) -> tuple[list[Clause], list[Problem]]:
    """The clauses of a text with those of the files it includes in their places."""
    clauses_here, problems = read_clauses(source, file)
    result: list[Clause] = []
    for clause in clauses_here:
        if not isinstance(clause, Directive):
            result.append(clause)
            continue
        opened = _open_included(clause, include, (*including, file))
        if isinstance(opened, Problem):
            problems.append(opened)
            continue
        more, wrong = parse_clauses(*opened, include, (*including, file))
        result.extend(more)
        problems.extend(wrong)
    return result, problems


def _open_included(
    directive: Directive, include: Include, including: tuple[str, ...]
) -> tuple[str, str] | Problem:
    place = directive.place
    if directive.name != "include":
        message = f"there is no directive '{directive.name}'; the one there is is include"
        return Problem(place.file, place.line, place.column, message)
    if len(directive.args) != 1 or not isinstance(directive.args[0], str):
        message = 'include takes the name of a file: { include("patrol.asl") }'
        return Problem(place.file, place.line, place.column, message)
    opened = include(directive.args[0], place)
    if not isinstance(opened, Problem) and opened[1] in including:
        message = f"{directive.args[0]} includes itself"
        return Problem(place.file, place.line, place.column, message)
    return opened


def make_program(found: Sequence[Clause], source: str, folder: Path | None) -> Program:
    return Program(
        source,
        tuple(c for c in found if isinstance(c, Belief | Rule)),
        tuple(c for c in found if isinstance(c, Goal)),
        tuple(c for c in found if isinstance(c, Plan)),
        folder,
    )
