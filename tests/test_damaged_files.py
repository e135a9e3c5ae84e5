"""Whatever is in a file: it is read, or one message says what is wrong."""

import ast
import csv
import os
import re
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

import bdi
import floorplan
import navigation
import sim
from bdi.facts import plain_fact
from bdi.parser import parse_clause
from bdi.tokens import clauses, tokenize
from fuzz.hunt import case
from fuzz.readers import READERS, SAMPLES
from sim.commands.percept_script import read_percepts
from sim.studies.folder import StudyFolder

ROOT = Path(__file__).resolve().parents[1]
CASES = int(os.environ.get("FUZZ_CASES", "15"))


@pytest.mark.parametrize("name", READERS)
def test_a_damaged_file_is_read_or_told(name):
    reader = READERS[name]
    for sample in reader.samples():
        reader.read(sample)
    for number in range(CASES):
        reader.read(case(reader, number, "test"))


READING = (
    *(
        "read_text",
        "read_bytes",
        "read_lines",
        "read_yaml",
        "parse_yaml",
        "parse_json",
        "loads",
        "from_json",
    ),
    *("reader", "readfile", "model_validate_json"),
)
"""Calls that take in foreign text; and `open` for reading."""

READ_BY = {
    "bdi/loading.py": ["program", "include"],
    "floorplan/document.py": ["floorplan", "trial"],
    "floorplan/dxf.py": ["dxf"],
    "floorplan/reading.py": ["floorplan", "wkt", "pgm", "events.jsonl", "percepts"],
    "floorplan/image.py": ["pgm", "png"],
    "floorplan/loading.py": ["floorplan", "ros_map"],
    "floorplan/wkt.py": ["wkt"],
    "sim/bridge/connection.py": ["bridge_agent"],
    "sim/bridge/protocol.py": ["bridge_server"],
    "sim/commands/percept_script.py": ["percepts"],
    "sim/commands/replay.py": ["page"],
    "sim/views/replay.py": ["page"],
    "sim/runs/run_folder.py": ["summary.json", "events.jsonl", "thoughts.jsonl"],
    "sim/record/scene_file.py": ["scene.json"],
    "sim/record/strict_json.py": ["summary.json"],
    "sim/studies/folder.py": ["study.json"],
    "sim/studies/study_file.py": ["study"],
    "sim/studies/table.py": ["results.csv"],
    "sim/trials/rules_file.py": ["rules"],
    "sim/trials/trial_file.py": ["trial", "ariac", "expectations"],
}
"""Which modules read, and who of the readers shows that they do it well."""

READ_OTHERWISE = {
    "bdi/tokens.py": "the grammar",
    "sim/commands/check.py": "hands on to the readers of trials, studies and floors",
    "sim/commands/list.py": "the built-in programs",
    "sim/commands/sources.py": "hands on to the readers of trials and floors",
    "sim/testing/items.py": "hands on to the reader of trials",
    "sim/studies/identity.py": "the user's own Python, which has been imported before",
    "sim/studies/report.py": "a page of ours",
    "sim/core/own_source.py": "the user's own Python, which is parsed",
}
"""Which modules read something else."""


def test_every_module_that_reads_is_known():
    found = set()
    for package in (bdi, floorplan, navigation, sim):
        folder = Path(package.__file__).parent
        for path in folder.rglob("*.py"):
            if any(map(_reads, ast.walk(ast.parse(path.read_text(encoding="utf-8"))))):
                found.add(path.relative_to(folder.parent).as_posix())
    assert found == READ_BY.keys() | READ_OTHERWISE.keys()
    assert {name for names in READ_BY.values() for name in names} <= READERS.keys()


def _reads(node):
    if not isinstance(node, ast.Call):
        return False
    name = ast.unparse(node.func).rpartition(".")[2]
    if name == "open":
        called = ast.unparse(node)
        return "Image.open(" in called or re.search(r"open\((encoding|'r)", called) is not None
    return name in READING


@pytest.fixture
def recorded(tmp_path):
    """A folder with a short recording."""
    text = "floorplan: ariac2023\nduration: 3.0\npeople: [{name: ada}]\n"
    recording = sim.Recording(tmp_path / "run")
    recording.finish(sim.run(sim.Trial.parse(text), recording))
    return tmp_path / "run"


