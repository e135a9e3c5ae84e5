"""Cliff's delta between the combinations of a study, and its interval."""

import math

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st

from sim.studies.comparison import cliffs_delta, compare, contrasts

figures = st.lists(st.integers(-3, 3), min_size=1, max_size=25).map(lambda v: np.array(v, float))


@given(figures, st.randoms(use_true_random=False))
def test_delta_is_what_counting_all_pairs_gives(one, random):
    other = np.array([random.randint(-3, 3) for _ in one], float)
    counted = np.sign(one[:, None] - other).mean()
    found = cliffs_delta(one, other)
    assert found.delta == pytest.approx(counted, abs=1e-12)
    assert -1 <= found.low <= found.high <= 1
    assert cliffs_delta(other, one).delta == pytest.approx(-counted, abs=1e-12)


def test_intervals_hold_the_true_delta_as_often_as_they_say():
    """Of normal figures that share draws: delta is 2 Φ(d / √2) - 1 with d the means' distance."""
    rng = np.random.default_rng(2)
    true = math.erf(0.5 / 2)
    held, widths = 0, []
    for k in range(100):
        shared = rng.normal(size=50)
        one, other = math.sqrt(0.5) * (shared + rng.normal(size=(2, 50)))
        found = cliffs_delta(one + 0.5, other)
        held += found.low <= true <= found.high
        if k >= 20:
            continue
        alone = cliffs_delta(one + 0.5, rng.permutation(other))
        widths.append((found.high - found.low) / (alone.high - alone.low))
    assert 0.89 <= held / 100 <= 0.99
    assert np.median(widths) < 0.85  # draws in common tell more than as many of either's own


def test_combinations_that_differ_in_one_factor_are_set_against_each_other():
    rows = [(a, b) for _ in range(3) for a in ("x", "y", "z") for b in ("p", "q")]
    columns = {
        "row": list(range(len(rows))),
        "first": [a for a, _ in rows],
        "second": [b for _, b in rows],
        "penalties": [{"x": 5, "y": 3, "z": 3}[a] for a, _ in rows],
        "jobs_done": [None if a == "z" else k for k, (a, _) in enumerate(rows)],
        "score": [1] * len(rows),
    }
    found = list(contrasts(compare(columns, ["first", "second"])))
    pairs = [(c.one.label, c.other.label) for c in found]
    assert pairs[:2] == [("x · p", "y · p"), ("x · p", "z · p")]
    assert len(pairs) == 2 * 3 + 3 * 1
    effects = {measure.column: effect for measure, effect in found[0].effects.items()}
    assert effects.keys() == {"penalties", "jobs_done"}
    assert effects["penalties"].delta == effects["penalties"].low == 1.0
    assert [effect is None for effect in found[1].effects.values()] == [False, True]


def test_where_no_chief_figure_differs_the_others_are_compared():
    columns = {"row": [0, 1], "speed": ["1", "2"], "penalties": [0, 0], "agv_violations": [4, 3]}
    (found,) = contrasts(compare(columns, ["speed"]))
    assert {measure.column: effect.delta for measure, effect in found.effects.items()} == {
        "agv_violations": 1.0
    }


def test_missing_figures_take_their_repetition_with_them():
    one = np.array([1.0, math.nan, 5.0, 9.0])
    other = np.array([2.0, 0.0, math.nan, 3.0])
    assert cliffs_delta(one, other).delta == 0.0
    assert cliffs_delta(one[1:2], other[1:2]) is None


@settings(max_examples=10)
@given(st.integers(0, 2**32 - 1))
def test_the_interval_is_as_wide_as_theory_has_it(seed):
    """The variance of delta by Hájek's projection, for samples that share nothing."""
    one, other = np.random.default_rng(seed).normal([[0.3], [0.0]], size=(2, 300))
    signs = np.sign(one[:, None] - other)
    variance = (signs.mean(axis=1).var() + signs.mean(axis=0).var()) / 300
    found = cliffs_delta(one, other)
    assert found.high - found.low == pytest.approx(2 * 1.96 * math.sqrt(variance), rel=0.2)
