"""Features of Jason beyond its first book: meta-programming, patterns, namespaces, states."""

import pytest
from goals import printed, said

import bdi


def test_a_plan_is_decomposed_recomposed_and_executed():
    lines = said(
        'P =.. [lbl, {+!x(A)}, true, {.print("x ", A); .wait(10); !y}]; .add_plan(P); !x(3);'
        " .relevant_plans({+!x(_)}, [Q]); Q =.. [L, E, C, {First; Rest}]; .print(L, E, C); First;"
        " .print(Rest)",
        "+!y <- .print(y).",
    )
    assert lines[:2] == ["x 3", "y"]
    assert lines[2].startswith("lbl[source(self)]+!x(")
    assert lines[3].startswith("x ")
    assert lines[4] == ".wait(10); !y"


def test_bodies_in_braces_may_contain_waits_and_forks():
    body = "B = { .print(a); .wait(5) |&| .wait(9); .print(b) }; X = 1; B; +{+!z <- .print(X)}; !z"
    assert said(body) == ["a", "b", "1"]


@pytest.mark.parametrize(
    ("pattern", "plans", "lines"),
    [
        ("dg(g)", "+!g <- .print(a); +g; .print(no).", ["a"]),
        ("ebdg(g)", "+!g : n(0) <- .print(once). +!g <- .print(then); +g.", ["once", "then"]),
        ("rc(g, m)", "+!g : m <- .print(a); -m; .print(no).", ["a"]),
    ],
)
def test_patterns_make_goals_declarative(pattern, plans, lines):
    assert printed(f"n(0). m. !g. {{ begin {pattern} }} {plans} {{ end }}") == lines


def test_a_variable_as_a_query_finds_only_beliefs_without_namespace():
    lines = printed(
        """b(1). other::b(2). { begin namespace(hidden, local) } b(3). { end }
        !go. +!go <- .findall(X, X, L); .print(L); .findall(N, .namespace(N), Ns); .print(Ns)."""
    )
    assert lines == ["[b(1)[source(self)]]", "[default,other]"]


def test_namespaces_keep_names_apart(tmp_path):
    (tmp_path / "module.asl").write_text(
        """{ namespace(priv, local) }
        level(1). priv::hidden(2).
        +!report : level(L) & priv::hidden(H) <- .print(this_ns, L, H); +done(::level); !next.
        { begin namespace(priv) } +!never. { end }
        +!next <- .print(next).
        """,
        encoding="utf-8",
    )
    main = tmp_path / "main.asl"
    main.write_text(
        """{ include("module.asl", one) } { include("module.asl", two) }
        level(7). !go.
        +!go <- !one::report; ?level(X); .print(X); N = two; !N::report;
            .findall(M, M::level(_), L); .sort(L, S); .print(S);
            if (not one::hidden(_)) { .print(hidden) }; one::level(1) =.. P; .print(P).
        +two::done(N::D) <- .print("told ", N, " ", D).""",
        encoding="utf-8",
    )
    lines = []
    bdi.Agent(bdi.parse_file(main), print=lines.append).advance(1.0)
    assert lines == [
        *("one12", "next", "7", "two12", "told two level", "next"),
        *("[default,one,two]", "hidden", "[one,level,[1],[]]"),
    ]


def test_a_goal_with_a_condition_lasts_until_it_holds_and_has_subplans():
    lines = printed(
        """!top.
        +!top <- !g(7); .print(back).
        +!g(Y) <: done(Y) <- !inner; .wait(10); +e(1); .wait(20); +done(7); .print(no).
        { +!inner <- .print("inside ", Y). +e(X) <- .print(X, Y). }
        +!inner <- .print(outside)."""
    )
    assert lines == ["inside 7", "17", "back"]


def test_a_percept_is_handled_by_the_subplans_of_each_intention():
    lines = []
    program = """!g(1). !g(2).
        +!g(N) <: false <- .wait(100000). { +light(C) <- .print(N, C). +off <- .done. }
        +light(C) <- .print(C)."""
    agent = bdi.Agent(bdi.parse(program), print=lines.append)
    agent.advance(0.0)
    agent.add_percept("light(red)")
    agent.advance(1.0)
    assert sorted(lines) == ["1red", "2red", "red"]
    agent.add_percept("off")
    agent.advance(2.0)
    assert agent.intentions == []


