"""The monitor against brute force: the same results and times, without a missed interval."""

import itertools
import math
from dataclasses import dataclass

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st
from stretches import assert_bounds, assert_negative_within, encounters, part_of

import navigation
from navigation import (
    ApproachLaw,
    FixedDistance,
    IntegralLaw,
    Motion,
    Piece,
    Scaled,
    SeparationLaw,
)
from navigation.separation import required_at, required_at_speeds

LAW = SeparationLaw(t1=1.0, t2=1.5, stopping=0.0, intrusion=1.0)
INTEGRAL_LAW = IntegralLaw(t1=1.0, t2=1.5, stopping=0.0, intrusion=1.0)
TOO_CLOSE = navigation.TooClose(LAW)
END = 30.0

point = st.tuples(st.floats(-10, 0), st.floats(-6, 6))
walked = st.builds(
    lambda points, start: navigation.walk(points, start),
    st.lists(point, min_size=2, max_size=6),
    st.floats(0, 5),
)
tracked = st.builds(
    # At rest at both ends, so that speeds are continuous.
    lambda points, start, step: Motion.from_samples(
        start + step * np.arange(len(points) + 2), [points[0], *points, points[-1]]
    ),
    st.lists(point, min_size=2, max_size=12),
    st.floats(0, 5),
    st.floats(0.5, 3),
)
walks = st.one_of(walked, tracked)
poses = st.tuples(st.floats(-10, 0), st.floats(-6, 6), st.floats(-3, 3))


@st.composite
def gantry_motions(draw):
    """Return a few moves, each of which replaces the previous one on its way."""
    motions = [navigation.gantry_move(draw(poses), draw(poses), draw(st.floats(0, 5)))]
    for _ in range(draw(st.integers(0, 3))):
        last = motions[-1]
        t = last.start + draw(st.floats(0.1, 1.0)) * (last.end - last.start)
        motions.append(navigation.gantry_move(last.state(t), draw(poses), t))
    return navigation.join(motions)


linear_laws = st.builds(
    lambda t1, t2, b, d: SeparationLaw(t1=t1, t2=t2, stopping=b, intrusion=d),
    *(st.floats(0, 2) for _ in range(4)),
)
laws = st.one_of(
    linear_laws,
    st.builds(FixedDistance, st.floats(0, 6)),
    st.builds(lambda factor, cap: Scaled(LAW, factor, cap), st.floats(0, 2), st.floats(0, 8)),
)


def margin(person, machine, law, ts):
    """Return distance minus required distance at many times."""
    apart = np.hypot(*(person.position(ts) - machine.position(ts)).T)
    speeds = [np.hypot(*motion.velocity(ts).T) for motion in (person, machine)]
    takes_arrays = isinstance(law, SeparationLaw)
    return apart - (law.distance if takes_arrays else np.vectorize(law.distance))(*speeds)


def sampled(person, machine, law, step=1e-3):
    ts = np.arange(0, END + step, step)
    return ts, margin(person, machine, law, ts)


@given(walks, gantry_motions(), laws)
def test_violations_are_those_of_dense_sampling(person, machine, law):
    ts, margins = sampled(person, machine, law)
    found = navigation.violations(person, machine, law, 0.0, END)
    assert_negative_within(found, ts, margins, END)
    assert navigation.first_violation(person, machine, law, 0.0, END) == (
        found[0][0] if found else None
    )
    for (_, end), (begin, _) in itertools.pairwise(found):
        assert begin > end


@given(walks, gantry_motions(), laws)
def test_a_violation_begins_and_ends_at_the_limit(person, machine, law):
    for begin, end in navigation.violations(person, machine, law, 0.0, END):
        for t, before in ((begin, begin - 1e-6), (end, end + 1e-6)):
            if 1e-6 < t < END - 1e-6:
                around = margin(person, machine, law, np.array([t, before]))
                jumps = abs(np.diff(around)[0]) > 1e-4
                assert jumps or abs(around[0]) < 2e-6 * 20


@given(walks, gantry_motions())
def test_the_minimum_is_that_of_dense_sampling(person, machine):
    ts = np.arange(0, END, 1e-3)
    apart = np.hypot(*(person.position(ts) - machine.position(ts)).T)
    t, distance = navigation.minimum_separation(person, machine, 0.0, END)
    assert 0 <= t <= END
    assert distance <= apart.min() + 1e-9
    # Between samples, the distance falls by at most the motion in half a step.
    fastest = np.hypot(*(person.velocity(ts) - machine.velocity(ts)).T).max()
    assert distance >= apart.min() - 1e-3 * fastest - 1e-9
    exact = math.dist(person.position(t), machine.position(t))
    assert distance == pytest.approx(exact, abs=1e-9)


