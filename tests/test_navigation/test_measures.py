"""Measures of motions, against dense sampling and the monitor."""

import itertools
import math
import tracemalloc

import numpy as np
import pytest
from hypothesis import example, given, settings, strategies as st

import navigation
from navigation import FixedDistance, Motion, Piece
from navigation.kernels.odometer import Odometer
from navigation.measures import Company, Courses, nearest_pair

END = 12.0
SAMPLES = 12_000
TIMES = (np.arange(SAMPLES) + 0.5) * (END / SAMPLES)

coefficient = st.one_of(st.just(0.0), st.floats(-1.5, 1.5).filter(lambda c: abs(c) > 1e-3))


@st.composite
def motions(draw):
    """Return consecutive cubics with smooth bends, stops, turns on the spot, and some jumps."""
    pieces, jumps, t = [], set(), draw(st.floats(0, 2))
    at = [draw(st.floats(-4, 4)), draw(st.floats(-4, 4)), draw(st.floats(-3, 3))]
    for _ in range(draw(st.integers(1, 5))):
        duration = draw(st.floats(0.5, 3))
        axes = []
        for k in range(3):
            steady, bend, jerk = draw(st.tuples(coefficient, coefficient, coefficient))
            axes.append((at[k], steady, bend / duration / 2, jerk / duration**2 / 3))
        pieces.append(Piece(t, t + duration, *axes))
        t += duration
        u = duration
        at = [a + u * (b + u * (c + u * d)) for a, b, c, d in axes]
        at[2] += draw(st.sampled_from([0.0, 0.0, 1.0, -2.5]))
        if draw(st.booleans()):
            at[0] += 3.0
            jumps.add(t)
    return Motion(tuple(pieces), frozenset(jumps))


def sampled(motion):
    """Return speed, acceleration and turn rate at `TIMES`, computed by numpy."""
    speed, acceleration, spin = np.zeros((3, SAMPLES))
    for piece in motion.pieces:
        within = (piece.begin <= TIMES) & (piece.end > TIMES)
        u = TIMES[within] - piece.begin
        x, y, rotation = (np.polynomial.Polynomial(axis) for axis in piece[2:])
        speed[within] = np.hypot(x.deriv()(u), y.deriv()(u))
        acceleration[within] = np.hypot(x.deriv(2)(u), y.deriv(2)(u))
        spin[within] = rotation.deriv()(u)
    return speed, acceleration, spin


def gaps(own, others, begin, times):
    """Return the distances at `times` from others, of which the first is present from `begin`."""
    apart = np.array([np.hypot(*(own.position(times) - o.position(times)).T) for o in others])
    apart[0, begin > times] = np.inf
    return apart


def turns_on_the_spot(motion):
    return sum(
        abs(math.remainder(b.rotation[0] - motion.state_before(b.begin).position[2], math.tau))
        for b in motion.pieces[1:]
        if b.begin < END and b.begin not in motion.jumps
    )


@given(motions())
def test_measures_of_a_motion_are_those_of_dense_sampling(motion):
    courses = Courses([motion], [(0.0, END)])
    speed, acceleration, spin = sampled(motion)
    assert courses.length[0] == pytest.approx(speed.mean() * END, abs=2e-2)
    assert courses.acceleration[0] == pytest.approx(acceleration.mean() * END, abs=5e-2)
    assert courses.top_speed[0] == pytest.approx(speed.max(), abs=2e-2)
    assert courses.top_speed[0] >= speed.max() - 1e-9
    turning = np.abs(spin).mean() * END + turns_on_the_spot(motion)
    assert courses.turning[0] == pytest.approx(turning, abs=5e-2)
    slow = (speed < 0.4) & (np.abs(spin) < 0.3)
    assert courses.time_not_moving(0.4, 0.3)[0] == pytest.approx(slow.mean() * END, abs=0.1)


