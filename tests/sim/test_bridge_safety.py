"""Whatever a client does, nobody else is disturbed, memory is bounded, and the recording whole."""

import json
import socket
import struct
import time

import pytest
from bridge_parts import Client, require_whole, served, trial
from websockets.exceptions import ConnectionClosed

import sim
from sim.bridge.ledger import Ledger
from sim.bridge.outbox import LONGEST_QUEUE

SOUND = ("/clock", "/ariac_human/state", "/tf", "/joint_states")


@pytest.fixture(scope="module")
def busy(tmp_path_factory):
    """One session that goes on while others misbehave, and the folder it is recorded in."""
    folder = tmp_path_factory.mktemp("recording") / "run"
    recording = sim.Recording(folder)
    a_trial = trial("indifferent", duration=3000.0)
    with served(a_trial, recording, speed=20.0) as session:
        session.folder = folder
        yield session
    run = session.workcell.simulation.finish()
    recording.finish(run)
    require_whole(folder)


def require_undisturbed(session):
    """Somebody who does nothing wrong hears every tick."""
    with Client(session.url) as client:
        client.subscribe("/clock")
        stamps = [client.message("/clock")["clock"] for _ in range(20)]
        tenths = [stamp["sec"] * 10 + stamp["nanosec"] // 100_000_000 for stamp in stamps]
        assert tenths == list(range(tenths[0], tenths[0] + 20))


def test_a_message_of_3_mb_is_refused_and_its_sender_stays(busy):
    with Client(busy.url) as client:
        client.socket.send(json.dumps({"op": "publish", "topic": "/x", "msg": "x" * 3_000_000}))
        assert "is the most that is taken" in client.error()["msg"]
        assert client.call("/rosapi/nodes")[0]
    require_undisturbed(busy)


def test_a_message_that_is_longer_still_ends_the_connection(busy):
    with Client(busy.url) as client, pytest.raises(ConnectionClosed):
        client.socket.send("x" * 5_000_000)
        client.socket.recv(10)
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
        assert "1000 topics are the most" in complaint["msg"]
        assert len(busy.exchange.topics) <= before + 1000
    deadline = time.monotonic() + 10
    while len(busy.exchange.topics) > before and time.monotonic() < deadline:
        time.sleep(0.01)
    assert len(busy.exchange.topics) == before
    require_undisturbed(busy)


def test_a_client_that_never_reads_costs_others_nothing(busy):
    lazy = Client(busy.url, max_queue=1)
    with lazy:
        lazy.subscribe(*SOUND, queue_length=1_000_000)
        for _ in range(3):
            require_undisturbed(busy)
        clients = busy.do(lambda: list(busy.session.server.clients))
        assert all(client.account.held <= Ledger().most_for_one for client in clients)
        assert max(len(client.outbox) for client in clients) <= len(SOUND) * LONGEST_QUEUE


def test_a_client_that_asks_and_never_reads_is_let_go(busy):
    lazy = Client(busy.url, max_queue=1)
    with pytest.raises(ConnectionClosed), lazy:
        for _ in range(1_000_000):
            lazy.send(op="call_service", service="/rosapi/topics")
    require_undisturbed(busy)


def test_half_open_connections_are_nobody_s_concern(busy):
    host, port = busy.url.removeprefix("ws://").split(":")
    quiet = []
    for beginning in (b"", b"GET / HTTP/1.1\r\nHost: x\r\n", b"\x00\xff" * 100, b"GET /\r\n\r\n"):
        half = socket.create_connection((host, int(port)))
        half.sendall(beginning)
        quiet.append(half)
    abrupt = Client(busy.url)
    abrupt.__enter__()
    abrupt.subscribe(*SOUND)
    # A reset instead of a farewell: what a client leaves behind that was switched off.
    abrupt.socket.socket.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, struct.pack("ii", 1, 0))
    abrupt.socket.socket.close()
    require_undisturbed(busy)
    for half in quiet:
        half.close()
