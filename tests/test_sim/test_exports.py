"""Exports, read back with other libraries, equal the run."""

import csv
import json
import re
import shutil
import sqlite3
import subprocess
import sys
from contextlib import closing
from functools import partial
from pathlib import Path

import jupedsim
import numpy as np
import pandas as pd
import pyarrow.parquet as pq
import pytest
from mcap.reader import make_reader
from mcap_protobuf.decoder import DecoderFactory
from rosbags.highlevel import AnyReader
from run_events import record

import sim
from sim.exports.scene import line as log_line

TRIAL = """
name: busy
floorplan: ariac2023
duration: 45.0
people:
  - {name: ada, personality: antagonistic, radius: 0.25}
  - {name: ben-2, personality: helpful, start: {time: 5.0}}
gantry: {at: [-2.5, 0.5, 0.0]}
agvs:
  agv1: [{time: 20.0, to: assembly_front}]
"""
FIGURES = ["x", "y", "rotation", "vx", "vy"]
ENDINGS = [".csv", ".parquet", ".mcap", ".sqlite", ""]


def at(run, body, t):
    """Return x, y, rotation, vx, vy of a body, from its motion alone."""
    state = run.motions[body].state(t)
    return [*state.position, *state.velocity[:2]]


def at_nanosecond(run, body, nanoseconds):
    """Return the same at a time in nanoseconds, which rounding may move across a jump."""
    t = nanoseconds / 1e9
    near = [jump for jump in run.motions[body].jumps if round(jump * 1e9) == nanoseconds]
    return at(run, body, near[0] if near else t)


def around_jumps(run):
    """Return the times just before and at each jump, with the body that jumps."""
    jumps = [(jump, body) for body, motion in run.motions.items() for jump in motion.jumps]
    return [(t, body) for jump, body in sorted(jumps) for t in (jump - 1e-9, jump)]


@pytest.mark.parametrize("rate", [10.0, 7.3])
def test_csv_is_the_run_at_any_rate(run, tmp_path, rate):
    path = tmp_path / "run.csv"
    sim.export(run, path, rate=rate)
    rows = list(csv.DictReader(path.read_text().splitlines()))
    regular = [(t, body) for t in run.sample(rate)["t"].tolist() for body in run.motions]
    expected = sorted([*regular, *around_jumps(run)], key=lambda row: row[0])
    assert [row["body"] for row in rows] == [body for _, body in expected]
    for (t, _), row in zip(expected, rows, strict=True):
        assert float(row["t"]) == pytest.approx(t, abs=1e-9)
        figures = [float(row[name]) for name in FIGURES]
        assert figures == pytest.approx(at(run, row["body"], t), abs=1e-6)


def test_parquet_has_every_digit(run, tmp_path):
    path = tmp_path / "run.parquet"
    sim.export(run, path, rate=7.3)
    table = pd.read_parquet(path)
    samples = run.sample(7.3)
    assert list(table.columns) == ["t", "body", *FIGURES]
    for body in run.motions:
        mine = table[table.body == body]
        is_regular = np.isin(mine.t, samples["t"])
        assert (mine.t[is_regular].to_numpy() == samples["t"]).all()
        assert (mine[FIGURES][is_regular].to_numpy() == samples[body]).all()
        around = [t for t, jumping in around_jumps(run) if jumping == body]
        assert mine.t[~is_regular].tolist() == around
        for t, figures in zip(around, mine[FIGURES][~is_regular].to_numpy(), strict=True):
            assert figures.tolist() == at(run, body, t)
    schema = pq.read_schema(path)
    assert schema.metadata[b"trial"] == b"busy"
    assert schema.field("vx").metadata == {b"unit": b"m/s"}


