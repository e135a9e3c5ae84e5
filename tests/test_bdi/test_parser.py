"""The parser: any text becomes a program or an error with its place."""

import string

import pytest
from hypothesis import given, strategies as st

import bdi

PIECES = st.sampled_from(
    [
        *("a", "b(1)", "X", "_", '"text"', "3.5", "[1,2|T]", "{+!g}", ".print", "true", "not", "~"),
        *("(", ")", "[", "]", "{", "}", ".", ",", ";", ":", ":-", "<-", "!", "!!", "?", "+", "-"),
        *("&", "|", "|&|", "|||", "=", "==", "=..", "<", ">=", "*", "/", "**", "div", "mod", "@l"),
        *(
            "if",
            "else",
            "elif",
            "while",
            "for",
            "'q a'",
            '"',
            "//",
            "/*",
            "*/",
            "\n",
            "\\",
            "include",
        ),
    ]
)


def check(text):
    try:
        program = bdi.parse(text, "t.asl")
    except bdi.ProgramError as error:
        lines = text.count("\n") + 1
        for problem in error.problems:
            assert problem.file == "t.asl"
            assert 1 <= problem.line <= lines + 1
            assert problem.column >= 1
            assert problem.message
    else:
        written = str(program)
        again = bdi.parse(written, "t.asl")
        assert str(again) == written


@given(st.text(max_size=200))
def test_any_text_is_parsed_or_rejected(text):
    check(text)


@given(st.text(alphabet=string.printable, max_size=300))
def test_any_printable_text_is_parsed_or_rejected(text):
    check(text)


@given(st.lists(PIECES, max_size=40))
def test_any_tokens_are_parsed_or_rejected(pieces):
    check(" ".join(pieces))


NAMES = st.sampled_from(["a", "b", "go", "p1", "'An Atom'"])
VARIABLES = st.sampled_from(["X", "Y", "Long_Name1", "_"])
NUMBERS = st.floats(-1e9, 1e9, allow_nan=False).map(lambda x: f"{abs(x):.6g}")
STRINGS = st.text(alphabet='ab "\\n.;{}', max_size=6).map(
    lambda s: '"' + s.replace("\\", "").replace('"', '\\"') + '"'
)


def structures(terms):
    args = st.lists(terms, min_size=1, max_size=3).map(", ".join)
    lists = st.lists(terms, max_size=3).map(lambda items: f"[{', '.join(items)}]")
    return st.one_of(
        st.builds("{}({})".format, NAMES, args),
        st.builds("{}({})[{}]".format, NAMES, args, NAMES),
        st.builds("~{}({})".format, NAMES, args),
        lists,
        st.builds("[{}|{}]".format, terms, VARIABLES),
    )


TERMS = st.recursive(st.one_of(NAMES, VARIABLES, NUMBERS, STRINGS), structures, max_leaves=8)
SUMS = st.recursive(
    st.one_of(VARIABLES, NUMBERS),
    lambda s: st.builds("({} {} {})".format, s, st.sampled_from(["+", "-", "*", "**", "mod"]), s),
    max_leaves=5,
)
CONDITIONS = st.recursive(
    st.one_of(
        NAMES,
        st.builds("{} {} {}".format, SUMS, st.sampled_from(["<", "==", "\\==", "="]), SUMS),
        st.builds(".member({}, {})".format, TERMS, TERMS),
    ),
    lambda c: st.one_of(
        st.builds("({} & {})".format, c, c),
        st.builds("({} | {})".format, c, c),
        st.builds("not ({})".format, c),
    ),
    max_leaves=5,
)
LITERALS = st.builds("{}({})".format, st.sampled_from(["p", "q"]), TERMS)
STEPS = st.recursive(
    st.one_of(
        st.builds(
            "{}{}".format, st.sampled_from(["!", "!!", "?", "+", "-", "-+", "++", ""]), LITERALS
        ),
        st.builds("X = {}".format, SUMS),
        st.builds(".print({})".format, TERMS),
    ),
    lambda s: st.one_of(
        st.builds("if ({}) {{ {} }} else {{ {} }}".format, CONDITIONS, s, s),
        st.builds("for ({}) {{ {}; {} }}".format, CONDITIONS, s, s),
        st.builds("while ({}) {{ {} }}".format, CONDITIONS, s),
        st.builds("(a; {}) |&| !b ||| c".format, s),
        st.builds("({}; {})".format, s, s),
    ),
    max_leaves=4,
)
CLAUSES = st.one_of(
    st.builds("{}.".format, LITERALS),
    st.builds("{} :- {}.".format, LITERALS, CONDITIONS),
    st.builds("!{}.".format, LITERALS),
    st.builds("@l[atomic] +!{} : {} <- {}; {}.".format, LITERALS, CONDITIONS, STEPS, STEPS),
    st.builds("-{} <- {}.".format, LITERALS, STEPS),
    st.builds("+?{}.".format, LITERALS),
)


