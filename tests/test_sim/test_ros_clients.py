"""Unmodified rosbridge clients over a real socket: roslibpy and roslibjs."""

import json
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
from bridge_parts import relay, served, trial
from processes import started
from waiting import HANG, until

CLIENTS = Path(__file__).parent / "bridge_clients"
LATE = 1 / 64
"""Seconds of real time after which a client acts on a message."""

ROUND = ["station4", "station2", "station1"]


def python(script, url):
    host, port = url.removeprefix("ws://").split(":")
    return [sys.executable, str(CLIENTS / script), host, port]


def outcome(command, folder=None):
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, timeout=HANG)
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout)


def let_drive(command_for, speed, folder=None, duration=275.0):
    """Run a trial whose person is driven by a client. Return its messages and the run."""
    with served(trial(duration=duration), speed=speed, by_hand=True) as session:
        pipes = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE, "text": True}
        client = subprocess.Popen(command_for(session.url), cwd=folder, **pipes)
        if speed:
            until(lambda: session.accompany(LATE) or client.poll() is not None)
        heard, trouble = client.communicate(timeout=HANG)
        assert client.returncode == 0, trouble
        return json.loads(heard), session.join()


def require_a_whole_session(heard, run, speed):
    """Require 275 s in which the person patrols and is put back for violations.

    At a finite speed the client is late. At speed 0 it never is.
    """
    visits = run.summary["people"]["operator"]["visits"]
    assert heard["reached"] == len(visits)
    assert set(visits) >= set(ROUND)
    assert heard["unsafe"] >= run.summary["penalties"] >= (1 if speed else 5)
    assert heard["topics"] > 15
    assert heard["services"] == 1
    assert run.duration == 275.0
    assert heard["states"] >= 1000
    if not speed:
        assert visits == [ROUND[k % 3] for k in range(35)]
        # The state is published ten times a second, and once more for each decision.
        assert 2750 <= heard["states"] <= 2850


@pytest.mark.slow
def test_roslibpy_drives_the_person_at_fifty_times_the_speed():
    require_a_whole_session(*let_drive(lambda url: python("agent_roslibpy.py", url), 50.0), 50.0)


@pytest.mark.slow
def test_roslibpy_is_never_late_at_speed_0():
    """The client acts at the time of each message, so that every run is the same."""
    runs = [
        let_drive(lambda url: python("agent_roslibpy.py", url), 0.0, duration=40.0)[1]
        for _ in range(2)
    ]
    assert runs[0].events == runs[1].events
    arrived = [event["t"] for event in runs[0].events if event["kind"] == "arrived"]
    went = [event["t"] for event in runs[0].events if event["kind"] == "goal"]
    assert set(arrived) <= set(went)


def test_the_bundled_agent_drives_a_person_of_roslibpy(tmp_path):
    with relay() as url:
        agent = started("bridge", "ariac2023", "--connect", url, cwd=tmp_path)
        goals = outcome(python("simulation_roslibpy.py", url))
        actions, notices = agent.communicate(timeout=HANG)
    assert agent.returncode == 0, notices
    stations = {"4": [-10.8, -3.75], "2": [-10.8, 3.75], "1": [-5.0, 3.75], "3": [-5.0, -3.75]}
    assert goals == [stations[name] for name in "42134"]
    printed = [json.loads(line)["action"] for line in actions.splitlines()]
    assert printed[0] == "move(-10.8,-3.75,0)"
    assert len(printed) == 5
    assert notices == f"connected to {url}\n"


@pytest.fixture(scope="module")
def roslibjs(tmp_path_factory):
    """Folder with roslibjs."""
    if not (shutil.which("node") and shutil.which("npm")):
        pytest.skip("node and npm are not on the path")
    folder = tmp_path_factory.mktemp("roslibjs")
    (folder / "package.json").write_text('{"private": true}')
    done = subprocess.run(
        ["npm", "install", "--no-audit", "--no-fund", "roslib@2"],
        cwd=folder,
        capture_output=True,
        text=True,
    )
    if done.returncode:
        pytest.skip(f"npm can't install roslib here: {done.stderr.strip()[-200:]}")
    return folder


@pytest.mark.slow
@pytest.mark.parametrize("speed", [0.0, 50.0])
def test_roslibjs_drives_the_person(roslibjs, speed):
    def command(url):
        return ["node", str(CLIENTS / "agent_roslibjs.mjs"), url]

    require_a_whole_session(*let_drive(command, speed, roslibjs), speed)
