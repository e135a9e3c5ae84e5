"""Programs with expected lines of output, and traces of a person's actions."""

import json
import re
import subprocess
import sys
from pathlib import Path

import pytest

import bdi

PROGRAMS = sorted((Path(__file__).parent / "programs").glob("*.asl"))

# Programs, societies and traces of a person's actions, with what Jason 3.3 prints.
REFERENCE = Path(__file__).parent / "reference"

DEVIATIONS = Path(__file__).parents[2] / "docs" / "deviations.md"
# Programs and societies that deviate from Jason according to the table of deviations.
DEVIATING = set(
    re.findall(r"`(\w\d+)`", DEVIATIONS.read_text(encoding="utf-8").partition("## AgentSpeak")[2])
)

# Actions of this functor fail in the programs here.
FAILING = "jump"


def run_out(program, limit=1000, actions=False):
    """Return the lines that a program prints, with its external actions if `actions` is true."""
    lines = []

    def act(action):
        if actions:
            lines.append(f"action {action}")
        return action.functor != FAILING

    agent = bdi.Agent(program, act=act, print=lines.append)
    agent.advance(0.0)
    for _ in range(limit):
        if agent.next_wakeup is None:
            return "\n".join(lines).splitlines()
        agent.advance(agent.next_wakeup)
    raise AssertionError("the program does not end")


@pytest.mark.parametrize("path", PROGRAMS, ids=lambda path: path.stem)
def test_programs_print_the_expected_lines(path):
    expected = path.with_suffix(".out").read_text(encoding="utf-8").splitlines()
    assert run_out(bdi.parse_file(path)) == expected


@pytest.mark.parametrize(
    "path", sorted((REFERENCE / "programs").glob("*.asl")), ids=lambda path: path.stem
)
def test_reference_programs_behave_as_in_jason(path):
    expected = path.with_suffix(".out").read_text(encoding="utf-8").splitlines()
    actions = any(line.startswith("action ") for line in expected)
    printed = run_out(bdi.parse_file(path), actions=actions)
    if path.stem.partition("_")[0] in DEVIATING:
        assert printed != expected, "it runs as in Jason: take it off the table of deviations"
    else:
        assert printed == expected


@pytest.mark.parametrize(
    "output", sorted((REFERENCE / "societies").glob("*.out")), ids=lambda path: path.stem
)
def test_reference_societies_behave_as_in_jason(output):
    lines, society = [], bdi.Society()
    for path in sorted(output.parent.glob(f"{output.stem}-*.asl")):
        name = path.stem.partition("-")[2]

        def say(line, name=name):
            lines.append(f"{name}: {line}")

        bdi.Agent(bdi.parse_file(path), name=name, society=society, print=say)
    society.advance(20.0)
    expected = output.read_text(encoding="utf-8").splitlines()
    # Only the lines of each agent are ordered.
    assert sorted(lines, key=lambda line: line.split(":")[0]) == expected


def replay(trace):
    """Return the actions and lines of an agent that receives the percepts of a trace."""
    actions, prints = [], []

    def act(action):
        actions.append({"t_ms": round(agent.now * 1000), "action": str(action)})
        return True

    def say(text):
        prints.append({"t_ms": round(agent.now * 1000), "text": text})

    program = bdi.parse_file(REFERENCE / "operator" / trace["program"])
    agent = bdi.Agent(program, beliefs=[trace["belief"]], act=act, print=say)
    for time in sorted({change["t_ms"] for change in trace["percepts"]}):
        for change in trace["percepts"]:
            if change["t_ms"] == time and "add" in change:
                agent.add_percept(change["add"])
            elif change["t_ms"] == time:
                agent.remove_percept(change["remove"])
        agent.advance(time / 1000)
    agent.advance(trace["end_ms"] / 1000)
    return actions, prints


def test_reference_traces_are_reproduced():
    paths = sorted((REFERENCE / "traces").glob("*.json"))
    assert paths
    for path in paths:
        trace = json.loads(path.read_text(encoding="utf-8"))
        assert replay(trace) == (trace["actions"], trace["prints"]), path.name


