"""Motions: continuity, limits, and agreement of all ways to evaluate them, also in tracks."""

import functools
import itertools
import math
import pickle
from array import array

import numpy as np
import pytest
import ruckig
from hypothesis import assume, example, given, strategies as st

import floorplan
import navigation
from navigation import Motion, Piece
from navigation.kernels.pieces import along_legs
from navigation.machines import ARIAC_GANTRY, AxisLimits, AxisState, lane_state, to_position
from navigation.motion import State, Track, motion_of
from navigation.walking import corner_speed

coordinate = st.floats(-20, 20)
point = st.tuples(coordinate, coordinate)
paths = st.lists(point, min_size=2, max_size=8)
pose = st.tuples(st.floats(-14.4, 0.4), st.floats(-7, 7), st.floats(-math.pi, math.pi))


def instants(motion, n=4000):
    """Return many times of a motion, including its breaks and their neighbourhoods."""
    breaks = [t for p in motion.pieces for t in (p.begin, p.end)]
    near = [b + d for b in breaks for d in (-1e-9, 0.0, 1e-9)]
    return np.unique(np.concatenate([np.linspace(motion.start, motion.end, n), near]))


def assert_continuous(motion, max_speed):
    ts = instants(motion)
    steps = np.hypot(*np.diff(motion.position(ts), axis=0).T)
    assert (steps <= max_speed * np.diff(ts) * (1 + 1e-6) + 1e-9).all()


@pytest.mark.parametrize("axis", ["x", "y", "rotation"])
@pytest.mark.parametrize("degree", [1, 2, 3])
def test_a_piece_stands_only_if_no_axis_changes(axis, degree):
    still = Piece(0.0, 1.0, (1.0, 0.0, 0.0, 0.0), (2.0, 0.0, 0.0, 0.0), (0.5, 0.0, 0.0, 0.0))
    assert (still.stands, still.moves) == (True, False)
    cubic = [*getattr(still, axis)]
    cubic[degree] = -0.1
    changes = still._replace(**{axis: tuple(cubic)})
    assert (changes.stands, changes.moves) == (False, axis != "rotation")


@given(paths, st.floats(0.2, 2), st.floats(0.5, 5))
def test_a_walk_keeps_its_limits_and_reaches_its_goal(points, top, acceleration):
    assume(math.dist(points[0], points[-1]) > 1e-3 or len(points) > 2)
    walk = navigation.walk(points, 5.0, max_speed=top, max_acceleration=acceleration)
    assert walk.start == 5.0
    assert walk.position(walk.start) == pytest.approx(points[0], abs=1e-6)
    assert walk.position(walk.end + 10) == pytest.approx(points[-1], abs=1e-6)
    assert_continuous(walk, top)
    ts = instants(walk)
    speed = np.hypot(*walk.velocity(ts).T)
    assert speed.max() <= top * (1 + 1e-9)
    change = np.abs(np.diff(speed))
    assert (change <= acceleration * np.diff(ts) * (1 + 1e-6) + 1e-6).all()


@given(paths)
def test_a_walk_stays_on_its_path(points):
    from shapely.geometry import LineString, Point

    walk = navigation.walk(points)
    if walk.end == walk.start:
        return
    line = LineString(points)
    for x, y in walk.position(np.linspace(walk.start, walk.end, 200)):
        assert line.distance(Point(x, y)) < 1e-6


@given(paths)
def test_a_walk_takes_every_corner_at_no_more_than_its_speed(points):
    walk = navigation.walk(points)
    for before, after in itertools.pairwise(walk.pieces):
        if before.rotation[0] == after.rotation[0]:
            continue
        turn = abs((after.rotation[0] - before.rotation[0] + math.pi) % (2 * math.pi) - math.pi)
        half = math.cos(turn / 2)
        limit = math.sqrt(2.5 * 0.05 * half / (1 - half)) if half < 1 else math.inf
        assert walk.state(after.begin).speed <= limit * (1 + 1e-6) + 1e-9


