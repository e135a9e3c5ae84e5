"""Laws: formulas, bounds over intervals, and validation."""

import math

import numpy as np
import pytest
from hypothesis import given, strategies as st
from stretches import encounters, part_of

import floorplan
import navigation
from navigation import (
    ApproachLaw,
    Enclosure,
    FixedDistance,
    IntegralLaw,
    Motion,
    Piece,
    Scaled,
    SeparationLaw,
)
from navigation.kernels.encounter import Encounter
from navigation.kernels.odometer import Odometer
from navigation.machines import ARIAC_GANTRY, AxisLimits
from navigation.motion import State
from navigation.separation import is_of_motions, is_of_speeds, required_at, required_at_speeds


def test_the_linear_form_equals_its_formula():
    law = SeparationLaw(t1=1.0, t2=1.5, stopping=0.25, intrusion=1.0)
    assert law.distance(human_speed=1.0, robot_speed=0.5) == pytest.approx(2.5 + 0.5 + 0.25 + 1.0)
    assert law.distance(0.0, 0.0) == 1.25


def test_a_scaled_law_is_a_multiple_with_a_cap():
    law = Scaled(SeparationLaw(t1=1.0, t2=1.5, intrusion=1.2), 1.75, cap=5.0)
    assert law.distance(0.0, 0.0) == pytest.approx(2.1)
    assert law.distance(1.0, 0.0) == pytest.approx(1.75 * 3.7)
    assert law.distance(2.0, 0.0) == 1.75 * 5.0


def test_a_fixed_distance_is_independent_of_speeds():
    assert FixedDistance(2.1).distance(3.0, 4.0) == 2.1


def test_the_approach_speed_of_the_standard_is_a_constant():
    law = ApproachLaw(time=0.5, intrusion=0.85)
    assert law.distance(0.0, 3.0) == law.distance(2.0, 0.0) == pytest.approx(1.6 * 0.5 + 0.85)
    assert ApproachLaw(time=2.0, speed=2.0).distance(0.0, 0.0) == 4.0


def integral(law, person, machine, t):
    """Return the requirement of the integral law at one time."""
    encounter, *_ = encounters(person, machine, t, t)
    return law.required(encounter, t, t).value


def test_at_constant_speeds_the_integral_form_is_the_linear_form():
    terms = {"t1": 0.7, "t2": 1.1, "stopping": 0.25, "intrusion": 0.5}
    person = navigation.walk([(-20, 0), (20, 0)], 0.0, max_speed=1.3)
    machine = navigation.gantry_move((-14, -7, 0), (0, 7, 0))
    assert integral(IntegralLaw(**terms), person, machine, 10.0) == pytest.approx(
        SeparationLaw(**terms).distance(1.3, machine.state(10.0).speed), abs=1e-12
    )


def test_the_integral_form_uses_the_remaining_path():
    """Braking from 1 m/s at 2.5 m/s² takes 0.4 s and 0.2 m."""
    person = navigation.walk([(0, 0), (5, 0)], 0.0)
    machine = navigation.standing((0, 0))
    law = IntegralLaw(t1=1.0, t2=1.0, human_uncertainty=0.1, robot_uncertainty=0.2, intrusion=0.3)
    assert person.end == pytest.approx(5.4, abs=1e-6)
    assert integral(law, person, machine, 5.0) == pytest.approx(0.2 + 0.6, abs=1e-6)
    assert integral(law, person, machine, 4.0) == pytest.approx(1.2 + 0.6, abs=1e-6)
    assert integral(law, person, machine, 5.4) == pytest.approx(0.6, abs=1e-6)


def test_the_integral_form_brakes_linearly_by_default():
    person = navigation.standing((0, 0))
    machine = navigation.walk([(0, 0), (50, 0)], 0.0, max_speed=2.0)
    law = IntegralLaw(t1=1.0, t2=1.5)
    assert integral(law, person, machine, 10.0) == pytest.approx(2.0 * 1.0 + 2.0 * 1.5 / 2)