@pytest.mark.parametrize("mirrored", [False, True])
def test_a_reversal_close_to_an_end_counts(mirrored):
    """So close that no node of a quadrature rule is between."""
    turn, end, nothing = 0.001, 0.4, (0.0, 0.0, 0.0, 0.0)
    y = (0.0, -2.0 * turn, 1.0, 0.0)
    if mirrored:
        y = (0.0, 2.0 * (end - turn), -1.0, 0.0)
    motion = Motion((Piece(0.0, end, nothing, y, nothing),))
    (way,) = Courses([motion], [(0.0, end)]).length
    assert way == pytest.approx(turn**2 + (end - turn) ** 2, abs=1e-11)


@given(motions(), st.floats(0, 6), st.floats(0, 6))
def test_the_length_is_that_of_the_odometer(motion, begin, more):
    odometer, end = Odometer(motion), begin + more
    (way,) = Courses([motion], [(begin, end)]).length
    assert way == pytest.approx(odometer.reading(end) - odometer.reading(begin), abs=1e-8)


@given(motions(), motions(), st.floats(0.1, 6))
def test_distances_are_those_of_the_monitor(a, b, metres):
    courses = Courses([a, b], [(0.0, END)] * 2)
    (company,) = courses.company([(0, [1])], [metres])
    nearest = navigation.minimum_separation(a, b, 0.0, END)[1]
    assert company.minimum == pytest.approx(nearest, abs=1e-6)
    inside = navigation.violations(a, b, FixedDistance(metres), 0.0, END)
    assert company.within[0] == pytest.approx(sum(t - s for s, t in inside), abs=1e-5)
    apart = np.hypot(*(a.position(TIMES) - b.position(TIMES)).T)
    assert company.mean == pytest.approx(apart.mean(), abs=2e-3)
    assert company.maximum == pytest.approx(apart.max(), abs=2e-2)
    assert company.maximum >= apart.max() - 1e-9


def jumping(*places):
    """Return a motion that stands at each of several places on x for one second."""
    stands = [navigation.standing((x, 0.0), start=float(t)) for t, x in enumerate(places)]
    return navigation.join(stands, end=float(len(places)))


@settings(max_examples=40)
@given(motions(), st.lists(motions(), min_size=2, max_size=3), st.floats(0, 4), st.floats(0, 0.5))
@example(jumping(0.0), [jumping(1.0, 5.0), jumping(8.0)], 0.9998, 0.0)
def test_the_nearest_of_several_is_that_of_dense_sampling(own, others, begin, radius):
    everybody = [own, *others]
    spans = [(0.0, END), (begin, END), *[(0.0, END)] * (len(others) - 1)]
    courses = Courses(everybody, spans)
    radii = [radius, *[0.1] * len(others)]
    (company,) = courses.company([(0, range(1, len(everybody)))], [1.0, 3.0], radii)
    apart = gaps(own, others, begin, TIMES) - radius - 0.1
    nearest = apart.min(0)
    # Intervals shorter than a sample count as well, between a jump and `begin` or the end.
    changes = [t for m in everybody for t in m.jumps if t < END]
    before = [t - 1e-9 for t in (*changes, END)]
    instants = np.array([*TIMES, begin, *changes, *before])
    extremes = gaps(own, others, begin, instants) - radius - 0.1
    assert company.time == END
    assert company.mean == pytest.approx(nearest.mean(), abs=2e-2)
    assert company.minimum == pytest.approx(extremes.min(), abs=2e-2)
    assert company.maximum == pytest.approx(extremes[np.isfinite(extremes)].max(), abs=2e-2)
    for metres, seconds in zip([1.0, 3.0], company.within, strict=True):
        assert seconds == pytest.approx((nearest < metres).mean() * END, abs=0.02)


def test_a_teleport_adds_neither_length_nor_turning():
    there = navigation.standing((0.0, 0.0), heading=0.0, start=0.0)
    away = navigation.standing((5.0, 5.0), heading=2.0, start=3.0)
    courses = Courses([navigation.join([there, away], end=6.0)], [(0.0, 6.0)])
    assert (courses.length[0], courses.turning[0], courses.top_speed[0]) == (0.0, 0.0, 0.0)
    assert courses.time_not_moving(0.001, 0.01)[0] == 6.0


