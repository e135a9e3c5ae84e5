"""The monitor against brute force: the same verdict, the same instants, nothing missed."""

import itertools
import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import navigation
from navigation import FixedDistance, Scaled, SeparationLaw

LAW = SeparationLaw(t1=1.0, t2=1.5, stopping=0.0, intrusion=1.0)
END = 30.0

point = st.tuples(st.floats(-10, 0), st.floats(-6, 6))
walks = st.builds(
    lambda points, start: navigation.walk(points, start),
    st.lists(point, min_size=2, max_size=6),
    st.floats(0, 5),
)
poses = st.tuples(st.floats(-10, 0), st.floats(-6, 6), st.floats(-3, 3))


@st.composite
def gantry_motions(draw):
    """A few moves, each replacing the one before somewhere on its way."""
    motions = [navigation.gantry_move(draw(poses), draw(poses), draw(st.floats(0, 5)))]
    for _ in range(draw(st.integers(0, 3))):
        last = motions[-1]
        t = last.start + draw(st.floats(0.1, 1.0)) * (last.end - last.start)
        motions.append(navigation.gantry_move(last.state(t), draw(poses), t))
    return navigation.join(motions)


laws = st.one_of(
    st.builds(
        lambda t1, t2, b, d: SeparationLaw(t1=t1, t2=t2, stopping=b, intrusion=d),
        *(st.floats(0, 2) for _ in range(4)),
    ),
    st.builds(FixedDistance, st.floats(0, 6)),
    st.builds(lambda factor, cap: Scaled(LAW, factor, cap), st.floats(0, 2), st.floats(0, 8)),
)


def margin(person, machine, law, ts):
    """Distance minus required distance at many instants."""
    apart = np.hypot(*(person.position(ts) - machine.position(ts)).T)
    human, robot = (np.hypot(*motion.velocity(ts).T) for motion in (person, machine))
    return apart - np.array([law.distance(h, r) for h, r in zip(human, robot, strict=True)])


def sampled(person, machine, law, step=1e-3):
    ts = np.arange(0, END + step, step)
    return ts, margin(person, machine, law, ts)


@given(walks, gantry_motions(), laws)
def test_violations_are_those_of_dense_sampling(person, machine, law):
    ts, margins = sampled(person, machine, law)
    found = navigation.violations(person, machine, law, 0.0, END)
    inside = np.zeros(len(ts), dtype=bool)
    for begin, end in found:
        assert 0.0 <= begin <= end <= END
        inside |= (ts >= begin) & (ts <= end)
    # Where sampling is sure, the monitor agrees; the doubtful are within rounding of the limit.
    assert inside[margins < -1e-6].all()
    assert not inside[margins > 1e-6].any()
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
    assert distance >= apart.min() - 3e-3
    exact = math.dist(person.position(t), machine.position(t))
    assert distance == pytest.approx(exact, abs=1e-9)


@pytest.mark.parametrize("milliseconds", [1.0, 0.1, 0.01])
def test_a_violation_of_a_millisecond_is_not_missed(milliseconds):
    """Two pass on a right line at 2 m/s: the chord of the limit is as short as we like."""
    half_chord = 1.0 * milliseconds / 2000
    offset = math.sqrt(3.5**2 - half_chord**2)
    person = navigation.walk([(-9, 0), (9, 0)], 0.0)
    machine = navigation.standing((0.0, offset))
    found = navigation.violations(person, machine, LAW, 0.0, 60.0)
    assert len(found) == 1
    begin, end = found[0]
    middle = 9.0 + 0.2  # 0.2 s more than at top speed all the way, for speeding up
    assert begin == pytest.approx(middle - half_chord, abs=1e-6)
    assert end == pytest.approx(middle + half_chord, abs=1e-6)


def test_a_near_miss_is_no_violation():
    person = navigation.walk([(-9, 0), (9, 0)], 0.0)
    machine = navigation.standing((0.0, 3.5 + 1e-9))
    assert navigation.violations(person, machine, LAW, 0.0, 60.0) == []


def test_the_first_instant_against_a_closed_form():
    """Head on at top speed: 3.5 m before a gantry that stands, √ and all left out."""
    person = navigation.walk([(-10, 0), (10, 0)], 0.0)
    machine = navigation.standing((0.0, 0.0))
    t = navigation.first_violation(person, machine, LAW, 0.0, 60.0)
    assert t == pytest.approx(6.5 + 0.2, abs=1e-6)


def test_those_who_stand_are_judged_once_and_for_ever():
    near, far = navigation.standing((0, 0)), navigation.standing((1.0, 0))
    assert navigation.violations(near, far, LAW, 0.0, 1e6) == []
    close = navigation.standing((0.999, 0))
    assert navigation.violations(near, close, LAW, 0.0, 1e6) == [(0.0, 1e6)]
    assert navigation.first_violation(near, close, LAW, 3.0, 3.0) == 3.0


def test_a_person_put_elsewhere_is_out_of_danger_at_once():
    walk = navigation.walk([(-10, 0), (10, 0)], 0.0)
    person = navigation.join([walk, navigation.standing((-20, 0), start=8.0)], end=20.0)
    machine = navigation.standing((0, 0))
    assert navigation.violations(person, machine, LAW, 0.0, 20.0) == [
        (pytest.approx(6.7, abs=1e-6), 8.0)
    ]


@pytest.mark.parametrize("span", [(1.0, 0.0), (0.0, math.inf), (math.nan, 1.0)])
def test_spans_that_make_no_sense_are_refused(span):
    body = navigation.standing((0, 0))
    with pytest.raises(ValueError, match="can't watch from"):
        navigation.first_violation(body, body, LAW, *span)


def test_conditions_combine():
    person = navigation.walk([(-10, 0), (10, 0)], 0.0)
    machine = navigation.standing((0.0, 1.0))
    near = navigation.TooClose(FixedDistance(5.0))
    approaching = navigation.Both(near, navigation.Approaching())
    ((begin, end),) = navigation.when(approaching, person, machine, 0.0, 60.0)
    assert begin == pytest.approx(10.2 - math.sqrt(24), abs=1e-6)
    assert end == pytest.approx(10.2, abs=1e-6)
    leaving = navigation.Both(near, navigation.Not(navigation.Approaching()))
    ((begin, end),) = navigation.when(leaving, person, machine, 0.0, 60.0)
    assert (begin, end) == pytest.approx((10.2, 10.2 + math.sqrt(24)), abs=1e-6)
    apart = list(navigation.when(navigation.Apart(5.0), person, machine, 0.0, 60.0))
    assert len(apart) == 2
    moving = navigation.when(navigation.Moving(), machine, person, 0.0, 60.0)
    ((begin, end),) = moving
    assert begin == pytest.approx(0.01 / 2.5, abs=1e-6)
    assert end == pytest.approx(person.end - 0.01 / 2.5, abs=1e-5)
