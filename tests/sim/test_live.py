"""A run in the browser while it goes on, and the server behind it."""

import http.client
import json
import signal
import socket
import subprocess
import sys
import threading
import urllib.parse

import pytest
from test_command import environment

import sim
from sim.live.page_server import PageServer, Stream


def get(server, path="/", method="GET", **headers):
    place = urllib.parse.urlsplit(server.url)
    connection = http.client.HTTPConnection(place.hostname, place.port, timeout=30)
    connection.request(method, path, headers=headers)
    return connection.getresponse()


def messages(response):
    """The data of the server-sent events in a response, with the kind of each."""
    for block in response.read().decode().split("\n\n"):
        fields = dict(line.split(": ", 1) for line in block.splitlines() if ": " in line)
        if "data" in fields:
            yield fields["event"], json.loads(fields["data"])


# ── the server ──


def test_a_page_is_served_to_this_machine_only():
    with PageServer(lambda: "<p>ä</p>") as server:
        response = get(server)
        assert response.status == 200
        assert response.read().decode() == "<p>ä</p>"
        assert get(server, "/elsewhere").status == 404
        assert get(server, "/stream").status == 404
        for host in ("evil.example:80", "127.0.0.1.evil.example:80", ""):
            assert get(server, Host=host).status == 403, host
        port = urllib.parse.urlsplit(server.url).port
        with pytest.raises(OSError), socket.create_connection((_other_address(), port), 2):
            pass


def _other_address():
    """An address of this machine that is not loopback's 127.0.0.1."""
    return "127.0.0.2"


def test_head_is_answered_with_the_headers_alone():
    with PageServer(lambda: "<p>ä</p>", stream=Stream()) as server:
        for path, kind in (("/", "text/html; charset=utf-8"), ("/stream", "text/event-stream")):
            response = get(server, path, "HEAD")
            assert (response.status, response.getheader("Content-Type")) == (200, kind)
            assert response.read() == b""
        assert get(server, "/", "HEAD").getheader("Content-Length") == "9"
        assert get(server, "/", "HEAD", Host="evil.example").status == 403


def test_a_port_that_is_taken_is_said():
    with PageServer(lambda: "") as server:
        port = urllib.parse.urlsplit(server.url).port
        with pytest.raises(OSError, match=f"can't serve at 127.0.0.1:{port}: "):
            PageServer(lambda: "", port=port)


def test_a_late_reader_gets_every_message_and_one_who_comes_back_the_rest():
    stream = Stream()
    for k in range(3):
        stream.send(json.dumps(k))
    with PageServer(lambda: "", stream=stream) as server:
        late = get(server, "/stream")
        assert late.getheader("Content-Type") == "text/event-stream"
        stream.send("3", event="finished")
        stream.close()
        expected = [("message", 0), ("message", 1), ("message", 2), ("finished", 3)]
        assert list(messages(late)) == expected
        assert list(messages(get(server, "/stream", **{"Last-Event-ID": "1"}))) == expected[2:]


def test_messages_come_as_they_are_sent():
    stream = Stream()
    got = stream.messages()
    thread = threading.Thread(target=lambda: stream.send("1"))
    thread.start()
    assert b"data: 1" in next(got)
    thread.join()
    assert stream.wait_for_reader(0)
    stream.close()
    assert list(got) == []
    assert stream.wait_until_read(0)


# ── the run ──


TRIAL = """
floorplan: ariac2023
duration: 40
people: [{name: operator, personality: antagonistic}]
gantry: {controller: oblivious, jobs: [{pick: bin2, place: agv1, part: purple pump}]}
agvs: {agv2: [{time: 3.0, to: assembly_back}]}
"""


def watched(trial, speed, meanwhile=lambda server: None):
    """The run of a trial that is watched, and what came over the stream."""
    live = sim.LiveRun(trial.duration, speed=speed)
    with live.server as server:
        simulation = sim.Simulation(trial, live)
        simulation.start()
        meanwhile(server)
        response = get(server, "/stream")
        live.advance(simulation)
        run = simulation.finish()
        live.finish(run)
        return run, list(messages(response))


def test_a_watched_run_is_the_same_run():
    trial = sim.Trial.parse(TRIAL)
    run, told = watched(trial, speed=100.0)
    plain = sim.run(trial)
    assert run.events == plain.events
    events = [data["event"] for kind, data in told if kind == "message" and "event" in data]
    assert events == list(run.events)
    kind, whole = told[-1]
    assert kind == "finished"
    assert whole["events"] == list(run.events)


def test_the_plans_that_are_told_add_up_to_the_motions():
    run, told = watched(sim.Trial.parse(TRIAL), speed=100.0)
    pieces = {name: [] for name in run.motions}
    for kind, data in told:
        if kind == "message" and "motion" in data:
            mine, new = pieces[data["motion"]["body"]], data["motion"]["pieces"]
            while mine and mine[-1][0] >= new[0][0]:
                mine.pop()
            if mine:
                mine[-1][1] = min(mine[-1][1], new[0][0])
            mine.extend(new)
    for name, motion in run.motions.items():
        for k in range(400):
            t = k * 0.1 + 0.003
            [*_, piece] = [piece for piece in pieces[name] if piece[0] <= t]
            u = min(t, piece[1]) - piece[0]
            at = [sum(c * u**n for n, c in enumerate(axis)) for axis in piece[2:4]]
            assert at == pytest.approx(motion.position(t), abs=1e-6), (name, t)


