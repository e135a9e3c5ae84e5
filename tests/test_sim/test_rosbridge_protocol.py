"""The rosbridge protocol and its messages: operations, types, fragments, queues, trajectories."""

import asyncio
import json
import math

import numpy as np
import pytest
from bridge_parts import Client, served, trial
from hypothesis import assume, given, strategies as st

import floorplan
from navigation import standing
from navigation.motion import State
from sim.bridge.client import MOST_REPLIES, Outbox, TopicQueue
from sim.bridge.messages import (
    MESSAGES,
    MessageError,
    UnknownTypeError,
    conform,
    message_type,
)
from sim.bridge.protocol import (
    Account,
    Fragment,
    Ledger,
    ProtocolError,
    Reassembly,
    Subscribe,
    decode,
    fragments,
)
from sim.competition.machine_topics import trajectory_of
from sim.competition.messages import joint_state, order_message
from sim.machines.gantry.trajectories import (
    JOINTS,
    TrajectoryError,
    joint_values,
    motion_along,
    pose_of,
    target_in,
)
from sim.orders.workload import AssemblyTask, CombinedTask, KittingTask, Order, PartType

JSON = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=20),
    lambda inner: (
        st.lists(inner, max_size=4) | st.dictionaries(st.text(max_size=10), inner, max_size=4)
    ),
    max_leaves=20,
)
MOST = Ledger().most_for_one
OPERATIONS = st.sampled_from(
    ["advertise", "unadvertise", "publish", "subscribe", "unsubscribe", "call_service"]
) | st.sampled_from(["set_level", "status", "fragment"])


def test_an_operation_is_read():
    text = '{"op": "subscribe", "id": "one", "topic": "/clock", "throttle_rate": 100, "more": 1}'
    operation = decode(text)
    assert isinstance(operation, Subscribe)
    assert (operation.topic, operation.throttle_rate, operation.id) == ("/clock", 100, "one")


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("{", "not JSON"),
        ("[1, 2]", '"op"'),
        ('"hello"', '"op"'),
        ('{"op": 3}', '"op"'),
        ('{"op": "dance"}', "unknown operation 'dance'"),
        ('{"op": "publish", "msg": {}}', "topic"),
        ('{"op": "publish", "topic": 5, "msg": {}}', "topic"),
        ('{"op": "publish", "topic": "/a", "msg": {"x": NaN}}', "not JSON"),
        ('{"op": "subscribe", "topic": "/a", "throttle_rate": -1}', "throttle_rate"),
        ('{"op": "set_level", "level": "loud"}', "level"),
        ("[" * 100_000, "not JSON"),
        (" " * 1_000_001, "is the maximum"),
        (b"\xff\x00", "not JSON"),
    ],
)
def test_an_invalid_operation_is_rejected(text, words):
    with pytest.raises(ProtocolError) as caught:
        decode(text)
    assert words in str(caught.value)
    assert "\n" not in str(caught.value)


def test_an_error_names_the_interaction_that_it_is_about():
    with pytest.raises(ProtocolError) as caught:
        decode('{"op": "publish", "id": "seven", "topic": 5}')
    assert caught.value.id == "seven"


@given(
    st.fixed_dictionaries(
        {"op": OPERATIONS | JSON},
        optional={"topic": JSON, "msg": JSON, "id": JSON},
    )
    | JSON
)
def test_any_json_is_an_operation_or_an_error(data):
    text = json.dumps(data)
    try:
        operation = decode(text)
    except ProtocolError as why:
        assert str(why)
    else:
        assert operation.op == data["op"]


def test_types_are_those_of_ros():
    """Compare with the .msg files of ROS 2, which has no ariac_msgs."""
    typesys = pytest.importorskip("rosbags.typesys")
    store = typesys.get_typestore(typesys.Stores.ROS2_HUMBLE)
    theirs = [type_ for name, type_ in MESSAGES.items() if name in store.types and type_.fields]
    assert len(theirs) > 15
    for type_ in theirs:
        text, _, _ = store.generate_msgdef(type_.name, ros_version=2)[0].partition("=" * 80)
        ours = [f"{kind.replace('/msg/', '/')} {name}" for name, kind in type_.fields.items()]
        assert text.strip().splitlines() == ours