@pytest.mark.parametrize("tiny", [0.0, 5e-324, -5e-324])
def test_a_turn_with_a_tiny_curvature_is_exact(tiny):
    still = (0.0, 0.0, 0.0, 0.0)
    motion = Motion((Piece(0.0, 2.0, still, still, (0.0, 0.25, tiny, tiny)),))
    assert Courses([motion], [(0.0, 2.0)]).turning[0] == 0.5


def test_measures_equal_closed_forms():
    """4 m at 1 m/s and 2 m/s², past a person who stands 0.5 m beside the middle."""
    walk = navigation.walk([(0, 0), (4, 0)], max_speed=1.0, max_acceleration=2.0)
    other = navigation.standing((2.0, 0.5))
    courses = Courses([walk, other], [(0.0, walk.end)] * 2)
    (company,) = courses.company([(0, [1])], [1.0])
    assert walk.end == pytest.approx(4.5)
    assert courses.length == pytest.approx([4.0, 0.0])
    assert courses.acceleration[0] == pytest.approx(2.0)  # up by 1 m/s, down by 1 m/s
    assert courses.top_speed[0] == pytest.approx(1.0)
    assert courses.time_not_moving(0.001, 0.01)[0] == pytest.approx(2 * 0.001 / 2.0)
    assert company.minimum == pytest.approx(0.5)
    assert company.maximum == pytest.approx(math.hypot(2.0, 0.5))
    assert company.within[0] == pytest.approx(2 * math.sqrt(0.75))


def test_constant_distances_need_no_subdivision():
    """A tie all along must not be divided forever."""
    walk = navigation.walk([(0, 0), (40, 30)])
    beside = navigation.walk([(1, 2), (41, 32)])
    (company,) = Courses([walk, beside], [(0.0, 60.0)] * 2).company(
        [(0, [1])], [math.sqrt(5), math.sqrt(5) - 1e-6, math.sqrt(5) + 1e-6]
    )
    assert company.within[1:] == (0.0, pytest.approx(60.0))
    assert company.mean == pytest.approx(math.sqrt(5))


def test_invalid_spans_are_rejected():
    here = navigation.standing((0.0, 0.0))
    for span in ((2.0, 1.0), (0.0, math.inf), (math.nan, 1.0)):
        with pytest.raises(ValueError, match="can't look"):
            Courses([here], [span])


def test_bodies_that_are_never_present_together_have_no_distance():
    here, there = navigation.standing((0.0, 0.0)), navigation.standing((1.0, 0.0))
    courses = Courses([here, there], [(0.0, 1.0), (1.0, 2.0)])
    (company,) = courses.company([(0, [1])], [2.0])
    assert company == Company(0.0, 0.0, 0.0, 0.0, (0.0,))
    assert Courses([here], [(1.0, 1.0)]).length[0] == 0.0


def test_measures_of_parts_add_up():
    walk = navigation.walk([(0, 0), (4, 0), (4, 3), (1, 1)])
    gantry = navigation.gantry_move((0.0, 4.0, 0.0), (5.0, -1.0, 2.0), start=1.0)
    cuts = [0.0, 1.7, 3.1, 3.1, 9.0, 14.0]
    pair = [walk, gantry]
    parts = [Courses(pair, [span] * 2) for span in itertools.pairwise(cuts)]
    whole = Courses(pair, [(cuts[0], cuts[-1])] * 2)
    for name in ("length", "acceleration", "jerk"):
        total = sum(getattr(part, name) for part in parts)
        assert getattr(whole, name) == pytest.approx(total, abs=1e-8)
    mean = sum(p.company([(0, [1])])[0].mean * p.time[0] for p in parts) / 14.0
    assert whole.company([(0, [1])])[0].mean == pytest.approx(mean, abs=1e-8)