@given(st.lists(CLAUSES, max_size=4).map("\n".join))
def test_a_printed_program_parses_to_the_same_program(source):
    program = bdi.parse(source)
    written = str(program)
    assert str(bdi.parse(written)) == written


@pytest.mark.parametrize(
    ("written", "meant"),
    [
        ("(a; b); c", "a; b; c"),
        ("a; (b; c)", "a; b; c"),
        ("((a; b))", "a; b"),
        ("x; (a ||| b); c", "x; a ||| b; c"),
        ("if (p) { (a; b) }", "if (p) { a; b }"),
        ("(+q(a); ?q(X); X)", "+q(a); ?q(X); X"),
        ("a; ((-p; b); (-+q(1); ++r))", "a; -p; b; -+q(1); ++r"),
        ("(-p) |&| (+q; a)", "-p |&| (+q; a)"),
        (
            "X = 1; ((-X) < 2; (-X) < 3); -X < 3; a",
            "X = 1; (-X) < 2; (-X) < 3; (-X < 3); a",
        ),
        ("X = 1; -3 < X; (-3 < X; a)", "X = 1; (-3) < X; -3 < X; a"),
    ],
)
def test_brackets_around_steps_make_no_difference(written, meant):
    done = []
    for body in (written, meant):
        acted = []
        program = bdi.parse(f"p. !g. +!g <- {body}.")
        bdi.Agent(program, act=lambda action, acted=acted: not acted.append(str(action))).advance(0)
        done.append((str(program), acted))
    assert done[0] == done[1]
    assert done[0][1]


def test_empty_annotations_are_ignored():
    written = "p[]. +!g <- !b(X[]); _[]; ~a(Y[])[]; Z[b]; Z[]."
    assert str(bdi.parse(written)) == str(bdi.parse("p. +!g <- !b(X); _; ~a(Y); Z[b]; Z."))


def problems(source):
    with pytest.raises(bdi.ProgramError) as wrong:
        bdi.parse(source, "x.asl")
    return [(p.line, p.column, p.message) for p in wrong.value.problems]


def test_all_invalid_clauses_are_reported():
    source = "a(1.\n!go.\n+!go <- .print(1) .print(2).\nb(2).\n+!c : <- d.\nX."
    assert [place[:2] for place in problems(source)] == [(1, 4), (3, 19), (5, 7), (6, 1)]


@pytest.mark.parametrize(
    ("source", "place", "part"),
    [
        ("a", (1, 2), "found the end, expected"),
        ("a(", (1, 3), "expected a term"),
        ('a("x).', (1, 3), "does not end on its line"),
        ("a. §", (1, 4), "'§' has no meaning"),
        ("+!a <- !.print(1).", (1, 8), "cannot be applied to the internal action"),
        ("+!a <- 3.", (1, 8), "cannot be a step of a plan"),
        ("+!a <- X + a.", (1, 8), "numbers and variables"),
        ("-+a <- b.", (1, 1), "begins with '+' or '-'"),
        ("a <- b.", (1, 3), "found '<-'"),
        (".print(1).", (1, 1), "cannot be a belief"),
        ("!X.", (1, 1), "cannot be a goal"),
        ("a(1e999).", (1, 3), "too large"),
        ("{ includ(x) }", (1, 1), "no directive 'includ'"),
        ('{ include("x.asl") }', (1, 1), "none is built in"),
        ("/* open", (1, 1), "found '/'"),
        ("+~.print(1).", (1, 2), "cannot be negated"),
    ],
)
def test_an_error_has_a_line_and_a_column(source, place, part):
    ((line, column, message),) = problems(source)
    assert (line, column) == place, message
    assert part in message


def test_deep_nesting_is_parsed_or_rejected():
    for depth in (10, 100, 5000):
        for text in ("a(" + "(" * depth + "1" + ")" * depth + ").", "a" * depth + "(" * depth):
            check(text)
        check("+!a <- " + "; ".join(["b"] * depth) + ".")


