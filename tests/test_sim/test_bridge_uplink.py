"""The bridge as a client of another rosbridge server."""

import asyncio
import json

import pytest
from bridge_parts import Client, ConnectError, Exchange, InThread, Session, Workcell, relay
from test_bridge import HALL, goal_of
from waiting import HANG, until
from websockets.asyncio.server import serve

import sim
from sim.bridge import BridgeError


class Uplinked:
    """A session that serves a trial through the rosbridge server at `url`."""

    def __init__(self, url, text=HALL, speed=20.0):
        self.notices = []
        exchange = Exchange()
        self.workcell = Workcell(sim.Trial.parse(text), exchange)

        async def main(opened):
            session = Session(self.workcell, exchange, speed=speed, notice=self.notices.append)
            opened()
            await session.connect(url)
            await session.run()

        self.thread = InThread(main)

    def __enter__(self):
        return self

    def __exit__(self, *why):
        self.thread.stop()


def test_a_trial_is_served_through_another_server():
    with relay() as url, Client(url) as client:
        client.subscribe("/odom", type="nav_msgs/Odometry")
        client.subscribe("/goal_result", "/ann/percept", type="std_msgs/String")
        client.settle()
        with Uplinked(url, HALL.replace("duration: 40", "duration: 12")) as served:
            assert client.message("/ann/percept") == {"data": "human_start"}
            client.publish("/goal_pose", **goal_of(6.0, 4.0))
            assert client.message("/goal_result") == {"data": "succeeded"}
            position = client.message("/odom")["pose"]["pose"]["position"]
            assert (position["x"], position["y"]) == pytest.approx((6.0, 4.0))
            until(lambda: served.thread.join(0.1))
        assert served.thread.failure is None
    run = served.workcell.simulation.finish()
    assert {command.machine for command in run.trial.commands} == {"bot"}


class Ros:
    """A server that records operations, calls services, and has no types of ARIAC."""

    def __init__(self):
        self.said = []
        self.socket = None

    async def attend(self, socket):
        self.socket = socket
        async for text in socket:
            said = json.loads(text)
            self.said.append(said)
            if said["op"].startswith("advertise") and said["type"].startswith("ariac_msgs"):
                why = {"op": "status", "level": "error", "id": said["id"], "msg": "no ariac_msgs"}
                await socket.send(json.dumps(why))

    def get(self, **fields):
        return [one for one in self.said if fields.items() <= one.items()]


def test_services_and_types_are_those_of_the_server():
    ros, port = Ros(), []

    async def main(opened):
        async with serve(ros.attend, "127.0.0.1", 0) as server:
            port.append(server.sockets[0].getsockname()[1])
            opened()
            await asyncio.Event().wait()

    server = InThread(main)
    text = "floorplan: ariac2023\npeople: [{name: operator, personality: external}]\n"
    with Uplinked(f"ws://127.0.0.1:{port[0]}", text, speed=1.0) as served:
        until(lambda: ros.get(op="publish", topic="/clock"))
        until(lambda: any("/ariac_human/state is omitted" in line for line in served.notices))
        count = len(ros.get(op="publish", topic="/ariac_human/state"))
        assert ros.get(op="advertise", topic="/ariac/start_human")[0]["latch"]
        assert ros.get(op="subscribe", topic="/ariac_human/goal_position")
        assert ros.get(op="advertise_service", service="/ariac/end_competition")
        goal = {"op": "publish", "topic": "/ariac_human/goal_position", "msg": {"x": -10.0}}
        call = {"op": "call_service", "service": "/ariac/end_competition", "id": "c", "args": {}}
        for operation in (goal, call):
            asyncio.run_coroutine_threadsafe(
                ros.socket.send(json.dumps(operation)), server._loop
            ).result(HANG)
        until(lambda: served.thread.join(0.1))
        assert ros.get(op="service_response", id="c")[0]["result"] is True
        assert len(ros.get(op="publish", topic="/ariac_human/state")) <= count + 1
    assert any(command.call == "act" for command in served.workcell.simulation.commands)
    server.stop()


def test_time_stops_while_the_connection_is_broken(monkeypatch):
    monkeypatch.setattr("sim.bridge.uplink._FIRST_RETRY", 0.01)
    with relay() as url:
        served = Uplinked(url, HALL.replace("duration: 40", "duration: 4000"))
        until(lambda: served.workcell.now > 1.0)
    with served:
        until(lambda: any("no connection" in line for line in served.notices))
        stood = served.workcell.now
        with relay(int(url.rpartition(":")[2])):
            until(lambda: served.workcell.now > stood)


def test_unsupported_features_of_another_server_are_reported(tmp_path, floorwalker):
    with pytest.raises(ConnectError, match="can't connect"):
        wrong = Uplinked("ws://127.0.0.1:1")
        wrong.thread.join(HANG)
        raise wrong.thread.failure
    with relay() as url, pytest.raises(BridgeError, match="speed"):
        wrong = Uplinked(url, speed=0.0)
        wrong.thread.join(HANG)
        raise wrong.thread.failure
    done = floorwalker("bridge", "--to", "ws://127.0.0.1:1", "ariac2023", cwd=tmp_path)
    assert done.returncode == 1
    assert "can't connect" in done.stderr
