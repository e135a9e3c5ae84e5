"""Plan bodies compiled to a graph of steps; `execution.py` carries them out."""

from __future__ import annotations

from ..language.body import (
    Achieve,
    Act,
    Body,
    BodyFormula,
    Constraint,
    Event,
    For,
    If,
    Test,
    Update,
    While,
)
from ..language.program import Rule, RuleTerm
from ..language.terms import TRUE, Literal, Term
from .beliefs import with_source
from .builders import Build, builder
from .compiled import Condition, condition


class Step:
    """One step of a body.

    `operation` names what it does: the operator of a goal, belief or fork, the name of a control
    structure, or the kind of an action. `term` is the goal, belief, action or condition it is
    about; `build` makes its value, `check` solves it. `branches` are the first steps of the bodies
    inside it, `next` is the step after it.
    """

    __slots__ = ("branches", "build", "check", "formula", "next", "operation", "term")

    def __init__(
        self, operation: str, formula: BodyFormula, following: Step | None, term: Term = TRUE
    ) -> None:
        self.operation = operation
        self.formula = formula
        self.next = following
        self.term = term
        self.branches: tuple[Step | None, ...] = ()
        if isinstance(formula, Achieve | Update | Act):
            self.build: Build = builder(term)
            if isinstance(formula, Achieve | Update) and not isinstance(term, Literal):
                self.build = _with_source(self.build)
        else:
            self.check: Condition = condition(term)

    @property
    def goal(self) -> Event | None:
        """The subgoal for which the step waits, if it is one."""
        formula = self.formula
        return formula.goal if isinstance(formula, Achieve) and not formula.new_focus else None


def compile_body(body: Body, following: Step | None = None) -> Step | None:
    """Return the first step of a body that continues with `following`."""
    # From the last on, as each step knows the one after it.
    for formula in reversed(body):
        following = _compile(formula, following)
    return following


def _compile(formula: BodyFormula, following: Step | None) -> Step:
    if isinstance(formula, Achieve):
        operation = "!!" if formula.new_focus else "!"
        return Step(operation, formula, following, _sourced(formula.goal))
    if isinstance(formula, Update):
        return Step(formula.operator, formula, following, _sourced(formula.belief))
    if isinstance(formula, Test):
        return Step("?", formula, following, formula.formula)
    if isinstance(formula, Act):
        return Step(_kind(formula.action), formula, following, formula.action)
    if isinstance(formula, Constraint):
        return Step("constraint", formula, following, formula.relation)
    if isinstance(formula, If):
        step = Step("if", formula, following, formula.condition)
        step.branches = (
            compile_body(formula.then, following),
            compile_body(formula.otherwise, following),
        )
        return step
    if isinstance(formula, While):
        return _compile_loop("while", formula, formula.condition, following)
    if isinstance(formula, For):
        return _compile_loop("for", formula, formula.generator, following)
    step = Step("|&|" if formula.all_of else "|||", formula, following)
    meeting = Step("join", formula, following)
    step.branches = tuple(compile_body(branch, meeting) for branch in formula.branches)
    return step


def _compile_loop(name: str, formula: While | For, term: Term, following: Step | None) -> Step:
    """Return the step that begins a loop; the last of its body leads to one that repeats it."""
    first = Step(name, formula, following, term)
    again = Step(f"{name} again", formula, following, term)
    # The body leads back to a step of its own kind: a loop begins in another way than it goes on.
    first.branches = again.branches = (compile_body(formula.body, again) or again,)
    return first


def _sourced(term: Term) -> Term:
    """Return a literal or a rule with a source; anything else as it is."""
    if isinstance(term, RuleTerm):
        rule = term.rule
        return RuleTerm(Rule(with_source(rule.head), rule.body, rule.place))
    return with_source(term) if isinstance(term, Literal) else term


def _with_source(build: Build) -> Build:
    """Return the function that gives a source to what a variable stands for."""
    return lambda u: _sourced(build(u))


def _kind(action: Event) -> str:
    if isinstance(action, Literal):
        return "internal action" if action.is_internal_action else "external action"
    return "variable"