def test_mcap_is_a_scene_that_moves_as_the_run(run, tmp_path):
    path = tmp_path / "run.mcap"
    sim.export(run, path, rate=10.0)
    with path.open("rb") as file:
        reader = make_reader(file, validate_crcs=True, decoder_factories=[DecoderFactory()])
        messages = list(reader.iter_decoded_messages(log_time_order=False))
        metadata = {record.name: record.metadata for record in reader.iter_metadata()}
    times = [entry.message.log_time for entry in messages]
    assert times == sorted(times)
    assert metadata["floorwalker"]["trial"] == "busy"
    assert json.loads(metadata["floorwalker"]["summary"])["penalties"] == run.summary["penalties"]

    topics = {}
    for entry in messages:
        topic = topics.setdefault(entry.channel.topic, [])
        topic.append((entry.message.log_time, entry.schema.name, entry.decoded_message))
    kinds = {topic: {kind for _, kind, _ in entries} for topic, entries in topics.items()}
    assert kinds["/floor"] == kinds["/bodies"] == kinds["/violations"] == {"foxglove.SceneUpdate"}
    assert kinds["/events"] == {"foxglove.Log"}
    assert kinds["/ada/way"] == {"foxglove.PosesInFrame"}
    assert kinds["/ben-2/pose"] == {"foxglove.PoseInFrame"}

    frames = {"map"}
    for time, _, message in topics["/tf"]:
        for transform in message.transforms:
            assert transform.parent_frame_id == "map"
            frames.add(transform.child_frame_id)
            body, _, part = transform.child_frame_id.partition("/")
            x, y, rotation, *_ = at_nanosecond(run, body, time)
            position = transform.translation.x, transform.translation.y
            if part == "bridge":
                assert position == pytest.approx((x, 0.0), abs=1e-6)
                continue
            assert position == pytest.approx((x, y), abs=1e-6)
            q = transform.rotation
            assert 2 * np.arctan2(q.z, q.w) == pytest.approx(rotation, abs=1e-6)
    entities = [e for topic in ("/floor", "/bodies") for e in topics[topic][0][2].entities]
    assert {entity.frame_id for entity in entities} == frames
    assert all(entity.frame_locked for entity in entities)
    names = [entity.id for entity in entities]
    assert len(set(names)) == len(names)
    assert {f"obstacle {o.name}" for o in run.floorplan.obstacles} < set(names)
    (ada,) = (entity for entity in entities if entity.id == "ada")
    assert ada.cylinders[0].size.x == 0.5
    assert ada.cylinders[0].size.z == run.floorplan.human.height


def test_no_viewer_draws_a_teleport_as_a_slide(run, tmp_path):
    """There are two poses a nanosecond apart, one on each side of a jump."""
    path = tmp_path / "run.mcap"
    sim.export(run, path, rate=2.0)
    (jump, *_) = sorted(run.motions["ada"].jumps)
    with path.open("rb") as file:
        reader = make_reader(file, decoder_factories=[DecoderFactory()])
        positions = {
            decoded.message.log_time: decoded.decoded_message.pose.position
            for decoded in reader.iter_decoded_messages(topics=["/ada/pose"])
        }
    after = round(jump * 1e9)
    zone = run.floorplan.safe_zone.position
    assert (positions[after].x, positions[after].y) == pytest.approx(zone)
    before = run.motions["ada"].state_before(jump).at
    assert (positions[after - 1].x, positions[after - 1].y) == pytest.approx(before, abs=1e-6)


def test_events_and_violations_are_marked_at_their_places(run, tmp_path):
    path = tmp_path / "run.mcap"
    sim.export(run, path, rate=1.0)
    with path.open("rb") as file:
        reader = make_reader(file, decoder_factories=[DecoderFactory()])
        topics = {}
        for entry in reader.iter_decoded_messages(topics=["/events", "/violations"]):
            topics.setdefault(entry.channel.topic, []).append(entry.decoded_message)
    log = topics["/events"]
    assert [line.message.split()[0] for line in log] == [event["kind"] for event in run.events]
    violations = [event for event in run.events if event["kind"] == "violation"]
    assert len(topics["/violations"]) == len(violations)
    for event, mark in zip(violations, topics["/violations"], strict=True):
        (entity,) = mark.entities
        line = entity.lines[1].points
        ends = [np.array([point.x, point.y]) for point in (line[0], line[-1])]
        assert np.linalg.norm(ends[1] - ends[0]) == pytest.approx(event["distance"], abs=1e-5)
        assert entity.lifetime.seconds > 0


