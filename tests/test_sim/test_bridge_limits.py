"""Accepted clients of a bridge, and the bytes buffered for them."""

import itertools
import json
import random
import resource
import socket
import threading
import time
from contextlib import suppress

import pytest
from bridge_parts import Client, Command, Ledger, OriginError, Origins, relay
from waiting import HANG, until
from websockets.exceptions import ConnectionClosed, InvalidStatus

TEXT = "std_msgs/String"
UPGRADE = (
    b"GET / HTTP/1.1\r\nHost: x\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n"
    b"Sec-WebSocket-Key: AAAAAAAAAAAAAAAAAAAAAA==\r\nSec-WebSocket-Version: 13\r\n\r\n"
)


def place_of(url):
    host, port = url.removeprefix("ws://").split(":")
    return host, int(port)


# ── web pages ──


def is_let_in(url, origin):
    try:
        with Client(url, origin=origin) as client:
            client.settle()
            return True
    except InvalidStatus as refusal:
        assert refusal.response.status_code == 403
        return False


def test_pages_of_other_origins_are_rejected():
    notices = []
    named = Origins(["http://Robot:8080", "https://lab.example:443"])
    with relay(origins=named, notice=notices.append) as url:
        for origin in (
            *(None, "http://localhost", "http://localhost:8080", "https://127.0.0.1:3000"),
            *("http://[::1]:8080", "http://127.1.2.3", "http://robot:8080", "https://lab.example"),
        ):
            assert is_let_in(url, origin), origin
        assert notices == []
        for origin in (
            *("http://evil.example", "null", "http://localhost.evil.example", "file://"),
            *("http://127.0.0.1.evil.example", "http://localhost:80@evil.example", "http://robot"),
            *("https://robot:8080", "http://lab.example", "http://10.0.0.1", "x" * 500, ""),
        ):
            assert not is_let_in(url, origin), origin
        before = len(notices)
        assert not is_let_in(url, "http://evil.example")
        assert len(notices) == before
    assert "'http://evil.example'" in notices[0]
    assert "--origin" in notices[0]
    with relay(origins=Origins(["null"])) as url:
        assert is_let_in(url, "null")


def test_a_page_behind_a_custom_host_name_is_rejected():
    """A name may resolve to this machine after its page is loaded, unlike an IP address."""
    with relay() as url:
        for host, origin, status in (
            (b"evil.example:9090", b"http://evil.example:9090", b"403"),
            (b"192.0.2.7:9090", b"http://192.0.2.7:9090", b"101"),
            (b"[2001:db8::7]:9090", b"http://[2001:db8::7]:9090", b"101"),
            (b"192.0.2.7:9090", b"http://192.0.2.7:8080", b"403"),
            (b"192.0.2.7:9090", b"http://evil.example:9090", b"403"),
            (b"localhost:9090", b"localhost:9090", b"101"),
            (b"evil.example", b"evil.example", b"403"),
        ):
            with socket.create_connection(place_of(url), timeout=HANG) as client:
                client.sendall(
                    UPGRADE.replace(b"Host: x", b"Host: %b\r\nOrigin: %b" % (host, origin))
                )
                assert client.recv(100).split()[1] == status, origin


@pytest.mark.parametrize("origin", ["robot:8080", "*", "http://robot/page", "", "http://a b"])
def test_an_invalid_origin_is_rejected(origin):
    with pytest.raises(OriginError, match="one looks like http://host:8080"):
        Origins([origin])


# ── buffered bytes ──


def publisher(client, topic="/talk"):
    client.send(op="advertise", topic=topic, type=TEXT)
    return lambda text: client.publish(topic, data=text)


def why_closed(client):
    """Wait until a client is disconnected, and return the reason."""
    with pytest.raises(ConnectionClosed) as closed:
        while True:
            client.socket.recv(HANG)
    assert closed.value.rcvd is not None, "no farewell"
    assert closed.value.rcvd.code == 1008
    return closed.value.rcvd.reason


def test_messages_that_are_throttled_away_count():
    ledger = Ledger(most_for_one=1_000_000)
    notices = []
    with (
        relay(ledger=ledger, notice=notices.append) as url,
        Client(url) as speaker,
        Client(url) as greedy,
        Client(url) as modest,
    ):
        say = publisher(speaker)
        greedy.subscribe("/talk", throttle_rate=1e9, queue_length=1000)
        modest.subscribe("/talk", throttle_rate=1e9, queue_length=3)
        for client in (greedy, modest):
            client.settle()
        for _ in range(30):
            say("x" * 100_000)
        assert "more than 1000000 bytes" in why_closed(greedy)
        speaker.settle()
        assert 300_000 < ledger.held < 400_000
        modest.send(op="unsubscribe", topic="/talk")
        modest.settle()
        assert ledger.held < 10_000
    assert notices == [
        "a client was disconnected: more than 1000000 bytes are held for this client"
    ]


@pytest.mark.slow
def test_fragments_of_all_clients_count_together():
    ledger = Ledger(most_for_all=1_500_000)
    most = []
    with relay(ledger=ledger) as url, Client(url) as modest:
        modest.send(op="fragment", id="mine", data='{"op":"set_', num=0, total=2)
        crowd = [Client(url) for _ in range(8)]
        for k, client in enumerate(crowd):
            client.__enter__()
            # Python uses four bytes for each of these characters.
            data = "\U0001f600" * 10_000
            with suppress(ConnectionClosed):
                for num in range(7):
                    client.send(op="fragment", id=f"f{k}", data=data, num=num, total=1000)
                client.settle()
            most.append(ledger.held)
        assert max(most) <= ledger.most_for_all
        assert max(most) > 700_000
        let_go = [client for client in crowd if client.socket.state.name != "OPEN"]
        assert len(let_go) >= 8 - 1_500_000 // 280_000
        for client in crowd:
            client.__exit__(None, None, None)
        modest.send(op="fragment", id="mine", data='level","level":"nonsense"}', num=1, total=2)
        assert "set_level" in modest.error()["msg"]
        until(lambda: ledger.held == 0)


