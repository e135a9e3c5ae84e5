"""The bridge as the simulation: topics, services and time, over a real socket."""

import asyncio
import json
import math
import socket
from contextlib import suppress
from dataclasses import replace

import pytest
from bridge_parts import (
    STEP,
    AddressError,
    BridgeError,
    Client,
    ConnectError,
    Exchange,
    InThread,
    Pacer,
    RemoteAgent,
    Session,
    Workcell,
    relay,
    served,
    trial,
)
from small_floors import HALL as FLOOR, on_floor
from waiting import HANG, until

import bdi
import sim

HUMAN = ("/ariac/start_human", "/ariac_human/position_reached", "/ariac_human/unsafe_distance")


def drive(url, personality, a_trial=None, **options):
    """Run an agent against `url`, and return its actions as (time, action)."""
    done = []
    a_trial = (a_trial or trial()).with_personality(personality)
    agent = RemoteAgent(
        url,
        a_trial,
        a_trial.people[0],
        did=lambda t, action: done.append((t, str(action))),
        **options,
    )
    asyncio.run(asyncio.wait_for(agent.run(), HANG))
    return done


def happenings(run):
    """Return the events of a run without those about its driver."""
    return [event for event in run.events if event["kind"] not in ("trial_started", "said")]


@pytest.mark.parametrize(
    ("personality", "duration"),
    [
        ("antagonistic", 120.0),
        ("helpful", 60.0),
        ("indifferent", 60.0),
        pytest.param("antagonistic", 275.0, marks=pytest.mark.slow),
        pytest.param("helpful", 275.0, marks=pytest.mark.slow),
        pytest.param("indifferent", 275.0, marks=pytest.mark.slow),
    ],
)
def test_an_agent_across_the_bridge_acts_as_in_the_simulation(personality, duration):
    within = sim.run(trial(personality, duration))
    with served(trial("external", duration)) as session:
        done = drive(session.url, personality)
        across = session.join()
    assert happenings(across) == happenings(within)
    assert across.summary["penalties"] == within.summary["penalties"]
    assert len(done) > 5
    for name, motion in within.motions.items():
        assert across.motions[name] == motion


def in_bytes(folder):
    return [(folder / name).read_bytes() for name in ("events.jsonl", "motions.jsonl")]


@pytest.mark.parametrize(("personality", "speed"), [("antagonistic", 0.0), ("curious", 40.0)])
def test_a_run_of_an_agent_across_the_bridge_repeats_to_the_byte(personality, speed, tmp_path):
    recording, again = sim.Recording(tmp_path / "first"), sim.Recording(tmp_path / "second")
    with served(trial(duration=60.0), recording, speed=speed) as session:
        drive(session.url, personality)
        run = session.join()
    recording.finish(run)
    run.trial.save(tmp_path / "again.trial.yaml")
    repeated = sim.run(sim.Trial.load(tmp_path / "again.trial.yaml"), again)
    again.finish(repeated)
    assert {command.person for command in run.trial.commands} == {"operator"}
    assert repeated.trial.commands == run.trial.commands
    assert in_bytes(tmp_path / "second") == in_bytes(tmp_path / "first")


@pytest.mark.slow
@pytest.mark.parametrize("personality", ["curious", "scared", "surprised", "threatening"])
def test_agents_with_actions_beyond_ros_repeat_too(personality):
    within = sim.run(trial(personality))
    with served(trial("external")) as session:
        drive(session.url, personality)
        across = session.join()
    assert happenings(across) == happenings(within)


def test_an_agent_that_plans_its_own_paths_arrives():
    with served(trial(duration=40.0, start=1.0)) as session:
        drive(session.url, "indifferent", waypoints=True)
        run = session.join()
    goals = [event for event in run.events if event["kind"] == "goal"]
    assert any(goal["station"] is None for goal in goals)
    visits = run.summary["people"]["operator"]["visits"]
    assert [name for name in visits if name] == ["station4", "station2", "station1"][: len(visits)]
    assert len(visits) >= 2