@pytest.mark.parametrize(
    ("law", "milliseconds"),
    [(LAW, 1.0), (LAW, 0.1), (LAW, 0.01), (INTEGRAL_LAW, 1.0), (INTEGRAL_LAW, 0.1)],
)
def test_a_violation_of_a_millisecond_is_not_missed(law, milliseconds):
    """Two bodies pass each other at 2 m/s, with an arbitrarily short chord of the limit."""
    half_chord = 1.0 * milliseconds / 2000
    offset = math.sqrt(3.5**2 - half_chord**2)
    person = navigation.walk([(-9, 0), (9, 0)], 0.0)
    machine = navigation.standing((0.0, offset))
    ((begin, end),) = navigation.violations(person, machine, law, 0.0, 60.0)
    middle = 9.0 + 0.2  # 0.2 s more than at top speed, for the acceleration
    assert begin == pytest.approx(middle - half_chord, abs=1e-6)
    assert end == pytest.approx(middle + half_chord, abs=1e-6)
    missed = navigation.standing((0.0, 3.5 + 1e-9))
    assert navigation.violations(person, missed, law, 0.0, 60.0) == []


def test_the_first_violation_equals_a_closed_form():
    """Head on at top speed, 3.5 m before a standing gantry, without square roots."""
    person = navigation.walk([(-10, 0), (10, 0)], 0.0)
    machine = navigation.standing((0.0, 0.0))
    t = navigation.first_violation(person, machine, LAW, 0.0, 60.0)
    assert t == pytest.approx(6.5 + 0.2, abs=1e-6)


def test_bodies_at_rest_are_evaluated_once():
    near, far = navigation.standing((0, 0)), navigation.standing((1.0, 0))
    assert navigation.violations(near, far, LAW, 0.0, 1e6) == []
    close = navigation.standing((0.999, 0))
    assert navigation.violations(near, close, LAW, 0.0, 1e6) == [(0.0, 1e6)]
    assert navigation.first_violation(near, close, LAW, 3.0, 3.0) == 3.0


def test_a_violation_ends_at_a_jump():
    walk = navigation.walk([(-10, 0), (10, 0)], 0.0)
    person = navigation.join([walk, navigation.standing((-20, 0), start=8.0)], end=20.0)
    machine = navigation.standing((0, 0))
    assert navigation.violations(person, machine, LAW, 0.0, 20.0) == [
        (pytest.approx(6.7, abs=1e-6), 8.0)
    ]


def test_conditions_combine():
    person = navigation.walk([(-10, 0), (10, 0)], 0.0)
    machine = navigation.standing((0.0, 1.0))
    near = navigation.TooClose(FixedDistance(5.0))
    approaching = near & navigation.Approaching()
    ((begin, end),) = navigation.when(approaching, person, machine, 0.0, 60.0)
    assert begin == pytest.approx(10.2 - math.sqrt(24), abs=1e-6)
    assert end == pytest.approx(10.2, abs=1e-6)
    leaving = near & ~navigation.Approaching()
    ((begin, end),) = navigation.when(leaving, person, machine, 0.0, 60.0)
    assert (begin, end) == pytest.approx((10.2, 10.2 + math.sqrt(24)), abs=1e-6)
    apart = list(navigation.when(navigation.Apart(5.0), person, machine, 0.0, 60.0))
    assert len(apart) == 2
    moving = navigation.when(navigation.Moving(), machine, person, 0.0, 60.0)
    ((begin, end),) = moving
    assert begin == pytest.approx(0.01 / 2.5, abs=1e-6)
    assert end == pytest.approx(person.end - 0.01 / 2.5, abs=1e-5)


@given(walks, gantry_motions(), st.floats(0, 1), st.floats(0, 1))
def test_bounds_enclose_the_rate_of_approach(person, machine, one, other):
    for encounter in encounters(person, machine, 0.0, END):
        span = encounter.end - encounter.begin
        begin, end = sorted(encounter.begin + share * span for share in (one, other))
        low, high = encounter.closing(begin, end)
        for t in np.linspace(begin, end, 20):
            (at, moved) = (machine.state(t).at, machine.state(t).velocity)
            (by, walked) = (person.state(t).at, person.state(t).velocity)
            if begin < t < end:
                rate = sum((at[k] - by[k]) * (moved[k] - walked[k]) for k in (0, 1))
                assert low - 1e-9 <= rate <= high + 1e-9


