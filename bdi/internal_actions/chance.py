"""Random choices. All draw from the agent's own numbers, so that a seed repeats a run."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import count

from ..language.terms import Cons, Nil, Term, Var, make_list
from ..reasoning.calls import Call
from .arguments import a_list, a_number, wrong
from .registry import STANDARD


@STANDARD.add(".random", least=1, most=3)
def random(call: Call, what: Term, *more: Term) -> object:
    """`.random(X)` or `.random(List, X)`; a last number is that of the answers, 0 for no end."""
    numbers = call.agent.random
    if isinstance(what, Nil | Cons):
        items = list(what)
        if not more or not isinstance(more[0], Var):
            raise wrong("random", "second argument must be a variable.")
        if not items:
            return False
        chosen = (items[int(numbers.random() * len(items))] for _ in _times(more[1:]))
        return call.each(more[0], chosen)
    if not isinstance(what, Var):
        raise wrong("random", "first argument must be a variable.")
    return call.each(what, (numbers.random() for _ in _times(more)))


def _times(limit: tuple[Term, ...]) -> Iterator[int]:
    most = int(a_number("random", limit[0], "last")) if limit else 1
    return iter(count()) if most == 0 else iter(range(most))


@STANDARD.add(".shuffle", least=2, most=2)
def shuffle(call: Call, elements: Term, result: Term) -> object:
    """`.shuffle(L, R)`: the elements in an order drawn at random."""
    items = list(a_list("shuffle", elements, "first"))
    call.agent.random.shuffle(items)
    return call.unify(result, make_list(items))


@STANDARD.add(".set_random_seed", least=1, most=1)
def set_random_seed(call: Call, seed: Term) -> bool:
    """`.set_random_seed(N)`: begin the random numbers anew."""
    call.agent.random.seed(int(a_number("set_random_seed", seed, "first")))
    return True