def test_a_jump_adds_no_path_length():
    walk = navigation.walk([(-10, 0), (10, 0)], 0.0)
    person = navigation.join([walk, navigation.standing((-20, 0), start=8.0)], end=20.0)
    odometer = Odometer(person)
    assert odometer.reading(8.0) == odometer.reading(20.0) == pytest.approx(7.8, abs=1e-6)
    law = IntegralLaw(t1=1.0, t2=1.0)
    machine = navigation.standing((0, 0))
    assert integral(law, person, machine, 7.5) == pytest.approx(0.5, abs=1e-6)


cubics = st.tuples(st.just(0.0), *(st.floats(-2, 2) for _ in range(3)))
curves = st.builds(
    lambda x, y, end: Motion((Piece(0.0, end, x, y, (0.0,) * 4),)),
    cubics,
    cubics,
    st.floats(0.01, 5),
)


@given(curves, st.floats(0, 1))
def test_an_odometer_reads_the_path_length(motion, share):
    t = share * motion.end
    steps = np.linspace(0.0, t, 20_001)
    chords = np.hypot(*np.diff(motion.position(steps), axis=0).T).sum()
    fastest = np.hypot(*motion.velocity(np.linspace(0, motion.end, 99)).T).max() + 1.0
    reading = Odometer(motion).reading(t)
    assert reading == pytest.approx(chords, abs=1e-6 * fastest * (1 + t))
    assert reading >= chords - 1e-9 * (1 + chords)


@given(
    st.one_of(st.floats(1e-12, 2), st.sampled_from([1e-10, 1e-7, 1e-4])),
    st.floats(-2, 2),
    st.floats(0.01, 2),
    st.floats(0, 5),
)
def test_an_odometer_agrees_with_the_closed_form_of_a_parabola(across, v, a, t):
    """∫ √(b² + w²) dw = (w √(b² + w²) + b² asinh(w / b)) / 2, however sharp the turn."""
    piece = Piece(0.0, 5.0, (0.0, across, 0.0, 0.0), (0.0, v, a, 0.0), (0.0,) * 4)

    def stem(w):
        return (w * math.hypot(across, w) + across**2 * math.asinh(w / across)) / 2

    length = (stem(v + 2 * a * t) - stem(v)) / (2 * a)
    assert Odometer(Motion((piece,))).reading(t) == pytest.approx(length, rel=1e-11, abs=1e-11)


def test_an_odometer_counts_back_and_forth():
    piece = Piece(0.0, 2.0, (0.0, 3.0, -3.0, 0.0), (0.0,) * 4, (0.0,) * 4)
    odometer = Odometer(Motion((piece,)))
    assert odometer.reading(0.5) == pytest.approx(0.75, abs=1e-14)
    assert odometer.reading(1.0) == pytest.approx(1.5, abs=1e-14)
    assert odometer.reading(2.0) == odometer.reading(9.0) == pytest.approx(7.5, abs=1e-13)
    assert odometer.reading(-1.0) == 0.0


@given(curves, curves, st.floats(0, 2), st.floats(0, 2), st.floats(0, 1), st.floats(0, 1))
def test_the_enclosure_of_a_law_holds_throughout_an_interval(person, machine, t1, t2, low, high):
    laws = [
        IntegralLaw(t1=t1, t2=t2, intrusion=0.5),
        SeparationLaw(t1=t1, t2=t2),
        ApproachLaw(time=t1),
        FixedDistance(t2),
    ]
    for law in laws:
        assert is_of_motions(law)
        for encounter in encounters(person, machine, 0.0, 6.0):
            begin, end = part_of(encounter, low, high)
            found = law.required(encounter, begin, end)
            # A jump to rest at the end is not part of the interval.
            for t in np.linspace(begin, end, 9)[:-1].tolist():
                exact = law.required(encounter, t, t).value
                u = t - (begin + end) / 2
                expected = found.value + found.slope * u + found.curve * u * u / 2
                assert abs(exact - expected) <= found.slack + 1e-10


