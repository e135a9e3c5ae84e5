"""The command `floorwalker ros2` with clients of a real rclpy, each in a process of its own."""

import math

import pytest
import shapely
from cells import COMPETITION, GANTRY, HANG, antagonist, hall

import sim

pytestmark = pytest.mark.slow

PENDING, COMPLETED, FAILED = 0, 1, 3
"""States of a nav2_msgs/WaypointStatus."""

UNSUPPORTED, OK, NOT_FOUND, OPERATION_FAILED, ALREADY = 0, 1, 2, 4, 101
"""Results of simulation_interfaces."""

PAUSED, PLAYING, STOPPED = 2, 1, 0
"""States of a simulation."""


def lines(folder, name):
    return (folder / name).read_bytes()


@pytest.mark.messages("people_msgs", "hunav_msgs")
def test_every_topic_has_its_type(ros):
    types = {
        "/clock": "rosgraph_msgs/msg/Clock",
        "/tf": "tf2_msgs/msg/TFMessage",
        "/tf_static": "tf2_msgs/msg/TFMessage",
        "/map": "nav_msgs/msg/OccupancyGrid",
        "/odom": "nav_msgs/msg/Odometry",
        "/cmd_vel": "geometry_msgs/msg/TwistStamped",
        "/scan": "sensor_msgs/msg/LaserScan",
        "/initialpose": "geometry_msgs/msg/PoseWithCovarianceStamped",
        "/people": "people_msgs/msg/People",
        "/human_states": "hunav_msgs/msg/Agents",
        "/people_poses": "geometry_msgs/msg/PoseArray",
        "/markers": "visualization_msgs/msg/MarkerArray",
        "/separation_markers": "visualization_msgs/msg/MarkerArray",
        "/diagnostics": "diagnostic_msgs/msg/DiagnosticArray",
        "/events": "std_msgs/msg/String",
    }
    with ros.serving(hall()):
        shown = ros.client("topics", names=[*types])
    assert {topic: shown[topic] for topic in types} == {k: [v] for k, v in types.items()}


def test_a_vehicle_stops_before_a_wall_and_its_scan_shows_the_wall_and_a_person(ros):
    with ros.serving(hall(), "--speed", "4"):
        seen = ros.client("drive", speed=1.0)
    x, y, heading = seen["odom"]
    assert 5.45 < 2.0 + x < 7.51 and y == pytest.approx(0.0, abs=1e-6)
    at = shapely.Point(2.0 + x, 6.5 + y)
    room = shapely.box(0, 0, 20, 12) - shapely.box(8, 6, 12, 7)
    seen_by_rays = shapely.union(
        room.boundary, shapely.Point(6, 4).buffer(0.3, quad_segs=5000).exterior
    )
    for k, distance in enumerate(seen["ranges"]):
        angle = heading + seen["first"] + k * seen["step"]
        far = shapely.Point(at.x + 50 * math.cos(angle), at.y + 50 * math.sin(angle))
        expected = shapely.intersection(shapely.LineString([at, far]), seen_by_rays).distance(at)
        assert distance == pytest.approx(expected, abs=1e-3), k
    assert (seen["rack"], seen["free"]) == (100, 0)


@pytest.mark.messages("nav2_msgs")
@pytest.mark.parametrize(("name", "to"), [("bot", (4.0, 10.0)), ("ann", (16.0, 10.0))])
def test_navigate_to_pose_leads_to_the_goal(ros, name, to):
    with ros.serving(hall(), "--speed", "8"):
        answer = ros.client("navigate", name=name, x=to[0], y=to[1], heading=1.5)
    assert answer["status"] == "succeeded"
    assert answer["distances"][-1] < answer["distances"][0]
    assert max(answer["times"]) > 1 and answer["times"][-1] <= 1
    assert math.dist(answer["end"], to) < 1.0


@pytest.mark.messages("nav2_msgs")
@pytest.mark.parametrize("name", ["bot", "ann"])
def test_a_cancelled_goal_ends_as_cancelled(ros, name):
    with ros.serving(hall(), "--speed", "2"):
        answer = ros.client("navigate", name=name, x=16.0, y=10.0, cancel_after=3)
    assert answer["status"] == "cancelled"
    assert math.dist(answer["end"], (16.0, 10.0)) > 1.0