@dataclass
class Counted:
    """Condition that counts its evaluations."""

    condition: navigation.Condition
    judged: int = 0

    def holds(self, encounter, begin, end):
        self.judged += 1
        return self.condition.holds(encounter, begin, end)


def test_a_stop_beside_a_machine_needs_few_evaluations():
    # The person stops 0.6 m beside the machine's centre and 0.03 mm past it.
    person = navigation.walk([(-3.0, 0.0), (0.0, 0.0)], 0.0, max_speed=0.4)
    leaving = Counted(~navigation.Approaching())
    machine = navigation.standing((-2.2e-5, 0.634))
    t = navigation.first_time(leaving, person, machine, 1.0, person.end)
    assert person.position(t)[0] == pytest.approx(-2.2e-5, abs=1e-7)
    assert leaving.judged < 200


def integral_margin(person, machine, law, ts):
    """Return the margin of the integral law, by the trapezium rule on steps of 0.5 ms."""
    steps = np.arange(0.0, END + 5.0, 5e-4)
    ways = []
    for motion in (person, machine):
        speed = np.hypot(*motion.velocity(steps).T)
        ways.append(np.concatenate([[0.0], np.cumsum((speed[1:] + speed[:-1]) / 2 * 5e-4)]))
    human, robot = (lambda t, way=way: np.interp(t, steps, way) for way in ways)
    required = human(ts + law.t1 + law.t2) - human(ts) + robot(ts + law.t1) - robot(ts)
    if law.stopping is None:
        required += np.hypot(*machine.velocity(ts + law.t1).T) * law.t2 / 2
    else:
        required += law.stopping
    apart = np.hypot(*(person.position(ts) - machine.position(ts)).T)
    return apart - required - law.intrusion


integral_laws = st.builds(
    lambda t1, t2, stopping, intrusion: IntegralLaw(
        t1=t1, t2=t2, stopping=stopping, intrusion=intrusion
    ),
    st.floats(0, 2),
    st.floats(0, 2),
    st.one_of(st.none(), st.floats(0, 1)),
    st.floats(0, 2),
)


@st.composite
def with_pieces_of_no_length(draw, motions):
    """Return a motion, and the same with pieces without duration of any velocity."""
    motion = draw(motions)
    coefficient = st.floats(-20, 20)
    pieces = []
    for piece in motion.pieces:
        if draw(st.booleans()):
            rest = [draw(st.tuples(*(coefficient,) * 3)) for _ in range(3)]
            x, y, turn = (
                (axis[0], *others)
                for axis, others in zip((piece.x, piece.y, piece.rotation), rest, strict=True)
            )
            pieces.append(Piece(piece.begin, piece.begin, x, y, turn))
        pieces.append(piece)
    last = motion.state(motion.end)
    speed = draw(coefficient)
    x, y, turn = ((at, speed, 0.0, 0.0) for at in last.position)
    pieces.append(Piece(motion.end, motion.end, x, y, turn))
    return motion, Motion(tuple(pieces), motion.jumps)


@given(
    with_pieces_of_no_length(walks),
    with_pieces_of_no_length(gantry_motions()),
    st.one_of(laws, integral_laws),
)
def test_pieces_without_duration_change_nothing(persons, machines, law):
    plain, padded = zip(persons, machines, strict=True)
    for question in (navigation.violations, navigation.first_violation, navigation.minimum_margin):
        assert question(*padded, law, 0.0, END) == question(*plain, law, 0.0, END)
    nearest = navigation.minimum_separation(*padded, 0.0, END)
    assert nearest == navigation.minimum_separation(*plain, 0.0, END)


@given(walks, gantry_motions(), integral_laws)
def test_the_integral_law_is_that_of_dense_sampling(person, machine, law):
    ts = np.arange(0, END, 1e-3)
    margins = integral_margin(person, machine, law, ts)
    found = navigation.violations(person, machine, law, 0.0, END)
    inside = np.zeros(len(ts), dtype=bool)
    for begin, end in found:
        inside |= (ts >= begin) & (ts <= end)
    # A trapezium with a jump of speed has an error of up to 0.5 ms at 2 m/s.
    assert inside[margins < -5e-3].all()
    assert not inside[margins > 5e-3].any()
    _, least = navigation.minimum_margin(person, machine, law, 0.0, END)
    assert margins.min() - 1e-2 <= least <= margins.min() + 5e-3
    assert (least < -1e-9) == bool(found) or abs(least) <= 1e-9