def test_events_of_fields_and_traffic_name_all_bodies():
    text = {
        "field_stop": {"machine": "fork", "cause": "intrusion", "person": "eve"},
        "machine_waiting": {"machine": "fork", "for_machine": "cart"},
        "traffic_deadlock": {"machines": ["fork", "cart"]},
    }
    lines = [log_line({"t": 1.0, "kind": kind, **fields}) for kind, fields in text.items()]
    assert [(one.level, one.name, one.text) for one in lines] == [
        ("warning", "eve", "field_stop machine=fork cause=intrusion"),
        ("info", "fork", "machine_waiting for_machine=cart"),
        ("warning", "trial", "traffic_deadlock machines=(fork, cart)"),
    ]


def test_exported_paths_lead_from_goal_to_goal_without_a_jump(run, tmp_path):
    path = tmp_path / "run.mcap"
    sim.export(run, path, rate=1.0)
    goals = [e for e in run.events if e["kind"] == "goal" and e["person"] == "ada"]
    with path.open("rb") as file:
        reader = make_reader(file, decoder_factories=[DecoderFactory()])
        ways = [entry.decoded_message for entry in reader.iter_decoded_messages(["/ada/way"])]
    assert len(ways) == len(goals)
    for goal, way in zip(goals, ways, strict=True):
        x, y, *_ = at(run, "ada", goal["t"] + 1e-8)
        first = way.poses[0].position
        assert (first.x, first.y) == pytest.approx((x, y), abs=1e-6)
        points = np.array([(pose.position.x, pose.position.y) for pose in way.poses])
        assert np.linalg.norm(np.diff(points, axis=0), axis=1).max(initial=0.0) < 10.0
    assert (points[-1] != points[0]).any()


def test_a_ros_bag_has_the_topics_of_rviz(run, tmp_path):
    path = tmp_path / "bag"
    sim.export(run, path, rate=10.0)
    topics = {}
    with AnyReader([path]) as bag:
        for connection, time, raw in bag.messages():
            assert re.fullmatch(
                r"/[A-Za-z][A-Za-z0-9_]*(/[A-Za-z][A-Za-z0-9_]*)?", connection.topic
            )
            message = bag.deserialize(raw, connection.msgtype)
            topics.setdefault((connection.topic, connection.msgtype), []).append((time, message))
    poses = topics["/ben_2/pose", "geometry_msgs/msg/PoseStamped"]
    velocities = topics["/ben_2/velocity", "geometry_msgs/msg/TwistStamped"]
    assert len(poses) == len(velocities) == 451 + 2 * len(run.motions["ben-2"].jumps)
    for (time, pose), (_, velocity) in zip(poses, velocities, strict=True):
        stamp = pose.header.stamp
        assert stamp.sec * 10**9 + stamp.nanosec == time
        x, y, rotation, vx, vy = at_nanosecond(run, "ben-2", time)
        place, turn, twist = pose.pose.position, pose.pose.orientation, velocity.twist.linear
        assert (place.x, place.y, place.z) == pytest.approx((x, y, 0.0), abs=1e-6)
        assert 2 * np.arctan2(turn.z, turn.w) == pytest.approx(rotation, abs=1e-6)
        assert (twist.x, twist.y) == pytest.approx((vx, vy), abs=1e-6)
    ((_, markers),) = topics["/markers", "visualization_msgs/msg/MarkerArray"]
    frames = {
        transform.child_frame_id
        for _, message in topics["/tf", "tf2_msgs/msg/TFMessage"]
        for transform in message.transforms
    }
    assert {marker.header.frame_id for marker in markers.markers} == {"map"} | frames
    assert {"map"} | frames >= {"ada/base", "ben-2/base", "gantry/base", "gantry/bridge"}
    identities = [(marker.ns, marker.id) for marker in markers.markers]
    assert len(set(identities)) == len(identities)
    ways = topics["/ada/way", "nav_msgs/msg/Path"]
    assert all(way.poses for _, way in ways)
    log = topics["/events", "rcl_interfaces/msg/Log"]
    assert len(log) == len(run.events)
    assert ("/violations", "visualization_msgs/msg/MarkerArray") in topics


