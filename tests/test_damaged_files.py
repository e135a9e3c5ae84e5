"""Whatever is in a file: it is read, or one message says what is wrong."""

import os
import subprocess
import sys
from pathlib import Path
from random import Random

import pytest

import bdi
import floorplan
import sim
from fuzz.mutations import damaged
from fuzz.readers import DXF, READERS, recording, recording_of

ROOT = Path(__file__).resolve().parents[1]
CASES = int(os.environ.get("FUZZ_CASES", "120"))


@pytest.mark.parametrize("name", READERS)
def test_a_damaged_file_is_read_or_told(name):
    read, sample = READERS[name]
    read(sample)
    for case in range(CASES):
        read(damaged(sample, Random(f"test {case}")))


def test_a_damaged_recording_is_read_or_told(tmp_path):
    files = recording_of(tmp_path / "run")
    for name, sample in files.items():
        for case in range(CASES // 3):
            recording(files, name, damaged(sample, Random(f"test {case}")))


def test_a_recording_with_a_number_too_large_for_a_float_is_told(tmp_path):
    files = recording_of(tmp_path / "run")
    scene = files["scene.json"].replace(b"-22.0", b"9" * 400, 1)
    (tmp_path / "run" / "scene.json").write_bytes(scene)
    with pytest.raises(sim.RecordingError, match="scene"):
        sim.load_run(tmp_path / "run")


def test_a_thing_that_ezdxf_does_not_know_has_no_layer(tmp_path):
    path = tmp_path / "floor.dxf"
    path.write_bytes(DXF.replace(b"LWPOLYLINE", b"LWPOLY"))
    with pytest.raises(floorplan.FloorplanError, match="1 LWPOLY can't be read as outlines"):
        floorplan.load(path)


TOO_MUCH = {
    "nested lists": ("[" * 100_000, "nested too deeply"),
    "aliases of aliases": (
        "a: &a [x,x,x,x,x,x,x,x,x,x]\n"
        + "".join(
            f"{name}: &{name} [{','.join(['*' + before] * 10)}]\n"
            for before, name in zip("abcdefgh", "bcdefghi", strict=True)
        ),
        "more than 1,000,000 values",
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
    "a term in itself": "!g. +!g <- X = f(X); .print(X).",
}


@pytest.mark.parametrize("case", ENDLESS)
def test_a_program_without_end_is_stopped(case):
    program = bdi.parse(ENDLESS[case], "p.asl")
    agent = bdi.Agent(program, act=lambda term: True, print=lambda text: None, max_cycles=20_000)
    with pytest.raises(bdi.EndlessProgramError, match=r"p\.asl"):
        agent.advance(1.0)


def test_a_formula_too_deep_to_follow_is_told():
    program = bdi.parse("x.\n!g. +!g : " + " & ".join(["x"] * 4000) + " <- .print(a).", "p.asl")
    with pytest.raises(bdi.ProgramError, match=r"p\.asl: a formula or a term is nested too deeply"):
        bdi.Agent(program, act=lambda term: True)


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


@pytest.mark.parametrize("room", [2000, 12_000, 100_000])
def test_a_recording_on_a_full_disk_stays_whole(tmp_path, room):
    """A limit on the size of files stands for the disk."""
    arguments = [str(room), "run", "--duration", "60", "--out", "out"]
    done = subprocess.run(
        [sys.executable, "-c", FULL_DISK, *arguments],
        cwd=tmp_path,
        env={**os.environ, "PYTHONPATH": str(ROOT)},
        capture_output=True,
        text=True,
        timeout=120,
    )
    assert done.returncode == 1
    assert done.stderr.startswith("floorwalker: can't go on writing to out: ")
    assert len(done.stderr.splitlines()) == 1
    out = tmp_path / "out"
    assert not (out / "replay.html").exists()
    assert not list(out.glob("*.part"))
    for lines in out.glob("*.jsonl"):
        assert lines.read_bytes()[-1:] in (b"", b"\n"), lines.name
    if (out / "scene.json").exists():
        assert 0 <= sim.load_run(out).duration <= 60
