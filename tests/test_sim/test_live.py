"""A live run in the browser, and its server."""

import http.client
import json
import math
import re
import signal
import socket
import threading
import urllib.parse

import pytest
from bridge_parts import Client, served
from processes import started
from run_events import record
from waiting import HANG, Hand, until

import sim
from sim.live.page_server import MessageStream, PageServer


def get(server, path="/", method="GET", body=None, **headers):
    """Return the response to a request for a path below the address of the server."""
    place = urllib.parse.urlsplit(server.url)
    connection = http.client.HTTPConnection(place.hostname, place.port, timeout=HANG)
    connection.request(method, place.path + path[1:], body, headers)
    return connection.getresponse()


def post(server, wish, **headers):
    """Return the status and the answer to a request of the page."""
    headers = {"Content-Type": "application/json", **headers}
    response = get(server, "/control", "POST", json.dumps(wish).encode(), **headers)
    text = response.read()
    return response.status, json.loads(text) if response.status in (200, 409) else None


def messages(response):
    """Return data and kind of the server-sent events in a response."""
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
    """Return an address of this machine other than 127.0.0.1."""
    return "127.0.0.2"


def test_head_is_answered_with_the_headers_alone():
    with PageServer(lambda: "<p>ä</p>", stream=MessageStream()) as server:
        for path, kind in (("/", "text/html; charset=utf-8"), ("/stream", "text/event-stream")):
            response = get(server, path, "HEAD")
            assert (response.status, response.getheader("Content-Type")) == (200, kind)
            assert response.read() == b""
        assert get(server, "/", "HEAD").getheader("Content-Length") == "9"
        assert get(server, "/", "HEAD", Host="evil.example").status == 403


def test_an_occupied_port_is_reported():
    with PageServer(lambda: "") as server:
        port = urllib.parse.urlsplit(server.url).port
        with pytest.raises(OSError, match=f"can't serve at 127.0.0.1:{port}: "):
            PageServer(lambda: "", port=port)


def test_a_late_reader_gets_every_message_and_a_returning_one_the_rest():
    stream = MessageStream()
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
    stream = MessageStream()
    got = stream.messages()
    thread = threading.Thread(target=lambda: stream.send("1"))
    thread.start()
    assert b"data: 1" in next(got)
    thread.join()
    assert stream.wait_for_reader(0)
    stream.close()
    assert list(got) == []
    assert stream.wait_until_read(0)


def test_only_the_page_itself_has_control():
    wishes = []
    with PageServer(lambda: "", control=lambda wish: wishes.append(wish) or {}) as server:
        port = urllib.parse.urlsplit(server.url).port
        root = f"http://127.0.0.1:{port}"
        assert post(server, {"a": 1}, Origin=root) == (200, {})
        assert post(server, {"a": 2}) == (200, {})  # no browser
        for origin in ("http://evil.example", "null", f"http://127.0.0.1:{port + 1}"):
            assert post(server, 3, Origin=origin)[0] == 403, origin
        assert post(server, 3, Host="evil.example")[0] == 403
        assert post(server, 3, **{"Content-Type": "text/plain"})[0] == 400
        assert (
            get(server, "/control", "POST", b"{", **{"Content-Type": "application/json"}).status
            == 400
        )
        connection = http.client.HTTPConnection("127.0.0.1", port, timeout=HANG)
        for method, path in (("GET", "/"), ("GET", "/stream"), ("POST", "/control")):
            connection.request(method, path)  # without the secret
            response = connection.getresponse()
            response.read()
            assert response.status == 404
    assert wishes == [{"a": 1}, {"a": 2}]


# ── the run ──


TRIAL = """
floorplan: ariac2023
duration: 40
people: [{name: operator, personality: antagonistic}]
gantry: {controller: oblivious, jobs: [{pick: bin2, place: agv1, part: purple pump}]}
agvs: {agv2: [{time: 3.0, to: assembly_back}]}
"""