@pytest.mark.slow
def test_pedpy_reads_people_without_teleports(run, tmp_path):
    pedpy = pytest.importorskip("pedpy", reason="PedPy needs Python 3.11")
    path = tmp_path / "run.sqlite"
    sim.export(run, path, rate=10.0)
    trajectory = pedpy.load_trajectory_from_jupedsim_sqlite(trajectory_file=path)
    area = pedpy.load_walkable_area_from_jupedsim_sqlite(trajectory_file=path)
    assert trajectory.frame_rate == 10.0
    assert pedpy.is_trajectory_valid(traj_data=trajectory, walkable_area=area)
    counts = trajectory.data.groupby("frame").id.nunique()
    assert (counts == 2).all()
    assert len(counts) == 451
    speeds = pedpy.compute_individual_speed(
        traj_data=trajectory,
        frame_step=1,
        speed_calculation=pedpy.SpeedCalculation.BORDER_SINGLE_SIDED,
    )
    assert speeds.speed.max() < run.floorplan.human.max_speed + 1e-6
    with closing(sqlite3.connect(path)) as database:
        (text,) = database.execute(
            "SELECT value FROM metadata WHERE key = 'floorwalker_agents'"
        ).fetchone()
    agents = {agent["id"]: agent["person"] for agent in json.loads(text)}
    assert set(agents.values()) == {"ada", "ben-2"}
    for row in trajectory.data.itertuples():
        state = at(run, agents[row.id], row.frame / 10.0)
        assert (row.x, row.y) == pytest.approx(state[:2], abs=1e-9)


def test_jupedsim_replays_an_export(run, tmp_path):
    path = tmp_path / "run.sqlite"
    sim.export(run, path, rate=4.0)
    recording = jupedsim.Recording(str(path))
    assert recording.num_frames == 181
    assert recording.fps == 4.0
    assert recording.bounds().xmin == run.floorplan.boundary.bounds[0]
    assert recording.geometry().area == pytest.approx(run.floorplan.free(0.0, 1.75).area)
    frame = recording.frame(100)
    assert recording.geometry_id_for_frame(100) == recording.geometry_id_for_frame(0)
    looks = {agent.position: agent.orientation for agent in frame.agents}
    for name in ("ada", "ben-2"):
        x, y, rotation, *_ = at(run, name, 25.0)
        assert looks[x, y] == pytest.approx((np.cos(rotation), np.sin(rotation)))


@pytest.mark.parametrize("ending", ENDINGS)
def test_a_recording_exports_to_the_bytes_of_its_run(run, tmp_path, ending):
    record(run.trial, tmp_path / "recorded")
    contents = []
    for k, source in enumerate((run, run, sim.load_run(tmp_path / "recorded"))):
        path = tmp_path / str(k) / f"out{ending}"
        sim.export(source, path, rate=5.0)
        files = sorted(path.iterdir()) if path.is_dir() else [path]
        contents.append([(file.name, file.read_bytes()) for file in files])
    assert contents[0] == contents[1] == contents[2]


@pytest.mark.parametrize("ending", ENDINGS)
def test_a_floor_without_people_and_machines_is_exported(tmp_path, ending):
    square = "floorplan: square.yaml\nduration: 2.0\n"
    (tmp_path / "square.yaml").write_text("boundary: [[0, 0], [9, 0], [9, 9], [0, 9]]\n")
    run = sim.run(sim.Trial.parse(square, folder=tmp_path))
    sim.export(run, tmp_path / f"out{ending}")
    assert (tmp_path / f"out{ending}").exists()


def test_a_file_is_replaced_and_a_folder_is_not(run, tmp_path):
    path = tmp_path / "run.csv"
    path.write_text("old")
    sim.export(run, path, rate=1.0)
    assert path.read_text().startswith("t,body,x")
    (tmp_path / "bag").mkdir()
    for name in ("bag", "taken.csv"):
        (tmp_path / name).mkdir(exist_ok=True)
        with pytest.raises(sim.OutputError, match="is there already"):
            sim.export(run, tmp_path / name)


