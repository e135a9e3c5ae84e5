"""Recorded people from ROS 2 bags: poses, odometry, people and transforms."""

import math

import numpy as np
import pytest

import sim

rosbag2 = pytest.importorskip("rosbags.rosbag2")
typesys = pytest.importorskip("rosbags.typesys")

HALL = """\
floorplan:
  boundary: [[0, 0], [20, 0], [20, 10], [0, 10]]
  stations: {west: [1, 5], east: [19, 5]}
  safe_zone: {at: [1, 1]}
duration: 12
"""
EPOCH = 1_700_000_000

PEOPLE = {
    "people_msgs/msg/Person": "string name\ngeometry_msgs/Point position\n"
    "geometry_msgs/Point velocity\nfloat64 reliability\nstring[] tagnames\nstring[] tags\n",
    "people_msgs/msg/People": "std_msgs/Header header\npeople_msgs/Person[] people\n",
}

store = typesys.get_typestore(typesys.Stores.ROS2_HUMBLE)
for kind, definition in PEOPLE.items():
    store.register(typesys.get_types_from_msg(definition, kind))
made = store.types


def header(t, frame="map"):
    stamp = made["builtin_interfaces/msg/Time"](EPOCH + int(t), round(t % 1 * 1e9))
    return made["std_msgs/msg/Header"](stamp, frame)


def point(x, y):
    return made["geometry_msgs/msg/Point"](x, y, 0.0)


def turned(yaw):
    return made["geometry_msgs/msg/Quaternion"](0.0, 0.0, math.sin(yaw / 2), math.cos(yaw / 2))


def pose(x, y, yaw=0.0):
    return made["geometry_msgs/msg/Pose"](point(x, y), turned(yaw))


def stamped(t, x, y, yaw=0.0, frame="map"):
    return made["geometry_msgs/msg/PoseStamped"](header(t, frame), pose(x, y, yaw))


def odometry(t, x, y, yaw=0.0):
    nothing = made["geometry_msgs/msg/Vector3"](0.0, 0.0, 0.0)
    twist = made["geometry_msgs/msg/Twist"](nothing, nothing)
    unsure = np.zeros(36)
    return made["nav_msgs/msg/Odometry"](
        header(t, "odom"),
        "base",
        made["geometry_msgs/msg/PoseWithCovariance"](pose(x, y, yaw), unsure),
        made["geometry_msgs/msg/TwistWithCovariance"](twist, unsure),
    )


def people(t, **places):
    some = [
        made["people_msgs/msg/Person"](name, point(*at), point(0.0, 0.0), 1.0, [], [])
        for name, at in places.items()
    ]
    return made["people_msgs/msg/People"](header(t), some)


def transform(t, x, y, child, parent="map"):
    moved = made["geometry_msgs/msg/Transform"](
        made["geometry_msgs/msg/Vector3"](x, y, 0.0), turned(0.0)
    )
    one = made["geometry_msgs/msg/TransformStamped"](header(t, parent), child, moved)
    return made["tf2_msgs/msg/TFMessage"]([one])


def a_bag(path, topics, storage="MCAP"):
    """Write messages by topic, as (seconds, message), into a bag with rosbags' own writer."""
    plugin = rosbag2.StoragePlugin[storage]
    with rosbag2.Writer(path, version=8, storage_plugin=plugin) as bag:
        for topic, messages in topics.items():
            kind = messages[0].__msgtype__
            connection = bag.add_connection(topic, kind, typestore=store)
            for k, message in enumerate(messages):
                data = store.serialize_cdr(message, kind)
                bag.write(connection, (EPOCH + 5) * 10**9 + k, data)
    return path


TIMES = np.arange(0.0, 8.01, 0.5)


@pytest.mark.parametrize("storage", ["SQLITE3", "MCAP"])
def test_recorded_people_walk_as_in_a_bag(tmp_path, storage):
    """They pass every pose at the header's time. A folder, its file, or one body may be named."""
    topics = {
        "/eve/pose": [stamped(t, 2 + t, 5.0, 0.5) for t in TIMES],
        "/robot/odom": [odometry(t + 0.25, 2 + 1.5 * t, 7.0) for t in TIMES],
        "/seen": [people(t, mo=(3.0 + t, 2.0), **{"ann b": (17.0 - t, 3.0)}) for t in TIMES],
        "/tf": [transform(t, 4.0 + t, 9.0, "cart") for t in TIMES],
    }
    a_bag(tmp_path / "bag", topics, storage)
    (file,) = (one.name for one in (tmp_path / "bag").iterdir() if one.suffix in (".mcap", ".db3"))
    text = (
        HALL
        + "people:\n  - {name: eve, recorded: bag}\n"
        + "".join(
            f"  - {{name: p{k}, recorded: {{file: bag/{file}, body: {body}}}}}\n"
            for k, body in enumerate(["robot", "mo", "ann b", "cart", "/eve/pose"])
        )
    )
    run = sim.run(sim.Trial.parse(text, folder=tmp_path))

    def at(name, t):
        return run.motions[name].position(t)

    assert np.allclose(at("eve", TIMES), np.column_stack([2 + TIMES, 0 * TIMES + 5]))
    assert run.motions["eve"].state(2.0).position[2] == pytest.approx(0.5)
    assert np.allclose(at("p0", TIMES + 0.25)[:, 0], 2 + 1.5 * TIMES)
    assert np.allclose(at("p1", 4.0), (7.0, 2.0)) and np.allclose(at("p2", 4.0), (13.0, 3.0))
    assert np.allclose(at("p3", 4.0), (8.0, 9.0)) and np.allclose(at("p4", 4.0), (6.0, 5.0))