def watched(trial, speed, meanwhile=lambda server: None):
    """Return the run of a trial that is watched, and the messages of the stream."""
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
    run, sent = watched(trial, speed=100.0)
    plain = sim.run(trial)
    assert run.events == plain.events
    events = [data["event"] for kind, data in sent if kind == "message" and "event" in data]
    assert events == list(run.events)
    kind, whole = sent[-1]
    assert kind == "finished"
    assert whole["events"] == list(run.events)


def test_the_published_plans_add_up_to_the_motions():
    run, sent = watched(sim.Trial.parse(TRIAL), speed=100.0)
    pieces = {name: [] for name in run.motions}
    for kind, data in sent:
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
def test_an_invalid_speed_is_rejected(speed):
    with pytest.raises(ValueError, match="speed must be more than 0"):
        sim.LiveRun(10.0, speed=speed)


# ── control ──


def everything(folder):
    """Return the files of a recording without values that differ between runs."""
    files = {path.name: path.read_bytes() for path in folder.iterdir()}
    summary = json.loads(files.pop("summary.json"))
    return files | {"summary": {k: v for k, v in summary.items() if k not in TIMING}}


TIMING = ("cpu_seconds", "realtime_factor")


def controlled(trial, recording, live, script):
    """Return the run of a trial that a `script` controls through the page server."""
    with live.server as server:
        simulation = sim.Simulation(trial, recording, live)

        def control():
            try:
                script(server, simulation)
            except BaseException:
                simulation.stop()
                raise

        hands = threading.Thread(target=control)
        hands.start()
        live.advance(simulation)
        run = simulation.finish()
        recording.finish(run)
        live.finish(run)
        hands.join()
        return run


def test_commands_from_the_page_repeat_from_a_file(tmp_path):
    trial = sim.Trial.parse(TRIAL)
    box = {"x": [-12.0, -11.0], "y": [1.0, 3.0]}
    answers = []

    hand = Hand()
    live = sim.LiveRun(trial.duration, speed=20.0, now=hand)

    def script(server, simulation):
        def ask(wish):
            answers.append(post(server, wish))

        def reach(t):
            hand.move((t - simulation.clock.now) / live.speed)
            until(lambda: simulation.clock.now == pytest.approx(t))

        reach(4.0)
        ask({"pace": {"paused": True}})
        hand.move(1000.0)
        paused = simulation.clock.now
        for command in (
            {"send": "operator", "to": [-6.5, 5.123456789123]},
            {"block": "pallet", **box},
            {"hold": "agv2"},
        ):
            ask({"command": command})
        ask({"command": {"send": "nobody", "to": "station1"}})
        ask({"command": {"block": "bin2", **box}})
        ask({"command": {"hold": "gantry", "release": "gantry"}})
        ask({"pace": {"speed": 0}})
        ask({"pace": {"speed": "fast"}})
        ask({"leave": True})
        assert simulation.clock.now == paused
        ask({"pace": {"paused": False, "speed": 40.0}})
        reach(12.0)
        ask({"command": {"release": "agv2"}})
        ask({"command": {"clear": "pallet"}})
        ask({"command": {"send": "operator", "to": "station2"}})
        hand.move(trial.duration)

    recording = sim.Recording(tmp_path / "watched")
    run = controlled(trial, recording, live, script)
    problems = [answer["problem"] for status, answer in answers if status == 409]
    assert [problem.split("; ")[0] for problem in problems] == [
        "no person is called 'nobody'",
        "something else is called 'bin2' already",
        "give a time and one of send, block, clear, hold, release",
        "speed must be more than 0, not 0",
        "speed must be a number, not 'fast'",
        "expected a pace or a command: send, block, clear, hold, release",
    ]
    assert sum(status == 200 for status, _ in answers) == 8
    done = [event for event in run.events if event["kind"] == "commanded"]
    assert [event["t"] for event in done] == pytest.approx([4.001] * 3 + [12.001] * 3)
    went = [e for e in run.events if e["kind"] == "goal" and e["t"] == done[-1]["t"]]
    assert [e["station"] for e in went] == ["station2"]
    again = sim.Trial.parse(f"{TRIAL}commands: {tmp_path / 'watched' / 'commands.yaml'}\n")
    record(again, tmp_path / "repeated")
    assert everything(tmp_path / "repeated") == everything(tmp_path / "watched")


