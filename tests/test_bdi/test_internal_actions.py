"""Internal actions, functions and the order of terms, one formula at a time."""

import re

import pytest
from goals import said

import bdi


def value(expression):
    (line,) = said(f"X = {expression}; .print(X)")
    return line


@pytest.mark.parametrize(
    ("expression", "result"),
    [
        ("1/0", "Infinity"),
        ("0/0", "NaN"),
        ("-1/0", "-Infinity"),
        ("7 div 2", "3"),
        ("-7 div 2", "-3"),
        ("7 div 0", "NaN"),
        ("-7 mod 3", "-1"),
        ("7 mod 0", "NaN"),
        ("2 ** 10", "1024"),
        ("0 ** -1", "Infinity"),
        ("(-8) ** 0.5", "NaN"),
        ("10 ** 400", "Infinity"),
        ("(-10) ** 401", "-Infinity"),
        ("math.round(2.5)", "3"),
        ("math.round(-2.5)", "-2"),
        ("math.round(1/0)", "Infinity"),
        ("math.sqrt(-1)", "NaN"),
        ("math.log(0)", "-Infinity"),
        ("math.log(-1)", "NaN"),
        ("math.floor(a)", "NaN"),
        ("math.max([3, 8, 5])", "8"),
        ("math.min(3, 8)", "3"),
        ("math.max([])", "NaN"),
        ("math.max([a, 1])", "NaN"),
        ("math.sum([1, 2, 3.5])", "6.5"),
        ("math.median([1, 5, 3])", "3"),
        ("math.std_dev([2, 4, 6])", "2"),
        ('.length("four")', "4"),
        (".length(7)", "NaN"),
    ],
)
def test_arithmetic_is_that_of_java(expression, result):
    assert value(expression) == result


@pytest.mark.parametrize("sum_", ["A + 1", "1 + A", "A + B", "B + A", "A + A", "2 * (A + B)"])
def test_arithmetic_of_other_terms_than_numbers_is_undefined(sum_):
    for term in ("a", "p(1)", '"a"', "[1]"):
        assert said(f"A = {term}; B = 2; X = {sum_}; .print(X)") == ["NaN"], term
        assert said(f"A = {term}; B = 2; .print({sum_})") == ["NaN"], term


HOLDS = """
.length([a, b], 2)             .length("abc", 3)              .member(b, [a, b])
.concat([a], [b, c], [a, b, c])
.concat("a", 1, b, "a1b")      .concat(a, b, ab)              .nth(1, [a, b], b)
.max([2, b, "s", 3], b)        .min([2, b, "s", 3], 2)        .reverse("abc", "cba")
.reverse([1, 2], [2, 1])       .delete(1, [a, b, c], [a, c])  .delete(0, 2, [a, b, c], [c])
.delete(a, [a, b, a], [b])     .delete(1, 2, "abc", "ac")     .delete(1, "abc", "ac")
.delete(5, "abc", "abc")       .delete("b", "abcb", "ac")
.union([b, a], [a, c], [a, b, c])
.intersection([a, b], [b, c], [b])                            .difference([a, b], [b], [a])
.prefix([a], [a, b])           .suffix([b], [a, b])           .sublist([b], [a, b, c])
.range(2, 1, 3)                not .range(4, 1, 3)            .empty([])
not .empty([a])                .empty("")                     not .empty(7)
.substring("an", "banana")     .substring("an", "banana", 3)  .substring("an", "banana", 1, 2)
not .substring("x", "banana")  .replace("a-b", "(a)-(b)", "$2+$1", "b+a")
.term2string(p(1), "p(1)")     not .term2string(p(1), "p(2)")  .upper_case(ab, "AB")
.lower_case("AB", "ab")        .random([a], R) & R == a                not .random([], X)
.string("a")                   .number(1)                     .atom(a)
.list([a])                     .literal(p(1))                 .structure(p(1))
.structure([a])                .ground(p(1))                  not .ground(p(X))
not .atom(p(1))                .count(.member(X, [a, b]), 2)  .count(a, [a, b, a], 2)
.sort([c, a, b], [a, b, c])    .sort([2, 10, 1], [1, 2, 10])  .date(2023, 1, 1)
.time(0, 0, 0)                 .time(0, 0, 0, 0)              .belief(here(1))
not .belief(derived(1))        .my_name(N) & .atom(N)                .intend(go)
not .my_name({})               not .my_name({a; b})           not .range({}, 1, 3)
not .length([a], {+!g})        not .date({a}, 1, 1)           not .my_name({@p +!g <- a})
not .my_name(1 + X)            not .my_name(a & b)            not .my_name(1 < 2)
.desire(go)                    not .intend(stay)              not .desire(stay)
p(1) < p(2)                    p(1, 1) < p(2)                 ~a(1) > a(1)
[a, b] < [a, c]                [a, a] < [b]                   1 < a
[a] < a                        X > a                          X + 1 \\== Y * 1
(X + 1) \\== (X + 2)           not (p(X) = q(X))              [H|T] = [a, b]
p(X, X) = p(Y, a)              A[y] = a[x, y]                 [a|T] = [a, b, c]
"""


