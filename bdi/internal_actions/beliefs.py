"""Actions on beliefs, and queries for all answers of a formula."""

from __future__ import annotations

from collections.abc import Iterator

from ..language.order import distinct
from ..language.program import Rule, RuleTerm
from ..language.substitution import Unifier, substitute
from ..language.terms import Literal, Qualified, Term, Var, make_list
from ..reasoning.beliefs import with_source
from ..reasoning.calls import Call
from ..reasoning.mail import without_source
from .arguments import a_list, a_literal, wrong
from .registry import STANDARD


@STANDARD.add(".abolish", least=1, most=1)
def abolish(call: Call, pattern: Term) -> bool:
    """Remove all beliefs that match, from any source if the pattern names none."""
    if not isinstance(pattern, Literal | Var | Qualified):
        raise wrong("abolish", "first argument must be a literal or variable.")
    for found in call.agent.beliefs.matching(pattern, call.unifier):
        call.agent.abolish(found)
    return True


@STANDARD.add(".perceive", most=0)
def perceive(call: Call) -> bool:
    """Do nothing: percepts are believed as soon as they come."""
    return True


@STANDARD.add(".asserta", least=1, most=1)
def asserta(call: Call, belief: Term) -> bool:
    """Add a belief or a rule before the others, with source `self` if it names none."""
    if isinstance(belief, RuleTerm):
        rule = belief.rule
        call.agent.beliefs.add_rule(Rule(with_source(rule.head), rule.body, rule.place))
    else:
        call.agent.believe(a_literal("asserta", belief))
    return True


@STANDARD.add(".assertz", least=1, most=1)
def assertz(call: Call, belief: Term) -> bool:
    """Add a belief or a rule after the others, with the sources that it names and no other."""
    if isinstance(belief, RuleTerm):
        call.agent.beliefs.add_rule(belief.rule, at_end=True)
    else:
        call.agent.add_belief(a_literal("assertz", belief), at_end=True)
    return True


@STANDARD.add(".belief", least=1, most=1)
def belief(call: Call, pattern: Term) -> Iterator[Unifier]:
    """Yield an answer for each belief, and none for what rules derive."""
    if isinstance(pattern, Literal | Var | Qualified):
        found = call.agent.beliefs.matching(pattern, call.unifier)
        yield from call.each(pattern, found)


@STANDARD.add(".relevant_rules", least=2, most=2)
def relevant_rules(call: Call, head: Term, result: Term) -> object:
    """Unify with the rules whose head unifies, without their sources."""
    if not isinstance(head, Literal | Var | Qualified):
        raise wrong("relevant_rules", "first argument must be a literal or variable.")
    rules = [
        RuleTerm(Rule(_bare(rule.head), rule.body, rule.place))
        for rule in call.agent.beliefs.rules()
        if call.unify(head, _bare(rule.head)) is not None
    ]
    return call.unify(make_list(rules), result)


def _bare(head: Literal) -> Literal:
    bare = without_source(head)
    return bare if isinstance(bare, Literal) else head


@STANDARD.add(".list_rules", most=0)
def list_rules(call: Call) -> bool:
    """Print the rules."""
    for rule in call.agent.beliefs.rules():
        call.agent.say(str(rule))
    return True


def answers(call: Call, term: Term, formula: Term) -> list[Term]:
    """Return a term as it is in each solution of a formula."""
    return [substitute(term, u) for u in call.agent.logic.solutions(formula, call.unifier)]


@STANDARD.add(".findall", least=3, most=3)
def findall(call: Call, term: Term, formula: Term, result: Term) -> object:
    """`.findall(T, F, L)`: a term as it is in each answer of a formula."""
    return call.unify(result, call.agent.logic.collected(term, formula, call.unifier))


@STANDARD.add(".setof", least=3, most=3)
def setof(call: Call, term: Term, formula: Term, result: Term) -> object:
    """`.setof(T, F, L)`: as `.findall`, in standard order and each once."""
    return call.unify(result, make_list(distinct(answers(call, term, formula))))


@STANDARD.add(".count", least=2, most=3)
def count(call: Call, what: Term, *more: Term) -> object:
    """`.count(Formula, N)`, or `.count(Element, List, N)` for the elements that unify."""
    if len(more) == 1:
        number = sum(1 for _ in call.agent.logic.solutions(what, call.unifier))
        return call.unify(more[0], number)
    elements = a_list("count", more[0], "second")
    number = sum(call.unify(what, element) is not None for element in elements)
    return call.unify(more[1], number)