@pytest.mark.slow
def test_the_browser_follows_the_run_and_gets_all_of_it(open_address):
    trial = sim.Trial.parse(TRIAL)
    hand = Hand()
    live = sim.LiveRun(trial.duration, speed=20.0, now=hand)
    with live.server as server:
        simulation = sim.Simulation(trial, live)
        simulation.start()
        viewer = open_address(server.url)
        seen = []
        running = threading.Thread(target=live.advance, args=(simulation,), daemon=True)
        running.start()
        hand.move(12.0 / 20.0)
        viewer.wait_until(lambda: viewer.time > 10.0)
        seen.append(viewer.page.evaluate("floorwalker.recording.events.length"))
        assert viewer.page.locator("#live").get_attribute("aria-pressed") == "true"
        assert viewer.time <= simulation.clock.now + 1e-9
        hand.move((trial.duration - 12.0) / 20.0)
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


@pytest.mark.slow
def test_a_viewer_can_look_back_while_the_run_continues(open_address):
    trial = sim.Trial.parse(TRIAL)
    hand = Hand()
    live = sim.LiveRun(trial.duration, speed=10.0, now=hand)
    with live.server as server:
        simulation = sim.Simulation(trial, live)
        simulation.start()
        viewer = open_address(server.url)
        running = threading.Thread(target=live.advance, args=(simulation,), daemon=True)
        running.start()
        hand.move(0.7)
        viewer.wait_until(lambda: viewer.time > 5.0)
        speeds = viewer.page.locator("#speed")
        assert speeds.input_value() == "10"
        offered = [float(text.rstrip("×")) for text in speeds.inner_text().split()]
        assert offered == sorted({*offered, 8.0, 10.0, 16.0})

        def follows():
            viewer.settle()
            return viewer.page.locator("#live").get_attribute("aria-pressed") == "true"

        assert follows()
        viewer.page.keyboard.press("Home")
        assert not follows()
        viewer.page.locator("#live").click()
        assert follows()
        viewer.page.keyboard.press("Space")
        viewer.page.keyboard.press("Home")
        assert not follows()
        assert viewer.time == 0.0
        viewer.page.locator("#live").click()
        viewer.wait_until(lambda: viewer.time > 6.0)
        assert viewer.time <= simulation.clock.now == pytest.approx(7.0)
        viewer.context.close()  # a closed browser does not stop the run
        hand.move(trial.duration / 10.0)
        running.join()
        assert simulation.clock.now == trial.duration
        live.finish(simulation.finish())