def formulas(table):
    for line in table.strip().splitlines():
        yield from filter(None, (part.strip() for part in re.split(r" {2,}", line)))


@pytest.mark.parametrize("formula", list(formulas(HOLDS)))
def test_the_formula_holds(formula):
    lines = said(
        f"if ({formula}) {{ .print(holds) }} else {{ .print(fails) }}",
        "here(1). derived(X) :- here(X).",
    )
    assert lines == ["holds"]


@pytest.mark.parametrize(
    ("formula", "solutions"),
    [
        (".member(X, [a, b])", "[a,b]"),
        (".range(X, 1, 5, 2)", "[1,3,5]"),
        (".range(X, 3, 1, -1)", "[3,2,1]"),
        (".prefix(X, [a, b])", "[[a,b],[a],[]]"),
        (".suffix(X, [a, b])", "[[a,b],[b],[]]"),
        (".sublist(X, [a, b])", "[[a,b],[a],[b],[]]"),
        ('.substring("an", "banana", X)', "[1,3]"),
        (".belief(here(X))", "[1,2]"),
        (".random([a], X, 3)", "[a,a,a]"),
        ("here(X) | X = 3", "[1,2,3]"),
        ("here(X) & X > 1", "[2]"),
        ('.term2string(X, "p(1)")', "[p(1)]"),
        ("p(1)[a] =.. X", "[[default,p,[1],[a]]]"),
        ("p(1)[a] =.. [F, A, N] & X = N", "[[a]]"),
        ("X =.. [default, p, [1, 2], [a]]", "[p(1,2)[a]]"),
        ('X =.. ["p", [1]]', "[p(1)]"),
        ("X =.. [p]", "[p]"),
        ("X =.. [3, [1]]", "[]"),
        ("X =.. [p, 1]", "[]"),
        ("3 =.. X", "[]"),
        ("here(1)[source(self)|R] & X = R", "[[]]"),
        ("here(1)[seen|R] & X = R", "[]"),
    ],
)
def test_solutions_are_in_order(formula, solutions):
    assert said(f".findall(X, {formula}, L); .print(L)", "here(1). here(2).") == [solutions]


