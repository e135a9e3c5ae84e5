"""Rules that contexts ask, compiled and kept, beside the search that keeps nothing."""

from __future__ import annotations

from random import Random

import pytest

import bdi
from bdi.language.substitution import Unifier, substitute
from bdi.language.terms import Term
from bdi.reasoning.contexts import answers, condition
from bdi.reasoning.logic import Logic

FORMULAS = (
    "p(X)",
    "q(X, Y)",
    "q(Y, X)",
    "q(X, X)",
    "not p(Y)",
    "X \\== Y",
    "Y = X",
    "(p(X) | q(Y, X))",
    ".findall(Z, q(X, Z), L) & .length(L, N) & N > 1",
    ".findall(Z, p(Z), L) & .nth(I, L, X) & .nth((I + 1) mod 2, L, Y)",
    ".member(Y, [a, X, c])",
)
HEADS = ("(X, Y)", "(Y, X)", "(X, b)", "(a, Y)", "(X, X)", "(X, _)")
PLACES = ("a", "b", "X", "Y")


def _rule(random: Random, name: str, below: list[str]) -> str:
    """Return a rule that may ask those `below` it, and now and then itself."""
    known = [f"{asked}({', '.join(random.choices('XYab', k=2))})" for asked in below]
    formulas = [random.choice((*FORMULAS, *known, *known)) for _ in range(random.randint(1, 3))]
    return f"{name}{random.choice(HEADS)} :- {' & '.join(formulas)}."


def _program(random: Random) -> str:
    names = ["r", "s", "t"]
    rules = [
        _rule(random, name, names[:k]) for k, name in enumerate(names) for _ in range(1 + k % 2)
    ]
    if random.random() < 0.3:  # a circle, which stops at a longer list
        rules.append("r(X, Y) :- q(X, Z) & X \\== Z & u(Z, Y, [X]).")
        rules.append("u(X, Y, L) :- .length(L, N) & N < 4 & (Y = X | q(X, Z) & u(Z, Y, [X|L])).")
    return "\n".join(rules)


def _values(formula: Term, found: Unifier | None) -> str:
    return "none" if found is None else str(substitute(formula, found))


@pytest.mark.parametrize("seed", range(25))
def test_contexts_have_the_answers_of_the_search(seed: int) -> None:
    random = Random(seed)
    agent = bdi.Agent(bdi.parse(_program(random)))
    logic: Logic = agent._state.logic
    believed: list[bdi.Literal] = []
    for _ in range(12):
        if believed and random.random() < 0.4:
            agent.disbelieve(believed.pop(random.randrange(len(believed))))
        else:
            two = random.choices(("a", "b", "c", "d"), k=2)
            text = random.choice((f"p({two[0]})", f"q({two[0]}, {two[1]})"))
            believed.append(bdi.parse_literal(text))
            agent.believe(believed[-1])
        for _ in range(2):
            asked = f"{random.choice('rst')}({', '.join(random.choices(PLACES, k=2))})"
            text = random.choice((asked, f"{asked} & not p(X)", f"q(X, Y) & {asked}"))
            formula = bdi.parse(f"+go : {text} <- done.").plans[0].context
            logic.begin_instant()
            logic.begin_cycle()
            searched = [_values(formula, one) for one in logic.solutions(formula, {})]
            compiled = [_values(formula, one) for one in answers(formula)(logic, {})]
            first = _values(formula, condition(formula)(logic, {}))
            plain = [text for text in searched if "_" not in text]
            assert [text for text in compiled if "_" not in text] == plain
            assert len(compiled) == len(searched)
            assert first == [*searched, "none"][0] or "_" in first