def test_enclosures_add_up():
    one = (
        Enclosure(value=1.0, slope=0.5, slack=0.1) * -2.0
        + Enclosure(value=1.0, slope=1.0, slack=0.0)
        + 4.0
    )
    assert (one.value, one.slope, one.slack) == (3.0, 0.0, 0.2)
    assert one.range(10.0) == (2.8, 3.2)
    two = (
        Enclosure(value=1.0, slope=0.5, slack=0.0, curve=2.0)
        + Enclosure(value=0.0, slope=0.0, slack=0.0, curve=1.0)
    ) * 2.0
    assert (two.curve, two.range(1.0)) == (6.0, (-2.0, 6.0))
    assert Enclosure.between(1.0, 2.0).range(3.0) == (1.0, 2.0)


@pytest.mark.parametrize("value", [-0.1, math.nan, math.inf, "0.1"])
def test_invalid_values_of_other_laws_are_rejected(value):
    integral_terms = ("t1", "t2", "stopping", "intrusion", "human_uncertainty", "robot_uncertainty")
    for term in integral_terms:
        with pytest.raises(ValueError, match=f"{term} must be a number of at least 0"):
            IntegralLaw(**{"t1": 1.0, "t2": 1.0, term: value})
    for term in ("time", "intrusion", "speed"):
        with pytest.raises(ValueError, match=f"{term} must be a number of at least 0"):
            ApproachLaw(**{"time": 1.0, term: value})


@pytest.mark.parametrize("term", ["t1", "t2", "stopping", "intrusion"])
@pytest.mark.parametrize("value", [-0.1, math.nan, math.inf, "0.1"])
def test_invalid_values_of_laws_are_rejected(term, value):
    with pytest.raises(ValueError, match=f"{term} must be a number of at least 0"):
        SeparationLaw(**{"t1": 1.0, "t2": 1.0, term: value})
    with pytest.raises(ValueError, match="metres must be"):
        FixedDistance(value)


LAWS = [
    SeparationLaw(t1=0.7, t2=1.1, stopping=0.25, intrusion=0.5),
    IntegralLaw(t1=0.7, t2=1.1, stopping=0.25, intrusion=0.5),
    ApproachLaw(time=1.5, intrusion=0.2),
    FixedDistance(2.1),
]


@pytest.mark.parametrize("law", LAWS)
def test_requirements_at_a_time_and_at_constant_speeds_are_equal(law):
    person = navigation.walk([(-20, 0), (20, 0)], 0.0, max_speed=1.3)
    machine = navigation.gantry_move((-14, -7, 0), (0, 7, 0))
    steady = required_at_speeds(law, 1.3, machine.state(10.0).speed)
    assert required_at(law, person, machine, 10.0) == pytest.approx(steady, abs=1e-9)
    assert required_at(Scaled(law, 2.0), person, machine, 10.0) == pytest.approx(
        2 * steady, abs=1e-9
    )
    assert required_at_speeds(Scaled(law, 2.0, cap=0.3), 1.3, 1.0) == 0.6


@pytest.mark.parametrize("cap", [math.inf, 1.3])
def test_a_scaled_predictive_law_agrees_with_dense_sampling(cap):
    """A person who stops beside a standing machine, against samples of the requirement."""
    person = navigation.walk([(-6, 0.8), (-0.5, 0.8)], 0.0)
    machine = navigation.standing((0, 0))
    law = Scaled(IntegralLaw(t1=0.5, t2=0.7, intrusion=0.9), 1.2, cap)
    ts = np.arange(0.0, 8.0, 1e-3)
    required = np.array([required_at(law, person, machine, t) for t in ts.tolist()])
    gap = np.hypot(*person.position(ts).T)
    changes = ts[1:][np.diff(gap < required)]
    spans = navigation.violations(person, machine, law, 0.0, 8.0)
    found = [t for span in spans for t in span if 0.0 < t < 8.0]
    assert found == pytest.approx(changes.tolist(), abs=1.1e-3)
    assert found
    _, margin = navigation.minimum_margin(person, machine, law, 0.0, 8.0)
    # Where the cap begins, the margin has a corner between two samples.
    least = (gap - required).min()
    assert least - 1e-3 <= margin <= least + 1e-9


