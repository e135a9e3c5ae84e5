"""Faulty clients disturb no others, use bounded memory, and leave the recording complete."""

import json
import random
import re
import socket
import struct
import threading
from pathlib import Path

import pytest
from bridge_parts import LONGEST_QUEUE, Client, Command, Ledger, require_whole, served, trial
from waiting import HANG, until
from websockets.client import ClientProtocol
from websockets.exceptions import ConnectionClosed
from websockets.uri import parse_uri

import sim

SOUND = ("/clock", "/ariac_human/state", "/tf", "/joint_states")


@pytest.fixture(scope="module")
def busy(tmp_path_factory):
    """Session for misbehaving clients, and the folder of its recording."""
    folder = tmp_path_factory.mktemp("recording") / "run"
    recording = sim.Recording(folder)
    a_trial = trial("indifferent", duration=1e6)
    with served(a_trial, recording, speed=20.0) as session:
        session.folder = folder
        yield session
    run = session.workcell.simulation.finish()
    recording.finish(run)
    require_whole(folder)


def require_undisturbed(session):
    """Require that another client gets every tick."""
    with Client(session.url) as client:
        client.subscribe("/clock")
        stamps = [client.message("/clock")["clock"] for _ in range(20)]
        tenths = [stamp["sec"] * 10 + stamp["nanosec"] // 100_000_000 for stamp in stamps]
        assert tenths == list(range(tenths[0], tenths[0] + 20))


def test_a_message_of_3_mb_is_rejected_and_its_sender_stays_connected(busy):
    with Client(busy.url) as client:
        client.socket.send(json.dumps({"op": "publish", "topic": "/x", "msg": "x" * 3_000_000}))
        assert "is the maximum" in client.error()["msg"]
        assert client.call("/rosapi/nodes")[0]
    require_undisturbed(busy)


def test_a_message_that_is_longer_still_ends_the_connection(busy):
    with Client(busy.url) as client, pytest.raises(ConnectionClosed):
        client.socket.send("x" * 5_000_000)
        client.socket.recv(HANG)
    require_undisturbed(busy)


@pytest.mark.slow
def test_ten_thousand_topics_are_too_many(busy):
    before = len(busy.exchange.topics)
    with Client(busy.url) as client:
        for k in range(10_000):
            client.send(op="advertise", topic=f"/topic{k}", type="std_msgs/Bool")
            if k % 100 == 99:
                client.call("/rosapi/nodes")
        client.send(op="subscribe", topic="/one_more", type="std_msgs/Bool", id="one more")
        complaint = client.error()
        assert "1000 topics of clients are the maximum" in complaint["msg"]
        assert len(busy.exchange.topics) <= before + 1000
    until(lambda: len(busy.exchange.topics) <= before)
    assert len(busy.exchange.topics) == before
    require_undisturbed(busy)


def test_a_client_that_never_reads_does_not_delay_others(busy):
    lazy = Client(busy.url, max_queue=1)
    with lazy:
        lazy.subscribe(*SOUND, queue_length=1_000_000)
        for _ in range(3):
            require_undisturbed(busy)
        clients = busy.do(lambda: list(busy.session.server.clients))
        assert all(client.account.held <= Ledger().most_for_one for client in clients)
        assert max(len(client.outbox) for client in clients) <= len(SOUND) * LONGEST_QUEUE


def test_a_client_that_calls_and_never_reads_is_disconnected(busy):
    lazy = Client(busy.url, max_queue=1)
    with pytest.raises(ConnectionClosed), lazy:
        for _ in range(1_000_000):
            lazy.send(op="call_service", service="/rosapi/topics")
    require_undisturbed(busy)


def test_half_open_connections_do_not_disturb_other_clients(busy):
    host, port = busy.url.removeprefix("ws://").split(":")
    quiet = []
    for beginning in (b"", b"GET / HTTP/1.1\r\nHost: x\r\n", b"\x00\xff" * 100, b"GET /\r\n\r\n"):
        half = socket.create_connection((host, int(port)))
        half.sendall(beginning)
        quiet.append(half)
    # Reset the connection without a close frame, as a client that is switched off does.
    abrupt = socket.create_connection((host, int(port)))
    protocol = ClientProtocol(parse_uri(busy.url))
    protocol.send_request(protocol.connect())
    abrupt.sendall(b"".join(protocol.data_to_send()))
    protocol.receive_data(abrupt.recv(65536))
    for topic in SOUND:
        protocol.send_text(json.dumps({"op": "subscribe", "topic": topic}).encode())
    abrupt.sendall(b"".join(protocol.data_to_send()))
    abrupt.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, struct.pack("ii", 1, 0))
    abrupt.close()
    require_undisturbed(busy)
    for half in quiet:
        half.close()


