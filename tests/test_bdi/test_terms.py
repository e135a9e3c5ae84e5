"""Terms of every kind: written and read, compared, unified, renamed, put in order."""

import os
import pickle
import subprocess
import sys

import pytest
from hypothesis import given, strategies as st

import bdi
from bdi.language.loading import parse_term
from bdi.language.substitution import Names, compare, rename, substitute, variable_names
from bdi.language.terms import is_ground, text as text_of
from bdi.language.unification import unify

ATOMS = st.sampled_from(["a", "b", "1", "2.5", '"s"', "X", "Y", "[]", "~p(1)"])


def compound(inner):
    pairs = st.tuples(inner, inner)
    return st.one_of(
        inner.map("p({})".format),
        pairs.map("q({0[0]},{0[1]})".format),
        pairs.map("r({0[0]})[{0[1]}]".format),
        pairs.map("[{0[0]},{0[1]}]".format),
        inner.map("[{}|Tail]".format),
        inner.map("A[{}]".format),
        inner.map("s[{}|Others]".format),
    )


VALUES = st.recursive(ATOMS, compound, max_leaves=6)
NUMBERS = st.sampled_from(["(X + 1)", "(X * Y)", "(-X)", "math.max([X,1])", "math.abs(X)"])
FORMULAS = st.recursive(
    st.one_of(
        st.tuples(VALUES, st.sampled_from(["<", "==", "="]), VALUES).map(" ".join),
        NUMBERS.map("{} > 3".format),
    ).map("({})".format),
    lambda inner: st.one_of(
        inner.map("(not {})".format),
        st.tuples(inner, st.sampled_from(["&", "|"]), inner).map(" ".join).map("({})".format),
    ),
    max_leaves=4,
)
TERMS = st.one_of(VALUES, NUMBERS, FORMULAS, FORMULAS.map("f({})".format)).map(parse_term)


@given(TERMS)
def test_what_is_written_is_read_again(term):
    again = parse_term(text_of(term))
    assert again == term
    assert hash(again) == hash(term)
    assert compare(again, term) == 0


@given(TERMS)
def test_a_term_can_be_made_equal_to_its_copies(term):
    assert unify(term, parse_term(text_of(term)), {})
    copy = rename(term, Names(), {})
    assert len(variable_names(copy)) == len(variable_names(term))
    assert not set(variable_names(copy)) & set(variable_names(term))


@given(TERMS)
def test_only_variables_are_bound(term):
    values = dict.fromkeys(variable_names(term), 3.0)
    bound = substitute(term, values)
    assert substitute(bound, values) == bound
    if is_ground(term):
        assert bound == term


@given(TERMS, TERMS)
def test_the_order_has_two_directions(one, other):
    assert compare(one, other) == -compare(other, one)


@pytest.mark.parametrize(
    ("one", "other", "unifies"),
    [
        ("X + 1", "X + 1", True),
        ("X + 1", "X + 2", False),
        ("f(1 + 2)", "f(3)", True),
        ("f(3)", "f(X + 1)", False),
        ("f(math.max([1, 4]))", "f(4)", True),
        ("(p(X) & q)", "(p(1) & q)", True),
        ("(p & q)", "(p | q)", False),
        ("(not p(X))", "(not p(2))", True),
        ("A[x]", "p[x, y]", True),
        ("p[x, y]", "A[x]", False),
        ("A[z]", "p[x, y]", False),
        ("A[x]", "B[x]", True),
        ("A[x]", "1", True),
        ("p(A[x], A)", "p(A[y], q)", False),  # looked for the end of A for ever
        ("[1, 2|T]", "[1, 2, 3]", True),
        ("[1, X]", "[1]", False),
        ("p[x|R]", "p[x, y, z]", True),
        ('"s"', "s", False),
    ],
)
def test_unification(one, other, unifies):
    assert unify(parse_term(one), parse_term(other), {}) is unifies


@pytest.mark.parametrize(
    ("value", "made"), [(True, "true"), (False, "false"), ([1, "s"], '[1,"s"]'), (2, "2")]
)
def test_python_values_become_terms(value, made):
    actions = bdi.InternalActions()

    @actions.add("my.value", least=1, most=1)
    def my_value(call, result):
        return call.unify(result, value)

    said = []
    program = bdi.parse("!go. +!go <- my.value(X); .term2string(X, S); .print(S).")
    bdi.Agent(program, actions=actions, act=lambda action: True, print=said.append).advance(0.0)
    assert said == [made]


def test_programs_of_other_processes_hash_as_those_made_here():
    text = "at(dock, 2)[source(self)]. !go. +!go : at(X, _) <- walk(X)."
    made = bdi.parse(text)
    send = f"import bdi, pickle, sys; made = bdi.parse({text!r})"
    use = "{made, *made.beliefs}; bdi.Agent(made, act=bool).advance(0.0)"
    sent = subprocess.run(
        [sys.executable, "-c", f"{send}; {use}; sys.stdout.buffer.write(pickle.dumps(made))"],
        env={**os.environ, "PYTHONHASHSEED": "1"},
        capture_output=True,
        check=True,
    )
    got = pickle.loads(sent.stdout)
    assert {got, *got.beliefs, *got.plans} == {made, *made.beliefs, *made.plans}