@pytest.mark.parametrize(
    ("degrees", "speed"),
    [(0, math.inf), (90, math.sqrt(2.5 * 0.05 / (math.sqrt(2) - 1))), (180, 0.0)],
)
def test_corner_speed_of_known_corners(degrees, speed):
    turn = math.radians(degrees)
    after = (10 + 10 * math.cos(turn), 10 * math.sin(turn))
    assert corner_speed((0, 0), (10, 0), after) == pytest.approx(speed)


def test_a_finely_cut_arc_is_walked_like_the_arc():
    """On an arc of radius r the speed is √(a r) for any number of corners."""
    radius = 0.2
    angles = np.linspace(0, math.pi, 200)
    points = radius * np.column_stack([np.cos(angles), np.sin(angles)])
    walk = navigation.walk(points, max_speed=5.0)
    top = np.hypot(*walk.velocity(instants(walk)).T).max()
    assert top == pytest.approx(math.sqrt(2.5 * radius), rel=1e-2)


@example([(0.0, 6.0), (0.0, 0.0), (4.0, 0.0)], 0.59375)  # right before a corner
@given(paths, st.floats(0, 1))
def test_a_stopping_person_brakes_on_the_path(points, share):
    walk = navigation.walk(points)
    assume(walk.end > walk.start)
    t = walk.start + share * (walk.end - walk.start)
    stop = navigation.stop_walking(walk, t)
    assert stop.position(t) == pytest.approx(walk.position(t), abs=1e-9)
    assert_continuous(stop, 1.0)
    speed = walk.state(t).speed
    assert stop.end - stop.start <= speed / 2.5 * (1 + 1e-4) + 1e-6
    length = np.hypot(*np.diff(stop.position(instants(stop)), axis=0).T).sum()
    assert length == pytest.approx(speed**2 / 5, rel=1e-3, abs=1e-6)


def test_a_path_too_short_for_a_stop_is_rejected():
    with pytest.raises(ValueError, match="too short to slow down from 1 m/s"):
        navigation.walk([(0, 0), (0.1, 0)], initial_speed=1.0)


@pytest.mark.parametrize("points", [[], [(0, 0, 0)], [(0, math.nan), (1, 1)], 3])
def test_invalid_points_are_rejected(points):
    with pytest.raises(ValueError, match="a path needs"):
        navigation.walk(points)


@given(pose, pose, pose, st.floats(0, 1))
def test_gantry_moves_keep_the_limits_of_every_axis_even_when_replaced(a, b, c, share):
    first = navigation.gantry_move(a, b, 2.0)
    t = first.start + share * (first.end - first.start)
    state = first.state(t)
    second = navigation.gantry_move(state, c, t)
    assert second.state(t).position == pytest.approx(state.position, abs=1e-9)
    assert second.state(second.end).position == pytest.approx(c, abs=1e-6)
    if first.start < t < first.end:
        assert second.state(t).velocity == pytest.approx(state.velocity, abs=1e-9)
        assert second.state(t).acceleration == pytest.approx(state.acceleration, abs=1e-6)
    for motion in (first, second):
        for piece in motion.pieces:
            for u in np.linspace(piece.begin, piece.end, 7)[:-1]:
                now = motion.state(float(u))
                for axis, limits in enumerate(ARIAC_GANTRY):
                    assert abs(now.velocity[axis]) <= limits.max_speed + 1e-6
                    assert abs(now.acceleration[axis]) <= limits.max_acceleration + 1e-6


def test_a_gantry_move_can_be_repeated_a_nanosecond_before_its_end():
    for x, left in itertools.product(np.linspace(-14, 0, 60), np.geomspace(5e-10, 1e-8, 25)):
        target = (float(x), 2.5, 1.0)
        first = navigation.gantry_move((-5.0, 1.0, 0.0), target)
        t = first.end - left
        again = navigation.gantry_move(first.state(t), target, t)
        assert again.end <= first.end + 1e-3
        assert again.position(again.end) == pytest.approx(target[:2], abs=1e-9)