@pytest.mark.parametrize(
    ("name", "old", "new", "told"),
    [
        ("scene.json", "-22.0", "9" * 400, r"scene.json: is not JSON: the number 9{20}… is too"),
        ("scene.json", "-22.0", "-1e999", "scene.json: is not JSON: the number -1e999 is too"),
        ("scene.json", '"agv_law":{', '"agv_law":0,"x":{', "scene.json: rules: "),
        ("motions.jsonl", '"pieces": [[0.0', '"pieces": [[1e300', "line 1, pieces"),
        ("summary.json", '"penalties": 0', '"penalties": NaN', "summary.json: is not JSON: NaN"),
        ("summary.json", "{", "[" * 100_000, "summary.json: is not JSON: it is nested too deeply"),
        ("events.jsonl", '"at": [', '"at": [1, ', "line 3: at of goal can't be"),
        ("events.jsonl", '"at": [', '"at": [Infinity, ', "line 3: is not JSON: Infinity is no"),
        ("events.jsonl", '"person": "ada"', '"person": ["ada"]', "person of human_started can't"),
        ("thoughts.jsonl", '"believes": [', '"believes": [7, ', "line 1, believes.0: input should"),
        ("thoughts.jsonl", '"t": 0.0', '"t": 0.0, "x": NaN', "line 1: is not JSON: NaN is no"),
    ],
)
def test_a_damaged_line_of_a_recording_is_told(recorded, name, old, new, told):
    text = (recorded / name).read_text()
    assert old in text
    (recorded / name).write_text(text.replace(old, new, 1))
    with pytest.raises(sim.RecordingError, match=told):
        sim.load_run(recorded)


@pytest.mark.parametrize(
    ("old", "new", "told"),
    [
        ("\n1,", "\n7,", "line 3: it is row 1, not '7'"),
        ("\n1,", "\n1,x,", "line 3: it has .* cells where there are .* columns"),
        ("row,", "number,", "line 1: the columns row and error are missing"),
        ("row,", "row,row,", "line 1: the column 'row' is there twice"),
        ("penalties\n", "penalties\n", None),
        ("\n0,0.9,0,,0\n", '\n0,0.9,0,,"many"\n', "line 2: row 0 is not as it was measured"),
        ("\n0,0.9,0,,0\n", "\n0,0.9,0,,1e999\n", "line 2: row 0 is not as it was measured"),
        ("\n1,1.1,0,,2\n", "\n1,1.1,0,,1\n", "line 3: row 1 is not as it was measured"),
        ("max_speed", "speed", "line 2: row 0 is not as it was measured"),
    ],
)
def test_damaged_results_of_a_study_are_told(tmp_path, old, new, told):
    (tmp_path / "t.yaml").write_text("floorplan: ariac2023\nduration: 1.0\npeople: [{name: a}]\n")
    text = "trials: [t.yaml]\ngrid: {max_speed: [0.9, 1.1]}\nrepeat: 1\n"
    study = sim.Study.parse(text, file=str(tmp_path / "s.yaml"), folder=tmp_path)
    table = "row,max_speed,seed,error,penalties\n0,0.9,0,,0\n1,1.1,0,,2\n"
    assert old in table
    with StudyFolder(tmp_path / "out", study) as folder:
        for line in csv.DictReader(table.splitlines()):
            folder.table.add(line)
    assert (tmp_path / "out" / "results.csv").read_text() == table
    (tmp_path / "out" / "results.csv").write_text(table.replace(old, new, 1))
    if told is None:
        assert sim.run_study(study, tmp_path / "out").columns["penalties"] == [0, 2]
        return
    with pytest.raises(ValueError, match=told):
        sim.run_study(study, tmp_path / "out", jobs=1)


@pytest.mark.parametrize(
    "trial",
    [
        f"floorplan: {'x' * 300}.yaml",
        'floorplan: "a\\0.yaml"',
        f"floorplan: ariac2023\nrules: {'x' * 300}",
        f"floorplan: ariac2023\npeople: [{{name: ada, personality: {'x' * 300}}}]",
        'floorplan: ariac2023\npeople: [{name: ada, personality: "a\\0"}]',
        f"floorplan: ariac2023\nariac: {'x' * 300}",
    ],
)
def test_a_name_that_no_file_can_have_is_told(trial):
    with pytest.raises(sim.TrialError, match="<text>: line "):
        sim.Trial.parse(trial)


def test_an_include_of_a_name_that_no_file_can_have_is_told(tmp_path):
    with pytest.raises(bdi.ProgramError, match="is no name of a file"):
        bdi.parse(f'{{ include("{"x" * 300}") }}', folder=tmp_path)


def test_a_distribution_of_nothing_is_told():
    text = "trials: [ariac2023]\nrandom: {max_speed: {normal: null}}"
    with pytest.raises(sim.StudyError, match=r"line 2, random\.max_speed: give one of uniform"):
        sim.Study.parse(text)