@settings(max_examples=20)
@given(st.lists(motions(), min_size=3, max_size=5), st.floats(0, 4), st.integers(1, 40))
def test_measures_are_the_same_together_and_alone(bodies, begin, largest):
    courses = Courses(bodies, [(begin, END), *[(0.0, END)] * (len(bodies) - 1)])
    asked = [(a, [b]) for a, b in itertools.combinations(range(len(bodies)), 2)]
    asked.append((0, range(1, len(bodies))))
    whole = [courses.company([one], [1.0, 3.0])[0] for one in asked]
    with pytest.MonkeyPatch.context() as patched:
        patched.setattr(navigation.measures, "_LARGEST", largest)
        for one, other in zip(courses.company(asked, [1.0, 3.0]), whole, strict=True):
            assert (one.time, *one.within) == pytest.approx((other.time, *other.within))
            assert one.mean == pytest.approx(other.mean, abs=1e-9)
            assert one.minimum == pytest.approx(other.minimum, abs=1e-6)
            assert one.maximum == pytest.approx(other.maximum, abs=1e-6)


def test_measures_of_a_crowd_fit_into_memory():
    """Distances of all pairs over the cuts of all motions would need gigabytes."""
    crowd = [
        navigation.walk([(x, k + x % 2 / 2) for x in range(9)], max_speed=1.0 + k / 100)
        for k in range(24)
    ]
    courses = Courses(crowd, [(0.0, 20.0)] * len(crowd))
    pairs = [(a, [b]) for a, b in itertools.combinations(range(len(crowd)), 2)]
    tracemalloc.start()
    courses.company([*pairs, (0, range(1, len(crowd)))], [1.0])
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert peak < 100e6


def wandering(
    rng: np.random.Generator, width: float, jumps: bool, length: float
) -> navigation.Motion:
    """Return a walk on a square floor with some jumps to other places."""
    late = length / 10
    walks = [
        navigation.walk(rng.uniform(0, width, (4, 2)), begin + rng.uniform(0, late), max_speed=1.5)
        for begin in ((0.0, length / 2) if jumps else (0.0,))
    ]
    return navigation.join(walks)


@pytest.mark.parametrize("jumps", [False, True])
@pytest.mark.parametrize("width", [6.0, 60.0])
@pytest.mark.parametrize("length", [20.0, 300.0])
def test_the_nearest_pair_is_that_of_an_oracle(length, width, jumps):
    rng = np.random.default_rng(7)
    for _ in range(20):
        count = int(rng.integers(2, 8))
        motions = [wandering(rng, width, jumps, length) for _ in range(count)]
        radii = rng.uniform(0.1, 0.4, count)
        found = nearest_pair(motions, list(radii), [1.5] * count, 0.0, length)
        apart = {
            (i, j): navigation.minimum_separation(motions[i], motions[j], 0.0, length)[1]
            - radii[i]
            - radii[j]
            for i, j in itertools.combinations(range(count), 2)
        }
        if min(apart.values()) >= 0:
            assert found.distance == pytest.approx(min(apart.values()), abs=1e-8)
            assert apart[found.pair] == pytest.approx(found.distance, abs=1e-8)
        assert found.overlaps == sum(gap < -1e-9 for gap in apart.values())


def test_absent_people_are_near_no_one():
    rng = np.random.default_rng(8)
    together = 0
    for _ in range(40):
        count = int(rng.integers(2, 6))
        motions = [wandering(rng, 6.0, jumps=True, length=20.0) for _ in range(count)]
        spans = [np.sort(rng.uniform(-5.0, 25.0, 4)).reshape(2, 2).tolist() for _ in range(count)]
        spans[0] = [(9.0, 9.0)]
        args = (motions, [0.0] * count, [1.5] * count, 0.0, 20.0)
        found = nearest_pair(*args, spans)
        apart = {}
        for i, j in itertools.combinations(range(count), 2):
            for one, other in itertools.product(spans[i], spans[j]):
                begin, end = max(one[0], other[0], 0.0), min(one[1], other[1], 20.0)
                if begin < end:
                    both = navigation.minimum_separation(motions[i], motions[j], begin, end)
                    apart[i, j] = min(both[1], apart.get((i, j), math.inf))
        together += bool(apart)
        if not apart:
            assert found is None
            continue
        assert found.distance == pytest.approx(min(apart.values()), abs=1e-6)
        assert apart[found.pair] == pytest.approx(found.distance, abs=1e-6)
    assert 5 < together < 40