@given(pose, pose)
def test_gantry_moves_from_rest_go_straight_and_their_axes_arrive_together(a, b):
    motion = navigation.gantry_move(a, b)
    if motion.end - motion.start < 1e-6:
        return
    for t in np.linspace(motion.start, motion.end, 20):
        now = np.array(motion.state(float(t)).position)
        direction = np.array(b) - np.array(a)
        share = (now - a) @ direction / (direction @ direction)
        assert now == pytest.approx(np.array(a) + share * direction, abs=1e-6)


@given(pose, pose, st.floats(0.01, 0.99))
def test_a_gantry_stop_ends_at_rest(a, b, share):
    motion = navigation.gantry_move(a, b)
    t = share * motion.end
    stop = navigation.gantry_stop(motion.state(t), t)
    assert stop.state(t).position == pytest.approx(motion.state(t).position, abs=1e-9)
    assert np.abs(stop.velocity(stop.end - 1e-9)).max() < 1e-6
    assert stop.end - t <= 1.0 / 0.5 + 2 * 0.5 / 2.0 + 1e-6


@given(
    st.tuples(st.floats(-9, 9), st.floats(-2, 2), st.floats(-1.5, 1.5)),
    st.floats(0.2, 2),
    st.one_of(st.just(math.inf), st.floats(0.5, 20)),
)
def test_a_stop_is_as_fast_as_that_of_ruckig(state, top, jerk):
    """For a single axis, also if it exceeds its limit of acceleration."""
    if jerk == math.inf:
        state = (*state[:2], 0.0)
    task = ruckig.InputParameter(1)
    task.control_interface = ruckig.ControlInterface.Velocity
    task.current_position, task.current_velocity, task.current_acceleration = ([c] for c in state)
    task.target_velocity, task.target_acceleration = [0.0], [0.0]
    task.max_velocity, task.max_acceleration, task.max_jerk = [9.0], [top], [jerk]
    oracle = ruckig.Trajectory(1)
    ruckig.Ruckig(1).calculate(task, oracle)
    limits = (AxisLimits(9.0, top, jerk),) * 3
    axes = [(c, 0.0, c) for c in state]
    stop = navigation.gantry_stop(State(*axes), 5.0, limits=limits)
    # An axis with less than 1e-7 m/s² counts as standing. A stop would take (1 + √2) a / j.
    assert stop.end - 5.0 == pytest.approx(oracle.duration, abs=1e-7 + 2.5e-7 / jerk)
    assert stop.state(5.0).position == axes[0]
    for share in (0.3, 0.6, 1.0):
        t = share * oracle.duration
        expected, _, _ = oracle.at_time(t)
        assert stop.state(5.0 + t).position == pytest.approx(
            (expected[0], 0.0, expected[0]), abs=1e-6
        )


def test_an_agv_run_is_the_trapezoid_of_its_limits():
    lane = floorplan.load("ariac2023").lane("agv1")
    run = navigation.agv_run(lane, 0.0, "assembly_front", 30.0)
    # 2 m/s reached after 1 s and 1 m at 2 m/s²: 1 + 3.6 / 2 + 1 seconds in all.
    assert run.end == pytest.approx(33.8)
    assert run.position(31.0) == pytest.approx((-3.27, 4.8))
    assert run.velocity(32.0) == pytest.approx((-2.0, 0.0), abs=1e-9)
    assert run.position(40.0) == pytest.approx((-7.87, 4.8))
    turned = navigation.agv_run(lane, run.state(32.0), 0.0, 32.0)
    assert turned.velocity(32.0) == pytest.approx((-2.0, 0.0), abs=1e-9)
    assert turned.position(turned.end) == pytest.approx((-2.27, 4.8))


@given(st.lists(st.floats(0, 18), max_size=4))
def test_a_returning_agv_stays_on_its_lane(stops):
    """Rounding must not put an AGV 4e-16 m before the begin of its lane."""
    lane = floorplan.load("ariac2023").lane("agv1")
    state, t = AxisState(0.0), 0.0
    for q in [*stops, 0.0, 18.0, 0.0]:
        run = navigation.agv_run(lane, state, q, t)
        t = run.end + 1.0
        state = lane_state(lane, run.state(t))
        assert lane.limits[0] <= state.position <= lane.limits[1]
        assert state.position == pytest.approx(q, abs=1e-9)


