"""Motions of vehicles against closed forms, and against the equations of motion in small steps."""

import math
import random

import numpy as np
import pytest
import ruckig
from hypothesis import given, settings, strategies as st

from navigation import (
    VehicleLimits,
    join,
    vehicle_path,
    vehicle_segment,
    vehicle_stop,
    vehicle_turn,
    vehicle_twist,
)

CART = VehicleLimits()
FREE = VehicleLimits(side_speed=0.8)
POSES = st.tuples(st.floats(-20, 20), st.floats(-20, 20), st.floats(-7, 7))


def twists(limits):
    """Return random twists within limits."""
    sides = st.floats(-limits.side_speed, limits.side_speed)
    turns = st.floats(-limits.turn_speed, limits.turn_speed)
    return st.tuples(st.floats(-limits.speed, limits.speed), sides, turns)


def body_velocity(motion, t):
    """Return velocities forwards and to the left, and headings at given times."""
    rotation, velocity = motion.rotation(t), motion.velocity(t)
    c, s = np.cos(rotation), np.sin(rotation)
    forwards = velocity[:, 0] * c + velocity[:, 1] * s
    return forwards, velocity[:, 1] * c - velocity[:, 0] * s, rotation


def profile(target, limits, t):
    """Return a velocity of Ruckig from 0 to a target, and its integral."""
    task = ruckig.InputParameter(1)
    task.control_interface = ruckig.ControlInterface.Velocity
    speed, acceleration, jerk = limits
    task.max_velocity, task.max_acceleration, task.max_jerk = [speed], [acceleration], [jerk]
    task.target_velocity = [target]
    found = ruckig.Trajectory(1)
    ruckig.Ruckig(1).calculate(task, found)
    place, velocity = zip(*(found.at_time(u)[:2] for u in t), strict=True)
    return np.array(place)[:, 0], np.array(velocity)[:, 0]


@given(POSES, st.floats(0.01, 40.0), st.sampled_from([1, -1]))
def test_a_segment_is_the_double_s_profile_along_its_heading(pose, length, way):
    x, y, rotation = pose
    to = (x + way * length * math.cos(rotation), y + way * length * math.sin(rotation))
    motion = vehicle_segment(pose, to, 2.0, limits=CART)
    v, a, j = CART.speed, CART.acceleration, CART.jerk
    if length > v * v / a + v * a / j:  # it reaches its top speed
        assert motion.end - motion.start == pytest.approx(length / v + v / a + a / j)
    assert motion.position(motion.end) == pytest.approx(np.array(to), abs=1e-9)
    t = np.linspace(motion.start, motion.end, 400)
    forwards, aside, heading = body_velocity(motion, t)
    assert abs(aside).max() < 1e-9 and set(heading) == {rotation}
    assert abs(forwards).max() <= v + 1e-9 and (way * forwards >= -1e-9).all()


@given(POSES, st.floats(-6.3, 6.3))
def test_a_turn_on_the_spot_stays_where_it_is(pose, turn):
    motion = vehicle_turn(pose, pose[2] + turn, limits=CART)
    t = np.linspace(0.0, motion.end, 200)
    assert (motion.position(t) == pose[:2]).all()
    assert motion.rotation(motion.end) == pytest.approx(pose[2] + turn, abs=1e-9)
    assert abs(motion.cubics(t)[:, 2, 1]).max() <= CART.turn_speed + 1e-9