@pytest.mark.parametrize(
    ("source", "printed"),
    [
        ("2 + 3 * 4", "(2+(3*4))"),
        ("2 - 3 - 4", "((2-3)-4)"),
        ("2 ** 3 ** 2", "(2**(3**2))"),
        ("X mod 2 + 1", "((X mod 2)+1)"),
        ("-X", "(-X)"),
        ("-3", "-3"),
        ("a & b | c & not d", "((a & b) | (c & not (d)))"),
        ("[a, b|[c|T]]", "[a,b,c|T]"),
        ("p(1)[b, a, b]", "p(1)[a,b]"),
        ("~p(1)", "~p(1)"),
        ("1.50", "1.5"),
        ("f(-0.5e3)", "f(-500)"),
        ('"a\\"b"', '"a"b"'),
        ("{ !a; +b }", "{ !a; +b }"),
        ("{ +!a(X) }", "{ +!a(X) }"),
        ("{ @l +!a : b <- c }", "{ @l +!a : b <- c }"),
        ("math.abs(-1) + X", "(math.abs(-1)+X)"),
    ],
)
def test_terms_are_parsed_and_printed(source, printed):
    (rule,) = bdi.parse(f"x :- {source}.").beliefs
    assert str(rule) == f"x :- {printed}"


def test_comments_and_layout_are_ignored():
    one = bdi.parse("a.// b.\n/* c. \n * d. */ e(1,/* two */2). +!g:a<-b;c.")
    other = bdi.parse("a.\n\n  e( 1 , 2 ) .\n+!g : a <- b ; c ; .")
    assert str(one) == str(other)


def test_programs_include_files(tmp_path):
    (tmp_path / "sub").mkdir()
    (tmp_path / "main.asl").write_text('a. { include("sub/part.asl") } c.', encoding="utf-8")
    (tmp_path / "sub" / "part.asl").write_text("b.", encoding="utf-8")
    assert str(bdi.parse_file(tmp_path / "main.asl")) == "a.\nb.\nc.\n"
    (tmp_path / "outside.asl").write_text('{ include("../x.asl") }', encoding="utf-8")
    (tmp_path / "loop.asl").write_text('{ include("loop.asl") }', encoding="utf-8")
    (tmp_path / "wrong.asl").write_text('{ include("bad.asl") }\nx(.', encoding="utf-8")
    (tmp_path / "bad.asl").write_text("ok.\nnot ok.", encoding="utf-8")
    for name, part in (
        ("outside", "outside the program's folder"),
        ("loop", "includes itself"),
        ("wrong", "bad.asl:2:1"),
        ("nowhere", "no such file"),
    ):
        with pytest.raises(bdi.ProgramError, match=part.replace(".", r"\.")):
            bdi.parse_file(tmp_path / f"{name}.asl")
    with pytest.raises(bdi.ProgramError) as wrong:
        bdi.parse_file(tmp_path / "wrong.asl")
    assert len(wrong.value.problems) == 2


def test_files_without_text_are_rejected(tmp_path):
    path = tmp_path / "x.asl"
    path.write_bytes(b"a(\xff).")
    with pytest.raises(bdi.ProgramError, match="UTF-8"):
        bdi.parse_file(path)
    with pytest.raises(bdi.ProgramError, match="no regular file"):
        bdi.parse_file(tmp_path)


@pytest.mark.parametrize("numbers", ["1", "-0", "01", "1.50", "-2.25, 3", "1 ,2", "  4  "])
def test_facts_with_numbers_are_those_of_a_program(numbers):
    fact, program = bdi.parse_literal(f"at({numbers})"), bdi.parse(f"at({numbers}).")
    assert repr(fact.args) == repr(program.beliefs[0].belief.args)
    assert fact == program.beliefs[0].belief


@pytest.mark.parametrize("name", ["not", "mod", "true", "while", "A"])
def test_reserved_words_are_no_facts(name):
    with pytest.raises(bdi.ProgramError, match=name):
        bdi.parse_literal(f"{name}(1)")


@pytest.mark.parametrize("text", ["", " ", "\n"])
def test_an_empty_text_is_no_literal(text):
    with pytest.raises(bdi.ProgramError, match="found the end"):
        bdi.parse_literal(text)


def test_files_with_the_same_text_have_separate_locations_and_are_read_again(tmp_path):
    one, other = tmp_path / "one.asl", tmp_path / "other.asl"
    for path in (one, other):
        path.write_text("!walk.\n+!walk <- wait.\n")
    assert {plan.place.file for plan in bdi.parse_file(one).plans} == {str(one)}
    assert {plan.place.file for plan in bdi.parse_file(other).plans} == {str(other)}
    one.write_text("!rest.\n")
    assert [str(goal) for goal in bdi.parse_file(one).goals] == ["!rest"]


def test_an_invalid_text_is_rejected_each_time():
    errors = []
    for _ in range(2):
        with pytest.raises(bdi.ProgramError) as refused:
            bdi.parse("!walk.\n+!walk <- .\n+!rest <- ?.\n", "p.asl")
        errors.append(str(refused.value))
    assert errors[0] == errors[1]
    assert errors[0].count("p.asl:") == 2
