"""The rosbridge protocol: operations, message types, fragments, queues."""

import asyncio
import json
import math

import pytest
from hypothesis import given, strategies as st

from sim.bridge.client import MOST_REPLIES, Outbox, TopicQueue
from sim.bridge.messages import MESSAGES, MessageError, UnknownTypeError, conform, message_type
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
    ("text", "told"),
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
        (" " * 1_000_001, "is the most"),
        (b"\xff\x00", "not JSON"),
    ],
)
def test_what_is_no_operation_is_told(text, told):
    with pytest.raises(ProtocolError) as caught:
        decode(text)
    assert told in str(caught.value)
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
def test_nothing_but_an_operation_or_an_error_comes_of_any_json(data):
    text = json.dumps(data)
    try:
        operation = decode(text)
    except ProtocolError as why:
        assert str(why)
    else:
        assert operation.op == data["op"]


def test_types_are_those_of_ros():
    """The fields are those of the .msg files of ROS 2, which has no ariac_msgs."""
    typesys = pytest.importorskip("rosbags.typesys")
    store = typesys.get_typestore(typesys.Stores.ROS2_HUMBLE)
    theirs = [type_ for name, type_ in MESSAGES.items() if name in store.types and type_.fields]
    assert len(theirs) > 15
    for type_ in theirs:
        text, _, _ = store.generate_msgdef(type_.name, ros_version=2)[0].partition("=" * 80)
        ours = [f"{kind.replace('/msg/', '/')} {name}" for name, kind in type_.fields.items()]
        assert text.strip().splitlines() == ours


def test_types_go_by_either_name():
    assert message_type("std_msgs/Bool") is message_type("std_msgs/msg/Bool")
    with pytest.raises(UnknownTypeError, match="did you mean"):
        message_type("std_msgs/Boll")


@pytest.mark.parametrize(
    ("type_", "message", "told"),
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
        ("sensor_msgs/JointState", {"position": [0.0] * 10_001}, "10000 is the most"),
        (
            "tf2_msgs/TFMessage",
            {"transforms": [{"transform": {"rotation": {"w": None}}}]},
            "transforms[0].transform.rotation.w should be a float64, not None",
        ),
    ],
)
def test_what_is_wrong_in_a_message_is_told_with_its_place(type_, message, told):
    with pytest.raises(MessageError) as caught:
        conform(message_type(type_), message)
    assert told in str(caught.value)
    assert len(str(caught.value)) < 300


@given(st.sampled_from(sorted(MESSAGES)), JSON)
def test_whatever_conforms_is_complete_and_can_be_sent(name, data):
    type_ = MESSAGES[name]
    try:
        message = conform(type_, data)
    except MessageError:
        return
    assert list(message) == list(type_.fields)
    assert conform(type_, json.loads(json.dumps(message, allow_nan=False))) == message


@given(st.text(max_size=2000), st.integers(1, 500), st.randoms(use_true_random=False))
def test_fragments_in_any_order_make_the_message_again(text, size, random):
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


def test_fragments_do_not_pile_up():
    account = an_account()
    reassembly = Reassembly(account)
    with pytest.raises(ProtocolError, match="more than"):
        for num in range(100):
            reassembly.add(fragment("big", num, 1000, "x" * 100_000))
    with pytest.raises(ProtocolError, match="are the most"):
        for id in range(100):
            reassembly.add(fragment(f"many{id}", 0, 2))
    with pytest.raises(ProtocolError, match="fragment 3 of 2"):
        reassembly.add(fragment("odd", 3, 2))
    assert account.held
    reassembly.clear()
    assert account.held == 0


def everything_in(outbox):
    async def read():
        found = []
        while outbox:
            found.append((await outbox.get())[0])
        return found

    return asyncio.run(read())


def test_the_oldest_messages_of_a_topic_go_first_when_too_many_wait():
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
    assert 0 < last < 200  # what was handed out last is under way


def test_what_can_not_be_thrown_away_is_bounded():
    for text, many, told in (
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
        assert told in refused[0]
        assert len(outbox) <= many


def test_of_all_clients_the_one_with_the_most_is_let_go():
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


def test_what_waits_of_a_topic_can_be_dropped():
    account = an_account()
    outbox = Outbox(account)
    stream = TopicQueue(10)
    outbox.reply("kept")
    before = account.held
    outbox.put(stream, "gone")
    outbox.drop(stream)
    assert account.held == before
    assert everything_in(outbox) == ["kept"]
