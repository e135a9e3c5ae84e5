"""The command `floorwalker bridge`: both ends of a bridge, and the messages for errors."""

import json
from urllib.request import Request, urlopen

import pytest
from bridge_parts import Client, Command, relay, require_whole

import sim

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


def test_both_ends_of_a_bridge(folder):
    with Command(folder, "outside.yaml", "--speed", "0") as server:
        connect = ("--connect", server.url, "--personality", "indifferent")
        with Command(folder, "outside.yaml", *connect) as agent:
            code, output = agent.finish()
        assert (code, agent.notices) == (0, [f"connected to {server.url}"])
        actions = [json.loads(line) for line in output.splitlines()]
        assert actions[0] == {"t": 0.0, "action": "move(-10.8,-3.75,0)"}
        code, report = server.finish()
    assert code == 0, server.notices
    # The time spent waiting depends on how soon the agent connects.
    alone = "stands still at t = 0.0 s: there is no agent"
    assert [notice for notice in server.notices[1:] if notice != alone] == ["the trial begins"]
    assert "station4" in report
    require_whole(folder / "out")


def test_an_interrupted_run_is_recorded_with_the_commands_from_its_page(folder):
    options = ("--duration", "1e6", "--speed", "20", "--grace", "0", "--watch", "--no-open")
    with Command(folder, "outside.yaml", *options) as server:
        with Client(server.url) as agent:
            agent.subscribe("/ariac/start_human", "/clock")
            agent.hear_until(lambda said: said["topic"] == "/clock" and said["msg"]["clock"]["sec"])
            words, _, page = server.notices[0].rpartition(" ")
            assert words == "The run is shown live at"
            command = {"send": "operator", "to": "station1"}
            wish = json.dumps({"command": command}).encode()
            kind = {"Content-Type": "application/json"}
            with urlopen(Request(f"{page}control", wish, kind)) as answer:
                at = json.load(answer)["t"]
            done = folder / "out" / "commands.yaml"
            server.wait_for(done.exists)
        server.wait_for(lambda: "stands still at t = 0.0" not in server.notices[-1])
        assert server.interrupt() == 130
    require_whole(folder / "out")
    again = sim.Trial.parse(f"{OUTSIDE}commands: {done}\n")
    assert [(one.time, one.send) for one in again.commands] == [(at, "operator")]
    assert "The recording up to then is kept" in server.notices[-1]


def test_errors_are_reported_and_leave_no_folder_behind(folder, floorwalker):
    with relay() as url:
        taken = url.rpartition(":")[2]
        for arguments, code, words in (
            (["outside.yaml", "--port", taken], 1, f"can't serve at 127.0.0.1:{taken}"),
            (["outside.yaml", "--speed", "-1"], 2, "--speed: must be 0 or more, not -1"),
            (["outside.yaml", "--port", "70000"], 2, "--port"),
            (["outside.yaml", "--connect", url], 1, "say with --personality"),
            (
                ["outside.yaml", "--connect", url, "--watch"],
                2,
                "--watch: cannot be combined with --connect",
            ),
            (["--connect", "ws://127.0.0.1:1"], 1, "can't connect to ws://127.0.0.1:1"),
            (["--connect", "nonsense"], 1, "nonsense is not an address"),
        ):
            done = floorwalker("bridge", *arguments, cwd=folder)
            assert (done.returncode, done.stdout) == (code, ""), done.stderr
            assert words in done.stderr
            assert "Traceback" not in done.stderr
    assert [path.name for path in folder.iterdir()] == ["outside.yaml"]


def test_another_host_is_served_with_a_notice(folder, floorwalker):
    options = ("--host", "0.0.0.0", "--port", "0", "--personality", "indifferent")
    done = floorwalker("bridge", "outside.yaml", *options, "--duration", "0.1", cwd=folder)
    warning, address, *_ = done.stderr.splitlines()
    assert "anyone who can reach 0.0.0.0 can control" in warning
    assert address.startswith("serving ws://0.0.0.0:")
