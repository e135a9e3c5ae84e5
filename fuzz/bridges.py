"""Readers of what comes over a rosbridge: at the server from its clients, and at an agent."""

from __future__ import annotations

import asyncio
import json
from typing import Any

import sim
from sim.bridge import Connection, Exchange, Workcell
from sim.bridge.client import Client
from sim.bridge.ledger import Account, Ledger
from sim.bridge.remote_person import RemotePerson

TRIAL = """
floorplan: ariac2023
duration: 10000.0
people: [{name: operator, personality: external}]
gantry: {controller: external}
"""
JOINTS = ["gantry_x_axis_joint", "gantry_y_axis_joint", "gantry_rotation_joint"]
POINT = {"positions": [0.5, 0.5, 0.0], "velocities": [0, 0, 0], "time_from_start": {"sec": 9}}
TO_SERVER: tuple[dict[str, Any], ...] = (
    {"op": "subscribe", "id": "a", "topic": "/clock", "type": "rosgraph_msgs/Clock"},
    {"op": "subscribe", "topic": "/tf", "throttle_rate": 100, "queue_length": 3},
    {"op": "advertise", "topic": "/mine", "type": "std_msgs/String"},
    {"op": "publish", "topic": "/mine", "msg": {"data": "hello"}},
    {"op": "publish", "topic": "/ariac_human/goal_position", "msg": {"x": -8.0, "y": 0.0}},
    {"op": "publish", "topic": "/ariac_human/action", "msg": {"data": "move(-5, 3, 0)"}},
    {"op": "publish", "topic": "/ariac_human/stop", "msg": {"data": True}},
    {
        "op": "publish",
        "topic": "/gantry_controller/joint_trajectory",
        "msg": {"joint_names": JOINTS, "points": [POINT]},
    },
    {"op": "call_service", "id": "c", "service": "/ariac/move_agv1", "args": {"location": 1}},
    {"op": "call_service", "service": "/rosapi/topics", "fragment_size": 100},
    {"op": "fragment", "id": "f", "data": '{"op": "set_', "num": 0, "total": 2},
    {"op": "fragment", "id": "f", "data": 'level", "level": "info"}', "num": 1, "total": 2},
    {"op": "unsubscribe", "topic": "/clock", "id": "a"},
    {"op": "status", "level": "info", "msg": "well"},
)
ZERO = {"x": 0.0, "y": 0.0, "z": 0.0}
STATE = {
    "human_position": {"x": -10.0, "y": 0.0, "z": 0.0},
    "robot_position": {"x": -9.0, "y": 0.5, "z": 0.0},
    "human_velocity": ZERO,
    "robot_velocity": ZERO,
}
TO_AGENT: tuple[dict[str, Any], ...] = (
    {"op": "publish", "topic": "/ariac/start_human", "msg": {"data": True}},
    {"op": "publish", "topic": "/ariac_human/state", "msg": STATE},
    {"op": "publish", "topic": "/ariac/agv1_status", "msg": {"location": 0, "position": 3.0}},
    {"op": "publish", "topic": "/ariac_human/position_reached", "msg": {"data": True}},
    {"op": "publish", "topic": "/ariac_human/unsafe_distance", "msg": {"data": False}},
    {"op": "service_response", "id": "call-1", "values": {"time": 1.0}, "result": True},
    {"op": "status", "level": "error", "msg": "no"},
)
CASES_A_WORKCELL = 300


def messages(operations: tuple[dict[str, Any], ...]) -> bytes:
    """Operations as a file, one a line."""
    return b"\n".join(json.dumps(operation).encode() for operation in operations)


class Server:
    """Takes each line of a file as a message of a client, while the simulation goes on."""

    def __init__(self) -> None:
        self._cases = 0
        self._loop = asyncio.new_event_loop()
        self._exchange = Exchange()
        self._workcell: Workcell | None = None

    def __call__(self, data: bytes) -> None:
        """Somebody connects, says what stands in `data`, and goes."""
        self._loop.run_until_complete(self._hear(data))

    async def _hear(self, data: bytes) -> None:
        if self._workcell is None or self._cases % CASES_A_WORKCELL == 0:
            self._exchange = Exchange()
            self._workcell = Workcell(sim.Trial.parse(TRIAL), self._exchange)
        self._cases += 1

        async def send(text: str) -> None:
            json.loads(text)

        client = Client("fuzz", send, Account(Ledger(), lambda why: None))
        sending = asyncio.ensure_future(client.send_forever())
        for line in data.split(b"\n"):
            self._exchange.take(client, line)
        simulation = self._workcell.simulation
        simulation.advance(simulation.clock.now + 0.2)
        await client.idle(0.01)
        self._exchange.forget(client)
        sending.cancel()


class Agent:
    """Takes each line of a file as a message of the server that an agent is connected to."""

    def __init__(self) -> None:
        self._loop = asyncio.new_event_loop()
        self._trial = sim.Trial.parse(TRIAL)
        self._person: RemotePerson | None = None

    def __call__(self, data: bytes) -> None:
        """Hear what stands in `data`."""
        self._loop.run_until_complete(self._hear(data))

    async def _hear(self, data: bytes) -> None:
        connection = Connection("ws://nowhere")
        self._person = self._person or RemotePerson(
            self._trial,
            self._trial.people[0],
            waypoints=False,
            now=lambda: 0.0,
            perceived=lambda: None,
            notice=lambda text: None,
        )
        self._person.connect(connection, ())
        call = asyncio.ensure_future(connection.call("/service", {}, 0.001))
        await asyncio.sleep(0)
        for line in data.split(b"\n"):
            connection._take(line)
        await asyncio.wait([call])
        call.exception()