@pytest.mark.parametrize(
    ("action", "message"),
    [
        (".concat([a], b, X)", "arg[1] is not a list"),
        (".concat([a], [b], c)", "is not a list nor a variable"),
        (".nth(0, a, X)", "second argument should be a list"),
        (".sort(a, X)", "first argument must be a list"),
        (".range(X, 1, b)", "third parameter ('b') must be a number"),
        (".range(X, 1, 3, 0)", "the step must not be 0"),
        (".delete(a, b, X)", "Incorrect use of the internal action '.delete'"),
        (".replace(a, b, c, X)", "must be strings"),
        ('.replace("a", "(", "b", X)', "is not a regular expression"),
        (".term2string(X, Y)", "invalid case of term2string"),
        ('.term2string(X, "p(")', "expected"),
        (".random(a)", "first argument must be a variable"),
        (".random([a], b)", "second argument must be a variable"),
        (".wait([a])", "nothing to wait for"),
        ('.wait("+")', ""),
        ('.at("soon", {+!a})', "did not parse"),
        ('.at("now + 1 s", 3)', "is not an event"),
        (".add_plan(7)", "can not be used as a plan"),
        ('.add_plan("+!x <- ")', ""),
        (".include(7)", "first argument must be a string"),
        ('.include("nowhere.asl")', "nowhere.asl"),
        (".relevant_plans(7, P)", "must follow the syntax of a trigger"),
        (".drop_intention(7)", "must be a literal"),
        (".abolish(7)", "must be a literal or variable"),
        (".asserta(7)", "must be a literal"),
        (".length(a, b, c)", "2 arguments are expected."),
        (".abolish(a, b)", "One argument is expected."),
        (".random(a, b, c, d)", "From 1 to 3 arguments are expected."),
        (".fail_goal(7)", "must be a literal"),
    ],
)
def test_an_invalid_argument_is_reported(action, message):
    (line,) = said(action)
    assert message in line


def test_log_prints_or_warns():
    assert said(".log(info, a, 1); .log(fine, b); .log(warning, c)") == ["a1"]


def test_a_seed_repeats_random_numbers():
    first, second = said(
        ".set_random_seed(7); .random(X); .shuffle([1, 2, 3, 4, 5, 6], L); .print(X, L);"
        ".set_random_seed(7); .random(Y); .shuffle([1, 2, 3, 4, 5, 6], M); .print(Y, M)"
    )
    assert first == second


def test_at_raises_an_event_later():
    lines = said(
        '.at("now + 2 minutes", {+!ring}); .wait(119000); .print(before); .wait(2000);'
        " .print(after)",
        '+!ring <- .time(H, M, S); .print(H, ":", M, ":", S).',
    )
    assert lines == ["before", "0:2:0", "after"]


def test_plans_are_added_and_removed_at_run_time():
    assert said(
        '.add_plan("@late +!greet <- .print(hello)."); !greet;'
        ' .add_plan("+!greet <- .print(first).", self, begin); !greet;'
        " .relevant_plans({+!greet}, _, L); .length(L, N); .print(N);"
        " .remove_plan(late); .relevant_plans({+!greet}, _, K); .length(K, O); .print(O)"
    ) == ["hello", "first", "2", "1"]


RESUMED = "!!work; .wait(10); .print(goes_on); .resume(work); .wait(10); .print(done)"


@pytest.mark.parametrize(
    ("body", "plans", "lines"),
    [
        (
            RESUMED,
            "+!work <- .print(waits); .suspend; .print(resumed).",
            "waits goes_on resumed done",
        ),
        (
            RESUMED,
            "+!work <- .print(waits); .suspend(work); .print(resumed).",
            "waits goes_on resumed done",
        ),
        (
            "!!work; .suspend(work); .wait(50); .print(later); .resume(work); .wait(10);"
            " .print(done)",
            "+!work <- .print(works).",
            "later works done",
        ),
        (
            "!!count(0); !!nothing; .suspend(count(_)); .wait(5); .print(resumes);"
            " .resume(count(_)); .wait(5); .print(done)",
            "+!count(N) : N < 50 <- !count(N + 1). +!count(N) <- .print(N). +!nothing.",
            "resumes 50 done",
        ),
        (
            "!!work; .wait(10); .suspend(work); .wait(500); .print(late); .resume(work);"
            " .wait(20); .print(end)",
            "+!work <- .wait({+nothing}, 100); .print(never). -!work <- .print(failed).",
            "late failed end",
        ),
    ],
)
def test_goals_are_suspended_and_resumed(body, plans, lines):
    assert said(body, plans) == lines.split()