def test_the_state_is_published_ten_times_a_simulated_second():
    with served(trial("indifferent", duration=5.0), hold=True) as session:
        with Client(session.url) as client:
            client.subscribe(
                "/ariac_human/state", "/clock", "/tf", "/joint_states", "/ariac/agv1_status"
            )
            client.call("/ariac/start_competition")
            heard = {}
            while True:
                said = client.hear_until(lambda said: said["op"] == "publish")
                heard.setdefault(said["topic"], []).append(said["msg"])
                if said["topic"] == "/tf" and len(heard["/tf"]) == 50:
                    break
        run = session.join()
    stamps = [m["clock"]["sec"] + m["clock"]["nanosec"] / 1e9 for m in heard["/clock"]]
    assert stamps == pytest.approx([k / 10 for k in range(1, 51)])
    for t, state in zip(stamps, heard["/ariac_human/state"], strict=True):
        x, y = run.motions["operator"].position(t)
        assert (state["human_position"]["x"], state["human_position"]["y"]) == pytest.approx((x, y))
        assert (state["robot_position"]["x"], state["robot_position"]["y"]) == (-2.5, 0.5)
    (frames,) = {tuple(f["child_frame_id"] for f in m["transforms"]) for m in heard["/tf"]}
    assert frames == ("base_link", "torso_base", "agv1_base", "agv2_base", "agv3_base", "agv4_base")
    assert heard["/ariac/agv1_status"][0] == {"location": 0, "position": 0.0, "velocity": 0.0}
    joints = heard["/joint_states"][0]
    assert dict(zip(joints["name"], joints["position"], strict=True)) == {
        "gantry_x_axis_joint": pytest.approx(4.5),
        "gantry_y_axis_joint": -0.5,
        "gantry_rotation_joint": 0.0,
    }


def test_an_external_client_drives_the_person():
    with (
        served(trial(duration=40.0), speed=20.0, by_hand=True) as session,
        Pacer(session) as client,
    ):
        client.subscribe(*HUMAN)
        assert client.message("/ariac/start_human") == {"data": True}
        client.publish("/ariac_human/goal_position", x=-10.8, y=-3.75, z=0.0)
        assert client.message("/ariac_human/position_reached") == {"data": True}
        client.publish("/ariac_human/goal_position", x=-4.0, y=0.0, z=0.0)
        assert client.message("/ariac_human/unsafe_distance") == {"data": True}
        client.publish("/ariac_human/go_home", data=True)
        run = session.join()
    assert run.summary["people"]["operator"]["visits"] == ["station4"]
    assert run.summary["penalties"] == 1
    reasons = [event["reason"] for event in run.events if event["kind"] == "teleport"]
    assert reasons[0] == "gantry"


def test_every_gantry_is_published_as_a_gantry():
    north = sim.MachineEntry("gantry", {"at": [-10.8, -1.5, 0.0]})
    a_trial = replace(trial("indifferent", duration=20.0), machines={"north": north})
    with served(a_trial, speed=20.0, by_hand=True) as session, Pacer(session) as client:
        client.subscribe("/ariac_human/unsafe_distance")
        assert client.message("/ariac_human/unsafe_distance") == {"data": True}
        run = session.join()
    assert {event["with"] for event in run.events if event["kind"] == "violation"} == {"north"}


def test_a_stop_message_stops_the_person():
    with (
        served(trial(duration=20.0), speed=10.0, by_hand=True) as session,
        Pacer(session) as client,
    ):
        client.subscribe("/ariac/start_human", "/ariac_human/state")
        client.message("/ariac/start_human")
        client.publish("/ariac_human/goal_position", x=-5.0, y=-9.0)
        client.hear_until(lambda said: is_state(said) and said["msg"]["human_velocity"]["x"] > 0.9)
        client.publish("/ariac_human/stop", data=True)
        run = session.join()
    assert run.motions["operator"].velocity(19.9) == pytest.approx((0.0, 0.0))
    assert run.motions["operator"].position(19.9)[0] < -6.0


def is_state(said):
    return said.get("topic") == "/ariac_human/state"