SAMPLES = Path(__file__).parents[1] / "damaged_files" / "samples" / "to_server.jsonl"
ODDITIES = ["", "null", "-1", "1e308", "NaN", "[]", "{}", '"none"', '"', "}", "9" * 400, "\ud800"]
FUZZED = """
floorplan: ariac2023
duration: 100000.0
people: [{name: operator, personality: external}]
gantry: {controller: external}
"""


def random_message(chances):
    """Return a valid message, one with odd values, or random bytes."""
    if chances.random() < 0.1:
        return chances.randbytes(chances.randint(0, 200))
    text = chances.choice(SAMPLES.read_text().splitlines())
    for value in chances.sample(re.findall(r'"[^"]*"|[-\d.]+', text), chances.choice([0, 1, 1, 3])):
        text = text.replace(value, chances.choice(ODDITIES), 1)
    return text.encode("utf-8", "surrogatepass")


def fuzz(url, seed, over):
    """Connect, send random messages and disconnect in different ways until the session ends."""
    chances = random.Random(seed)
    while not over.is_set():
        try:
            with Client(url, max_queue=chances.choice([1, 16])) as client:
                for _ in range(chances.randint(1, 2000)):
                    client.socket.send(random_message(chances), text=chances.random() < 0.8)
                    if chances.random() < 0.05:
                        client.socket.recv(0.01)
                    if over.is_set():
                        break
                if chances.random() < 0.3:
                    client.socket.socket.close()
        except (ConnectionClosed, OSError):
            continue


@pytest.mark.slow
def test_random_messages_of_several_clients_do_not_disturb_others(tmp_path):
    (tmp_path / "fuzzed.yaml").write_text(FUZZED)
    with Command(tmp_path, "fuzzed.yaml", "--speed", "5") as server, Client(server.url) as good:
        good.subscribe("/ariac/start_human", "/clock")
        type_ = "trajectory_msgs/JointTrajectory"
        good.send(op="advertise", topic="/gantry_controller/joint_trajectory", type=type_)
        good.message("/clock")
        before = resident(server.process.pid)
        over = threading.Event()
        fuzzers = [
            threading.Thread(target=fuzz, args=(server.url, seed, over)) for seed in range(3)
        ]
        for fuzzer in fuzzers:
            fuzzer.start()
        peak = before
        try:
            for tick in range(300):  # 30 s at five times the speed
                good.message("/clock")
                if tick % 50 == 0:
                    peak = max(peak, resident(server.process.pid))
        finally:
            over.set()
            for fuzzer in fuzzers:
                fuzzer.join()
        assert server.process.poll() is None, server.notices
        assert peak - before < 200e6
        assert server.interrupt() == 130
    assert not [line for line in server.notices if "Traceback" in line or "Error" in line]
    require_whole(tmp_path / "out")


def resident(pid):
    """Return the memory of a process in bytes."""
    status = Path(f"/proc/{pid}/status")
    if not status.exists():
        return 0
    return int(re.search(r"VmRSS:\s+(\d+)", status.read_text()).group(1)) * 1024