@pytest.mark.messages("nav2_msgs")
@pytest.mark.parametrize("name", ["bot", "ann"])
def test_navigate_through_poses_passes_each_pose_in_turn(ros, name):
    poses = [(4.0, 9.0, 0.5), (6.0, 9.0, 0.0), (6.0, 10.5, 1.5)]
    with ros.serving(hall(), "--speed", "4"):
        answer = ros.client("go_through", name=name, poses=poses)
    assert (answer["status"], answer["error"]) == ("succeeded", [0, ""])
    assert sorted(set(answer["left"]), reverse=True) == [3, 2, 1]
    assert answer["left"] == sorted(answer["left"], reverse=True)
    for x, y, _ in poses:
        assert min(math.dist(place, (x, y)) for place in answer["places"]) < 0.6
    assert answer["waypoints"] == [[k, COMPLETED, list(pose[:2])] for k, pose in enumerate(poses)]
    assert answer["states"][0] == [PENDING, PENDING, PENDING]
    assert [COMPLETED, COMPLETED, PENDING] in answer["states"]


@pytest.mark.messages("nav2_msgs")
def test_waypoints_are_followed_and_one_without_a_path_is_named(ros):
    there, in_rack = (4.0, 9.0), (10.0, 6.5)
    with ros.serving(hall(), "--speed", "4") as server:
        done = ros.client("follow_waypoints", name="bot", poses=[there, (5.0, 9.5)])
        missed = ros.client("follow_waypoints", name="bot", poses=[there, in_rack, there])
        through = ros.client("go_through", name="bot", poses=[there, in_rack, there])
    assert (done["status"], done["waypoints"]) == ("succeeded", [])
    assert sorted(set(done["current"])) == [0, 1]
    assert missed["status"] == "aborted"
    assert missed["waypoints"] == [[1, FAILED, [*in_rack]]]
    assert [state for _, state, _ in through["waypoints"]] == [COMPLETED, FAILED, PENDING]
    assert "bot/follow_waypoints" in server.notices


@pytest.mark.messages("nav2_msgs")
def test_follow_path_drives_along_a_dense_path_and_can_be_cancelled(ros):
    there = [(2.0 + 0.05 * k, 6.5 - 0.05 * k) for k in range(61)]
    back = [*reversed(there)]
    with ros.serving(hall(), "--speed", "4") as server:
        answer = ros.client("follow", name="bot", points=there)
        cancelled = ros.client("follow", name="bot", points=back, cancel_after=3)
        outside = ros.client("follow", name="bot", points=[(2.0, 6.5), (-3.0, 6.5)])
        empty = ros.client("follow", name="bot", points=[])
    assert answer["status"] == "succeeded"
    assert answer["distances"][0] > 3.0 > 1.0 > answer["distances"][-1]
    assert max(answer["speeds"]) > 0.3
    assert cancelled["status"] == "cancelled" and cancelled["distances"][-1] > 1.0
    assert not outside["accepted"] and not empty["accepted"]
    assert sum("bot/follow_path" in line for line in server.notices.splitlines()) == 2


@pytest.mark.messages("nav2_msgs")
def test_a_goal_under_way_ends_with_the_run(ros):
    trial = hall(60.0).replace("size: [1.0, 0.7]", "size: [1.0, 0.7], max_speed: 0.05")
    with ros.serving(trial, "--speed", "3"):
        answer = ros.client("navigate", name="bot", x=4.0, y=10.0)
    assert answer["status"] == "aborted" and "over" in answer["error"][1]


@pytest.mark.messages("nav2_msgs")
@pytest.mark.parametrize(("name", "x"), [("bot", 10.0), ("ann", 10.0), ("bot", math.nan)])
def test_a_goal_in_a_rack_is_rejected_with_one_line(ros, name, x):
    with ros.serving(hall()) as server:
        assert ros.client("navigate", name=name, x=x, y=6.5) == {"accepted": False}
    assert sum(f"{name}/navigate_to_pose" in line for line in server.notices.splitlines()) == 1