def test_services_of_the_workcell():
    with served(trial(duration=100.0), hold=True) as session, Client(session.url) as client:
        client.subscribe("/ariac/competition_state")
        assert client.message("/ariac/competition_state") == {"competition_state": 1}
        ok, answer = client.call("/ariac/move_agv2", location=1)
        assert ok and answer["success"]
        ok, answer = client.call("/ariac/move_agv2", location=7)
        assert ok and not answer["success"]
        assert "1 assembly_front" in answer["message"]
        ok, answer = client.call("/ariac_human/teleport")
        assert answer["success"]
        ok, answer = client.call("/ariac/set_human_safe_zone_penalty")
        assert "penalties: 1" in answer["message"]
        ok, answer = client.call("/ariac/set_human_safe_zone_penalty")
        assert "penalties: 1" in answer["message"]
        ok, answer = client.call("/ariac/no_such_service")
        assert not ok and "no service is called" in answer
        client.call("/ariac/start_competition")
        client.subscribe("/ariac/start_human")
        assert client.message("/ariac/competition_state") == {"competition_state": 2}
        client.call("/ariac/end_competition")
        assert client.message("/ariac/competition_state") == {"competition_state": 4}
        run = session.join()
    assert run.summary["penalties"] == 1
    assert run.summary["interrupted"]
    assert next(e["agv"] for e in run.events if e["kind"] == "agv_moved") == "agv2"


def test_rosapi_lists_topics_and_services():
    with served(trial("indifferent"), hold=True) as session, Client(session.url) as client:
        _, listed = client.call("/rosapi/topics")
        types = dict(zip(listed["topics"], listed["types"], strict=True))
        assert types["/ariac_human/state"] == "ariac_msgs/msg/HumanState"
        assert types["/ariac_human/goal_position"] == "geometry_msgs/msg/Point"
        assert len(types) > 15
        _, listed = client.call("rosapi/services")
        assert "/ariac/move_agv4" in listed["services"]
        assert (
            client.call("/rosapi/topic_type", topic="/clock")[1]["type"]
            == "rosgraph_msgs/msg/Clock"
        )
        _, listed = client.call("/rosapi/topics_for_type", type="ariac_msgs/AGVStatus")
        assert len(listed["topics"]) == 4
        _, details = client.call("/rosapi/message_details", type="ariac_msgs/HumanState")
        assert [one["type"] for one in details["typedefs"]] == [
            "ariac_msgs/msg/HumanState",
            "geometry_msgs/msg/Point",
            "geometry_msgs/msg/Vector3",
        ]


def test_time_stops_without_the_agent_and_continues_after_its_return():
    with served(trial(duration=300.0), speed=50.0, by_hand=True) as session:
        with Pacer(session) as agent:
            agent.subscribe("/ariac/start_human")
            agent.message("/ariac/start_human")
            agent.publish("/ariac_human/goal_position", x=-10.8, y=-3.75)
            agent.settle()
            session.move(0.1)
            assert session.now > 2.0
        until(lambda: session.move(STEP) or "stands still" in session.notices[-1])
        stood_at = session.now
        assert "there is no agent" in session.notices[-1]
        session.move(0.3)
        assert session.now == stood_at
        with Pacer(session) as agent:
            agent.subscribe("/ariac/start_human", "/ariac_human/position_reached")
            assert agent.message("/ariac/start_human") == {"data": True}
            assert agent.message("/ariac_human/position_reached") == {"data": True}
            assert session.notices[-1] == f"goes on at t = {stood_at:.1f} s"


def test_the_run_continues_while_a_viewer_is_disconnected():
    with served(trial("indifferent", duration=60.0), speed=20.0, by_hand=True) as session:
        times = []
        for _ in range(3):
            with Pacer(session) as viewer:
                viewer.subscribe("/clock")
                clock = viewer.message("/clock")["clock"]
                times.append(clock["sec"] + clock["nanosec"] / 1e9)
            session.move(0.1)
        assert times == sorted(set(times))
        assert times[-1] > 2 * 0.1 * 20.0
        assert session.notices[-1] == "the trial begins"


