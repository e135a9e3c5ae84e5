"""The stderr of every command contains its own notices only, also if the command ends early."""

import os
import re
import signal
import subprocess
import sys

import pytest
from processes import command_line, in_a_process, started
from waiting import HANG

from navigation.kernels import COMPILED
from sim.core.compilation import NOTICE

STRICT = ("-X", "dev", "-W", "default")
"""Options by which the interpreter shows every warning, also about unclosed files."""

SLOWNESS = r"Executing <.*> took \d+\.\d+ seconds\n"
"""Message of asyncio on a busy machine with these options."""

SOURCES = "" if COMPILED else f"{NOTICE}\n"
"""The notice of a command that runs a trial with uncompiled kernels."""

CALLS = {
    "agent": "agent short.asl --percepts percepts.jsonl --belief helpful --trace",
    "benchmark": "benchmark --floorplan hall.yaml --planner RRTConnect --queries 1 --out b",
    "bridge": "bridge short.trial.yaml --port 0 --speed 0 --out bridged",
    "check": "check short.trial.yaml short.study.yaml short.asl hall.yaml",
    "convert": "convert hall.yaml other.yaml",
    "export": "export run --out run.mcap",
    "fields": "fields short.trial.yaml",
    "list": "list",
    "metrics": "metrics run",
    "new": "new trial",
    "plan": "plan hall.yaml 1 1 9 5 --planner RRTConnect --plot way.png",
    "plot floorplan": "plot floorplan hall.yaml --out floor.png",
    "plot heatmap": "plot heatmap run --out heat.png",
    "plot path": "plot path hall.yaml 1 1 9 5 --out path.svg",
    "plot density": "plot density run --of speed --out density.png",
    "plot riskmap": "plot riskmap run --of time --out risk.png",
    "plot separation": "plot separation run --out separation.png",
    "plot spacetime": "plot spacetime run --out spacetime.pdf",
    "plot trails": "plot trails run --out trails.png",
    "render": "render run --out film.gif --to 2 --fps 4 --width 200",
    "replay": "replay run --out page.html --no-open",
    "report": "report run --out report.html",
    "ros2": "ros2 --help",
    "run": "run short.trial.yaml --out another",
    "search": "search drawn.study.yaml --sampler random --evaluations 4 --jobs 1 --below -9",
    "study": "study short.study.yaml --jobs 2 --out studied",
}
"""A call of each command, in the folder `samples`."""

NOTICES = {
    "agent": r"( +\d+\.\d{3} .*\n)+",
    "benchmark": r"Wrote b/report\.html, CSV files of all answers and an OMPL log for each floor\n",
    "bridge": r"serving ws://127\.0\.0\.1:\d+\n(stands still at t = 0\.0 s: there is no agent\n)?"
    r"the trial begins\n",
    "search": r"drawn: 4 of 4 evaluations least \S+\n",
    "plot riskmap": r"Nobody was nearer than required .*\n",
}
"""Notices that a command prints on stderr. Other commands print none."""

FURTHER = (
    *(f"export run --out run{ending}" for ending in (".csv", ".parquet", ".sqlite", "-bag")),
    *("list --help", "--help", "--version", "metrics run --json"),
)


@pytest.fixture(scope="module")
def samples(tmp_path_factory):
    """A folder with a file of each kind, and a recorded run."""
    folder = tmp_path_factory.mktemp("samples")
    files = {
        "short.trial.yaml": "floorplan: ariac2023\nduration: 4.0\npeople: [{name: operator, "
        "personality: helpful}]\ngantry: {controller: pausing, at: [-2.5, 0.5, 0.0]}\n",
        "short.study.yaml": "trials: [short.trial.yaml]\ngrid: {personality: [helpful, curious]}\n",
        "drawn.study.yaml": "trials: [short.trial.yaml]\n"
        "random: {max_speed: {uniform: [0.5, 1.5]}}\nsearch: {minimise: least_margin}\n",
        "short.asl": "+bell <- .print(hello); wave.\n",
        "percepts.jsonl": '{"t": 1.0, "add": "bell"}\n',
        "hall.yaml": "boundary: [[0, 0], [10, 0], [10, 6], [0, 6]]\n"
        "obstacles:\n  press: {x: [4, 6], y: [2, 4], z: [0, 2]}\n",
        "forever.asl": "!go.\n+!go <- .print(on); .wait(10); !go.\n",
    }
    for name, text in files.items():
        (folder / name).write_text(text)
    done = in_a_process("run", "short.trial.yaml", "--out", "run", cwd=folder, options=STRICT)
    assert_clean("run", done)
    return folder