@pytest.mark.messages("simulation_interfaces")
def test_lock_step_has_the_events_of_a_run(ros, floorwalker):
    with ros.serving(antagonist(275), "--step", "--out", "stepped") as server:
        ros.client("step", count=50, times=275)
        server.wait(HANG)
    assert floorwalker("run", "cell.trial.yaml", "--out", "run", cwd=ros.folder).returncode == 0
    for name in ("events.jsonl", "motions.jsonl"):
        assert lines(ros.folder / "stepped", name) == lines(ros.folder / "run", name)


@pytest.mark.messages("simulation_interfaces")
def test_simulation_interfaces_describe_people_machines_and_the_floor(ros):
    with ros.serving(hall()):
        seen = ros.client("read_simulation", radius=1.0)
    assert seen["all"] == [OK, "ann", "bot"]
    assert seen["named"] == seen["robots"] == seen["west"] == [OK, "bot"]
    assert seen["near"] == [OK, "ann"] and seen["both"] == [OK]
    assert seen["people"] == seen["all"]
    assert (seen["bad"], seen["unknown"]) == ([OPERATION_FAILED], [UNSUPPORTED])
    assert seen["states"] == [["ann"], [6.0, 1]] and seen["missing"] == [NOT_FOUND] * 3
    assert "amr" in seen["info"] and seen["info"][0] == 1
    assert seen["bounds"][0][:2] == [0.5, 0.35] and seen["bounds"][1] == [-0.5, -0.35, 0.0]
    assert sorted(seen["poses"]) == [["dock", 4.0, 10.0], ["press", 16.0, 10.0]]
    assert seen["world"] == "hall" and seen["reset"]


@pytest.mark.messages("simulation_interfaces", "nav2_msgs", "hunav_msgs")
@pytest.mark.parametrize("service", ["reset_simulation", "reset_agents"])
def test_a_reset_begins_the_run_again_and_loses_no_recording(ros, service):
    with ros.serving(hall(), "--speed", "4", "--out", "run") as server:
        seen = ros.client("reset", service=service)
    assert seen["done"] and seen["partly"] in (None, UNSUPPORTED)
    assert seen["after"][0] < seen["before"][0] and seen["after"][1] < 0.01 < seen["before"][1]
    assert (seen["first"], seen["again"]) == (6, 4) and "again" in seen["error"]
    first, second = (sim.load_run(ros.folder / name) for name in ("run", "run-2"))
    assert first.duration >= seen["before"][0] and first.summary["interrupted"]
    assert lines(ros.folder / "run-2", "commands.yaml").count(b"move_to") == 1
    assert second.motions["bot"].position(0.0) == pytest.approx(first.motions["bot"].position(0.0))
    assert "reset at" in server.notices and "recorded in run" in server.notices


@pytest.mark.messages("simulation_interfaces")
def test_states_change_and_steps_can_be_cancelled(ros):
    with ros.serving(hall(3600), "--out", "run") as server:
        seen = ros.client("change_states")
        assert server.wait(HANG) == 0
    assert seen["seen"] == [
        *([OK, PAUSED], [ALREADY, PAUSED], [OK, STOPPED], [OK, PLAYING]),
        *([UNSUPPORTED, PLAYING], [OK, PAUSED]),
    ]
    assert (seen["steps"], seen["cancelled"]) == (OK, 5)
    assert sim.load_run(ros.folder / "run-2").duration > 0


@pytest.mark.messages("ariac_msgs")
def test_topics_of_the_competition_drive_a_person_and_an_agv(ros):
    options = ("--personality", "external", "--rules", "observe", "--duration", "600")
    with ros.serving(COMPETITION, *options, "--speed", "10") as server:
        seen = ros.client("compete")
        assert server.wait(HANG) == 0
    assert (seen["phase"], seen["health"]) == (3, [True, True])
    assert math.dist(seen["at"], (-6.0, 3.0)) < 1.0
    assert seen["moved"] == [False, True] and seen["done"]
    assert seen["orders"] == [["KIT", [11]]]
    (line,) = (one for one in server.notices.splitlines() if "goal_position" in one)
    assert "nan" in line