@pytest.mark.parametrize(
    ("name", "options", "message"),
    [
        ("run.xlsx", {}, "no format ends in .xlsx; there are .csv"),
        ("run.csv", {"rate": 0.0}, "rate must be more than 0 Hz"),
        ("run.csv", {"rate": float("nan")}, "rate must be more than 0 Hz"),
        ("run.csv", {"format": "mcapp"}, "did you mean 'mcap'"),
    ],
)
def test_files_that_cannot_be_written_are_reported(run, tmp_path, name, options, message):
    with pytest.raises(ValueError, match=re.escape(message)):
        sim.export(run, tmp_path / name, **options)
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(
    ("name", "module", "part"),
    [
        ("run.parquet", "parquet_file", "pyarrow"),
        ("run.mcap", "mcap_file", "foxglove"),
        ("bag", "ros_bag", "rosbags"),
    ],
)
def test_a_missing_package_is_named_with_its_extra(run, tmp_path, monkeypatch, name, module, part):
    gone = [loaded for loaded in sys.modules if loaded.partition(".")[0] == part]
    for loaded in [*gone, part]:
        monkeypatch.setitem(sys.modules, loaded, None)
    for ours in [loaded for loaded in sys.modules if loaded.startswith("sim.exports.ros_")]:
        monkeypatch.delitem(sys.modules, ours)
    monkeypatch.delitem(sys.modules, f"sim.exports.{module}", raising=False)
    with pytest.raises(ValueError, match=re.escape("pip install 'floorwalker[export]'")):
        sim.export(run, tmp_path / name)


FULL_DISK = """
import resource, signal, sys
import sim
from sim.exports.scene import line as log_line
run = sim.run(sim.Trial.parse(open(sys.argv[1]).read()))
signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
for ending in sys.argv[2:]:
    sim.export(run, "whole" + ending)  # loads what it needs
    resource.setrlimit(resource.RLIMIT_FSIZE, (9000, resource.RLIM_INFINITY))
    try:
        sim.export(run, "full" + ending)
    except sim.OutputError as why:
        print(why)
    resource.setrlimit(resource.RLIMIT_FSIZE, (resource.RLIM_INFINITY,) * 2)
"""


@pytest.mark.slow
def test_a_full_disk_is_reported_and_leaves_no_partial_file(tmp_path):
    (tmp_path / "t.yaml").write_text(TRIAL)
    root = Path(__file__).resolve().parents[2]
    done = subprocess.run(
        [sys.executable, "-c", FULL_DISK, "t.yaml", *ENDINGS],
        cwd=tmp_path,
        env={"PYTHONPATH": str(root), "PATH": ""},
        capture_output=True,
        text=True,
        timeout=120,
    )
    assert done.stderr == ""
    lines = done.stdout.splitlines()
    assert len(lines) == len(ENDINGS)
    for ending, line in zip(ENDINGS, lines, strict=True):
        assert line.startswith(f"can't write full{ending}: ")
    left = sorted(path.name for path in tmp_path.iterdir())
    assert left == sorted(["t.yaml", *(f"whole{ending}" for ending in ENDINGS)])


def test_the_command_exports_recordings_and_trials(tmp_path, floorwalker):
    floorwalker = partial(floorwalker, cwd=tmp_path)
    (tmp_path / "busy.trial.yaml").write_text(TRIAL)
    assert floorwalker("run", "busy.trial.yaml", "--out", "rec").returncode == 0
    done = floorwalker("export", "rec", "--out", "a.csv", "--rate", "5")
    assert (done.returncode, done.stderr) == (0, "")
    assert done.stdout == "Wrote 45 s of busy at 5 Hz to a.csv\n"
    assert floorwalker("export", "busy.trial.yaml", "--out", "b", "--format", "csv").returncode == 0
    assert sorted((tmp_path / "a.csv").read_text().splitlines()[0:1]) == [
        "t,body,x,y,rotation,vx,vy"
    ]
    refused = floorwalker("export", "rec", "--out", "c.txt")
    assert refused.returncode == 1
    assert "no format ends in .txt" in refused.stderr
    assert "Traceback" not in refused.stderr
    shutil.rmtree(tmp_path / "rec")
    missing = floorwalker("export", "rec", "--out", "c.csv")
    assert missing.returncode == 1
    assert "rec" in missing.stderr