@pytest.mark.parametrize("speed", [0.0, -1.0, float("inf"), float("nan")])
def test_a_speed_that_makes_no_sense_is_refused(speed):
    with pytest.raises(ValueError, match="speed must be more than 0"):
        sim.LiveRun(10.0, speed=speed)


def test_the_browser_follows_the_run_and_gets_all_of_it(open_address):
    trial = sim.Trial.parse(TRIAL)
    live = sim.LiveRun(trial.duration, speed=20.0)
    with live.server as server:
        simulation = sim.Simulation(trial, live)
        simulation.start()
        viewer = open_address(server.url)
        seen = []
        running = threading.Thread(target=live.advance, args=(simulation,))
        running.start()
        viewer.wait_until(lambda: viewer.time > 10.0)
        seen.append(viewer.page.evaluate("floorwalker.recording.events.length"))
        assert viewer.page.locator("#live").get_attribute("aria-pressed") == "true"
        assert viewer.time <= simulation.clock.now + 1e-9
        running.join()
        run = simulation.finish()
        live.finish(run)
        viewer.wait_until(lambda: viewer.text("#subtitle") == "the run is over")
    assert 0 < seen[0] <= len(run.events)
    shown = viewer.page.evaluate("floorwalker.recording")
    assert shown["events"] == json.loads(json.dumps(run.events))
    assert viewer.page.locator("#live").is_hidden()
    viewer.seek(21.0)
    for name, motion in run.motions.items():
        pose = viewer.page.evaluate("n => floorwalker.pose(n, 21.0)", name)
        assert (pose["x"], pose["y"]) == pytest.approx(motion.position(21.0), abs=1e-6)
    assert viewer.complaints == []


def test_looking_back_while_it_goes_on(open_address):
    trial = sim.Trial.parse(TRIAL)
    live = sim.LiveRun(trial.duration, speed=10.0)
    with live.server as server:
        simulation = sim.Simulation(trial, live)
        simulation.start()
        viewer = open_address(server.url)
        running = threading.Thread(target=live.advance, args=(simulation,))
        running.start()
        viewer.wait_until(lambda: viewer.time > 5.0)
        speeds = viewer.page.locator("#speed")
        assert speeds.input_value() == "10"
        offered = [float(text.rstrip("×")) for text in speeds.inner_text().split()]
        assert offered == sorted({*offered, 8.0, 10.0, 16.0})
        viewer.page.keyboard.press("Home")
        viewer.page.keyboard.press("Space")
        viewer.settle()
        stopped = viewer.time
        assert stopped < 5.0
        assert viewer.page.locator("#live").get_attribute("aria-pressed") == "false"
        viewer.page.locator("#live").click()
        viewer.wait_until(lambda: viewer.time > 6.0)
        viewer.context.close()  # a closed browser does not stop the run
        running.join()
        assert simulation.clock.now == trial.duration
        live.finish(simulation.finish())


def start(arguments, folder):
    command = [sys.executable, "-m", "sim.cli", *arguments]
    return subprocess.Popen(
        command,
        cwd=folder,
        env=environment(),
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )


def test_ctrl_c_keeps_what_was_recorded(tmp_path):
    arguments = ["run", "--watch", "--no-open", "--speed", "20", "--out", str(tmp_path / "run")]
    process = start(arguments, tmp_path)
    assert process.stderr.readline().startswith("http://127.0.0.1:")
    events = tmp_path / "run" / "events.jsonl"
    while '"arrived"' not in events.read_text(encoding="utf-8"):
        assert process.poll() is None
    process.send_signal(signal.SIGINT)
    _, err = process.communicate(timeout=60)
    assert process.returncode == 130
    assert err.startswith("Stopped at t = ")
    assert "Traceback" not in err
    assert sim.load_run(tmp_path / "run").duration > 0
    assert (tmp_path / "run" / "replay.html").exists()


def test_replay_serves_until_it_is_told_to_stop(tmp_path):
    recording = sim.Recording(tmp_path / "run")
    recording.finish(sim.run(sim.Trial.parse(TRIAL), recording))
    process = start(["replay", "run", "--serve", "--no-open"], tmp_path)
    url = process.stdout.readline().strip()
    place = urllib.parse.urlsplit(url)
    connection = http.client.HTTPConnection(place.hostname, place.port, timeout=30)
    connection.request("GET", "/")
    page = connection.getresponse().read().decode()
    assert 'id="recording"' in page
    process.send_signal(signal.SIGINT)
    _, err = process.communicate(timeout=60)
    assert process.returncode == 0
    assert err == "Ctrl-C ends it.\n"
