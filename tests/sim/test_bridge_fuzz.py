"""A minute of nonsense from several clients at once, while one behaves."""

import json
import os
import random
import re
import signal
import subprocess
import sys
import threading
import time
from pathlib import Path

import pytest
from bridge_parts import Client, require_whole
from websockets.exceptions import ConnectionClosed

TRAJECTORY = "/gantry_controller/joint_trajectory"
ODDITIES = [None, True, False, 0, -1, 1e308, 2**70, 10**400, "", "x" * 500, "\x00", "é"]
INSERTIONS = ["", "NaN", '"', "}", "9" * 400, "\ud800"]


def random_value(chances, depth=0):
    kinds = [
        lambda: chances.choice(
            [None, True, False, 0, -1, 1e308, 2**70, 10**400, "", "x" * 500, "\x00", "é"]
        ),
        lambda: chances.uniform(-100, 100),
        lambda: chances.randint(-300, 300),
        lambda: chances.choice(NAMES),
        lambda: [random_value(chances, depth + 1) for _ in range(chances.randint(0, 4))],
        lambda: {
            chances.choice(FIELDS): random_value(chances, depth + 1)
            for _ in range(chances.randint(0, 4))
        },
    ]
    return chances.choice(kinds[: 4 if depth > 3 else 6])()


NAMES = [
    *("/ariac_human/goal_position", "/ariac_human/stop", "/ariac_human/go_home", "/clock"),
    *("/ariac_human/action", "/ariac/start_human", "/gantry_controller/joint_trajectory"),
    *("/ariac/move_agv1", "/ariac_human/teleport", "/ariac/set_human_safe_zone_penalty"),
    *("/rosapi/topics", "/rosapi/message_details", "/floorwalker/advance", "/nowhere"),
    *("geometry_msgs/Point", "std_msgs/Bool", "std_msgs/msg/String", "none", "error"),
    *("move(-5, 3, 0)", "walk_speed(0.5)", "teleport_safe", "move(1e400, 0)", "f(", "a" * 200),
]
FIELDS = [
    *("op", "topic", "type", "msg", "id", "service", "args", "throttle_rate", "queue_length"),
    *("fragment_size", "compression", "level", "data", "num", "total", "x", "y", "z", "location"),
    *("joint_names", "points", "positions", "time_from_start", "sec", "nanosec", "until"),
]
OPERATIONS = [
    *("advertise", "unadvertise", "publish", "subscribe", "unsubscribe", "call_service"),
    *("set_level", "status", "fragment", "png", "service_response"),
]
MESSAGES = [
    {"op": "publish", "topic": "/ariac_human/goal_position", "msg": {"x": -8.0, "y": 0.0}},
    {"op": "publish", "topic": "/ariac_human/stop", "msg": {"data": True}},
    {"op": "publish", "topic": "/ariac_human/go_home", "msg": {"data": True}},
    {"op": "publish", "topic": "/ariac_human/action", "msg": {"data": "walk_speed(0.5)"}},
    {"op": "call_service", "service": "/ariac/move_agv1", "args": {"location": 1}},
    {"op": "call_service", "service": "/ariac_human/teleport"},
    {"op": "subscribe", "topic": "/tf", "throttle_rate": 1, "queue_length": 3, "fragment_size": 9},
    {"op": "fragment", "id": "f", "num": 0, "total": 2, "data": '{"op": "publish",'},
    {
        "op": "publish",
        "topic": "/gantry_controller/joint_trajectory",
        "msg": {
            "joint_names": [
                "gantry_x_axis_joint",
                "gantry_y_axis_joint",
                "gantry_rotation_joint",
            ],
            "points": [{"positions": [1.0, 1.0, 0.0], "time_from_start": {"sec": 9}}],
        },
    },
]


def random_message(chances):
    kind = chances.randrange(6)
    if kind == 0:
        return chances.randbytes(chances.randint(0, 200))
    if kind == 1:
        text = json.dumps(chances.choice(MESSAGES))
        place = chances.randrange(len(text))
        return text[:place] + chances.choice(INSERTIONS) + text[place:]
    if kind == 2:
        return json.dumps(random_value(chances))
    if kind == 3:
        fields = {field: random_value(chances) for field in chances.sample(FIELDS, 5)}
        return json.dumps({**fields, "op": chances.choice(OPERATIONS)})
    message = dict(chances.choice(MESSAGES))
    if kind == 4:
        message[chances.choice([*message, *FIELDS])] = random_value(chances)
    return json.dumps(message)


def fuzz(url, seed, deadline):
    """Connect, say all sorts of things, and go, in all sorts of ways, until the deadline."""
    chances = random.Random(seed)
    while time.monotonic() < deadline:
        try:
            with Client(url, max_queue=chances.choice([1, 16])) as client:
                for _ in range(chances.randint(1, 2000)):
                    message = random_message(chances)
                    if isinstance(message, str):
                        message = message.encode("utf-8", "surrogatepass")
                    client.socket.send(message, text=chances.random() < 0.8)
                    if chances.random() < 0.05:
                        client.socket.recv(0.01)
                    if time.monotonic() > deadline:
                        break
                if chances.random() < 0.3:
                    client.socket.socket.close()
        except (ConnectionClosed, TimeoutError, OSError):
            continue


FUZZED = """
floorplan: ariac2023
duration: 100000.0
people: [{name: operator, personality: external}]
gantry: {controller: external}
"""


@pytest.mark.slow
def test_a_minute_of_nonsense(tmp_path):
    (tmp_path / "fuzzed.yaml").write_text(FUZZED)
    command = ["bridge", "fuzzed.yaml", "--port", "0", "--speed", "5", "--out", "out"]
    server = subprocess.Popen(
        [sys.executable, "-m", "sim.cli", *command],
        cwd=tmp_path,
        env={**os.environ, "PYTHONPATH": str(Path(__file__).resolve().parents[2])},
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )
    try:
        url = re.search(r"ws://\S+", server.stderr.readline()).group()
        notices = []
        reader = threading.Thread(target=lambda: notices.extend(server.stderr), daemon=True)
        reader.start()
        with Client(url) as good:
            good.subscribe("/ariac/start_human", "/clock")
            good.send(op="advertise", topic=TRAJECTORY, type="trajectory_msgs/JointTrajectory")
            good.message("/clock")
            before = resident(server.pid)
            deadline = time.monotonic() + 65
            fuzzers = [
                threading.Thread(target=fuzz, args=(url, seed, deadline)) for seed in range(3)
            ]
            for fuzzer in fuzzers:
                fuzzer.start()
            ticks, peak = 0, before
            while any(fuzzer.is_alive() for fuzzer in fuzzers):
                good.message("/clock")
                ticks += 1
                if ticks % 50 == 0:
                    peak = max(peak, resident(server.pid))
            assert server.poll() is None, notices
            assert ticks > 1000
            assert peak - before < 200e6
        server.send_signal(signal.SIGINT)
        assert server.wait(60) == 130
        reader.join(10)
    finally:
        server.kill()
        server.wait()
        server.stdout.close()
        server.stderr.close()
    assert not [line for line in notices if "Traceback" in line or "Error" in line]
    require_whole(tmp_path / "out")


def resident(pid):
    """The memory of a process, bytes."""
    status = Path(f"/proc/{pid}/status")
    if not status.exists():
        return 0
    return int(re.search(r"VmRSS:\s+(\d+)", status.read_text()).group(1)) * 1024