def refined_crossings(f, ts):
    """Return the sign changes of f, jumps included, bisected from 0.1 ms to 1 ns."""
    below = f(ts) < 0
    low, high = (ts[k][below[1:] != below[:-1]] for k in (slice(0, -1), slice(1, None)))
    starts_below = f(low) < 0 if len(low) else np.array([], dtype=bool)
    for _ in range(17):
        middle = (low + high) / 2
        same = (f(middle) < 0) == starts_below if len(low) else starts_below
        low, high = np.where(same, middle, low), np.where(same, high, middle)
    return (low + high) / 2


def refined_minima(f, ts):
    """Return the local minima near the samples to about 1e-12."""
    values = f(ts)
    inner = values[1:-1]
    low_enough = inner < values.min() + 1e-2
    dips = 1 + np.flatnonzero((inner < values[:-2]) & (inner <= values[2:]) & low_enough)
    low, high = ts[dips - 1], ts[dips + 1]
    for _ in range(60):
        third = (high - low) / 3
        left = f(low + third) < f(high - third) if len(low) else np.array([], dtype=bool)
        low, high = np.where(left, low, low + third), np.where(left, high - third, high)
    refined = f((low + high) / 2) if len(low) else values
    return float(min(refined.min(), values.min()))


@settings(max_examples=settings.default.max_examples // 3)
@given(walks, gantry_motions(), linear_laws)
def test_times_are_exact_to_a_microsecond(person, machine, law):
    """Every crossing in samples of 0.5 ms, refined, has an exact counterpart within 1 µs."""
    ts = np.arange(0, END, 5e-4)

    def f(t):
        return margin(person, machine, law, t)

    crossings = refined_crossings(f, ts)
    ends = np.array(
        [t for span in navigation.violations(person, machine, law, 0.0, END) for t in span]
    )
    for t in crossings:
        steep = abs(f(t + 1e-6) - f(t - 1e-6)) > 1e-9
        assert not steep or np.abs(ends - t).min() <= 1e-6


@given(walks, gantry_motions(), linear_laws)
def test_the_minimum_margin_is_that_of_dense_sampling(person, machine, law):
    ts = np.arange(0, END, 1e-3)
    least = refined_minima(lambda t: margin(person, machine, law, t), ts)
    t, margin_ = navigation.minimum_margin(person, machine, law, 0.0, END)
    assert 0.0 <= t <= END
    # Speeds jump only where sampling cannot hit the time before a change.
    assert margin_ <= least + 1e-9
    before, after = (margin(person, machine, law, np.array([u]))[0] for u in (t - 1e-9, t + 1e-9))
    assert margin_ >= min(before, after) - 1e-7
    found = navigation.violations(person, machine, law, 0.0, END)
    assert bool(found) == (margin_ < 0) or abs(margin_) < 1e-9


@given(walks, gantry_motions(), st.floats(0, 3))
def test_a_plain_law_has_the_same_minimum_margin_to_a_micrometre(person, machine, intrusion):
    law = SeparationLaw(t1=0.5, t2=1.0, intrusion=intrusion)
    plain = Scaled(law, 1.0)
    _, exact = navigation.minimum_margin(person, machine, law, 0.0, END)
    _, found = navigation.minimum_margin(person, machine, plain, 0.0, END)
    assert exact - 1e-9 <= found <= exact + 1e-6


def test_the_minimum_margin_of_a_fixed_distance_is_that_of_the_separation():
    person = navigation.walk([(-9, 1), (9, 1)], 0.0)
    machine = navigation.gantry_move((-7, 0, 0), (-1, 3, 0), 2.0)
    t, distance = navigation.minimum_separation(person, machine, 0.0, 60.0)
    law = FixedDistance(2.0)
    assert navigation.minimum_margin(person, machine, law, 0.0, 60.0) == (
        pytest.approx(t, abs=1e-4),
        pytest.approx(distance - 2.0, abs=1e-9),
    )


def test_the_minimum_margin_includes_both_sides_of_a_jump():
    """At top speed until a jump, the time before it counts, as for a violation."""
    walk = navigation.walk([(-10, 0), (10, 0)], 0.0)
    person = navigation.join([walk, navigation.standing((-20, 0), start=8.0)], end=20.0)
    machine = navigation.standing((0, 0))
    t, least = navigation.minimum_margin(person, machine, LAW, 0.0, 20.0)
    assert (t, least) == (8.0, pytest.approx(2.2 - 3.5, abs=1e-6))


def test_the_minimum_margin_if_slopes_of_distance_and_requirement_cancel():
    """When braking head on, d = s²/2a and k v shrink together, with a minimum at v = k a."""
    person = navigation.walk([(-10, 0), (-2, 0)], 0.0, max_speed=2.0, max_acceleration=0.5)
    machine = navigation.standing((0, 0))
    law = SeparationLaw(t1=0.0, t2=1.0)
    _, least = navigation.minimum_margin(person, machine, law, 0.0, 60.0)
    # At speed v the remaining path is v² and the margin 2 + v² − v, with a minimum at v = 1/2.
    assert least == pytest.approx(1.75, abs=1e-6)


def test_a_stop_exactly_at_the_limit_is_no_violation_of_the_integral_law():
    """On approach, distance and remaining path shrink together, a tie for 2.5 s."""
    person = navigation.walk([(-10, 0), (-1, 0)], 0.0)
    machine = navigation.standing((0, 0))
    assert navigation.violations(person, machine, INTEGRAL_LAW, 0.0, 20.0) == []
    _, least = navigation.minimum_margin(person, machine, INTEGRAL_LAW, 0.0, 20.0)
    assert least == pytest.approx(0.0)


def test_the_constant_approach_speed_applies_to_standing_people():
    person, machine = navigation.standing((0, 0)), navigation.walk([(9, 0), (1, 0)], 0.0)
    law = ApproachLaw(time=1.0, intrusion=0.4)
    t = navigation.first_violation(person, machine, law, 0.0, 20.0)
    assert t == pytest.approx(7.0 + 0.2, abs=1e-6)


@given(walks, gantry_motions(), *(st.floats(-1, 1) for _ in range(2)), st.floats(0, 1))
def test_bounds_on_distances_hold_throughout_an_interval(person, machine, slope, curve, share):
    for encounter in encounters(person, machine, 0.0, END):
        begin, end = part_of(encounter, 0.0, share)
        distances = np.vectorize(encounter.distance)
        assert_bounds(encounter, begin, end, slope, curve, distances)


@pytest.mark.parametrize("metres", [1e-9, 1e-80, 1e-145, 1e-160, 1e-300, 5e-324])
def test_tiny_motions_have_results(metres):
    person = navigation.standing((0, 0))
    machine = navigation.gantry_move((0.0, metres, 0.0), (0.0, 0.0, 0.5))
    drift = Motion((Piece(0.0, 3.0, (0.0, metres, metres, metres), (metres,) * 4, (0.0,) * 4),))
    for law in (IntegralLaw(t1=1.0, t2=1.0), LAW):
        for body in (machine, drift):
            margin_ = navigation.minimum_margin(person, body, law, 0.0, 5.0)[1]
            required = 1.0 if law is LAW else 0.0
            assert margin_ == pytest.approx(-required, abs=1e-7)
            found = navigation.violations(person, body, law, 0.0, 5.0)
            assert found == [(0.0, 5.0)] or law is not LAW


class Since:
    """Condition that the time is at least `t` seconds."""

    def __init__(self, t):
        self.t = t

    def holds(self, encounter, begin, end):
        return True if begin >= self.t else False if end < self.t else None


def test_a_time_is_found_in_any_span():
    stands = navigation.standing((0.0, 0.0))
    begun = navigation.first_time(Since(1.0), stands, stands, 0.0, 1e300)
    assert begun == pytest.approx(1.0, abs=1e-7)


def test_interleaved_searches_are_independent():
    person = navigation.walk([(-9.0, 0.0), (0.0, 0.0), (-9.0, 1.0)], 0.0)
    machines = [navigation.standing((-7.0, 0.5)), navigation.standing((-3.0, -0.5))]
    pairs = [(person, machine) for machine in machines]
    in_turn = zip(*(navigation.when(TOO_CLOSE, *pair, 0.0, END) for pair in pairs), strict=True)
    alone = [navigation.violations(*pair, LAW, 0.0, END) for pair in pairs]
    assert [*zip(*in_turn, strict=True)] == [tuple(found) for found in alone]


@dataclass(frozen=True)
class Kinetic:
    """Custom law: 0.5 m and the braking distance of the robot at 2 m/s²."""

    def distance(self, human_speed, robot_speed):
        return 0.5 + robot_speed**2 / 4


def test_a_custom_law_is_a_small_class():
    person = navigation.standing((0, 0))
    machine = navigation.walk([(-9, 0), (9, 0)], 0.0, max_speed=2.0)
    ((begin, end),) = navigation.violations(person, machine, Kinetic(), 0.0, 60.0)
    assert machine.position(begin)[0] == pytest.approx(-1.5, abs=1e-6)
    assert machine.position(end)[0] == pytest.approx(1.5, abs=1e-6)
    _, least = navigation.minimum_margin(person, machine, Kinetic(), 0.0, 60.0)
    assert least == pytest.approx(-1.5, abs=1e-6)


@dataclass(frozen=True)
class Constant:
    metres: float

    def distance(self, human_speed, robot_speed):
        return self.metres


class Shrinking:
    def distance(self, human_speed, robot_speed):
        return 3.0 - human_speed


class ShrinkingLater:
    """Law without a value at speeds that only an accelerating person has."""

    def distance(self, human_speed, robot_speed):
        return math.nan if 0.3 < human_speed < 0.9 else 2.9


def test_invalid_laws_are_rejected():
    person, machine = navigation.walk([(-2.9, 0), (9, 0)], 0.0), navigation.standing((0, 0))
    for law in (Constant(math.nan), Shrinking()):
        with pytest.raises(ValueError, match="must not ask for less when speeds grow"):
            navigation.violations(person, machine, law, 0.0, 60.0)
        with pytest.raises(ValueError, match="must not ask for less when speeds grow"):
            navigation.minimum_margin(person, machine, law, 0.0, 60.0)
    with pytest.raises(ValueError, match="must not ask for less when speeds grow"):
        navigation.violations(person, machine, ShrinkingLater(), 0.0, 60.0)
    with pytest.raises(ValueError, match="no finite distance"):
        navigation.minimum_margin(person, machine, Constant(math.inf), 0.0, 60.0)
    with pytest.raises(ValueError, match="has a method distance or required"):
        navigation.violations(person, machine, 3.5, 0.0, 60.0)


def test_invalid_motions_are_rejected():
    still = navigation.standing((0, 0))
    nowhere = Motion((Piece(0.0, 9.0, (math.nan, 0.0, 0.0, 0.0), (0.0,) * 4, (0.0,) * 4),))
    for pair in ((still, nowhere), (nowhere, still)):
        with pytest.raises(ValueError, match=r"a motion is not finite from t = 0\.0 s to 9\.0 s"):
            navigation.violations(*pair, LAW, 0.0, 60.0)
        with pytest.raises(ValueError, match="a motion is not finite"):
            navigation.minimum_separation(*pair, 0.0, 60.0)


@pytest.mark.parametrize("span", [(1.0, 0.0), (0.0, math.inf), (math.nan, 1.0)])
def test_invalid_spans_are_rejected(span):
    body = navigation.standing((0, 0))
    for ask in (
        lambda: navigation.minimum_margin(body, body, LAW, *span),
        lambda: navigation.minimum_separation(body, body, *span),
        lambda: navigation.violations(body, body, LAW, *span),
    ):
        with pytest.raises(ValueError, match="can't watch from"):
            ask()


def test_results_are_plain_numbers():
    """Numbers of numpy are not serializable to JSON."""
    number, row = np.float64, np.array
    person = navigation.walk(row([(-6.0, 0.0), (0.0, 0.0), (3.0, 4.0)]), number(0.3))
    gantry = navigation.gantry_move(row([-7.0, 0.0, 0.0]), row([-2.5, 0.5, 0.0]), number(1.0))
    gantry = navigation.join([gantry, navigation.gantry_stop(gantry.state(number(3)), number(3))])
    stopped = navigation.stop_walking(person.cut(number(0), number(5)), number(4))
    law = FixedDistance(number(2.0))
    span = (number(0), number(END))
    plain = [
        *(motion.pieces for motion in (person, gantry, stopped)),
        navigation.standing(row([1.0, 2.0]), heading=number(1), start=number(1)).pieces,
        navigation.violations(person, gantry, law, *span),
        navigation.first_violation(person, gantry, law, *span),
        navigation.minimum_separation(person, gantry, *span),
        navigation.minimum_margin(person, gantry, law, *span),
        required_at(law, person, gantry, number(2)),
        required_at_speeds(law, number(1), number(1)),
    ]
    assert "np." not in repr(plain)
    assert plain[4]