def test_the_command_replays_a_trace(floorwalker, tmp_path):
    for name in ("helpful_flip", "antagonistic_detect_arrive_resume"):
        trace = json.loads((REFERENCE / "traces" / f"{name}.json").read_text(encoding="utf-8"))
        script = tmp_path / "script.jsonl"
        lines = []
        for change in trace["percepts"]:
            how = "add" if "add" in change else "remove"
            lines.append(json.dumps({"t": change["t_ms"] / 1000, how: change[how]}))
        script.write_text("\n".join(lines), encoding="utf-8")
        done = floorwalker(
            *("agent", REFERENCE / "operator" / trace["program"]),
            *("--belief", trace["belief"], "--percepts", script),
            *("--until", trace["end_ms"] / 1000),
        )
        assert done.returncode == 0, done.stderr
        written = [json.loads(line) for line in done.stdout.splitlines()]
        expected = [
            {"t": entry["t_ms"] / 1000, "action": entry["action"]} for entry in trace["actions"]
        ]
        assert [entry for entry in written if "action" in entry] == expected
        printed = [{"t": e["t_ms"] / 1000, "print": e["text"]} for e in trace["prints"]]
        assert [entry for entry in written if "print" in entry] == printed


def test_the_command_runs_until_the_agent_is_idle(floorwalker):
    done = floorwalker("agent", PROGRAMS[0])
    expected = PROGRAMS[0].with_suffix(".out").read_text(encoding="utf-8").splitlines()
    assert [json.loads(line)["print"] for line in done.stdout.splitlines()] == expected


def test_the_command_warns_of_actions_that_do_not_exist(tmp_path):
    program = tmp_path / "one.asl"
    program.write_text("!go.\n+!go <- .nosuch(1).\n-!go[error(E)] <- .print(E).", "utf-8")
    # In this process, pytest would take the warning.
    command = [sys.executable, "-m", "floorwalker", "agent", program]
    done = subprocess.run(command, capture_output=True, text=True)
    assert (done.returncode, done.stdout) == (0, '{"t": 0.0, "print": "action_failed"}\n')
    assert f"{program}:2:9: there is no internal action .nosuch" in done.stderr


def test_a_trace_of_the_inside_goes_to_stderr(floorwalker, tmp_path):
    program = tmp_path / "one.asl"
    program.write_text("!start. +!start <- step; .wait(1500); .print(later).", encoding="utf-8")
    done = floorwalker("agent", program, "--trace")
    assert '{"t": 0.0, "action": "step"}' in done.stdout
    assert re.search(r"1\.500 +print +later", done.stderr)
    assert "one.asl:1" in done.stderr


@pytest.mark.parametrize(
    ("line", "message"),
    [
        ('{"t": 1}', '"add" or "remove"'),
        ('{"t": 1, "add": "a", "remove": "b"}', '"add" or "remove"'),
        ('{"t": 1, "add": "a", "x": 2}', '"add" or "remove"'),
        ('{"t": "soon", "add": "a"}', "number of seconds"),
        ('{"t": NaN, "add": "a"}', "number of seconds"),
        ('{"t": -1, "add": "a"}', "must be 0 or more"),
        ('{"t": 1, "add": 3}', "in quotes"),
        ('{"t": 1, "add": "a("}', "a("),
        ("percept", "not a line of JSON"),
        ("[]", '"add" or "remove"'),
    ],
)
def test_an_invalid_line_of_a_script_is_reported(tmp_path, floorwalker, line, message):
    script = tmp_path / "script.jsonl"
    script.write_text('{"t": 0.5, "add": "fine"}\n\n' + line + "\n", encoding="utf-8")
    (tmp_path / "idle.asl").write_text("+fine <- true.\n")
    wrong = floorwalker("agent", tmp_path / "idle.asl", "--percepts", script)
    assert wrong.returncode == 1
    assert f"{script}:3: " in wrong.stderr and message in wrong.stderr
