"""Terms, beliefs made of them, and rules in contexts, compared with plain searches."""

from __future__ import annotations

import os
import pickle
import subprocess
import sys
from random import Random

import pytest
from hypothesis import given, strategies as st

import bdi
from bdi.language.loading import parse_term
from bdi.language.substitution import Names, Unifier, compare, rename, substitute, variable_names
from bdi.language.terms import Term, is_ground, text as text_of
from bdi.language.unification import unify
from bdi.reasoning.beliefs import BeliefBase
from bdi.reasoning.contexts import answers, condition
from bdi.reasoning.logic import Logic

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
def test_a_printed_term_parses_to_the_same_term(term):
    again = parse_term(text_of(term))
    assert again == term
    assert hash(again) == hash(term)
    assert compare(again, term) == 0


@given(TERMS)
def test_a_term_unifies_with_its_copies(term):
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
def test_the_standard_order_is_antisymmetric(one, other):
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
        ("p(A[x], A)", "p(A[y], q)", False),  # an occurs check of A that would not end
        ("[1, 2|T]", "[1, 2, 3]", True),
        ("[1, X]", "[1]", False),
        ("p[x|R]", "p[x, y, z]", True),
        ('"s"', "s", False),
    ],
)
def test_terms_unify_as_in_jason(one, other, unifies):
    assert unify(parse_term(one), parse_term(other), {}) is unifies


@pytest.mark.parametrize(
    ("value", "made"), [(True, "true"), (False, "false"), ([1, "s"], '[1,"s"]'), (2, "2")]
)
def test_python_values_become_terms(value, made):
    actions = bdi.InternalActions()

    @actions.add("my.value", least=1, most=1)
    def my_value(call, result):
        return call.unify(result, value)

    lines = []
    program = bdi.parse("!go. +!go <- my.value(X); .term2string(X, S); .print(S).")
    bdi.Agent(program, actions=actions, act=lambda action: True, print=lines.append).advance(0.0)
    assert lines == [made]


def test_a_program_has_the_same_hash_after_pickling_in_another_process():
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


ARGUMENTS = st.sampled_from([1.0, 2.0, bdi.Literal("a"), "text", bdi.Var("Any")])
SOURCES = st.sampled_from([bdi.Literal("source", (bdi.Literal(n),)) for n in ("self", "ann")])
CHANGES = st.tuples(
    st.sampled_from(["add", "add", "add", "add at the end", "remove", "remove first"]),
    st.tuples(ARGUMENTS, st.integers(1, 4).map(float)),
    SOURCES,
)
PATTERNS = [
    bdi.parse_literal(text)
    for text in ("b(1, _)", "b(a, X)", 'b("text", 3)', "b(X, 2)", "b(X, X)", "b(3, Y)")
]


class List:
    """Beliefs in order, each with its arguments and sources, without an index."""

    def __init__(self):
        self.beliefs = []

    def find(self, args):
        return next((belief for belief in self.beliefs if belief[0] == args), None)

    def change(self, how, args, source):
        belief = self.find(args)
        if how.startswith("add"):
            if belief is not None:
                belief[1].add(source)
            elif how == "add":
                self.beliefs.insert(0, (args, {source}))
            else:
                self.beliefs.append((args, {source}))
            return
        if how == "remove first":
            belief = next((belief for belief in self.beliefs if source in belief[1]), None)
        if belief is not None:
            belief[1].discard(source)
            if not belief[1]:
                self.beliefs.remove(belief)


def matches(pattern, args):
    return unify(pattern, bdi.Literal("b", args), {})


@given(st.lists(CHANGES, max_size=40))
def test_beliefs_are_found_in_order_after_any_changes(changes):
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
            matching = [belief.args for belief in base.matching(pattern, {})]
            assert matching == [args for args, _ in plain.beliefs if matches(pattern, args)]


CONTEXTS = (
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
    """Return a rule that may query the rules `below`, and sometimes itself."""
    queries = [f"{below_name}({', '.join(random.choices('XYab', k=2))})" for below_name in below]
    formulas = [random.choice((*CONTEXTS, *queries, *queries)) for _ in range(random.randint(1, 3))]
    return f"{name}{random.choice(HEADS)} :- {' & '.join(formulas)}."


def _program(random: Random) -> str:
    names = ["r", "s", "t"]
    rules = [
        _rule(random, name, names[:k]) for k, name in enumerate(names) for _ in range(1 + k % 2)
    ]
    if random.random() < 0.3:  # a cycle, which ends at a longer list
        rules.append("r(X, Y) :- q(X, Z) & X \\== Z & u(Z, Y, [X]).")
        rules.append("u(X, Y, L) :- .length(L, N) & N < 4 & (Y = X | q(X, Z) & u(Z, Y, [X|L])).")
    return "\n".join(rules)


def _values(formula: Term, unifier: Unifier | None) -> str:
    return "none" if unifier is None else str(substitute(formula, unifier))


@pytest.mark.parametrize("seed", range(25))
def test_compiled_contexts_have_the_solutions_of_the_search(seed: int) -> None:
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
            query = f"{random.choice('rst')}({', '.join(random.choices(PLACES, k=2))})"
            text = random.choice((query, f"{query} & not p(X)", f"q(X, Y) & {query}"))
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


def test_python_lists_become_arguments_and_lists_are_iterable():
    seen = []
    program = bdi.parse("+path(L) <- .print(L); .send_on(L).".replace(".send_on", "send_on"))
    printed = []
    agent = bdi.Agent(
        program, act=lambda action: bool(seen.append(action)) or True, print=printed.append
    )
    agent.add_percept(bdi.Literal("path", ([1, 2.5, "a", (bdi.Literal("b"), [])],)))
    agent.advance(0.0)
    assert printed == ['[1,2.5,"a",[b,[]]]']
    (items,) = seen[0].args
    first, second, third, last = items
    assert (first, second, third) == (1.0, 2.5, "a") and len(items) == 4
    assert list(last) == [bdi.Literal("b"), next(iter(bdi.Literal("p", ([],)).args))]


def test_a_literal_with_a_list_equals_the_parsed_one():
    assert bdi.Literal("p", ([1, ["x"]],)) == bdi.parse_literal('p([1,["x"]])')


@pytest.mark.parametrize("value", [None, {"a": 1}, object()])
def test_an_argument_that_is_no_term_is_rejected(value):
    with pytest.raises(TypeError, match="a term must be"):
        bdi.Literal("p", ([value],))