def test_time_follows_the_wall_clock():
    with served(trial("indifferent", duration=5.0), speed=4.0, by_hand=True) as session:
        for k in range(5):
            assert session.now == pytest.approx(k, abs=1e-6)
            session.move(0.25)
        run = session.join()
    assert run.duration == 5.0


def test_small_messages_are_not_held_back_by_the_kernel():
    """Nagle's algorithm would delay each message by 40 ms, until the last one is acknowledged."""
    with served(trial()) as session, Client(session.url):

        def is_prompt():
            (connection,) = session.session.server.clients.values()
            peer = connection.transport.get_extra_info("socket")
            return peer.getsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY)

        assert session.do(is_prompt)


def test_messages_can_be_throttled_and_queued():
    a_trial = trial("indifferent", duration=2000.0)
    with served(a_trial, speed=20.0, by_hand=True) as session, Pacer(session) as client:

        def tenths(count):
            stamps = [client.message("/clock")["clock"] for _ in range(count)]
            return [stamp["sec"] * 10 + stamp["nanosec"] // 100_000_000 for stamp in stamps]

        client.subscribe("/clock", throttle_rate=250)
        first, second, third = tenths(3)
        assert (second - first, third - second) == (50, 50)  # 0.25 s at 20 times the speed
        client.send(op="unsubscribe", topic="/clock")
        client.heard()
        client.subscribe("/clock", throttle_rate=100, queue_length=1000)
        times = tenths(5)
        assert times == list(range(times[0], times[0] + 5))


def test_long_messages_are_fragmented_on_request():
    with served(trial("indifferent"), speed=1.0) as session, Client(session.url) as client:
        client.subscribe("/tf", fragment_size=200)
        pieces = [client.hear_until(lambda said: said["op"] == "fragment")]
        while len(pieces) < pieces[0]["total"]:
            pieces.append(client.hear())
        assert {piece["id"] for piece in pieces} == {pieces[0]["id"]}
        whole = json.loads("".join(piece["data"] for piece in pieces))
        assert whole["topic"] == "/tf"
        text = json.dumps({"op": "call_service", "service": "/rosapi/nodes", "id": "in pieces"})
        for num in range(2):
            client.send(
                op="fragment", id="f", num=num, total=2, data=text[num * 20 :][: 20 + 99 * num]
            )
        answer = client.hear_until(lambda said: said["op"] == "service_response")
        assert answer["id"] == "in pieces"


def test_clients_exchange_messages_on_custom_topics():
    with relay() as url, Client(url) as one, Client(url) as other:
        other.subscribe("/chat", type="std_msgs/String")
        other.call("/none")
        one.send(op="advertise", topic="/chat", type="std_msgs/msg/String")
        one.publish("/chat", data="hello")
        assert other.message("/chat") == {"data": "hello"}
        one.send(op="unadvertise", topic="/chat")
        one.send(op="set_level", level="warning")
        one.send(op="unadvertise", topic="/chat")
        assert one.error()["level"] == "warning"


@pytest.fixture(scope="module")
def held():
    """Session that waits to begin, shared by many tests."""
    with served(hold=True) as session:
        yield session


GOAL, STOP, ACTION = "/ariac_human/goal_position", "/ariac_human/stop", "/ariac_human/action"


@pytest.mark.parametrize(
    ("op", "topic", "rest", "words"),
    [
        ("publish", "/ariac_human/state", {"msg": {}}, "by the simulation alone"),
        ("publish", "/nowhere", {"msg": {}}, "no topic is called '/nowhere'"),
        ("publish", GOAL, {"msg": {"x": 99.0}}, "outside the floor"),
        ("publish", GOAL, {"msg": {"x": "a"}}, "x should be a float64"),
        ("publish", STOP, {"msg": {"data": 1}}, "should be a bool"),
        ("publish", ACTION, {"msg": {"data": "fly(1)"}}, "no action 'fly'"),
        ("publish", ACTION, {"msg": {"data": "fly("}}, "is no action"),
        ("advertise", "/clock", {"type": "std_msgs/Bool"}, "is of type"),
        ("advertise", "/x", {"type": "no_msgs/Thing"}, "unknown message type"),
        ("subscribe", "/x", {}, "give its type"),
        ("subscribe", "/tf", {"compression": "cbor"}, "no compression 'cbor'"),
        ("png", "/x", {"data": ""}, "unknown operation"),
    ],
)
def test_a_forbidden_operation_is_reported_to_its_client_alone(op, topic, rest, words, held):
    with Client(held.url) as wrong, Client(held.url) as other:
        wrong.send(op=op, topic=topic, **rest, id="why")
        complaint = wrong.error()
        assert words in complaint["msg"]
        assert (complaint["level"], complaint["id"]) == ("error", "why")
        assert other.call("/rosapi/nodes") == (True, {"nodes": ["/floorwalker"]})


def test_too_many_commands_at_one_time_are_rejected_and_the_run_continues():
    with served(trial(duration=5.0), hold=True) as session, Client(session.url) as client:
        for _ in range(2000):
            client.publish("/ariac_human/stop", data=True)
        assert "more than 300 commands" in client.error()["msg"]
        client.call("/ariac/start_competition")
        client.subscribe("/ariac/start_human")
        assert not session.join().summary["interrupted"]


def test_a_call_of_a_service_that_is_rejected_is_answered_and_the_run_continues():
    with served(trial(duration=5.0), hold=True) as session, Client(session.url) as client:
        answers = [client.call("/ariac/set_human_safe_zone_penalty") for _ in range(301)]
        assert answers[-2][0] and not answers[-1][0]
        assert "/ariac/set_human_safe_zone_penalty" in answers[-1][1]
        assert "more than 300" in answers[-1][1]
        assert client.call("/rosapi/nodes")[0]


def test_only_one_client_steps_the_time():
    with served(trial(duration=5.0)) as session, Client(session.url) as one:
        assert one.call("/floorwalker/advance", until=-1.0) == (True, {"time": 0.0, "ended": False})
        with Client(session.url) as other:
            ok, why = other.call("/floorwalker/advance", until=1.0)
            assert not ok and "another client" in why
        assert one.call("/floorwalker/advance", until=0.0)[1]["time"] == 0.0
        assert one.call("/floorwalker/advance", until=1.25)[1] == {"time": 1.25, "ended": False}
        one.settle()
        assert session.now == 1.25
        assert one.call("/floorwalker/advance", until=9.0)[1] == {"time": 5.0, "ended": True}
    with served(trial(), speed=1.0) as session, Client(session.url) as client:
        ok, why = client.call("/floorwalker/advance", until=1.0)
        assert not ok and "paced" in why


def test_the_run_stops_when_the_stepping_agent_disconnects():
    with served(trial(duration=50.0)) as session:
        with Client(session.url) as agent:
            agent.call("/floorwalker/advance", until=0.0)
            agent.call("/floorwalker/advance", until=2.5)
        until(lambda: "stands still at t = 2.5 s" in session.notices[-1])
        drive(session.url, "indifferent")
        run = session.join()
    assert run.summary["people"]["operator"]["visits"][0] == "station4"


def test_the_agent_works_with_a_plain_rosbridge():
    """Another simulation has no rosapi, no topics of Floorwalker, and states at 10 Hz."""
    heard = []
    with relay() as url, Client(url) as simulation:
        simulation.subscribe("/ariac_human/goal_position", type="geometry_msgs/Point")
        simulation.subscribe("/ariac_human/stop", "/ariac_human/go_home", type="std_msgs/Bool")
        simulation.call("/none")

        async def play():
            agent = asyncio.create_task(run_agent(url))
            await asyncio.to_thread(act_as_the_simulation, simulation, heard)
            await asyncio.wait_for(agent, HANG)

        asyncio.run(play())
    topics = [topic for topic, _ in heard]
    assert heard[0] == ("/ariac_human/goal_position", {"x": -10.8, "y": -3.75, "z": 0.0})
    assert heard[1] == ("/ariac_human/goal_position", {"x": -10.8, "y": 3.75, "z": 0.0})
    assert topics[2:5] == ["/ariac_human/stop", "/ariac_human/stop", "/ariac_human/goal_position"]
    assert math.dist((heard[4][1]["x"], heard[4][1]["y"]), (-7.0, 3.75)) < 1.5
    assert heard[5] == ("/ariac_human/go_home", {"data": True})
    assert len(heard) == 6


async def run_agent(url):
    a_trial = trial("antagonistic")
    await RemoteAgent(url, a_trial, a_trial.people[0]).run()


def act_as_the_simulation(client, heard):
    """Start the person, report one arrival, then move the gantry nearer until it is too close."""
    for topic, type_ in (
        ("/ariac/start_human", "std_msgs/Bool"),
        ("/ariac_human/position_reached", "std_msgs/Bool"),
        ("/ariac_human/unsafe_distance", "std_msgs/Bool"),
        ("/ariac_human/state", "ariac_msgs/HumanState"),
        ("/ariac/competition_state", "ariac_msgs/CompetitionState"),
    ):
        client.send(op="advertise", topic=topic, type=type_)

    def listen(count, **patience):
        while len(heard) < count:
            said = client.hear(**patience)
            if said["op"] == "publish":
                heard.append((said["topic"], said["msg"]))

    def say_state(robot_x):
        client.publish(
            "/ariac_human/state",
            human_position={"x": -10.8, "y": 3.75},
            robot_position={"x": robot_x, "y": 3.75},
            human_velocity={"x": 1.0},
            robot_velocity={"x": 0.0},
        )

    while not heard:  # until the agent has subscribed
        client.publish("/ariac/start_human", data=True)
        with suppress(TimeoutError):
            listen(1, timeout=0.2)
    client.publish("/ariac_human/position_reached", data=True)
    listen(2)
    for robot_x in (5.0, 0.0, -7.0):
        say_state(robot_x)
    listen(5)
    for _ in range(5):
        client.publish("/ariac_human/unsafe_distance", data=True)
    listen(6)
    client.publish("/ariac/competition_state", competition_state=4)


def test_an_agent_whose_connection_breaks_off_tries_again(monkeypatch):
    monkeypatch.setattr("sim.bridge.uplink._FIRST_RETRY", 0.01)
    notices, a_trial = [], trial("antagonistic")
    with relay() as url:

        async def main(opened):
            agent = RemoteAgent(url, a_trial, a_trial.people[0], notice=notices.append)
            opened()
            await agent.run()

        agent = InThread(main)
        until(lambda: notices)
    with relay(int(url.rpartition(":")[2])), Client(url) as simulation:
        phase = "/ariac/competition_state"
        simulation.send(op="advertise", topic=phase, type="ariac_msgs/CompetitionState")
        while not agent.join(0.1):
            simulation.publish(phase, competition_state=4)
    assert agent.failure is None
    connected = f"connected to {url}"
    lost = f"the connection to {url} broke off; trying again"
    assert notices == [connected, lost, connected]


def test_an_agent_without_a_server_is_reported():
    with pytest.raises(ConnectError, match="can't connect"):
        drive("ws://127.0.0.1:1", "indifferent")
    with pytest.raises(ConnectError, match="is not an address"):
        drive("http://127.0.0.1", "indifferent")
    with pytest.raises(BridgeError, match="--personality"):
        RemoteAgent("ws://127.0.0.1:1", trial(), trial().people[0])


HALL = on_floor(
    FLOOR,
    """\
duration: 40
rules: observe
people:
  - {name: ann, at: [2, 9], personality: external}
  - {name: bob, at: [18, 4], personality: external}
machines:
  bot: {kind: amr, at: [4, 4, 0], size: [1.0, 0.7], controller: external}
""",
)


def goal_of(x, y, turn=0.0, frame="map"):
    pose = {"position": {"x": x, "y": y}, "orientation": {"z": math.sin(turn), "w": math.cos(turn)}}
    return {"header": {"frame_id": frame}, "pose": pose}


def test_a_bridge_serves_several_people_and_vehicles(tmp_path):
    recording, again = sim.Recording(tmp_path / "first"), sim.Recording(tmp_path / "second")
    with (
        served(sim.Trial.parse(HALL), recording, speed=20.0, by_hand=True) as session,
        Pacer(session) as ann,
        Pacer(session) as bob,
    ):
        ann.subscribe("/ariac/start_human", "/goal_result", "/odom", "/scan")
        ann.settle()
        session.move(0.1)
        assert "there is no agent of bob" in session.notices[-1]
        assert session.now == 0.0
        bob.subscribe("/bob/percept", "/bob/goal_result", "/ann/odom")
        assert bob.message("/bob/percept") == {"data": "human_start"}
        ann.publish("/ariac_human/goal_position", x=4.0, y=9.0)
        bob.publish("/bob/goal_pose", **goal_of(15.0, 3.0))
        ann.publish("/goal_pose", **goal_of(7.0, 4.0))
        assert bob.message("/bob/goal_result") == {"data": "succeeded"}
        assert ann.message("/goal_result") == {"data": "succeeded"}
        pose = ann.message("/odom")["pose"]["pose"]
        assert (pose["position"]["x"], pose["position"]["y"]) == pytest.approx((7.0, 4.0))
        assert len(ann.message("/scan")["ranges"]) == 720
        ann.publish("/cmd_vel", linear={"x": 0.5}, angular={"z": 0.0})
        ann.settle()
        twist = ann.hear_until(
            lambda said: (
                said.get("topic") == "/odom" and said["msg"]["twist"]["twist"]["linear"]["x"]
            )
        )
        assert twist["msg"]["twist"]["twist"]["linear"]["x"] > 0
        assert bob.message("/ann/odom")["child_frame_id"] == "ann/base_link"
        run = session.join()
    recording.finish(run)
    assert {command.person or command.machine for command in run.trial.commands} == {
        *("ann", "bob", "bot"),
    }
    again.finish(sim.run(run.trial, again))
    assert in_bytes(tmp_path / "second") == in_bytes(tmp_path / "first")


@pytest.mark.parametrize(
    ("topic", "message", "words"),
    [
        ("/cmd_vel", {"linear": {"x": 1e999}}, ("/cmd_vel", "inf")),
        ("/cmd_vel", {"linear": {"x": math.nan}}, ("/cmd_vel", "nan")),
        ("/cmd_vel", {"linear": {"x": 99.0}}, ("/cmd_vel", "99")),
        ("/goal_pose", goal_of(10.0, 6.5), ("/goal_pose", "10", "6.5")),
        ("/bob/goal_pose", goal_of(10.0, 6.5), ("/bob/goal_pose", "10", "no room")),
        ("/goal_pose", goal_of(5.0, 4.0, frame="base_link"), ("/goal_pose", "base_link", "world")),
        ("/ariac_human/goal_position", {"x": 1e300}, ("/ariac_human/goal_position", "1e+300")),
    ],
)
def test_a_rejected_message_causes_one_line_with_its_topic_and_value(topic, message, words):
    with served(sim.Trial.parse(HALL), hold=True) as session, Client(session.url) as client:
        client.call("/ariac/start_competition")
        client.publish(topic, **message)
        line = client.error()["msg"]
        assert "\n" not in line
        for word in words:
            assert word in line


def test_a_flood_and_a_killed_client_do_not_disturb_other_clients(tmp_path):
    recording, again = sim.Recording(tmp_path / "first"), sim.Recording(tmp_path / "second")
    text = HALL.replace("personality: external", "personality: indifferent").replace(
        "duration: 40", "duration: 400"
    )
    with served(sim.Trial.parse(text), recording, speed=10.0) as session:
        with Client(session.url) as listener, Client(session.url) as flooding:
            listener.subscribe("/clock", queue_length=1000)
            killed = Client(session.url).__enter__()
            killed.subscribe("/clock", "/odom", "/scan")
            killed.publish("/goal_pose", **goal_of(15.0, 4.0))
            killed.settle()
            killed.socket.socket.shutdown(socket.SHUT_RDWR)
            for k in range(1000):
                flooding.publish("/cmd_vel", linear={"x": 0.001 * k})
            stamps = [listener.message("/clock")["clock"] for _ in range(30)]
        tenths = [stamp["sec"] * 10 + stamp["nanosec"] // 100_000_000 for stamp in stamps]
        assert tenths == list(range(tenths[0], tenths[0] + 30))
        session.stop()
        run = session.workcell.simulation.finish()
    recording.finish(run)
    assert {command.call for command in run.trial.commands} == {"move_to", "twist"}
    repeated = sim.Simulation(run.trial, again)
    repeated.advance(run.duration)
    again.finish(repeated.finish())
    assert in_bytes(tmp_path / "second") == in_bytes(tmp_path / "first")


def test_a_clock_that_goes_back_is_reported_and_the_agent_time_continues():
    notices, a_trial = [], trial("indifferent")
    agent = RemoteAgent("ws://127.0.0.1:1", a_trial, a_trial.people[0], notice=notices.append)
    times = []
    for t in (4.5, 5.0, 2.0, 3.0):
        agent._tick({"clock": {"sec": int(t), "nanosec": round(t % 1 * 1e9)}})
        times.append(agent._person.now)
    assert times == [4.5, 5.0, 5.0, 6.0]
    assert notices == ["/clock goes back from 5 s to 2 s"]


def test_a_recorded_person_and_people_with_programs_can_be_watched(tmp_path):
    lines = "".join(f"7,{k},{2 + 0.1 * k},2\n" for k in range(60))
    (tmp_path / "track.csv").write_text(f"id,frame,x,y\n{lines}")
    recorded = "recorded: {file: track.csv, frame_rate: 10}"
    text = HALL.replace("at: [2, 9], personality: external", recorded)
    a_trial = sim.Trial.parse(
        text.replace("external}\nmachines", "helpful}\nmachines"), folder=tmp_path
    )
    with served(a_trial, hold=True) as session, Client(session.url) as client:
        client.publish("/ariac_human/stop", data=True)
        assert "personality external" in client.error()["msg"]
        client.subscribe("/people_poses", "/ann/odom")
        client.call("/ariac/start_competition")
        assert len(client.message("/people_poses")["poses"]) == 2
        assert client.message("/ann/odom")["pose"]["pose"]["position"]["x"] >= 2.0


def test_two_publishers_of_one_topic_are_reported_once():
    with served(sim.Trial.parse(HALL), hold=True) as session:
        with Client(session.url) as one, Client(session.url) as other:
            for k in range(6):
                for client in (one, other):
                    client.publish("/cmd_vel", linear={"x": 0.1 * k})
                    client.settle()
        lines = [notice for notice in session.notices if "commanded by" in notice]
    assert len(lines) == 1


def test_an_occupied_port_is_reported():
    with relay() as url:
        port = int(url.rpartition(":")[2])
        exchange = Exchange()
        workcell = Workcell(trial(), exchange)

        async def serve():
            await Session(workcell, exchange).open(port=port)

        with pytest.raises(AddressError, match=f"can't serve at 127.0.0.1:{port}"):
            asyncio.run(serve())


def test_an_error_in_a_custom_controller_ends_the_run_with_that_error(tmp_path):
    (tmp_path / "broken_gantry.py").write_text(
        "def broken(gantry):\n    yield gantry.wait(1.0)\n    raise RuntimeError('out of oil')\n"
    )
    text = "floorplan: ariac2023\ngantry: {controller: 'broken_gantry:broken'}\n"
    a_trial = sim.Trial.parse(text, folder=tmp_path)
    with served(a_trial) as session, pytest.raises(sim.ControllerError, match="out of oil"):
        session.join()


def test_actions_are_equal_after_writing_and_reading():
    for x in (-10.8, 1 / 3, 1e-7, 123456.789):
        action = bdi.Literal("move", (x, 0.0))
        assert bdi.parse_literal(str(action)).args[0] == x