@pytest.mark.messages("hunav_msgs")
def test_a_clock_that_goes_back_is_one_line(ros):
    with ros.serving(antagonist(60), "--step") as server:
        places = ros.client("advance_back")
    assert places[1] == places[2] and places[3] != places[2] and places[3] == places[4]
    assert sum("clock went back" in line for line in server.notices.splitlines()) == 1


def test_another_simulator_in_the_domain_is_one_line(ros):
    with ros.serving(hall()) as server:
        ros.client("second_clock")
    assert sum(line.startswith("/clock") for line in server.notices.splitlines()) == 1


@pytest.mark.messages("nav2_msgs")
def test_a_run_that_clients_drove_is_repeated_to_the_byte(ros, floorwalker):
    with ros.serving(hall(160.0), "--speed", "4", "--out", "driven") as server:
        ros.client("navigate", name="ann", x=6.0, y=8.0)
        ros.client("drive", speed=0.8)
        ros.client("navigate", name="bot", x=3.0, y=9.0, cancel_after=4)
        server.wait(HANG)
    words = ("run", "cell.trial.yaml", "--commands", "driven/commands.yaml", "--out", "again")
    assert floorwalker(*words, cwd=ros.folder).returncode == 0
    for name in ("events.jsonl", "motions.jsonl"):
        assert lines(ros.folder / "again", name) == lines(ros.folder / "driven", name)


def test_a_gantry_follows_a_trajectory_and_rejects_one_that_is_too_fast(ros):
    with ros.serving(GANTRY, "--speed", "4") as server:
        answer = ros.client("trajectory", positions=[1.0, 1.0, 0.0], seconds=8)
        assert (answer["status"], answer["code"]) == (4, 0)
        assert answer["joints"] == pytest.approx([1.0, 1.0, 0.0], abs=1e-3)
        assert not ros.client("trajectory", positions=[-5.0, 1.0, 0.0], seconds=1)["accepted"]
    assert "follow_joint_trajectory" in server.notices


@pytest.mark.messages("hunav_msgs")
def test_people_walk_in_another_simulator_that_asks_for_them(ros):
    trial = antagonist(60)
    with ros.serving(trial, "--step"):
        seen = ros.client("agents", seconds=20)
    run = sim.run(sim.Trial.parse(trial))
    assert seen[0] == seen[1] == {"ann": pytest.approx(run.motions["ann"].position(0.0))}
    for t, people in enumerate(seen[1:]):
        assert people["ann"] == pytest.approx(run.motions["ann"].position(float(t)), abs=1e-3)


@pytest.mark.messages("people_msgs")
def test_viewers_see_people_frames_markers_and_the_monitor(ros):
    with ros.serving(hall()):
        seen = ros.client("listened")
    assert seen["people"] == {"ann": [6.0, 4.0]}
    assert {("map", "odom"), ("odom", "base_link"), ("map", "ann/base"), ("map", "bot/base")} <= {
        tuple(frame) for frame in seen["frames"]
    }
    (state,) = seen["monitor"]
    assert "ann" in state["name"] and "bot" in state["name"] and state["distance"] > 0
    assert seen["markers"] > 4


def test_bad_commands_are_one_line_each_and_good_ones_still_count(ros):
    with ros.serving(hall()) as server:
        assert ros.client("flood")
    rejected = [line for line in server.notices.splitlines() if line.startswith("cmd_vel")]
    assert len(rejected) == 1 and "nan" in rejected[0]
    assert (
        sum("initialpose" in line and "odom" in line for line in server.notices.splitlines()) == 1
    )


@pytest.mark.parametrize(
    "option", [("--namespace", "bad name"), ("--domain", "500"), ("--speed", "2", "--step")]
)
def test_an_option_that_ros_does_not_allow_is_one_line(ros, option):
    with ros.serving(hall(), *option, "--out", "run") as server:
        assert server.wait(HANG) == 1
    assert not (ros.folder / "run" / "summary.json").exists()
    (line,) = server.notices.splitlines()
    assert option[1] in line


def test_without_rclpy_one_line_explains_how_to_get_it(floorwalker, tmp_path):
    done = floorwalker("ros2", "ariac2023", cwd=tmp_path)
    assert done.returncode == 1 and "rclpy" in done.stderr and "setup.bash" in done.stderr
