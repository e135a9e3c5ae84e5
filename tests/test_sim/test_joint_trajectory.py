"""Joint trajectories from outside, as motions of the gantry."""

import numpy as np
import pytest
from bridge_parts import Client, served, trial
from hypothesis import assume, given, strategies as st

import floorplan
from navigation import standing
from navigation.motion import State
from sim.bridge.machine_topics import TrajectoryError, target_of, trajectory_motion
from sim.bridge.messages import JOINTS, conform, joint_state, joint_values, message_type, pose_of

GANTRY = floorplan.load("ariac2023").gantry
TYPE = message_type("trajectory_msgs/JointTrajectory")
HOME = standing((-7.0, 0.0)).state(0.0)
TOPIC = "/gantry_controller/joint_trajectory"


def trajectory(*points, names=JOINTS):
    """A message of points (time, positions) or (time, positions, velocities)."""
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
    """agv1's lane is at y = 4.8 in the world; the competition's own programs go to −4.8 for it."""
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
    motion = trajectory_motion(GANTRY, HOME, 10.0, message)
    assert (motion.start, motion.end) == (10.0, 18.0)
    middle = motion.state(14.0)
    assert middle.position == pytest.approx((-6.5, 0.5, 0.1))
    assert middle.velocity == pytest.approx((0.2, 0.1, 0.0))
    assert motion.state(18.0).position == pytest.approx((-6.0, 0.7, 0.4))


def test_the_joints_may_come_in_any_order_and_a_first_point_where_it_is():
    names = ("gantry_rotation_joint", "gantry_y_axis_joint", "gantry_x_axis_joint")
    message = trajectory((0.0, (0, 0, 0)), (5.0, (0.3, 0.2, 0.1)), names=names)
    motion = trajectory_motion(GANTRY, HOME, 0.0, message)
    assert motion.state(5.0).position == pytest.approx((-6.9, -0.2, 0.3))


def test_without_velocities_it_goes_on_through_the_points():
    message = trajectory((4.0, (1, 0, 0)), (8.0, (2, 0, 0)), (12.0, (3, 0, 0)), (18.0, (3, 1, 0)))
    motion = trajectory_motion(GANTRY, HOME, 0.0, message)
    assert motion.velocity(4.0) == pytest.approx((0.25, 0.0))
    assert motion.velocity(12.0) == pytest.approx((0.0, 0.0))


def test_one_point_without_a_time_is_just_a_target():
    message = trajectory((0.0, (1.0, -2.0, 0.5)))
    assert target_of(GANTRY, message) == pytest.approx((-6.0, 2.0, 0.5))
    assert target_of(GANTRY, trajectory((1.0, (1.0, -2.0, 0.5)))) is None


@pytest.mark.parametrize(
    ("message", "told"),
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
def test_what_the_gantry_can_not_do_is_told(message, told):
    with pytest.raises(TrajectoryError) as caught:
        trajectory_motion(GANTRY, HOME, 0.0, message)
    assert told in str(caught.value)


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
def test_whatever_is_taken_stays_within_the_limits_at_every_instant(steps):
    t, points = 0.0, []
    for duration, joints in steps:
        t += duration
        points.append((round(t, 6), joints))
    try:
        motion = trajectory_motion(GANTRY, HOME, 0.0, trajectory(*points))
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


def test_a_controller_outside_moves_the_gantry():
    """And the rules hold for it: it is disabled when it comes too close, and told so."""
    a_trial = trial("indifferent", duration=40.0, controller="external", start=30.0)
    with served(a_trial, speed=20.0) as session, Client(session.url) as client:
        assert "no gantry controller" in session.notices[-1]
        client.send(op="advertise", topic=TOPIC, type="trajectory_msgs/JointTrajectory")
        client.subscribe("/joint_states", "/ariac/robot_health")
        client.message("/joint_states")
        send(client, trajectory((6.0, (3.5, -0.5, 0.5), (0, 0, 0))))
        reached = client.hear_until(
            lambda said: said["topic"] == "/joint_states" and said["msg"]["position"][0] == 3.5
        )
        assert reached["msg"]["position"] == pytest.approx([3.5, -0.5, 0.5])
        send(client, trajectory((0.0, (-7.2, 6.5, 0.0))))
        client.hear_until(
            lambda said: said["topic"] == "/ariac/robot_health" and not said["msg"]["ceiling_robot"]
        )
        send(client, trajectory((0.0, (0.0, 0.0, 0.0))))
        assert client.error()["msg"] == "the gantry is disabled"
        run = session.join()
    assert run.summary["penalties"] >= 1
    begun = run.motions["gantry"]
    assert begun.position(0.0) == pytest.approx((-2.5, 0.5))


def test_a_gantry_with_a_controller_of_its_own_takes_no_trajectories():
    with served(trial(), hold=True) as session, Client(session.url) as client:
        send(client, trajectory((0.0, (0.0, 0.0, 0.0))))
        assert "no topic is called" in client.error()["msg"]
