"""Programs without end, too deep or too long."""

import pytest

import bdi

ENDLESS = {
    "a goal that calls itself": "!g. +!g <- !g.",
    "a goal that starts itself": "!g. +!g <- !!g.",
    "a loop": "!g. +!g <- while (true) { X = 1 }.",
    "a rule that calls itself": "a :- a.\n!g. +!g : a <- .print(x).",
    "a rule with ever more answers": "n(0).\nn(X) :- n(Y) & X = Y+1.\n!g. +!g : n(X) & X < 0 <- x.",
    "too many combinations": "".join(f"p({k}).\n" for k in range(30))
    + "!g. +!g : p(A) & p(B) & p(C) & p(D) & p(E) & A+B+C+D+E < 0 <- x.",
    "a failure of failures": "!g. +!g <- !g; x. -!g <- !g; .fail.",
    "a term in itself": "!g. +!g <- X = f(X); .print(X).",
    "a term that doubles": "!g(0, a). +!g(N, X) <- !g(N+1, f(X, X)).",
    "a text that doubles in a term": '!g(0, "' + "x" * 1000 + '"). +!g(N, X) <- !g(N+1, [X, X]).',
    "a term that deepens": "!g(a). +!g(X) <- !g(f(X)).",
    "a for over too much": "!g. +!g <- for (.range(X, 1, 1000000000)) { y(X) }.",
    "a for over nothing but numbers": "!g. +!g <- for (.range(X, -1.0e300, 1.0e308)) { }.",
    "a while over too much": "!g. +!g <- while (.range(X, 1, 1000000000)) { y(X) }.",
    "a list of too much": "!g. +!g <- .findall(X, .range(X, 1, 1000000000), L).",
    "a count of too much": "!g. +!g <- .count(.range(X, 1, 1000000000), N).",
    "a search in every cycle": "!g. +!g : not (.range(X, 1, 15000) & X < 0) <- !!g.",
    "a condition on too much": "!g. +!g : .range(X, 1, 1000000000) & X < 0 <- y.",
}


LATER = "".join(f"X{n} = f(X{n + 1}, X{n + 1}); " for n in range(40))


@pytest.mark.slow
def test_a_term_that_doubles_when_it_is_printed_is_rejected():
    agent = bdi.Agent(bdi.parse(f"!g. +!g <- {LATER} .print(X0).", "p.asl"))
    with pytest.raises(bdi.EndlessProgramError, match=r"p\.asl:1:\d+: \+!g: a term of more than"):
        agent.advance(1.0)


@pytest.mark.parametrize("case", ENDLESS)
def test_a_program_without_end_is_stopped(case):
    program = bdi.parse(ENDLESS[case], "p.asl")
    agent = bdi.Agent(
        program,
        act=lambda term: True,
        print=lambda text: None,
        settings=bdi.AgentSettings(max_cycles=20_000, max_goals=20_000),
    )
    with pytest.raises(bdi.EndlessProgramError, match=r"p\.asl:\d+:\d+: \+!g"):
        agent.advance(1.0)


TOO_DEEP = {
    "a formula": "x :- " + " & ".join(["x"] * 4000) + ".",
    "a sum": "x(A) :- A > " + "+".join(["1"] * 4000) + ".",
    "a term": "x(" + "f(" * 5000 + "a" + ")" * 5000 + ").",
    "a list": "x(" + "[" * 5000 + "]" * 5000 + ").",
    "the tail of a list": "x(" + "[a|" * 5000 + "[]" + "]" * 5000 + ").",
    "annotations": "x" + "[a" * 5000 + "]" * 5000 + ".",
    "a block": "+!g <- " + "if (x) { " * 5000 + "y" + "}" * 5000 + ".",
    "a choice": "+!g <- if (x) { y }" + " elif (x) { y }" * 5000 + ".",
    "a plan within plans": "+!g <- " + ".add_plan({+!h <- " * 500 + "x" + "})" * 500 + ".",
    "what is no step": "+!g <- " + " & ".join(["x"] * 4000) + ".",
}


@pytest.mark.parametrize("case", TOO_DEEP)
def test_a_clause_nested_too_deeply_is_rejected(case):
    with pytest.raises(bdi.ProgramError, match=r"p\.asl:2:\d+: .*more than \d+ deep"):
        bdi.parse("x.\n" + TOO_DEEP[case], "p.asl")


@pytest.mark.parametrize(
    "text",
    [
        "x :- " + " & ".join(["x"] * 100) + ".",
        "x(" + "f(" * 55 + "a" + ")" * 55 + ").",
        "+!g <- " + "if (x) { " * 28 + "y" + "}" * 28 + ".",
        "x([" + ",".join(["a"] * 2000) + "]).",
    ],
)
def test_a_clause_of_moderate_depth_is_read_run_and_written(text):
    program = bdi.parse(text, "p.asl")
    assert str(bdi.parse(str(program))) == str(program)
    bdi.Agent(program, act=lambda term: True).advance(1.0)


@pytest.mark.parametrize("count", [1000, pytest.param(30_000, marks=pytest.mark.slow)])
def test_very_many_facts_are_believed(count):
    text = "".join(f"at(robot{k}, {k}.5, -{k}).\n" for k in range(count))
    agent = bdi.Agent(bdi.parse(text))
    assert len(agent.beliefs) == count
    assert str(next(iter(agent.beliefs))) == "at(robot0,0.5,0)[source(self)]"


def test_a_program_too_long_to_read_is_rejected():
    with pytest.raises(bdi.ProgramError, match="longer than the limit of 4,000,000 characters"):
        bdi.parse("// " + "x" * 5_000_000)


def test_texts_and_lists_do_not_grow_without_end():
    lines = []
    program = bdi.parse('!g("x"). +!g(X) <- .concat(X, X, Y); !g(Y). -!g(X) <- .print(failed).')
    bdi.Agent(program, act=lambda term: True, print=lines.append).advance(1.0)
    assert lines == ["failed"]


@pytest.mark.parametrize("name", ["../p.asl", "/etc/hostname", "link.asl", "sub/../../p.asl"])
def test_an_include_stays_in_the_folder_of_the_program(tmp_path, name):
    (tmp_path / "p.asl").write_text("secret.\n")
    folder = tmp_path / "mine"
    (folder / "sub").mkdir(parents=True)
    (folder / "link.asl").symlink_to(tmp_path / "p.asl")
    (folder / "main.asl").write_text(f'{{ include("{name}") }}\n')
    with pytest.raises(bdi.ProgramError, match="outside the program's folder"):
        bdi.parse_file(folder / "main.asl")


def test_an_include_of_a_name_that_no_file_can_have_is_rejected(tmp_path):
    with pytest.raises(bdi.ProgramError, match="is not a file name"):
        bdi.parse(f'{{ include("{"x" * 300}") }}', folder=tmp_path)