@pytest.mark.slow
def test_the_page_commands_the_run(open_address):
    trial = sim.Trial.parse(TRIAL.replace("duration: 40", "duration: 4000"))
    hand = Hand()
    live = sim.LiveRun(trial.duration, speed=2.0, now=hand)
    with live.server as server:
        simulation = sim.Simulation(trial, live)
        simulation.start()
        viewer = open_address(server.url, viewport={"width": 1200, "height": 800})
        page = viewer.page
        running = threading.Thread(target=live.advance, args=(simulation,), daemon=True)
        running.start()

        def wait_until(holds):
            """Advance the run while the condition does not hold."""

            def holds_by_now():
                hand.move(0.02)
                return holds()

            viewer.wait_until(holds_by_now)

        def press(name):
            page.locator(f"#{name}").click()

        def commanded():
            return [e for e in simulation.events if e["kind"] == "commanded"]

        def wait_for(name, words):
            wait_until(lambda: viewer.text(f"#{name}") == words)

        wait_until(lambda: viewer.time > 0.5)
        press("pause-run")
        wait_for("pause-run", "Resume run")
        press("hold")
        wait_for("control-status", "gantry is put on hold.")
        page.locator("#speed").select_option("64")
        wait_until(lambda: live.speed == 64.0)
        press("pause-run")
        wait_for("hold", "Release gantry")
        assert [e["hold"] for e in commanded()] == ["gantry"]
        press("hold")
        wait_for("hold", "Hold gantry")
        wait_for("control-status", "gantry may go on.")

        def on_floor(x, y):
            box = page.locator(".view canvas.flat").bounding_box()
            px, py = page.evaluate("p => floorwalker.place(...p)", [x, y])
            return box["x"] + px, box["y"] + py

        press("block")
        page.mouse.move(*on_floor(-13.0, 0.0))
        page.mouse.down()
        page.mouse.move(*on_floor(-12.0, 2.0), steps=3)
        page.mouse.up()
        wait_for("control-status", "box1 is put down.")
        wait_until(lambda: page.locator("#clear option").count() == 2)
        page.mouse.click(*on_floor(-12.5, 1.0))
        wait_for("control-status", "box1 is taken up.")
        wait_until(lambda: page.locator("#clear").is_hidden())
        page.keyboard.press("Escape")
        page.locator("#send").focus()
        for key in ("Tab", "Enter", *["ArrowLeft"] * 4, *["Shift+ArrowUp"] * 4):
            page.keyboard.press(key)
        assert viewer.text("#placing").startswith("1.00 × 2.00 m at x ")
        assert viewer.text("#control-status") == viewer.text("#placing")  # for screen readers
        where = re.findall(r"[xy] ([\d.−]+)", viewer.text("#placing"))
        middle = [float(metres.replace("−", "-")) for metres in where]
        page.keyboard.press("Enter")
        wait_for("control-status", "box2 is put down.")
        wait_until(lambda: page.locator("#clear option").count() == 2)
        page.keyboard.press("Enter")
        wait_for("control-status", "box2 is taken up.")
        wait_until(lambda: page.locator("#clear").is_hidden())
        page.keyboard.press("Escape")
        assert page.evaluate("document.activeElement.id") == "block"
        press("send")
        page.mouse.click(*on_floor(-9.0, 0.5))
        wait_until(lambda: len(commanded()) == 7)
        press("send")
        page.locator("#destination").select_option("station2")
        wait_until(lambda: len(commanded()) == 8)
        simulation.stop()
        running.join()
        live.finish(simulation.finish())
        viewer.wait_until(lambda: viewer.text("#subtitle") == "the run is over")
    _, _, block, clear, typed, _, send, again = commanded()
    corners = [(-13.0, 0.0), (-12.0, 0.0), (-12.0, 2.0), (-13.0, 2.0)]
    for corner in corners:
        assert min(math.dist(corner, other) for other in block["footprint"]) < 0.1
    assert clear["clear"] == block["block"] == "box1"
    assert sorted(map(tuple, typed["footprint"])) == sorted(
        (x + dx, y + dy) for dx in (-0.5, 0.5) for dy in (-1.0, 1.0) for x, y in [middle]
    )
    assert (send["send"], again["send"]) == ("operator", "operator")
    assert send["to"] == pytest.approx([-9.0, 0.5], abs=0.1)
    station = next(s for s in trial.floorplan.stations if s.name == "station2")
    assert again["to"] == [*station.position]
    assert page.locator("#control").is_hidden()
    assert viewer.complaints == []