MASK = b"mask"
ATTACKS = {
    "frames of one message": (b"\x01\x80" + MASK, b"\x00\xfe\x03\xe8" + MASK + b"x" * 1000),
    "empty frames": (b"\x01\x80" + MASK, b"\x00\x80" + MASK),
    "one long frame": (b"\x81\xff" + (3_000_000).to_bytes(8, "big") + MASK, b"x" * 1000),
    "pings": (b"", b"\x89\xfd" + MASK + b"x" * 125),
}
"""Bytes that begin a frame or message (RFC 6455, 5.2), and bytes that continue it forever."""


@pytest.mark.parametrize("attack", ATTACKS)
def test_incomplete_and_unread_messages_count(attack, monkeypatch):
    monkeypatch.setattr("sim.bridge.server._GOODBYE", 0.1)
    beginning, rest = ATTACKS[attack]
    ledger = Ledger(most_for_one=1_000_000)
    most = []
    over = threading.Event()

    def watch():
        while not over.wait(0.001):
            most.append(ledger.held)

    watching = threading.Thread(target=watch)
    with relay(ledger=ledger) as url:
        watching.start()
        with socket.create_connection(place_of(url), timeout=HANG) as wrong:
            wrong.sendall(UPGRADE + beginning)
            with pytest.raises(ConnectionError):
                while True:  # the client reads nothing
                    wrong.sendall(rest * 1000)
        over.set()
        watching.join()
        assert max(most) <= ledger.most_for_one
        with Client(url) as other:
            other.settle()
            until(lambda: ledger.held < 1000)


def test_a_message_that_grows_when_it_is_completed_is_not_passed_on():
    with relay() as url, Client(url) as speaker:
        speaker.send(op="advertise", topic="/many", type="tf2_msgs/TFMessage")
        speaker.publish("/many", transforms=[{}] * 10_000)
        assert "is the maximum" in speaker.error()["msg"]


def test_released_bytes_no_longer_count():
    """The count returns to zero when clients undo all their operations."""
    chances = random.Random(5)
    ledger = Ledger()
    topics = ["/a", "/b", "/c"]
    with relay(ledger=ledger) as url:
        with Client(url) as one, Client(url) as two:
            for client in (one, two):
                for topic in topics:
                    client.send(op="advertise", topic=topic, type=TEXT)
            for _ in range(500):
                client, topic = chances.choice([one, two]), chances.choice(topics)
                kind = chances.randrange(6)
                if kind == 0:
                    client.subscribe(
                        topic,
                        id=chances.choice(["x", "y", None]),
                        throttle_rate=chances.choice([0, 5, 1e6]),
                        queue_length=chances.choice([0, 1, 20]),
                        fragment_size=chances.choice([None, 100]),
                    )
                elif kind == 1:
                    client.send(op="unsubscribe", topic=topic, id=chances.choice(["x", "y", None]))
                elif kind == 2:
                    client.send(
                        **{"op": "fragment", "id": chances.choice("pqr"), "data": "x" * 99},
                        **{"num": chances.randrange(3), "total": 3},
                    )
                elif kind == 3:
                    client.socket.ping()
                else:
                    client.publish(topic, data="y" * chances.randrange(2000))
            for client in (one, two):
                for topic in topics:
                    client.send(op="unsubscribe", topic=topic)
                    client.send(op="unadvertise", topic=topic)
                for id, num in itertools.product("pqr", range(3)):
                    client.send(op="fragment", id=id, data=" ", num=num, total=3)
            for client in (one, two):
                client.settle()
        until(lambda: ledger.held == 0 and not ledger.accounts)


# ── sockets ──

FEW = 80
"""Number of files that a process may open."""


def test_silent_connections_are_limited(monkeypatch):
    monkeypatch.setattr("sim.bridge.server._MOST_CONNECTIONS", 3)
    with relay() as url:
        silent = [socket.create_connection(place_of(url), timeout=HANG) for _ in range(5)]
        for one in silent[3:]:
            with suppress(ConnectionResetError):
                assert one.recv(1) == b""
        silent[0].sendall(UPGRADE)
        assert silent[0].recv(100).split()[1] == b"101"
        for one in silent:
            one.close()
        with Client(url) as client:
            client.settle()


@pytest.mark.slow
def test_too_many_sockets_cause_one_line_on_stderr(tmp_path):
    (tmp_path / "trial.yaml").write_text(
        "floorplan: ariac2023\npeople: [{name: operator, personality: external}]\n"
    )

    def limit():
        resource.setrlimit(resource.RLIMIT_NOFILE, (FEW, FEW))

    with Command(tmp_path, "trial.yaml", preexec_fn=limit) as server:
        crowd = [socket.create_connection(place_of(server.url)) for _ in range(2 * FEW)]
        server.wait_for(lambda: len(server.notices) > 2)
        assert "stands still" in server.notices[1]
        assert "too many open files" in server.notices[2].lower()
        time.sleep(1.5)  # the server tries again every second
        for one in crowd:
            one.close()
        with Client(server.url) as client:
            assert client.call("/rosapi/topics")[0]
        crowd = [socket.create_connection(place_of(server.url)) for _ in range(2 * FEW)]
        time.sleep(0.5)  # the end of the session adds no message
        server.interrupt()
        for one in crowd:
            one.close()
    assert len(server.notices) <= 4, server.notices
    assert json.loads((tmp_path / "out" / "summary.json").read_text())