def test_types_have_two_names():
    assert message_type("std_msgs/Bool") is message_type("std_msgs/msg/Bool")
    with pytest.raises(UnknownTypeError, match="did you mean"):
        message_type("std_msgs/Boll")


@pytest.mark.parametrize(
    ("type_", "message", "words"),
    [
        ("geometry_msgs/Point", {"x": "1"}, "x should be a float64, not '1'"),
        ("geometry_msgs/Point", {"x": True}, "x should be a float64, not True"),
        ("geometry_msgs/Point", {"x": math.inf}, "x is not a finite number"),
        ("geometry_msgs/Point", {"x": 10**400}, "x is not a finite number"),
        ("geometry_msgs/Point", {"X": 1.0}, "has no field 'X' (there are: x, y, z)"),
        ("geometry_msgs/Point", [1, 2, 3], "should be a geometry_msgs/msg/Point, not a list"),
        ("std_msgs/Bool", {"data": 1}, "data should be a bool, not 1"),
        ("ariac_msgs/Part", {"color": 256}, "color = 256 is outside 0 … 255"),
        ("ariac_msgs/Part", {"color": 1.5}, "color should be a whole number, not 1.5"),
        ("ariac_msgs/Part", {"color": math.nan}, "color should be a whole number, not nan"),
        ("ariac_msgs/Part", {"color": 10**400}, "color = a huge number is outside 0 … 255"),
        ("ariac_msgs/AGVStatus", {"location": -129}, "location = -129 is outside -128 … 127"),
        ("sensor_msgs/JointState", {"name": "a"}, "name should be a list of string"),
        ("sensor_msgs/JointState", {"name": ["a", 1]}, "name[1] should be a string, not 1"),
        ("sensor_msgs/JointState", {"position": [0.0] * 10_001}, "10000 is the maximum"),
        (
            "tf2_msgs/TFMessage",
            {"transforms": [{"transform": {"rotation": {"w": None}}}]},
            "transforms[0].transform.rotation.w should be a float64, not None",
        ),
    ],
)
def test_an_invalid_message_is_rejected_with_its_place(type_, message, words):
    with pytest.raises(MessageError) as caught:
        conform(message_type(type_), message)
    assert words in str(caught.value)
    assert len(str(caught.value)) < 300


@given(st.sampled_from(sorted(MESSAGES)), JSON)
def test_a_valid_message_is_complete_and_can_be_sent(name, data):
    type_ = MESSAGES[name]
    try:
        message = conform(type_, data)
    except MessageError:
        return
    assert list(message) == list(type_.fields)
    assert conform(type_, json.loads(json.dumps(message, allow_nan=False))) == message


@given(st.text(max_size=2000), st.integers(1, 500), st.randoms(use_true_random=False))
def test_fragments_in_any_order_restore_the_message(text, size, random):
    pieces = list(fragments(text, size, "it"))
    if len(text) <= size:
        assert pieces == [text]
        return
    random.shuffle(pieces)
    account = an_account()
    reassembly = Reassembly(account)
    whole = [reassembly.add(decode(piece)) for piece in pieces]
    assert whole[:-1] == [None] * (len(pieces) - 1)
    assert whole[-1] == text
    assert account.held == 0


def an_account(let_go=lambda why: None):
    return Account(Ledger(), let_go)


def fragment(id, num, total, data="x"):
    return Fragment(op="fragment", id=id, num=num, total=total, data=data)


def test_the_number_of_fragments_is_bounded():
    account = an_account()
    reassembly = Reassembly(account)
    with pytest.raises(ProtocolError, match="more than"):
        for num in range(100):
            reassembly.add(fragment("big", num, 1000, "x" * 100_000))
    with pytest.raises(ProtocolError, match="are the maximum"):
        for id in range(100):
            reassembly.add(fragment(f"many{id}", 0, 2))
    with pytest.raises(ProtocolError, match="fragment 3 of 2"):
        reassembly.add(fragment("odd", 3, 2))
    assert account.held
    reassembly.clear()
    assert account.held == 0


def everything_in(outbox):
    async def read():
        messages = []
        while outbox:
            messages.append((await outbox.get())[0])
        return messages

    return asyncio.run(read())