def test_a_law_with_a_number_too_large_for_a_float_is_told(tmp_path):
    (tmp_path / "r.yaml").write_text(f"agv_law: {{fixed: {'9' * 400}}}\n")
    with pytest.raises(sim.RulesError, match=r"line 1, agv_law\.fixed\.metres: the number is too"):
        sim.load_rules(tmp_path / "r.yaml")


@pytest.mark.parametrize("t", ["9" * 400, "1e999", "true"])
def test_a_time_of_a_percept_that_is_none_is_told(tmp_path, t):
    (tmp_path / "p.jsonl").write_text(f'{{"t": {t}, "add": "a"}}\n')
    with pytest.raises(ValueError, match=r"p\.jsonl:1: .t. is a number of seconds"):
        read_percepts(tmp_path / "p.jsonl")


def test_messages_stay_short_whatever_is_in_the_file(tmp_path):
    (tmp_path / "f.yaml").write_text("boundary: [[0,0],[1,0],[1,1]]\n" + "x" * 100_000 + ": 1\n")
    with pytest.raises(floorplan.FloorplanError) as floor:
        floorplan.load(tmp_path / "f.yaml")
    with pytest.raises(bdi.ProgramError) as program:
        bdi.parse("a b. " * 100 + "x " + "y" * 100_000 + ".", "p.asl")
    assert len(program.value.problems) == 101
    assert str(program.value).splitlines()[-1] == "and 81 more"
    with pytest.raises(bdi.ProgramError) as literal:
        bdi.parse_literal("a(" + "b" * 100_000)
    assert max(len(str(why.value)) for why in (floor, program, literal)) < 3000


def test_a_thing_that_ezdxf_does_not_know_has_no_layer(tmp_path):
    path = tmp_path / "floor.dxf"
    path.write_bytes((SAMPLES / "floor.dxf").read_bytes().replace(b"LWPOLYLINE", b"LWPOLY"))
    with pytest.raises(floorplan.FloorplanError, match="2 LWPOLY can't be read as outlines"):
        floorplan.load(path)


def test_a_drawing_with_an_endless_number_is_told(tmp_path):
    path = tmp_path / "floor.dxf"
    path.write_bytes((SAMPLES / "floor.dxf").read_bytes().replace(b"\n90\n4\n", b"\n90\n-inf\n"))
    with pytest.raises(floorplan.FloorplanError, match="is not a DXF drawing"):
        floorplan.load(path)


TOO_MUCH = {
    "nested lists": ("[" * 100_000, "nested too deeply"),
    "aliases of aliases": (
        "a: &a [x,x,x,x,x,x,x,x,x,x]\n"
        + "".join(
            f"{name}: &{name} [{','.join(['*' + before] * 10)}]\n"
            for before, name in zip("abcdefgh", "bcdefghi", strict=True)
        ),
        "more than 300,000 values",
    ),
    "an alias to itself": ("a: &a [*a]", "line 1|a[0]: an alias (*) to something that contains it"),
    "10 MB": ("floorplan: ariac2023\n# " + "x" * 10_000_000, "longer than 4,000,000 characters"),
    "a list as a key": ("? [1, 2]\n: 1\n", "line 1: a key is plain text"),
    "a tag that promises too much": ("floorplan: !!bool maybe\n", "is not what its tag"),
    "an exponent without a sign": (
        "floorplan: ariac2023\nduration: 1e3\n",
        "line 2, duration: expected a number (to YAML 1e3 is text; write 1.0e+3 or 1000)",
    ),
}


@pytest.mark.parametrize("case", TOO_MUCH)
def test_yaml_that_asks_too_much_is_told(case):
    text, message = TOO_MUCH[case]
    with pytest.raises(sim.TrialError) as told:
        sim.Trial.parse(text)
    assert message.split("|")[-1] in str(told.value)


def test_only_the_first_of_many_problems_are_shown():
    text = "floorplan: ariac2023\nagvs:\n  agv1:\n" + "    - {time: x, to: warehouse}\n" * 500
    with pytest.raises(sim.TrialError) as told:
        sim.Trial.parse(text)
    assert len(told.value.problems) == 500
    lines = str(told.value).splitlines()
    assert lines[0] == "<text>: 500 problems"
    assert lines[-1].strip() == "and 480 more"
    assert len(lines) == 22


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
def test_a_term_that_doubles_when_it_is_printed_is_told():
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
        max_cycles=20_000,
        max_goals=20_000,
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
def test_a_clause_too_deep_to_follow_is_told(case):
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
def test_a_clause_that_is_not_too_deep_is_read_run_and_written(text):
    program = bdi.parse(text, "p.asl")
    assert str(bdi.parse(str(program))) == str(program)
    bdi.Agent(program, act=lambda term: True).advance(1.0)


