import math
from fractions import Fraction

import numpy as np
import pytest

from navigation.benchmark import Asked, Attempt, cost_over_time, success_over_time
from navigation.benchmark.peers import Progress
from navigation.benchmark.reports import median, share


@pytest.mark.parametrize("n", [1, 4, 10, 50, 200])
def test_shares_have_wilson_s_interval(n):
    """Its ends are the shares at which the normal test just refuses what was found."""
    for successes in {0, 1, n // 2, n}:
        p = successes / n
        found = share([1.0] * successes + [0.0] * (n - successes))
        assert found.value == pytest.approx(p)
        for end in (found.low, found.high):
            if 1e-12 < end < 1 - 1e-12:
                deviations = abs(p - end) / math.sqrt(end * (1 - end) / n)
                assert deviations == pytest.approx(1.959963984540054)
        assert 0 <= found.low <= p <= found.high <= 1
        assert found.low > 0 or successes == 0
        assert found.high < 1 or successes == n


@pytest.mark.parametrize("n", [6, 7, 20, 53, 200])
def test_medians_have_the_narrowest_interval_that_holds_them_so_often(n):
    """The median lies between two ranks as often as a fair coin falls so many times on one side."""
    found = median(list(range(n, 0, -1)))
    low, high = int(found.low), int(found.high)
    assert low + high == n + 1
    assert found.value == pytest.approx((n + 1) / 2)

    def held(low, high):
        return sum(Fraction(math.comb(n, k), 2**n) for k in range(low, high))

    assert held(low, high) >= Fraction(95, 100)
    assert held(low + 1, high - 1) < Fraction(95, 100)


def test_few_values_bound_no_median():
    found = median([3.0, 1.0, 2.0])
    assert (found.value, found.low, found.high) == (2.0, -math.inf, math.inf)
    assert math.isnan(median([]).value)


def attempt(query, run, progress, shortest=10.0, longest=math.inf):
    """An answer that became ever shorter, or none."""
    asked = Asked(
        floorplan="f",
        planner="p",
        query=query,
        run=run,
        seed=0,
        start=(0, 0),
        goal=(1, 1),
        shortest=shortest,
        longest=longest,
    )
    times = {"planning_seconds": 9.0, "simplification_seconds": 0.0, "scene_seconds": 0.0}
    figures = dict.fromkeys(
        ("memory", "length", "clearance", "turning", "ompl_clearance", "ompl_smoothness"), 0.0
    )
    return Attempt(
        asked=asked,
        solved=bool(progress),
        reason="" if progress else "not_found",
        wrong="",
        cpu_seconds=9.0,
        checks=0,
        bends=0,
        points=None,
        progress=tuple(Progress(0, t, length) for t, length in progress),
        **times,
        **figures,
    )


ANSWERS = [
    attempt(0, 0, [(1.0, 20.0), (4.0, 10.0)]),
    attempt(0, 1, []),
    attempt(1, 0, [(2.0, 30.0)]),
    attempt(1, 1, [(3.0, 20.0)]),
]


def test_success_over_time_counts_each_question_once():
    curve = success_over_time(ANSWERS)
    assert curve.seconds.tolist() == [1.0, 2.0, 3.0]
    assert curve.value.tolist() == [0.25, 0.5, 0.75]
    assert (curve.low <= curve.value).all()
    assert (curve.value <= curve.high).all()


def test_a_path_that_is_too_long_is_no_success_yet():
    found = [(1.0, 20.0), (4.0, 15.0), (5.0, 10.0)]
    curve = success_over_time([attempt(0, 0, found, longest=1.5)])
    assert (curve.seconds.tolist(), curve.value.tolist()) == ([4.0], [1.0])


def test_a_question_without_a_path_so_far_is_infinitely_long():
    curve = cost_over_time([a for a in ANSWERS if a.asked.run == 0] + [attempt(2, 0, [])])
    assert curve.seconds.tolist() == [1.0, 2.0, 4.0]
    assert np.array_equal(curve.value, [math.inf, 3.0, 3.0])
    assert len(cost_over_time([attempt(0, 0, [])]).seconds) == 0


def test_a_question_that_no_path_answers_has_no_cost():
    without = [attempt(k, 0, [], shortest=math.inf) for k in (2, 3)]
    curve = cost_over_time([attempt(0, 0, [(1.0, 20.0)]), *without])
    assert (curve.seconds.tolist(), curve.value.tolist()) == ([1.0], [2.0])