def test_the_oldest_messages_of_a_topic_are_dropped_when_too_many_wait():
    account = an_account()
    outbox = Outbox(account)
    short, long = TopicQueue(2), TopicQueue(10)
    for k in range(4):
        outbox.put(short, f"short{k}")
        outbox.put(long, f"long{k}")
        outbox.reply(f"reply{k}")
    expected = ["long0", "reply0", "long1", "reply1"]
    for k in (2, 3):
        expected += [f"short{k}", f"long{k}", f"reply{k}"]
    assert everything_in(outbox) == expected
    last = account.held
    assert 0 < last < 200  # the last message read is still under way


def test_held_messages_of_a_topic_are_sent_after_their_release():
    account = an_account()
    outbox, queue = Outbox(account), TopicQueue(2)
    outbox.put(queue, "ready")
    for k in range(3):  # drops "ready", then the oldest one that is held
        outbox.put(queue, f"held{k}", held=True)
    assert everything_in(outbox) == []
    outbox.release(queue)
    assert everything_in(outbox) == ["held1"]
    under_way = account.held
    outbox.drop(queue)
    assert 0 < account.held < under_way
    assert everything_in(outbox) == []


def test_messages_that_cannot_be_dropped_are_bounded():
    for text, many, words in (
        ("x", MOST_REPLIES, f"{MOST_REPLIES} answers wait"),
        ("x" * 100_000, MOST // 100_000, f"more than {MOST} bytes"),
        ("\U0001f600" * 25_000, MOST // 100_000, f"more than {MOST} bytes"),
    ):
        refused = []
        outbox = Outbox(an_account(refused.append))
        for _ in range(many - 1):
            outbox.reply(text)
        assert refused == []
        for _ in range(5):
            outbox.reply(text)
        assert len(refused) == 1
        assert words in refused[0]
        assert len(outbox) <= many


def test_the_client_with_the_most_waiting_data_is_disconnected():
    ledger, gone = Ledger(most_for_all=10_000_000), []
    accounts = [Account(ledger, lambda _, k=k: gone.append(k)) for k in range(30)]
    for round in range(1, 8):
        for k, account in enumerate(accounts):
            account.add(1_000_000 if k % 2 else round)
            assert ledger.held <= ledger.most_for_all
    assert gone
    assert all(k % 2 for k in gone)
    for account in accounts:
        account.close()
    assert ledger.held == 0


def test_waiting_messages_of_a_topic_can_be_dropped():
    account = an_account()
    outbox = Outbox(account)
    stream = TopicQueue(10)
    outbox.reply("kept")
    before = account.held
    outbox.put(stream, "gone")
    outbox.drop(stream)
    assert account.held == before
    assert everything_in(outbox) == ["kept"]


PUMP, BATTERY = PartType("purple", "pump"), PartType("red", "battery")


@pytest.mark.parametrize(
    ("order", "expected"),
    [
        (
            Order(
                "K1",
                KittingTask(agv="agv4", tray=3, destination="warehouse", products={3: PUMP}),
                priority=True,
            ),
            {
                "type": 0,
                "priority": True,
                "kitting_task": {
                    "agv_number": 4,
                    "tray_id": 3,
                    "destination": 3,
                    "parts": [{"part": {"color": 4, "type": 11}, "quadrant": 3}],
                },
            },
        ),
        (
            Order("K2", KittingTask(agv="agv1", tray=3, destination="as2", products={1: BATTERY})),
            {"type": 0, "priority": False, "kitting_task": {"destination": 2}},
        ),
        (
            Order("A1", AssemblyTask("as2", ("agv1", "agv2"), (BATTERY,))),
            {"type": 1, "assembly_task": {"agv_numbers": [1, 2], "station": 2}},
        ),
        (Order("C1", CombinedTask("as4", (PUMP,))), {"type": 2, "combined_task": {"station": 4}}),
    ],
)
def test_an_order_is_a_message_of_the_competition(order, expected):
    message = order_message(order, floorplan.load("ariac2023"))
    message = conform(message_type("ariac_msgs/Order"), message)
    assert message["id"] == order.id
    for field, value in expected.items():
        if isinstance(value, dict):
            assert value.items() <= message[field].items()
        else:
            assert message[field] == value
    for task in ("assembly_task", "combined_task"):
        for part in message[task]["parts"]:
            assert part["part"] in ({"color": 4, "type": 11}, {"color": 0, "type": 10})


GANTRY = floorplan.load("ariac2023").gantry
TYPE = message_type("trajectory_msgs/JointTrajectory")
HOME = standing((-7.0, 0.0)).state(0.0)
TOPIC = "/gantry_controller/joint_trajectory"


def trajectory(*points, names=JOINTS):
    """Return the trajectory of a message. See `message_of`."""
    return trajectory_of(message_of(*points, names=names))


def message_of(*points, names=JOINTS):
    """Return a message of points (time, positions) or (time, positions, velocities)."""
    written = []
    for t, positions, *velocities in points:
        whole, rest = divmod(t, 1.0)
        written.append(
            {
                "positions": list(positions),
                "velocities": list(velocities[0]) if velocities else [],
                "time_from_start": {"sec": int(whole), "nanosec": round(rest * 1e9)},
            }
        )
    return conform(TYPE, {"joint_names": list(names), "points": written})


def test_the_joints_are_those_of_the_competition():
    """The lane of agv1 is at y = 4.8 in the world, and at −4.8 in programs of the competition."""
    assert joint_values(GANTRY, (-7.0, 0.0, 0.0)) == pytest.approx((0.0, 0.0, 0.0))
    assert pose_of(GANTRY, (3.835, -4.8, 1.5)) == pytest.approx((-3.165, 4.8, 1.5))
    state = State((-6.0, 1.0, 0.5), (0.1, 0.2, 0.3), (0.0, 0.0, 0.0))
    reading = joint_state(1.5, GANTRY, state)
    assert reading["position"] == pytest.approx([1.0, -1.0, 0.5])
    assert reading["velocity"] == pytest.approx([0.1, -0.2, 0.3])
    assert reading["header"]["stamp"] == {"sec": 1, "nanosec": 500_000_000}


def test_a_trajectory_goes_through_its_points_at_their_times():
    message = trajectory(
        (4.0, (0.5, -0.5, 0.1), (0.2, -0.1, 0.0)), (8.0, (1.0, -0.7, 0.4), (0, 0, 0))
    )
    motion = motion_along(GANTRY, HOME, 10.0, message)
    assert (motion.start, motion.end) == (10.0, 18.0)
    middle = motion.state(14.0)
    assert middle.position == pytest.approx((-6.5, 0.5, 0.1))
    assert middle.velocity == pytest.approx((0.2, 0.1, 0.0))
    assert motion.state(18.0).position == pytest.approx((-6.0, 0.7, 0.4))


def test_joints_may_come_in_any_order_and_the_first_point_may_be_the_current_one():
    names = ("gantry_rotation_joint", "gantry_y_axis_joint", "gantry_x_axis_joint")
    message = trajectory((0.0, (0, 0, 0)), (5.0, (0.3, 0.2, 0.1)), names=names)
    motion = motion_along(GANTRY, HOME, 0.0, message)
    assert motion.state(5.0).position == pytest.approx((-6.9, -0.2, 0.3))


def test_a_trajectory_without_velocities_passes_its_points_without_a_stop():
    message = trajectory((4.0, (1, 0, 0)), (8.0, (2, 0, 0)), (12.0, (3, 0, 0)), (18.0, (3, 1, 0)))
    motion = motion_along(GANTRY, HOME, 0.0, message)
    assert motion.velocity(4.0) == pytest.approx((0.25, 0.0))
    assert motion.velocity(12.0) == pytest.approx((0.0, 0.0))


def test_one_point_without_a_time_is_just_a_target():
    message = trajectory((0.0, (1.0, -2.0, 0.5)))
    assert target_in(GANTRY, message) == pytest.approx((-6.0, 2.0, 0.5))
    assert target_in(GANTRY, trajectory((1.0, (1.0, -2.0, 0.5)))) is None


@pytest.mark.parametrize(
    ("message", "words"),
    [
        (trajectory(), "without points"),
        (trajectory((1.0, (0, 0)), names=JOINTS[:2]), "joint_names should be"),
        (trajectory((1.0, (0, 0))), "points[0] has 2 positions for 3 joints"),
        (trajectory((1.0, (0, 0, 0), (1,))), "points[0] has 1 velocities"),
        (trajectory((2.0, (0, 0, 0)), (2.0, (0, 0, 0))), "points[1] comes at 2 s, not after 2 s"),
        (trajectory((0.0, (0.5, 0, 0)), (5.0, (1, 0, 0))), "begins 0.500 m or rad from"),
        (trajectory((0.0, (0, 0, 0), (0, 0, 0))), "ends where it begins"),
        (trajectory((5.0, (0.5, 0, 0), (0.1, 0, 0))), "does not end at rest"),
        (trajectory((1.0, (3.0, 0, 0))), "gantry_x_axis_joint would move at"),
        (trajectory((1.0, (0.2, 0, 0))), "gantry_x_axis_joint would accelerate by 1.2 m/s²"),
        (trajectory((1.0, (0, 0, 0.2))), "gantry_rotation_joint would accelerate by 1.2 rad/s²"),
        (trajectory((60.0, (0, 7.5, 0))), "outside the gantry's range"),
        (
            trajectory((30.0, (7.3, 0, 0), (0.4, 0, 0)), (34.0, (7.3, 0, 0), (0, 0, 0))),
            "outside the gantry's range",
        ),
    ],
)
def test_a_trajectory_that_the_gantry_cannot_follow_is_rejected(message, words):
    with pytest.raises(TrajectoryError) as caught:
        motion_along(GANTRY, HOME, 0.0, message)
    assert words in str(caught.value)


@given(
    st.lists(
        st.tuples(
            st.floats(0.5, 30.0),
            st.tuples(st.floats(-7.0, 7.0), st.floats(-6.5, 6.5), st.floats(-3.0, 3.0)),
        ),
        min_size=1,
        max_size=4,
    )
)
def test_an_accepted_trajectory_stays_within_the_limits_at_all_times(steps):
    t, points = 0.0, []
    for duration, joints in steps:
        t += duration
        points.append((round(t, 6), joints))
    try:
        motion = motion_along(GANTRY, HOME, 0.0, trajectory(*points))
    except TrajectoryError:
        assume(False)
    times = np.linspace(0.0, motion.end, 2000)
    x, y = motion.position(times).T
    assert x.min() >= GANTRY.x.low and x.max() <= GANTRY.x.high
    assert y.min() >= GANTRY.y.low and y.max() <= GANTRY.y.high
    for axis, speeds in zip((GANTRY.x, GANTRY.y), motion.velocity(times).T, strict=True):
        assert np.abs(speeds).max() <= axis.max_speed * 1.011
        assert np.abs(np.gradient(speeds, times)).max() <= axis.max_acceleration * 1.02
    for t, joints in points:
        assert joint_values(GANTRY, motion.state(t).position) == pytest.approx(joints, abs=1e-6)


def send(client, message):
    client.send(op="publish", topic=TOPIC, msg=message)


def test_an_external_controller_moves_the_gantry():
    """The rules apply: the gantry is disabled when it comes too close, and an error reports it."""
    a_trial = trial("indifferent", duration=20.0, controller="external", start=10.0)
    with served(a_trial, speed=20.0) as session, Client(session.url) as client:
        assert "no gantry controller" in session.notices[-1]
        client.send(op="advertise", topic=TOPIC, type="trajectory_msgs/JointTrajectory")
        client.subscribe("/joint_states", "/ariac/robot_health")
        client.message("/joint_states")
        send(client, message_of((6.0, (3.5, -0.5, 0.5), (0, 0, 0))))
        reached = client.hear_until(
            lambda heard: heard["topic"] == "/joint_states" and heard["msg"]["position"][0] == 3.5
        )
        assert reached["msg"]["position"] == pytest.approx([3.5, -0.5, 0.5])
        send(client, message_of((0.0, (-7.2, 6.5, 0.0))))
        client.hear_until(
            lambda heard: (
                heard["topic"] == "/ariac/robot_health" and not heard["msg"]["ceiling_robot"]
            )
        )
        send(client, message_of((0.0, (0.0, 0.0, 0.0))))
        assert client.error()["msg"] == "the gantry is disabled"
        run = session.join()
    assert run.summary["penalties"] >= 1
    begun = run.motions["gantry"]
    assert begun.position(0.0) == pytest.approx((-2.5, 0.5))


def test_a_gantry_with_an_internal_controller_accepts_no_trajectories():
    with served(trial(), hold=True) as session, Client(session.url) as client:
        send(client, message_of((0.0, (0.0, 0.0, 0.0))))
        assert "no topic is called" in client.error()["msg"]
