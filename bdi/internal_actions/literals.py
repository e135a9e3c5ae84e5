"""Actions on literals and formulas as terms."""

from __future__ import annotations

from ..language.order import with_more_annots
from ..language.substitution import rename
from ..language.terms import FALSE, TRUE, Cons, Literal, Nil, Term, make_list, namespace_of
from ..reasoning.calls import Call
from ..reasoning.mail import nested_source, without_source
from .registry import STANDARD


def _annotated(term: Term, annot: Term) -> Term:
    if isinstance(term, Nil | Cons):
        return make_list([_annotated(element, annot) for element in term])
    if not isinstance(term, Literal):
        return term
    return with_more_annots(term, annot)


@STANDARD.add(".add_annot", least=3, most=3)
def add_annot(call: Call, term: Term, annot: Term, result: Term) -> object:
    """`.add_annot(T, A, R)`: a literal, or each of a list, with one more annotation."""
    return call.unify(result, _annotated(term, annot))


@STANDARD.add(".add_nested_source", least=3, most=3)
def add_nested_source(call: Call, term: Term, source: Term, result: Term) -> object:
    """`.add_nested_source(T, S, R)`: a literal, or each of a list, as S would tell it."""
    return call.unify(nested_source(term, source), result)


@STANDARD.add(".remove_source_annot", least=2, most=3)
def remove_source_annot(call: Call, term: Term, result: Term, *source: Term) -> object:
    """`.remove_source_annot(T, R, S?)`: a literal or list without its sources, or without one."""
    return call.unify(without_source(term, *source), result)


@STANDARD.add(".eval", least=2, most=2)
def evaluate(call: Call, result: Term, formula: Term) -> object:
    """`.eval(R, F)`: true or false, as a formula holds."""
    solution = call.agent.logic.first(formula, call.unifier)
    return call.unify(result, FALSE if solution is None else TRUE)


@STANDARD.add(".copy_term", least=2, most=2)
@STANDARD.add(".rename_apart", least=2, most=2)
def copy_term(call: Call, term: Term, copy: Term) -> object:
    """Unify with a copy of a term whose variables are new."""
    return call.unify(rename(term, call.agent.names, {}), copy)


@STANDARD.add(".namespace", least=1, most=1)
def namespace(call: Call, name: Term) -> object:
    """Yield the namespaces of the beliefs and plans there are, without local ones."""
    agent = call.agent
    functors = [belief.functor for belief in agent.beliefs]
    functors += [p.literal.functor for p in agent.plans if isinstance(p.literal, Literal)]
    names = dict.fromkeys(("default", *map(namespace_of, functors)))
    return call.each(name, [Literal(space) for space in names if not space.startswith("#")])