def test_goal_states_raise_events():
    lines = printed(
        """!a. +!a <- .wait(10); !b. +!b <- .fail.
        ^!a[state(S)] <- .print("a ", S). ^!b[state(S)[reason(R)]] <- .print("b ", S, R)."""
    )
    assert lines == [
        *("a pending", "a executing", "a waiting", "a executing", "b pending", "b executing"),
        *("b failedia_failed", "b finished", "a failed", "a finished"),
    ]


def test_an_idle_agent_raises_an_event():
    program = """!a. +!a <- .print(x); .wait(100); .print(y).
        +jag_sleeping <- .print(sleeping). +jag_awaking <- .print(awake)."""
    assert printed(program) == ["x", "sleeping", "y", "awake", "sleeping"]


def test_an_agent_sends_messages_to_itself():
    lines = printed(
        """!s. +?d(X) <- X = 9. +!k(1) <- .print(k).
        +!s <- .send(self, askOne, d(X), A); .print(A);
            .send([self], askAll, q(_), L); .print(L); .send(self, askOne, none, F); .print(F);
            .send(self, askHow, {+!k(_)}, [P]); .print(P); .send(self, untellHow, gone);
            .send(self, tellHow, "@new +!n <- .print(told)."); .wait(10); !n;
            .send(self, custom, x); .wait(10);
            .df_subscribe(cook); .df_register(cook); .wait(10); .df_search(cook, C); .print(C).
        q(1). q(2)[w].
        +provider(A, S) <- .print(A, S).
        +!kqml_received(S, custom, C, _) <- .print(S, C)."""
    )
    assert lines == [
        *("d(9)[source(human)]", "[[q(1)[source(human)],q(2)[source(human),w]]]", "false"),
        "{ @p__2[source(self)] +!k(1) <- .print(k) }",
        *("told", "selfx", "humancook", "[human]"),
    ]


def test_control_structures_maps_and_functions_are_internal_actions():
    lines = said(
        ".if_then_else(1 < 2, {.print(yes)}, {.print(no)});"
        " .foreach(.member(X, [1, 2]), {.print(X)});"
        ' .print(.count(q(_)), math.sum([])); .puts("has #{Y}"); .printf("%d %s %.2f", 3, a, 1.5);'
        " .map.create(M); .map.put(M, b, 2); .map.put(M, a, 1); .findall(K, .map.key(M, K), L);"
        " .print(M, L); .queue.create(Q, priority); .queue.add_all(Q, [3, 1]); .print(Q);"
        " .set.create(S, [b, a, b]); .length(S, N); .print(S, N); .findall(T, .type(b, T), LT);"
        " .print(LT); .relevant_rules(r(_), R); .print(R); .intention(_, State, _, current);"
        " .print(State)",
        "q(1). q(2). r(X) :- q(X).",
    )
    assert lines == [
        *("yes", "1", "2", "20", "has Y", "3 a 1.50", "{a->1,b->2}[a,b]", "[1,3]", "{a,b}2"),
        *("[atom,literal,ground]", "[{ r(X) :- q(X) }]", "running"),
    ]


def test_custom_functions_are_evaluated_in_terms():
    actions = bdi.InternalActions()

    @actions.function("my.half")
    def half(x):
        return x / 2

    lines = printed("!go. +!go : my.half(6) == 3 <- .print(my.half(3) + 1).", actions=actions)
    assert lines == ["2.5"]
    with pytest.raises(ValueError, match="already"):
        actions.function("my.half")


@pytest.mark.parametrize(
    ("program", "message"),
    [
        ("{ begin bdg(g) } +!g <- a.", "{ begin bdg } is not closed by { end }"),
        ("a. { end }", "there is no { begin"),
        ("{ begin bdg } +!g. { end }", "argument 1 of bdg is a goal"),
        ("{ begin nothing(g) } { end }", "there is no { begin nothing }"),
        ("{ namespace(1) }", "namespace takes a name"),
        ("{ namespace(a, secret) }", "local or global, not secret"),
        ("+!g <- a. { +!h <- b. c. }", "the braces of a plan may contain only plans"),
        ("+!g <- a. { +!h <- b.", "are not closed"),
        ("{ begin sga(a, b, c) } { end }", "sga takes an event"),
    ],
)
def test_an_invalid_directive_is_reported(program, message):
    with pytest.raises(bdi.ProgramError) as error:
        bdi.parse(program)
    assert message in str(error.value)
    assert error.value.problems[0].line == 1
