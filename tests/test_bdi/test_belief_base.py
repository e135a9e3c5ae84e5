"""The belief base against a plain list that is looked through from the front."""

from hypothesis import given, strategies as st

import bdi
from bdi.language.terms import is_ground
from bdi.language.unification import unify
from bdi.reasoning.beliefs import BeliefBase

TERMS = st.sampled_from([1.0, 2.0, bdi.Literal("a"), "text", bdi.Var("Any")])
SOURCES = st.sampled_from([bdi.Literal("source", (bdi.Literal(n),)) for n in ("self", "ann")])
CHANGES = st.tuples(
    st.sampled_from(["add", "add", "add", "add at the end", "remove", "remove first"]),
    st.tuples(TERMS, st.integers(1, 4).map(float)),
    SOURCES,
)
PATTERNS = [
    bdi.parse_literal(text)
    for text in ("b(1, _)", "b(a, X)", 'b("text", 3)', "b(X, 2)", "b(X, X)", "b(3, Y)")
]


class List:
    """Beliefs in order, each with its arguments and sources; nothing is filed."""

    def __init__(self):
        self.beliefs = []

    def find(self, args):
        return next((known for known in self.beliefs if known[0] == args), None)

    def change(self, how, args, source):
        known = self.find(args)
        if how.startswith("add"):
            if known is not None:
                known[1].add(source)
            elif how == "add":
                self.beliefs.insert(0, (args, {source}))
            else:
                self.beliefs.append((args, {source}))
            return
        if how == "remove first":
            known = next((known for known in self.beliefs if source in known[1]), None)
        if known is not None:
            known[1].discard(source)
            if not known[1]:
                self.beliefs.remove(known)


def matches(pattern, args):
    return unify(pattern, bdi.Literal("b", args), {})


@given(st.lists(CHANGES, max_size=40))
def test_beliefs_are_found_in_order_whatever_came_and_went(changes):
    base, plain = BeliefBase(), List()
    for how, args, source in changes:
        literal = bdi.Literal("b", args, (source,))
        if how == "remove" and is_ground(args[0]):
            base.remove(literal, {})
        elif how.startswith("remove"):
            how = "remove first"
            base.remove_first(literal.key, literal.annots)
        else:
            base.add(literal, at_end=how == "add at the end")
        plain.change(how, args, source)
        assert [(b.args, set(b.annots)) for b in base] == plain.beliefs
        assert len(base) == len(plain.beliefs)
        for pattern in PATTERNS:
            found = [belief.args for belief in base.matching(pattern, {})]
            assert found == [args for args, _ in plain.beliefs if matches(pattern, args)]