def test_a_scaled_predictive_law_has_no_distance_at_speeds_alone():
    law = Scaled(IntegralLaw(t1=0.5, t2=0.7), 2.0)
    assert not is_of_speeds(law)
    with pytest.raises(TypeError, match="more than two speeds"):
        law.distance(1.0, 0.0)


class RenamedIntegral(IntegralLaw):
    """Derived class without other methods."""


class DoubledDistance(SeparationLaw):
    """Derived class with another distance."""

    def distance(self, human_speed, robot_speed):
        return 2 * super().distance(human_speed, robot_speed)


@pytest.mark.parametrize(
    ("derived", "same"),
    [
        (RenamedIntegral(t1=0.5, t2=0.7), IntegralLaw(t1=0.5, t2=0.7)),
        (DoubledDistance(t1=0.5, t2=0.7), Scaled(SeparationLaw(t1=0.5, t2=0.7), 2.0)),
    ],
)
def test_a_derived_law_uses_the_methods_that_it_inherits_and_overrides(derived, same):
    person = navigation.walk([(-6, 0.8), (6, 0.8)], 0.0)
    machine = navigation.standing((0, 0))
    span = (0.0, 12.0)
    expected = navigation.violations(person, machine, same, *span)
    found = navigation.violations(person, machine, derived, *span)
    assert found and np.array(found) == pytest.approx(np.array(expected), abs=1e-6)
    encounter = Encounter(person, machine)
    encounter.come_to(2.0)
    encounter.next_stretch(2.0)
    assert derived.required(encounter, 2.0, 2.0).value == pytest.approx(
        same.required(encounter, 2.0, 2.0).value
    )


limits = st.builds(AxisLimits, st.floats(0.05, 3.0), st.floats(0.05, 3.0), st.floats(0.05, 20.0))


def state_of(axis, share, speed):
    """Return the state of an axis with a `share` of the maximum acceleration for its speed."""
    acceleration = share * min(axis.max_acceleration, math.sqrt(2 * axis.max_jerk * axis.max_speed))
    room = axis.max_speed - acceleration**2 / (2 * axis.max_jerk)
    return speed * max(room, 0.0), acceleration


@given(st.tuples(limits, limits, limits), st.lists(st.floats(-1, 1), min_size=6, max_size=6))
def test_no_stop_of_a_gantry_exceeds_that_of_its_law(axes, shares):
    """Ruckig stops from any state within the limits. From the worst the stop equals the law's."""
    law = SeparationLaw.for_machine(axes, t1=0.1, intrusion=0.2)

    def stop(shares, speeds):
        states = [state_of(*of) for of in zip(axes, shares, speeds, strict=True)]
        velocity, acceleration = zip(*states, strict=True)
        braked = navigation.gantry_stop(
            State((0.0, 0.0, 0.0), velocity, acceleration), 0.0, limits=axes
        )
        return braked.end, math.hypot(*braked.state(braked.end).at[:2])

    time, distance = stop(shares[:3], shares[3:])
    assert time <= law.t2 + 1e-6 and distance <= law.stopping + 1e-6
    assert stop((1, 1, 1), (1, 1, 1)) == pytest.approx((law.t2, law.stopping), abs=1e-6)
    assert (law.t1, law.intrusion) == (0.1, 0.2)


def test_laws_of_built_in_machines_have_their_stops():
    plan = floorplan.load("ariac2023")
    law = SeparationLaw.for_machine(plan.gantry, t1=1.0)
    assert law == SeparationLaw.for_machine(ARIAC_GANTRY, t1=1.0)
    assert law.t2 == pytest.approx(1.0 / 0.5 + 2 * 0.5 / 2.0)
    lane = plan.lanes[0]
    law = SeparationLaw.for_machine(lane, t1=1.0)
    run = navigation.agv_run(lane, 0.0, 17.0)
    fast = run.state(4.0)
    braked = navigation.agv_stop(lane, fast)
    assert fast.speed == pytest.approx(lane.max_speed)
    assert law.t2 == pytest.approx(braked.end)
    assert law.stopping == pytest.approx(math.dist(run.state(4.0).at[:2], braked.position(9.0)))
    with pytest.raises(TypeError, match="Gantry"):
        SeparationLaw.for_machine(plan, t1=1.0)