@pytest.mark.parametrize("scheme", ["light", pytest.param("dark", marks=pytest.mark.slow)])
def test_a_page_with_control_is_accessible(open_address, axe, scheme):
    """The rules are those of axe-core. A box is placed by keyboard."""
    trial = sim.Trial.parse(TRIAL)
    live = sim.LiveRun(trial.duration)
    with live.server as server:
        sim.Simulation(trial, live).start()
        viewer = open_address(server.url, color_scheme=scheme, reduced_motion="reduce")
        viewer.page.add_script_tag(content=axe)
        viewer.wait_until(lambda: viewer.page.locator("#control").is_visible())
        for name in ("send", "block"):
            viewer.page.locator(f"#{name}").focus()
            viewer.page.keyboard.press("Enter")
            viewer.page.locator("#placing").focus()
            viewer.page.keyboard.press("ArrowLeft")
            report = viewer.page.evaluate("axe.run(document, { resultTypes: ['violations'] })")
            assert [(v["id"], [n["html"] for n in v["nodes"]]) for v in report["violations"]] == []


@pytest.mark.parametrize("speed", [20.0, 0.0])
def test_a_run_on_the_bridge_has_a_page_too(speed):
    trial = sim.Trial.parse(
        TRIAL.replace("oblivious", "external").replace("duration: 40", "duration: 1000000")
    )
    live = sim.LiveRun(trial.duration, speed=speed or 1.0)
    with live.server as server, served(trial, live, speed=speed, viewer=live) as session:
        with Client(session.url) as controller:

            def answer_to(wish):
                status, answer = post(server, wish)
                return answer.get("problem", "") if status == 409 else ""

            def wait_for(words):
                until(lambda: any(words in notice for notice in session.notices))

            wait_for("there is no gantry controller")
            kind = "trajectory_msgs/JointTrajectory"
            controller.send(op="advertise", topic="/gantry_controller/joint_trajectory", type=kind)
            wait_for("the trial begins")
            assert answer_to({"pace": {"paused": True}}) == ""
            wait_for("it is paused on its page")
            paused = session.now
            assert answer_to({"command": {"hold": "agv2"}}) == ""
            assert answer_to({"command": {"send": "operator", "to": [-6.5, 5.0]}}) == ""
            has_speed = answer_to({"pace": {"speed": 40.0}})
            assert has_speed == (
                "" if speed else "the pace depends on the clients, so it has no speed"
            )
            assert session.now == paused
            assert answer_to({"pace": {"paused": False}}) == ""
            wait_for("goes on")
            until(lambda: session.now > paused + 1.0)
            controller.call("/ariac/end_competition")
        run = session.join()
        assert answer_to({"pace": {"paused": True}}) == "the run is over"
        live.finish(run)
    done = [event for event in run.events if event["kind"] == "commanded"]
    assert [(e["t"] > paused, e.get("hold"), e.get("send")) for e in done] == [
        (True, "agv2", None),
        (True, None, "operator"),
    ]


def test_ctrl_c_retains_the_recording(tmp_path):
    arguments = ["run", "--duration", "1e6", "--watch", "--no-open", "--speed", "20"]
    process = started(*arguments, "--out", "run", cwd=tmp_path)
    assert process.stderr.readline().startswith("The run is shown live at http://127.0.0.1:")
    events = tmp_path / "run" / "events.jsonl"
    until(lambda: '"arrived"' in events.read_text(encoding="utf-8"), process)
    process.send_signal(signal.SIGINT)
    _, err = process.communicate(timeout=HANG)
    assert process.returncode == 130
    assert err.startswith("Stopped at t = ")
    assert "Traceback" not in err
    assert sim.load_run(tmp_path / "run").duration > 0
    assert (tmp_path / "run" / "replay.html").exists()


def test_replay_serves_until_an_interrupt(tmp_path):
    record(sim.Trial.parse(TRIAL), tmp_path / "run")
    process = started("replay", "run", "--serve", "--no-open", cwd=tmp_path)
    url = process.stdout.readline().strip()
    place = urllib.parse.urlsplit(url)
    connection = http.client.HTTPConnection(place.hostname, place.port, timeout=HANG)
    connection.request("GET", "/")
    page = connection.getresponse().read().decode()
    assert 'id="recording"' in page
    process.send_signal(signal.SIGINT)
    _, err = process.communicate(timeout=HANG)
    assert process.returncode == 0
    assert err == "Press Ctrl-C to stop.\n"