@pytest.mark.parametrize("count", [5000, pytest.param(100_000, marks=pytest.mark.slow)])
def test_very_many_facts_are_believed(count):
    text = "".join(f"at(robot{k}, {k}.5, -{k}).\n" for k in range(count))
    agent = bdi.Agent(bdi.parse(text))
    assert len(agent.beliefs) == count
    assert str(next(iter(agent.beliefs))) == "at(robot0,0.5,0)[source(self)]"


FACT_PARTS = st.sampled_from(
    [
        "a",
        "at",
        "3",
        "-",
        "2.5e3",
        '"a\\n"',
        "(",
        ")",
        ",",
        ".",
        "X",
        "[b]",
        "~",
        "math.pi",
        "true",
        "'Odd'",
        ".f",
        "1e999",
        "+",
        "math.abs",
        "f(1)",
    ]
)


@given(st.lists(FACT_PARTS, max_size=6), st.lists(FACT_PARTS, max_size=3))
def test_plain_facts_are_read_as_the_parser_reads_them(inside, after):
    for text in ("at(" + "".join(inside) + ")" + "".join(after) + ".", "".join(inside + after)):
        for tokens in clauses(tokenize(text)):
            fact = plain_fact(tokens, "p.asl")
            if fact is not None:
                parsed = parse_clause(tokens, "p.asl")
                assert (fact, fact.place) == (parsed, parsed.place)
                assert str(fact) == str(parsed)


@given(
    st.lists(st.integers() | st.sampled_from(["a", "b1", '"text"', "-2.5", "'Q x'"]), min_size=1)
)
def test_plain_facts_do_not_need_the_parser(args):
    (tokens,) = clauses(tokenize(f"at({', '.join(map(str, args))})."))
    assert plain_fact(tokens, "p.asl") == parse_clause(tokens, "p.asl")


def test_a_program_too_long_to_read_is_told():
    with pytest.raises(bdi.ProgramError, match="longer than 4,000,000 characters"):
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


FULL_DISK = """
import resource, signal, sys
signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
resource.setrlimit(resource.RLIMIT_FSIZE, (int(sys.argv.pop(1)),) * 2)
from sim.cli import main
main()
"""


BRIDGE = ["bridge", "--port", "0", "--speed", "200"]


@pytest.mark.parametrize(
    ("room", "command"),
    [(2000, ["run"]), (12_000, ["run"]), (100_000, ["run"]), (12_000, BRIDGE)],
)
def test_a_recording_on_a_full_disk_stays_whole(tmp_path, room, command):
    """A limit on the size of files stands for the disk."""
    arguments = [str(room), *command, "--duration", "60", "--out", "out"]
    done = subprocess.run(
        [sys.executable, "-c", FULL_DISK, *arguments],
        cwd=tmp_path,
        env={**os.environ, "PYTHONPATH": str(ROOT)},
        capture_output=True,
        text=True,
        timeout=120,
    )
    assert done.returncode == 1
    *notices, told = done.stderr.splitlines()
    assert told.startswith("floorwalker: can't go on writing to out: ")
    assert all(notice.startswith(("serving", "the trial begins")) for notice in notices)
    assert len(notices) == (0 if command == ["run"] else 2)
    out = tmp_path / "out"
    assert not (out / "replay.html").exists()
    assert not list(out.glob(".unfinished-*"))
    for lines in out.glob("*.jsonl"):
        assert lines.read_bytes()[-1:] in (b"", b"\n"), lines.name
    if (out / "scene.json").exists():
        assert 0 <= sim.load_run(out).duration <= 60


@pytest.mark.parametrize("command", [["run"], BRIDGE])
def test_a_terminated_run_is_kept_whole(tmp_path, command):
    arguments = [*command, "--duration", "2000000", "--out", "out"]
    process = subprocess.Popen(
        [sys.executable, "-m", "sim.cli", *arguments],
        cwd=tmp_path,
        env={**os.environ, "PYTHONPATH": str(ROOT)},
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
    )
    events = tmp_path / "out" / "events.jsonl"
    deadline = time.monotonic() + 60
    while not (events.exists() and events.stat().st_size > 100):
        assert time.monotonic() < deadline and process.poll() is None
        time.sleep(0.05)
    process.send_signal(signal.SIGTERM)
    _, told = process.communicate(timeout=60)
    assert process.returncode == 130
    assert b"what happened is kept" in told and b"Traceback" not in told
    assert sim.load_run(tmp_path / "out").summary["interrupted"]