@pytest.mark.parametrize("limits", [CART, FREE])
@settings(max_examples=settings.default.max_examples // 5)
@given(data=st.data())
def test_a_twist_follows_the_equations_of_motion(limits, data):
    """Against Ruckig's profile of each axis, integrated by Simpson's rule in steps of 0.5 ms."""
    pose, twist = data.draw(POSES), data.draw(twists(limits))
    seconds = 6.0
    motion = vehicle_twist(pose, twist, seconds=seconds, limits=limits)
    t = np.linspace(0.0, seconds, 12001)
    drive = (limits.speed, limits.acceleration, limits.jerk)
    turn = (limits.turn_speed, limits.turn_acceleration, limits.turn_jerk)
    _, forwards = profile(min(max(twist[0], -0.9999 * drive[0]), 0.9999 * drive[0]), drive, t)
    side = 0.9999 * limits.side_speed
    aside = profile(min(max(twist[1], -side), side), drive, t)[1] if side else 0 * t
    turned, _ = profile(min(max(twist[2], -0.9999 * turn[0]), 0.9999 * turn[0]), turn, t)
    assert motion.rotation(t) == pytest.approx(pose[2] + turned, abs=1e-7)
    velocity = (forwards + 1j * aside) * np.exp(1j * (pose[2] + turned))
    steps = (velocity[:-2:2] + 4 * velocity[1:-1:2] + velocity[2::2]) * (t[2] / 6)
    place = complex(*pose[:2]) + np.append(0, np.cumsum(steps))
    found = motion.position(t[::2])
    assert abs(found[:, 0] + 1j * found[:, 1] - place).max() < 1.1e-5


@pytest.mark.parametrize("limits", [CART, FREE])
@settings(deadline=None, max_examples=40)
@given(data=st.data())
def test_consecutive_commands_keep_the_limits(limits, data):
    parts, current, t = [], data.draw(POSES), 0.0
    for _ in range(data.draw(st.integers(2, 8))):
        motion = vehicle_twist(current, data.draw(twists(limits)), t, seconds=4.0, limits=limits)
        then = t + data.draw(st.floats(0.02, 5.0))
        parts.append(motion.cut(t, then))
        current, t = motion.state(then), then
    stop = vehicle_stop(current, t, limits=limits)
    whole = join([*parts, stop])
    assert not whole.jumps and stop.state_before(stop.end).speed < 1e-6
    t = np.linspace(0.0, whole.end, 20_000, endpoint=False)
    forwards, aside, _ = body_velocity(whole, t)
    assert abs(forwards).max() <= limits.speed + 2e-6
    assert abs(aside).max() <= (limits.side_speed or 5e-4) + 2e-6
    assert abs(whole.cubics(t)[:, 2, 1]).max() <= limits.turn_speed + 1e-9
    velocity = whole.velocity(t)
    # Between two samples the velocity changes by the acceleration, and by the turn of the vehicle.
    most = 1.5 * limits.acceleration + limits.top_speed * limits.turn_speed
    assert np.hypot(*np.diff(velocity, axis=0).T).max() <= most * t[1] * 1.01 + 1e-3


@given(POSES, st.floats(0.1, 1.5))
def test_a_stop_has_the_duration_and_length_of_its_profile(pose, speed):
    motion = vehicle_twist(pose, (speed, 0.0), seconds=60.0, limits=CART)
    state = motion.state(30.0)
    stop = vehicle_stop(state, 30.0, limits=CART)
    v, a, j = state.speed, CART.acceleration, CART.jerk
    seconds = v / a + a / j if v * j >= a * a else 2 * math.sqrt(v / j)
    assert stop.end - 30.0 == pytest.approx(seconds)
    way = math.dist(state.at, stop.state(stop.end).at)
    assert way == pytest.approx(v * seconds / 2)
    assert seconds <= CART.longest_stop.time and way <= CART.longest_stop.distance


def test_a_path_turns_and_drives_from_pose_to_pose():
    poses = [(3.0, 0.0, 0.0), (3.0, 0.0, math.pi / 2), (3.0, 2.0, math.pi / 2)]
    motion = vehicle_path((0.0, 0.0, 0.0), poses, 1.0, limits=CART)
    assert motion.position(motion.end) == pytest.approx([3.0, 2.0])
    assert motion.rotation(motion.end) == pytest.approx(math.pi / 2)
    under_way = motion.state(2.2)
    again = vehicle_path(under_way, poses, 2.2, limits=CART.slower(0.5))
    assert again.end > motion.end
    assert np.hypot(*again.velocity(np.linspace(5.0, again.end, 500)).T).max() <= 0.75 + 1e-9


def test_impossible_motions_are_rejected():
    with pytest.raises(ValueError, match="must turn first"):
        vehicle_segment((0.0, 0.0, 0.0), (1.0, 1.0), limits=CART)
    aside = vehicle_segment((0.0, 0.0, 0.0), (0.0, 4.0), limits=FREE)
    assert np.hypot(*aside.velocity(np.linspace(0, aside.end, 99)).T).max() <= 0.8 + 1e-9
    for twist, message in (
        ((math.nan, 0.0), "must be finite"),
        ((1.6, 0.0), "1.6 m/s is faster than speed, 1.5 m/s"),
        ((0.0, -1.1), "-1.1 rad/s is faster than turn_speed, 1 rad/s"),
        ((0.0, 0.1, 0.0), "0.1 m/s is faster than side_speed, 0 m/s"),
        ((1.0,), r"must be \(v, ω\) or"),
    ):
        with pytest.raises(ValueError, match=message):
            vehicle_twist((0.0, 0.0, 0.0), twist, limits=CART)
    with pytest.raises(ValueError, match="jerk must be more than 0"):
        VehicleLimits(jerk=0.0)


def accelerations(motion):
    """Return time, acceleration before and after, and jerk after, for each piece of a motion."""
    last = np.zeros(3)
    for piece in motion.pieces:
        _, _, bend, twist = np.array([piece.x, piece.y, piece.rotation]).T
        yield piece.begin, last, 2 * bend, 6 * twist
        last = 2 * bend + 6 * twist * (piece.end - piece.begin)


@pytest.mark.parametrize("seed", range(40))
def test_the_jerk_limit_holds_when_the_top_speed_falls_below_the_present_speed(seed):
    draw = random.Random(seed)
    limits = VehicleLimits(speed=draw.choice([0.8, 1.5, 2.0]), jerk=draw.choice([1.0, 3.0, 10.0]))
    turns = seed % 2 == 1
    motion = (
        vehicle_turn((0, 0, 0), 3.0, limits=limits)
        if turns
        else vehicle_segment((0, 0, 0), (8.0, 0.0), limits=limits)
    )
    t = draw.uniform(0.0, motion.end)
    slower = limits.slower(draw.uniform(0.1, 1.0))
    state = motion.state(t)
    if turns:
        after = vehicle_turn(state, 3.0, t, limits=slower)
    else:
        after = vehicle_segment(state, (8.0, 0.0), t, limits=slower)
    assert after.position(after.end) == pytest.approx(motion.position(motion.end), abs=1e-6)
    jerk = limits.turn_jerk if turns else limits.jerk
    for begin, before, acceleration, change in accelerations(join([motion.cut(0, t), after])):
        assert acceleration == pytest.approx(before, abs=1e-5), begin
        assert np.abs(change).max() <= jerk * (1 + 1e-9)
    speed, rise = np.abs(state.velocity).max(), np.abs(state.acceleration).max()
    top = max(slower.turn_speed if turns else slower.speed, speed + rise**2 / (2 * jerk))
    for u in np.linspace(t, after.end, 300):
        assert np.abs(after.state(u).velocity).max() <= top + 1e-9