@given(st.lists(pose, min_size=2, max_size=5))
def test_scalars_arrays_and_states_agree(poses):
    motions, t, current = [], 0.0, poses[0]
    for target in poses[1:]:
        motions.append(navigation.gantry_move(current, target, t))
        t, current = motions[-1].end + 1.0, target
    whole = navigation.join(motions, end=t)
    assert whole.jumps == frozenset()
    ts = np.sort(np.concatenate([instants(whole, 50), [whole.start - 1, whole.end + 1]]))
    assert whole.position(ts).shape == (len(ts), 2)
    for k, t in enumerate(ts.tolist()):
        state = whole.state(t)
        assert whole.position(ts)[k] == pytest.approx(state.at, abs=1e-12)
        assert whole.position(t) == pytest.approx(state.at, abs=1e-12)
        assert whole.velocity(t) == pytest.approx(state.velocity[:2], abs=1e-12)
        assert whole.rotation(t) == pytest.approx(state.position[2], abs=1e-12)


@given(paths, st.floats(0, 1), st.floats(0, 1))
def test_a_cut_equals_the_motion_within_its_span(points, one, other):
    walk = navigation.walk(points)
    begin, end = sorted(walk.end * share for share in (one, other))
    part = walk.cut(begin, end)
    for t in np.linspace(begin, end, 20):
        assert part.position(t) == pytest.approx(walk.position(t), abs=1e-9)
    assert (part.start, part.end) == (begin, end)


def test_a_cut_includes_rests_of_the_motion():
    walk = navigation.walk([(0, 0), (3, 0)], 2.0)
    part = walk.cut(0.0, 10.0)
    assert (part.start, part.end) == (0.0, 10.0)
    assert part.position([1.0, 9.0]) == pytest.approx(walk.position([1.0, 9.0]))
    late = walk.cut(8.0, 9.0)
    assert (late.start, late.end, late.position(8.5)[0]) == (8.0, 9.0, pytest.approx(3.0))


def test_joined_motions_jump_only_where_they_are_apart():
    a = navigation.walk([(0, 0), (3, 0)], 0.0)
    b = navigation.standing((9, 9), start=2.0)
    whole = navigation.join([a, b], end=5.0)
    assert whole.jumps == {2.0}
    assert whole.position(2.0) == pytest.approx((9, 9))
    assert whole.state_before(2.0).at == pytest.approx(a.position(2.0))
    assert whole.state_before(2.0).speed == pytest.approx(1.0)
    assert (whole.start, whole.end) == (0.0, 5.0)


@given(
    st.lists(
        st.tuples(st.floats(0.01, 3), *[coordinate] * 2, st.floats(-math.pi, math.pi)), min_size=1
    )
)
def test_a_motion_passes_its_samples_smoothly(samples):
    steps, x, y, turned = np.array(samples).T
    t, xy = np.cumsum(steps), np.column_stack([x, y])
    motion = Motion.from_samples(t, xy, turned)
    assert (motion.start, motion.end) == (t[0], t[-1])
    assert motion.position(t) == pytest.approx(xy, abs=1e-9)
    turns = motion.rotation(t) - turned
    assert turns == pytest.approx(2 * math.pi * np.round(turns / (2 * math.pi)), abs=1e-9)
    assert (np.abs(np.diff(motion.rotation(t))) <= math.pi + 1e-9).all()
    for one, other in itertools.pairwise(motion.pieces):
        before, after = motion.state_before(one.end), motion.state(other.begin)
        assert before.velocity == pytest.approx(after.velocity, abs=1e-6)
    for k, piece in enumerate(motion.pieces[: len(t) - 1]):
        between = motion.position(np.linspace(piece.begin, piece.end, 20))
        assert (between >= np.minimum(xy[k], xy[k + 1]) - 1e-9).all()
        assert (between <= np.maximum(xy[k], xy[k + 1]) + 1e-9).all()