def test_a_run_that_was_exported_can_be_walked_again(tmp_path):
    text = HALL + "people: [{name: eve, personality: indifferent, at: [1, 5]}]\n"
    first = sim.run(sim.Trial.parse(text))
    sim.export(first, tmp_path / "bag", rate=20.0)
    again = sim.Trial.parse(HALL + "people: [{name: eve, recorded: bag}]\n", folder=tmp_path)
    times = np.arange(0.0, 12.0, 0.35)
    apart = sim.run(again).motions["eve"].position(times) - first.motions["eve"].position(times)
    assert np.hypot(*apart.T).max() < 0.01
    study = sim.Study("again", (again,))
    assert any("bag" in name for name in sim.studies.folder.identity(study))


WALK = [stamped(t, 2 + t, 5.0) for t in TIMES]
BAD = {
    "nowhere": (
        {"/eve/pose": [*WALK[:3], stamped(1.5, math.nan, 5.0)]},
        "topic /eve/pose, message 3: (nan, 5) is not a place",
    ),
    "another frame": (
        {"/eve/pose": [*WALK[:3], stamped(1.5, 3.5, 5.0, frame="odom")]},
        "topic /eve/pose, message 3: is in the frame 'odom', those before in 'map'",
    ),
    "a jump": (
        {"/eve/pose": [*WALK[:3], stamped(1.5, 15.0, 5.0)]},
        "topic /eve/pose, message 3: a jump of 12 m in 0.5 s",
    ),
    "a gap": (
        {"/eve/pose": [*WALK[:3], *WALK[9:]]},
        "topic /eve/pose, message 3: a gap of 3.5 s",
    ),
    "no poses": (
        {"/eve": [made["std_msgs/msg/String"]("here")]},
        "has no topic of a type with poses: geometry_msgs/msg/PoseStamped",
    ),
    "a frame that moves": (
        {"/tf": [transform(0.0, 1.0, 1.0, "cart"), transform(1.0, 2.0, 1.0, "cart")],
         "/tf2": [transform(0.0, 1.0, 1.0, "eve", "cart")]},
        "topic /tf2, message 0: 'eve' is in the frame 'cart', which moves itself",
    ),
    "another body": ({"/mo/pose": WALK, "/lu/pose": WALK}, "no body is called 'eve'"),
}  # fmt: skip


@pytest.mark.parametrize("name", BAD)
def test_bad_bags_are_rejected_with_topic_and_message(tmp_path, name):
    topics, message = BAD[name]
    a_bag(tmp_path / "bag", topics)
    with pytest.raises(sim.TrialError) as refused:
        sim.Trial.parse(HALL + "people: [{name: eve, recorded: bag}]\n", folder=tmp_path)
    assert message in str(refused.value) and "bag" in str(refused.value)


def test_a_folder_that_is_no_bag_is_an_error(tmp_path):
    (tmp_path / "empty").mkdir()
    for name in ("text.mcap", "text.parquet"):
        (tmp_path / name).write_text("t,name,x,y\n")
    (tmp_path / "run").mkdir()
    (tmp_path / "run" / "scene.json").write_text("{}")
    for file, message in {
        "empty": "there is no metadata.yaml in it",
        "text.mcap": "is no ROS 2 bag that can be read",
        "text.parquet": "is no Parquet file that can be read",
        "run": "this folder is a recorded run: give its trajectory.csv",
        "gone.mcap": "there is no such file",
    }.items():
        with pytest.raises(sim.TrialError, match=message):
            sim.Trial.parse(HALL + f"people: [{{name: e, recorded: {file}}}]\n", folder=tmp_path)


def test_a_bag_without_definitions_of_people_is_read(tmp_path):
    """SQLite bags before version 9 of the format contain no definitions."""
    a_bag(tmp_path / "bag", {"/seen": [people(t, mo=(3.0 + t, 2.0)) for t in TIMES]}, "SQLITE3")
    trial = sim.Trial.parse(HALL + "people: [{name: mo, recorded: bag}]\n", folder=tmp_path)
    at = sim.run(trial).motions["mo"].position(TIMES[1] - TIMES[0])
    assert at == pytest.approx((3.0 + TIMES[1], 2.0))