@pytest.mark.parametrize(
    ("how", "lines"),
    [
        ("succeed_goal", ["end"]),
        ("fail_goal", ["failed", "end"]),
        ("drop_event", ["end"]),
        ("drop_desire", ["end"]),
        ("drop_intention", ["works", "end"]),
        ("suspend", ["end", "works"]),
    ],
)
def test_queued_goals_can_be_ended(how, lines):
    """No event is handled while an atomic plan runs, so that of `work` is still in the queue."""
    heard = said(
        "!quiet; .wait(10); .print(end); .resume(work)",
        f"@quiet[atomic] +!quiet <- !!work; .{how}(work)."
        " +!work <- .print(works). -!work <- .print(failed).",
    )
    assert heard == lines


def test_an_intention_describes_itself():
    (line,) = said('.current_intention(intention(N, [im(_, T, _, _)|_])); .print(N, " ", T)')
    assert line.split(" ")[0].isdigit()
    assert "+!go" in line


def test_formulas_of_every_kind_are_copied_with_new_variables():
    rules = (
        "twice(X, Y) :- Y = X + X. longest(L, N) :- N = math.max(L). "
        "either(X) :- X = 1 | X = 2. other(X) :- not X = 1 & X \\== 2. "
        "with(X, A) :- here(X)[A|_]. here(5)[seen]. "
    )
    body = (
        "?twice(2, A); ?longest([1, 7], B); .findall(X, either(X), C); ?other(3); ?here(5)[seen];"
        ' .print(A, " ", B, " ", C)'
    )
    assert said(body, rules) == ["4 7 [1,2]"]


def test_the_sources_of_a_belief_are_independent():
    assert said(
        "+here(1)[source(bob)]; +here(1); -here(1)[source(bob)]; ?here(1)[source(self)];"
        " .count(here(_)[source(bob)], N); .print(N); -+here(2);"
        " .findall(X, here(X), L); .print(L); .abolish(here(_)); .count(here(_), M); .print(M)"
    ) == ["0", "[2]", "0"]


@pytest.mark.parametrize(
    ("condition", "time"),
    [
        ("1 < 2", 0.0),
        ("a", 0.0),
        ("not k", 0.0),
        ("a | b", 0.0),
        ("k | b", 1.0),
        ("a & b", 1.0),
        ("not k & b", 1.0),
        ("b & not k", 1.0),
        ("a & c(X) & X > 3", 3.0),
        ("c(X) & not X < 3", 3.0),
        ("1 > 2", None),
        ("not a", None),
    ],
)
def test_a_wait_ends_as_soon_as_its_condition_holds(condition, time):
    """`a` always holds, `b` from 1 s on, `c(2)` from 2 s, and `c(5)` from 3 s."""
    met = []
    agent = bdi.Agent(
        bdi.parse(f"a. !go. +!go <- .wait({condition}, 4000); .print(met). -!go."),
        print=lambda line: met.append(agent.now),
    )
    agent.advance(0.0)
    for instant, percept in ((1.0, "b"), (2.0, "c(2)"), (3.0, "c(5)")):
        agent.advance(instant)
        agent.add_percept(percept)
        agent.advance(instant)
    agent.advance(10.0)
    assert met == ([] if time is None else [time])


def test_beliefs_are_added_in_front_and_removed():
    assert said(
        "+f(1); .asserta(f(2)); .findall(X, f(X), L); .print(L); .perceive; .abolish(f(_));"
        " .count(f(_), N); .print(N)"
    ) == ["[2,1]", "0"]


def test_a_list_of_all_answers_is_updated_after_each_change_of_beliefs():
    ask = ".findall(X, f(X, Y), L{0}); .print(L{0}); "
    changes = [
        "+f(1, a)",
        "+f(2, a)",
        "+f(2, a)[seen]",
        "-f(1, a)",
        "-+f(3, b)",
        ".abolish(f(_, _))",
    ]
    steps = "".join(ask.format(k) + change + "; " for k, change in enumerate(changes))
    # With a value of Y the same query has other answers.
    bound = "+f(4, a); +f(5, b); " + ask.format(8) + "Y = b; " + ask.format(9)
    lists = said(steps + ask.format(7) + bound + "true")
    assert lists == ["[]", "[1]", "[2,1]", "[2,1]", "[2]", "[3]", "[]", "[5,4]", "[5]"]