def test_a_motion_through_samples_of_a_walk_converges_to_it():
    walk = navigation.walk([(0, 0), (6, 0), (6, 5)])
    ts = np.linspace(0, walk.end, 1000)
    off = []
    for count in (20, 80, 320):
        t = np.linspace(0, walk.end, count)
        tracked = Motion.from_samples(t, walk.position(t), walk.rotation(t))
        off.append(np.hypot(*(tracked.position(ts) - walk.position(ts)).T).max())
    assert off[2] < off[1] < off[0] < 0.2
    assert off[2] < 0.01


@pytest.mark.parametrize(
    ("t", "xy", "rotation", "message"),
    [
        ([], np.zeros((0, 2)), None, "a motion needs a sample, found none"),
        (0.0, [0.0, 0.0], None, "t must"),
        ([0.0, 1.0], [0.0, 1.0], None, "xy must"),
        ([0.0, 1.0], [[0.0, 1.0]], None, "xy must"),
        ([0.0, 1.0], [[0.0, 1.0]] * 2, [1.0], "rotation must"),
        ([0.0, math.nan], [[0.0, 1.0]] * 2, None, r"t\[1\]"),
        ([0.0, 1.0], [[0.0, 1.0], [math.inf, 0.0]], None, r"xy\[1\]"),
        ([0.0, 1.0, 1.0], [[0.0, 1.0]] * 3, None, r"t\[2\] = 1.0 s"),
    ],
)
def test_invalid_samples_are_rejected(t, xy, rotation, message):
    with pytest.raises(ValueError, match=message):
        Motion.from_samples(t, xy, rotation)


def test_gaps_and_jumps_are_rejected():
    zero = (0.0, 0.0, 0.0, 0.0)
    one = Piece(0.0, 1.0, zero, zero, zero)
    with pytest.raises(ValueError, match=r"gap from t = 1.0 s to 2.0 s"):
        Motion((one, Piece(2.0, 3.0, zero, zero, zero)))
    with pytest.raises(ValueError, match=r"jumps by 1 m at t = 1.0 s"):
        Motion((one, Piece(1.0, 3.0, (1.0, 0.0, 0.0, 0.0), zero, zero)))
    with pytest.raises(ValueError, match="at least one piece"):
        Motion(())


@pytest.mark.parametrize("limits", [(0, 1, 1), (1, -1, 1), (1, 1, math.nan)])
def test_limits_must_be_positive(limits):
    with pytest.raises(ValueError, match="must be more than 0"):
        AxisLimits(*limits)


@example(1_415_533_623)  # within a nanometre of its end
@given(st.integers(0, 2**32 - 1))
def test_braking_may_restart_while_braking(seed):
    """In spite of rounding of the remaining path in Ruckig."""
    random = np.random.default_rng(seed)
    walk = navigation.walk(random.uniform(0, 10, (4, 2)), 0.0, max_speed=1.5)
    t = random.uniform(0, walk.end)
    braking = navigation.stop_walking(walk, t)
    for later in random.uniform(t, braking.end, 20):
        again = navigation.stop_walking(braking, later)
        # A stop within 1e-9 m is immediate, which saves at most √(2 · 1e-9 / 2.5) s.
        assert again.end == pytest.approx(braking.end, abs=3e-5)
        assert again.position(again.end) == pytest.approx(braking.position(again.end), abs=1e-5)


