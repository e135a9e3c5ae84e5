"""Unification of terms: Robinson's algorithm (1965) over triangular unifiers, without occurs check.

As in Prolog and Jason, a variable may be bound to a term that contains it. Substitution then nests
too deeply and stops the agent. Annotations unify as subsets, and arithmetic is evaluated before it
is compared.

`matcher` and `belief_matcher` compile the frequent patterns.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeAlias

from .body import Achieve, Act, BodyFormula, BodyTerm, Constraint, Test, Update
from .operations import Arithmetic, Function, Operation, Qualified, Quoted, TriggerTerm
from .quoted import PlanTerm, RuleTerm
from .substitution import Unifier, substitute, walk
from .terms import (
    DEFAULT,
    AnnotatedVar,
    Cons,
    Literal,
    RestVar,
    Term,
    Var,
    make_list,
    namespace_of,
    placed,
)


def unify(one: Term, other: Term, u: Unifier) -> bool:
    """Return whether the terms unify, with bindings in `u`.

    The annotations of the first term must be among those of the second. After a failure `u`
    contains the bindings until then.
    """
    while one.__class__ is Var:
        value = u.get(one.name)
        if value is None:
            break
        one = value
    while other.__class__ is Var:
        value = u.get(other.name)
        if value is None:
            break
        other = value
    if one is other:
        return True
    if one.__class__ is Var:
        return _bind(one, other, u)
    if other.__class__ is Var:
        return _bind(other, one, u)
    if one.__class__ is Literal and other.__class__ is Literal:
        return unify_literals(one, other, u)
    # Compared by class, because this is faster than isinstance and most calls end here.
    if one.__class__ is float or one.__class__ is str:
        if other.__class__ is Arithmetic or other.__class__ is Function:
            other = substitute(other, u)
        if one == other:
            return True
        is_open = other.__class__ is not one.__class__ and isinstance(other, Var | Qualified)
        return is_open and unify(other, one, u)
    return _unify_others(one, other, u)


def try_unify(one: Term, other: Term, u: Unifier) -> bool:
    """Unify as `unify`, but leave `u` unchanged after a failure."""
    attempt = dict(u)
    if not unify(one, other, attempt):
        return False
    u.update(attempt)
    return True


def _bind(var: Var, value: Term, u: Unifier) -> bool:
    if value.__class__ is Literal and "::" in value.functor:
        return False  # a variable without namespace has no value in a namespace
    if value.__class__ is Qualified:
        namespace, inner = value.operands
        return not value.negated and unify(namespace, DEFAULT, u) and unify(var, inner, u)
    if value.__class__ is Arithmetic or value.__class__ is Function:
        value = substitute(value, u)
    if value.__class__ is Var and value.name == var.name:
        return True
    # Bind the named variable to the fresh one, because other clauses may use the name.
    if value.__class__ is Var and not value.fresh and var.fresh:
        u[value.name] = var
    else:
        u[var.name] = value
    return True


def unify_literals(one: Literal, other: Literal, u: Unifier) -> bool:
    """Unify two literals."""
    if (
        one.functor != other.functor
        or len(one.args) != len(other.args)
        or one.negated != other.negated
    ):
        return False
    for mine, theirs in zip(one.args, other.args):  # noqa: B905 - equal lengths, and often
        if not unify(mine, theirs, u):
            return False
    annots = one.annots
    if not annots or (annots is other.annots and other.ground):
        return True
    return unify_annots(annots, other.annots, u)


def unify_annots(mine: tuple[Term, ...], theirs: tuple[Term, ...], u: Unifier) -> bool:
    """Unify each annotation of `mine` with another one of `theirs`.

    An open tail of `mine` unifies with the rest of `theirs`. An open tail of `theirs` unifies with
    the annotations of `mine` that `theirs` lacks.
    """
    # As in Jason, each annotation unifies with the first possible one without backtracking, because
    # set unification is NP-complete (D. Kapur and P. Narendran, "NP-completeness of the set
    # unification and matching problems", CADE 1986). Queries try all choices of the annotations of
    # a belief (`Logic._with_annots`).
    remaining = [annot for annot in theirs if not isinstance(annot, RestVar)]
    tail = theirs[-1] if len(remaining) < len(theirs) else None
    missing: list[Term] = []
    rest: Term | None = None
    for annot in mine:
        if isinstance(annot, RestVar):
            rest = Var(annot.name)
            break
        for position, candidate in enumerate(remaining):
            if try_unify(annot, candidate, u):
                del remaining[position]
                break
        else:
            if tail is None:
                return False
            missing.append(annot)
    if tail is not None and not unify(_plain(tail), make_list(missing), u):
        return False
    return rest is None or unify(rest, make_list(remaining), u)


def _unify_others(one: Term, other: Term, u: Unifier) -> bool:
    if isinstance(one, Cons) and isinstance(other, Cons):
        return _unify_lists(one, other, u)
    for term in (one, other):
        if isinstance(term, Arithmetic | Function):
            one, other = substitute(one, u), substitute(other, u)
            if isinstance(one, Arithmetic | Function) or isinstance(other, Arithmetic | Function):
                return one == other
            return unify(one, other, u)
    if isinstance(one, AnnotatedVar) or isinstance(other, AnnotatedVar):
        return _unify_annotated(one, other, u)
    if isinstance(one, Qualified) or isinstance(other, Qualified):
        return _unify_qualified(one, other, u)
    if isinstance(one, Var) or isinstance(other, Var):
        return unify(_plain(one), _plain(other), u)
    if isinstance(one, Operation) and isinstance(other, Operation):
        # Operations unify as terms, without evaluation.
        pairs = zip(one.operands, other.operands)  # noqa: B905 - equal with equal symbols
        return one.symbol == other.symbol and all(unify(*pair, u) for pair in pairs)
    if isinstance(one, TriggerTerm) and isinstance(other, TriggerTerm):
        return one.sort == other.sort and unify(one.literal, other.literal, u)
    if isinstance(one, Quoted) and isinstance(other, Quoted):
        return _unify_quoted(one, other, u)
    if isinstance(one, PlanTerm | BodyTerm) and isinstance(other, Literal):
        structure = one.structure
        return structure is not None and unify(structure, other, u)
    if isinstance(other, PlanTerm | BodyTerm) and isinstance(one, Literal):
        structure = other.structure
        return structure is not None and unify(one, structure, u)
    return one == other


# ---- plans, rules and bodies as terms


def _unify_quoted(one: Quoted, other: Quoted, u: Unifier) -> bool:
    if isinstance(one, BodyTerm) and isinstance(other, BodyTerm):
        return _unify_bodies(one, other, u)
    if isinstance(one, PlanTerm) and isinstance(other, PlanTerm):
        # Plans with different labels unify, but a variable is bound to the label.
        label, value = one.plan.label, other.plan.label
        if isinstance(value, Var):
            label, value = value, label
        if isinstance(label, Var) and value is not None and not unify(label, value, u):
            return False
        return _unify_all(one.plan.parts[1:], other.plan.parts[1:], u)
    if isinstance(one, RuleTerm) and isinstance(other, RuleTerm):
        mine, theirs = one.rule, other.rule
        return _unify_all((mine.head, mine.body), (theirs.head, theirs.body), u)
    return one == other


def _unify_all(ones: tuple[Term, ...], others: tuple[Term, ...], u: Unifier) -> bool:
    return all(unify(*pair, u) for pair in zip(ones, others, strict=True))


def _unify_bodies(one: BodyTerm, other: BodyTerm, u: Unifier) -> bool:
    """Unify bodies step by step. A variable as the last step unifies with all further steps."""
    if not one.body or not other.body:
        return one.body == other.body
    for pattern, value in ((one, other), (other, one)):
        if len(pattern.body) == 1 < len(value.body):
            variable = _variable_step(pattern.body[0])
            if variable is not None:
                return unify(variable, value, u)
    if not _unify_steps(one, other, u):
        return False
    rest, others = BodyTerm(one.body[1:], one.bare), BodyTerm(other.body[1:], other.bare)
    for pattern, value in ((rest, others), (others, rest)):
        if len(pattern.body) == 1:
            variable = _variable_step(pattern.body[0])
            if variable is not None:
                return unify(variable, value, u)
    return _unify_bodies(rest, others, u)


def _unify_steps(first: BodyTerm, second: BodyTerm, u: Unifier) -> bool:
    """Unify the first steps of two bodies."""
    one, other = first.body[0], second.body[0]
    for pattern, value in ((one, second), (other, first)):
        variable = _variable_step(pattern)
        if variable is not None:
            return unify(variable, _step_term(value.body[0], value.bare), u)
    if isinstance(one, Achieve) and isinstance(other, Achieve):
        return one.new_focus == other.new_focus and unify(one.goal, other.goal, u)
    if isinstance(one, Test) and isinstance(other, Test):
        return unify(one.formula, other.formula, u)
    if isinstance(one, Update) and isinstance(other, Update):
        return one.operator == other.operator and unify(one.belief, other.belief, u)
    if isinstance(one, Act | Constraint) and isinstance(other, Act | Constraint):
        return unify(_step_term(one), _step_term(other), u)
    return one == other


def _variable_step(step: BodyFormula) -> Var | None:
    return step.action if isinstance(step, Act) and isinstance(step.action, Var) else None


def _step_term(step: BodyFormula, bare: bool = False) -> Term:
    """Return the value of a variable for a step: an action, or a body of one step."""
    if isinstance(step, Act):
        return step.action
    return step.relation if isinstance(step, Constraint) else BodyTerm((step,), bare)


def _plain(term: Term) -> Term:
    return Var(term.name) if isinstance(term, Var) else term


def _unify_lists(one: Cons, other: Cons, u: Unifier) -> bool:
    mine: Term = one
    theirs: Term = other
    while isinstance(mine, Cons) and isinstance(theirs, Cons):
        if mine is theirs:
            return True
        if not unify(mine.head, theirs.head, u):
            return False
        # A loop instead of recursion, because lists may be long. The tails may be variables.
        mine, theirs = walk(mine.tail, u), walk(theirs.tail, u)
    return unify(mine, theirs, u)


def _unify_annotated(one: Term, other: Term, u: Unifier) -> bool:
    """Unify two terms of which at least one is a variable with annotations, `X[a] = p[a, b]`.

    The annotations of the first term must be among those of the second. The variable is bound to a
    value without annotations.
    """
    if isinstance(one, Literal | AnnotatedVar | Var) and isinstance(other, Literal | AnnotatedVar):
        mine = one.annots if isinstance(one, Literal | AnnotatedVar) else ()
        if mine and not unify_annots(mine, other.annots, u):
            return False
    elif isinstance(one, AnnotatedVar) and isinstance(other, Var):
        # An unbound variable has no annotations, so X[a] does not unify with it, but X[|R] does.
        only_rest = len(one.annots) == 1 and isinstance(one.annots[0], RestVar)
        if not (only_rest and unify_annots(one.annots, (), u)):
            return False
    mine_is_open, theirs_is_open = isinstance(one, AnnotatedVar), isinstance(other, AnnotatedVar)
    left, right = _plain(one), _plain(other)
    if mine_is_open and isinstance(right, Literal):
        right = right.without_annots()
    if theirs_is_open and isinstance(left, Literal):
        left = left.without_annots()
    return unify(left, right, u)


def _unify_qualified(one: Term, other: Term, u: Unifier) -> bool:
    """Unify two terms of which at least one has an open namespace or negation."""
    if isinstance(one, Qualified) and isinstance(other, Qualified):
        return one.negated == other.negated and all(
            unify(mine, theirs, u)
            for mine, theirs in zip(one.operands, other.operands, strict=True)
        )
    qualified, literal = (one, other) if isinstance(one, Qualified) else (other, one)
    assert isinstance(qualified, Qualified)  # as the callers ensure
    # With a known namespace it becomes a literal. Otherwise the parts are unified one by one.
    value = substitute(qualified, u)
    if not isinstance(value, Qualified):
        return unify(value, other, u) if qualified is one else unify(one, value, u)
    namespace, inner = value.operands
    if not isinstance(literal, Literal):
        # Numbers, strings and lists have no namespace, but a variable in one may unify with them.
        return inner.__class__ is Var and not value.negated and unify(inner, literal, u)
    if value.negated and not literal.negated:
        return False
    bare = placed(literal, "default", False if value.negated else None)
    if not unify(namespace, Literal(namespace_of(literal.functor)), u):
        return False
    return unify(inner, bare, u) if qualified is one else unify(bare, inner, u)


def unified(one: Term, other: Term, u: Unifier) -> Unifier | None:
    """Return a copy of `u` with the bindings that unify the terms, or None."""
    result = dict(u)
    return result if unify(one, other, result) else None


def matched(pattern: Literal, belief: Literal, u: Unifier) -> Unifier | None:
    """Return `unified` of a query without annotations and a belief with the same key.

    Numbers, strings and atoms are compared here, and `u` is copied only for a binding, because most
    programs spend most of their time here.
    """
    if not belief.ground:
        return unified(pattern, belief, u)
    result = u
    for mine, theirs in zip(pattern.args, belief.args):  # noqa: B905 - equal lengths, and often
        if mine.__class__ is Var:
            value = result.get(mine.name)
            while value.__class__ is Var:
                mine, value = value, result.get(value.name)
            if value is None:
                if theirs.__class__ is Literal and "::" in theirs.functor:
                    return None
                if result is u:
                    result = u.copy()
                result[mine.name] = theirs
                continue
            mine = value
        if mine is theirs:
            continue
        if mine.__class__ is Literal and theirs.__class__ is Literal:
            if mine.key != theirs.key:
                return None
            if not mine.args and not mine.annots:
                continue
        elif mine.__class__ is float or mine.__class__ is str:
            if mine != theirs:
                return None
            continue
        if result is u:
            result = u.copy()
        if not unify(mine, theirs, result):
            return None
    return result


Match: TypeAlias = Callable[[Literal], Unifier | None]


def matcher(pattern: Literal | Var | Qualified) -> Match:
    """Return a function that unifies a trigger with the literal of an event of the same key."""
    if pattern.__class__ is not Literal or pattern.annots:
        return lambda literal: _unified(pattern, literal)
    args = pattern.args
    if not args:
        return lambda literal: {}
    names = [arg.name for arg in args if arg.__class__ is Var]
    if len(names) < len(args) or len(set(names)) < len(names):
        return lambda literal: matched(pattern, literal, {})

    if len(names) == 1:
        (name,) = names

        def match_one(literal: Literal) -> Unifier | None:
            (arg,) = literal.args
            return None if arg.__class__ is Literal and "::" in arg.functor else {name: arg}

        return match_one

    def match_all(literal: Literal) -> Unifier | None:
        for arg in literal.args:
            if arg.__class__ is Literal and "::" in arg.functor:
                return None
        return dict(zip(names, literal.args))  # noqa: B905 - equal lengths

    return match_all


def _unified(pattern: Term, literal: Literal) -> Unifier | None:
    u: Unifier = {}
    return u if unify(pattern, literal, u) else None


def belief_matcher(query: Literal) -> Callable[[Literal, Unifier], Unifier | None]:
    """Return `matched` for a query, compiled if its arguments are distinct variables."""
    if not query.args:
        return lambda belief, u: u
    names = [arg.name for arg in query.args if arg.__class__ is Var]
    if not names or len(set(names)) < len(query.args):
        return lambda belief, u: matched(query, belief, u)

    def match(belief: Literal, u: Unifier) -> Unifier | None:
        if not belief.ground:
            return matched(query, belief, u)
        result = u.copy()
        for name, arg in zip(names, belief.args):  # noqa: B905 - equal lengths, and often
            value = u.get(name)
            if value is None and not (arg.__class__ is Literal and "::" in arg.functor):
                result[name] = arg
            elif value is not arg:
                return matched(query, belief, u)
        return result

    return match
