"""Laws: the formula, and what is refused."""

import math

import pytest

from navigation import FixedDistance, Scaled, SeparationLaw


def test_the_linear_form():
    law = SeparationLaw(t1=1.0, t2=1.5, stopping=0.25, intrusion=1.0)
    assert law.distance(human_speed=1.0, robot_speed=0.5) == pytest.approx(2.5 + 0.5 + 0.25 + 1.0)
    assert law.distance(0.0, 0.0) == 1.25


def test_noticing_is_a_multiple_with_a_cap():
    law = Scaled(SeparationLaw(t1=1.0, t2=1.5, intrusion=1.2), 1.75, cap=5.0)
    assert law.distance(0.0, 0.0) == pytest.approx(2.1)
    assert law.distance(1.0, 0.0) == 5.0


def test_a_fixed_distance_does_not_care():
    assert FixedDistance(2.1).distance(3.0, 4.0) == 2.1


@pytest.mark.parametrize("term", ["t1", "t2", "stopping", "intrusion"])
@pytest.mark.parametrize("value", [-0.1, math.nan, math.inf])
def test_terms_are_finite_and_not_negative(term, value):
    with pytest.raises(ValueError, match=f"{term} must be a number of at least 0"):
        SeparationLaw(**{"t1": 1.0, "t2": 1.0, term: value})
    with pytest.raises(ValueError, match="metres must be"):
        FixedDistance(value)