@given(st.floats(0.0, 3.0), st.floats(0.0, 1.0), st.floats(1e-6, 50.0), st.floats(0.3, 2.0))
@example(2.0, 1.0, 0.3, 0.3)  # the last speed is rounded to above the top one
def test_a_segment_has_ruckigs_profile_without_a_jerk_limit(first, share, length, top):
    limits = AxisLimits(top, 2.5)
    reachable = math.sqrt(max(first**2 - 2 * limits.max_acceleration * length, 0.0))
    first = first if reachable < top else math.sqrt(2 * limits.max_acceleration * length)
    reachable = math.sqrt(max(first**2 - 1.999 * limits.max_acceleration * length, 0.0))
    most = min(top, math.sqrt(first**2 + 1.999 * limits.max_acceleration * length))
    last = min(reachable + share * max(most - reachable, 0.0), top)
    leg = along_legs([(0.0, 0.0), (length, 0.0)], [length], [first, last], top, 2.5, 0.0)
    (expected,) = to_position([AxisState(0.0, first)], [AxisState(length, last)], [limits])
    since, until, begin, speed, half = leg[-14:-9]
    duration = until - since
    assert begin + duration * (speed + duration * half) == pytest.approx(length, abs=1e-9)
    assert speed + 2 * half * duration == pytest.approx(last, abs=1e-6)
    whole = sum(duration for duration, _ in expected)
    assert until == pytest.approx(whole, abs=1e-7)


@pytest.mark.parametrize("kept", [list, functools.partial(array, "d")])
def test_a_pickled_motion_is_independent_of_compilation(kept):
    """Tables are lists if kernels are not compiled, and arrays if they are."""
    motion = navigation.walk([(0.0, 0.0), (3.0, 0.0), (3.0, 4.0)], 1.0)
    again = pickle.loads(pickle.dumps(motion_of(kept(motion.table), frozenset())))
    assert again == motion and hash(again) == hash(motion)
    assert again.state(2.0) == motion.state(2.0)
    assert navigation.minimum_separation(again, motion, 1.0, 4.0) == (1.0, 0.0)


corner = st.tuples(st.floats(-20, 20), st.floats(-20, 20))
walks = st.lists(st.lists(corner, min_size=2, max_size=4), min_size=1, max_size=5)


def one_after_another(walks):
    """Return walks as motions, each moved to the end of the previous one."""
    motions, t = [], 0.0
    for points in walks:
        motions.append(navigation.walk(points, t).cut(t, t + 30.0))
        t += 30.0
    return motions


def add(track, motion):
    track.add(motion, motion.start, motion.end)


@given(walks)
def test_a_track_is_the_motions_joined(walks):
    motions = one_after_another(walks)
    track = Track()
    for motion in motions:
        add(track, motion)
    whole, joined = track.motion(), navigation.join(motions)
    assert whole == joined
    assert hash(whole) == hash(joined)
    assert whole.jumps == joined.jumps
    ts = np.linspace(-1.0, joined.end + 1.0, 500)
    assert (whole.position(ts) == joined.position(ts)).all()
    assert (whole.velocity(ts) == joined.velocity(ts)).all()
    assert repr([*whole.table]) == repr([c for motion in motions for c in motion.table])  # -0.0 too
    for t in (0.0, 0.7, joined.end / 2, joined.end):
        assert whole.state(t) == joined.state(t)
        assert whole.pieces_from(t) == joined.pieces_from(t)
        assert whole.cut(t, t + 3.0) == joined.cut(t, t + 3.0)
    assert whole.pieces[-1] == joined.pieces[-1]
    assert len(whole.pieces) == len(joined.pieces)


def test_a_motion_of_a_track_does_not_change_later():
    track = Track()
    assert not track
    add(track, navigation.walk([(0, 0), (3, 0)], 0.0))
    early = track.motion()
    add(track, navigation.walk([(3, 0), (5, 0)], early.end))
    assert early.position(100.0)[0] == pytest.approx(3.0)
    assert track.motion().position(100.0)[0] == pytest.approx(5.0)


def test_a_gap_in_a_track_is_rejected():
    track = Track()
    add(track, navigation.walk([(0, 0), (3, 0)], 0.0))
    with pytest.raises(ValueError, match="gap"):
        add(track, navigation.standing((3, 0), start=50.0))


def test_pieces_of_a_track_are_a_sequence():
    track = Track()
    add(track, navigation.walk([(0, 0), (3, 0), (3, 5)], 0.0))
    pieces = track.motion().pieces
    assert Motion(tuple(pieces)) == track.motion()
    assert tuple(pieces[1:]) == tuple(pieces)[1:]
    assert pieces != list(pieces)