def assert_clean(name, done):
    """Check that a command printed only its output and notices."""
    said = re.sub(SLOWNESS, "", done.stderr).removeprefix(SOURCES)
    assert re.fullmatch(NOTICES.get(name, ""), said), said
    assert done.returncode == 0
    assert "Warning" not in done.stdout


def test_every_command_is_called_below(floorwalker, monkeypatch):
    def offered(line):
        monkeypatch.setenv("_FLOORWALKER_COMPLETE", "complete_bash")
        monkeypatch.setenv("COMP_WORDS", line)
        monkeypatch.setenv("COMP_CWORD", str(line.count(" ")))
        return floorwalker().stdout.split()

    commands = [
        *offered("floorwalker "),
        *(f"plot {name}" for name in offered("floorwalker plot ")),
    ]
    assert sorted(commands) == sorted([*CALLS, "plot"])


ALONE = ("bridge", pytest.param("study", marks=pytest.mark.slow))
"""Commands that start servers or processes, whose remains show at the end of the process.

`run` is tested in the same way when the samples are made.
"""


@pytest.mark.parametrize("name", ALONE)
def test_commands_print_only_their_output(name, samples):
    assert_clean(name, in_a_process(*CALLS[name].split(), cwd=samples, options=STRICT))


ONE_AFTER_ANOTHER = """
import sys
from sim.cli import main
for call in sys.argv[1:]:
    sys.argv = ["floorwalker", *call.split()]
    try:
        main()
    except SystemExit as ended:
        print(f"== {ended.code or 0} {call}", file=sys.stderr, flush=True)
"""


@pytest.mark.slow
def test_other_commands_print_only_their_output_one_after_another(samples):
    """In one process, because the start takes most of a command's time."""
    calls = {name: call for name, call in CALLS.items() if name not in (*ALONE, "study")}
    done = subprocess.run(
        [sys.executable, *STRICT, "-c", ONE_AFTER_ANOTHER, *calls.values()],
        cwd=samples,
        capture_output=True,
        text=True,
        timeout=HANG,
    )
    said = "".join(f"{NOTICES.get(name, '')}== 0 {re.escape(calls[name])}\n" for name in calls)
    assert re.fullmatch(said, re.sub(SLOWNESS, "", done.stderr.replace(SOURCES, ""))), done.stderr
    assert done.returncode == 0
    assert "Warning" not in done.stdout


@pytest.mark.slow
@pytest.mark.parametrize("words", FURTHER)
def test_variants_print_nothing(words, samples):
    done = in_a_process(*words.split(), cwd=samples, options=STRICT)
    assert (done.returncode, done.stderr.removeprefix(SOURCES)) == (0, "")


@pytest.mark.parametrize("name", ["agent", "list", "run"])
def test_a_closed_pipe_ends_a_command_silently(name, samples):
    words = {**CALLS, "run": "run short.trial.yaml"}[name]
    reader, writer = os.pipe()
    os.close(reader)
    done = subprocess.run(
        command_line(*words.replace(" --trace", "").split()),
        cwd=samples,
        stdout=writer,
        stderr=subprocess.PIPE,
        timeout=HANG,
    )
    os.close(writer)
    assert done.stderr.removeprefix(SOURCES.encode()) == b""


def test_ctrl_c_ends_a_command_in_silence(samples):
    process = started("agent", "forever.asl", "--until", "1e9", cwd=samples)
    process.stdout.readline()
    process.send_signal(signal.SIGINT)
    _, said = process.communicate(timeout=HANG)
    assert (process.returncode, said) == (130, "")


STOPPED_WHILE_LOADED = """
import signal
import sys
from pathlib import Path
try:
    signal.raise_signal(signal.SIGINT)
    Path("loaded").touch()
except KeyboardInterrupt:
    print("it came inside of an import", file=sys.stderr)
def stands(gantry):
    while True:
        yield gantry.wait(1.0)
"""


def test_ctrl_c_waits_for_imports(tmp_path):
    """Compiled packages print tracebacks if Ctrl-C interrupts their import."""
    (tmp_path / "heavy.py").write_text(STOPPED_WHILE_LOADED)
    (tmp_path / "heavy.trial.yaml").write_text(
        "floorplan: ariac2023\nduration: 1.0e+6\ngantry: {controller: 'heavy:stands'}\n"
    )
    done = in_a_process("run", "heavy.trial.yaml", cwd=tmp_path)
    assert done.returncode == 130
    assert (tmp_path / "loaded").exists()
    assert "inside of an import" not in done.stderr
    assert "Traceback" not in done.stderr
