"""The command `floorwalker bridge`: both ends of it, and what it says when something is wrong."""

import json
import re
import subprocess
import sys
import threading

import pytest
from bridge_parts import Client, relay, require_whole

OUTSIDE = """
floorplan: ariac2023
duration: 30.0
people: [{name: operator, personality: external}]
gantry: {at: [-2.5, 0.5, 0.0]}
expect: {visits: [station4, station2]}
"""


@pytest.fixture
def folder(tmp_path):
    (tmp_path / "outside.yaml").write_text(OUTSIDE)
    return tmp_path


def begin(folder, *arguments):
    return subprocess.Popen(
        [sys.executable, "-m", "sim.cli", "bridge", *arguments],
        cwd=folder,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )


def run(folder, *arguments):
    process = begin(folder, *arguments)
    output, notices = process.communicate(timeout=60)
    return process.returncode, output, notices


def test_both_ends_of_a_bridge(folder):
    server = begin(folder, "outside.yaml", "--speed", "0", "--port", "0", "--out", "out")
    url = re.fullmatch(r"serving (ws://127\.0\.0\.1:\d+)\n", server.stderr.readline()).group(1)
    code, output, notices = run(
        folder, "outside.yaml", "--connect", url, "--personality", "indifferent"
    )
    assert (code, notices) == (0, f"connected to {url}\n")
    actions = [json.loads(line) for line in output.splitlines()]
    assert actions[0] == {"t": 0.0, "action": "move(-10.8,-3.75,0)"}
    report, notices = server.communicate(timeout=60)
    assert server.returncode == 0, notices
    # Whether it had time to stand still depends on how soon the agent came.
    alone = "stands still at t = 0.0 s: there is no agent\n"
    assert notices.removeprefix(alone) == "the trial begins\n"
    assert "station4" in report
    require_whole(folder / "out")


def test_a_run_that_is_interrupted_is_kept(folder):
    server = begin(folder, "outside.yaml", "--port", "0", "--speed", "20", "--out", "out")
    notices = []
    url = server.stderr.readline().split()[-1]
    listening = threading.Thread(target=lambda: notices.extend(server.stderr), daemon=True)
    listening.start()
    with Client(url) as agent:
        agent.subscribe("/ariac/start_human", "/clock")
        agent.hear_until(lambda said: said["topic"] == "/clock" and said["msg"]["clock"]["sec"])
    while not any("stands still at t = 0.0" not in text for text in notices[1:]):
        listening.join(0.05)
    server.send_signal(2)
    assert server.wait(30) == 130
    listening.join(10)
    server.stdout.close()
    server.stderr.close()
    require_whole(folder / "out")
    assert "what happened is kept" in notices[-1]


def test_what_is_wrong_is_told_and_leaves_no_folder_behind(folder, floorwalker):
    with relay() as url:
        taken = url.rpartition(":")[2]
        for arguments, code, told in (
            (["outside.yaml", "--port", taken], 1, f"can't serve at 127.0.0.1:{taken}"),
            (["outside.yaml", "--speed", "-1"], 2, "must be 0 or more, not -1"),
            (["outside.yaml", "--port", "70000"], 2, "--port"),
            (["outside.yaml", "--connect", url], 1, "say with --personality"),
            (["--connect", "ws://127.0.0.1:1"], 1, "can't connect to ws://127.0.0.1:1"),
            (["--connect", "nonsense"], 1, "nonsense is no address"),
        ):
            done = floorwalker("bridge", *arguments, cwd=folder)
            assert (done.returncode, done.stdout) == (code, ""), done.stderr
            assert told in done.stderr
            assert "Traceback" not in done.stderr
    assert [path.name for path in folder.iterdir()] == ["outside.yaml"]


def test_another_host_is_served_with_a_notice(folder):
    server = begin(folder, "outside.yaml", "--host", "0.0.0.0", "--port", "0", "--out", "out")
    first, second = server.stderr.readline(), server.stderr.readline()
    server.send_signal(2)
    assert server.wait(30) == 130
    server.stdout.close()
    server.stderr.close()
    assert "everybody who can reach 0.0.0.0 can take part" in first
    assert second.startswith("serving ws://0.0.0.0:")
