"""Statistics of a study: means, Cliff's delta between its combinations, and their intervals."""

import math
import statistics

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st

from sim.studies import figure
from sim.studies.comparison import Measure, cliffs_delta, compare, contrasts, measures, spread

some_figures = st.lists(st.integers(-3, 3), min_size=1, max_size=25).map(
    lambda v: np.array(v, float)
)


@given(some_figures, st.randoms(use_true_random=False))
def test_delta_equals_a_count_of_all_pairs(one, random):
    other = np.array([random.randint(-3, 3) for _ in one], float)
    counted = np.sign(one[:, None] - other).mean()
    effect = cliffs_delta(one, other)
    assert effect.delta == pytest.approx(counted, abs=1e-12)
    assert -1 <= effect.low <= effect.high <= 1
    assert cliffs_delta(other, one).delta == pytest.approx(-counted, abs=1e-12)


def test_intervals_contain_the_true_delta_as_often_as_stated():
    """For normal values with shared draws, delta is 2 Φ(d / √2) - 1 with d the means' distance."""
    rng = np.random.default_rng(2)
    true = math.erf(0.5 / 2)
    count, widths = 0, []
    for k in range(100):
        shared = rng.normal(size=50)
        one, other = math.sqrt(0.5) * (shared + rng.normal(size=(2, 50)))
        effect = cliffs_delta(one + 0.5, other)
        count += effect.low <= true <= effect.high
        if k >= 20:
            continue
        alone = cliffs_delta(one + 0.5, rng.permutation(other))
        widths.append((effect.high - effect.low) / (alone.high - alone.low))
    assert 0.89 <= count / 100 <= 0.99
    # shared draws give narrower intervals than the same number of separate ones
    assert np.median(widths) < 0.85


def test_combinations_that_differ_in_one_factor_are_compared():
    rows = [(a, b) for _ in range(3) for a in ("x", "y", "z") for b in ("p", "q")]
    columns = {
        "row": list(range(len(rows))),
        "first": [a for a, _ in rows],
        "second": [b for _, b in rows],
        "penalties": [{"x": 5, "y": 3, "z": 3}[a] for a, _ in rows],
        "jobs_done": [None if a == "z" else k for k, (a, _) in enumerate(rows)],
        "score": [1] * len(rows),
    }
    compared = list(contrasts(compare(columns, ["first", "second"])))
    pairs = [(c.one.label, c.other.label) for c in compared]
    assert pairs[:2] == [("x · p", "y · p"), ("x · p", "z · p")]
    assert len(pairs) == 2 * 3 + 3 * 1
    effects = {measure.column: effect for measure, effect in compared[0].effects.items()}
    assert effects.keys() == {"penalties", "jobs_done"}
    assert effects["penalties"].delta == effects["penalties"].low == 1.0
    assert [effect is None for effect in compared[1].effects.values()] == [False, True]


def test_other_figures_are_compared_if_no_main_figure_differs():
    columns = {"row": [0, 1], "speed": ["1", "2"], "penalties": [0, 0], "agv_violations": [4, 3]}
    (contrast,) = contrasts(compare(columns, ["speed"]))
    assert {measure.column: effect.delta for measure, effect in contrast.effects.items()} == {
        "agv_violations": 1.0
    }


def test_a_missing_figure_omits_its_repetition():
    one = np.array([1.0, math.nan, 5.0, 9.0])
    other = np.array([2.0, 0.0, math.nan, 3.0])
    assert cliffs_delta(one, other).delta == 0.0
    assert cliffs_delta(one[1:2], other[1:2]) is None


@settings(max_examples=10)
@given(st.integers(0, 2**32 - 1))
def test_the_interval_is_as_wide_as_in_theory(seed):
    """Compare with the variance of delta by Hájek's projection, for independent samples."""
    one, other = np.random.default_rng(seed).normal([[0.3], [0.0]], size=(2, 300))
    signs = np.sign(one[:, None] - other)
    variance = (signs.mean(axis=1).var() + signs.mean(axis=0).var()) / 300
    effect = cliffs_delta(one, other)
    assert effect.high - effect.low == pytest.approx(2 * 1.96 * math.sqrt(variance), rel=0.2)


floats = st.lists(st.floats(-1e6, 1e6), min_size=1, max_size=30).map(np.array)


@given(floats)
def test_an_interval_contains_its_mean_and_stays_among_the_values(values):
    interval = spread(values)
    slack = 1e-9 * (1 + np.abs(values).max())
    assert interval.mean == pytest.approx(statistics.fmean(values), abs=slack)
    assert values.min() - slack <= interval.low <= interval.high <= values.max() + slack
    assert interval.least == values.min() and interval.most == values.max()
    assert interval.median == pytest.approx(statistics.median(values), abs=slack)


@settings(max_examples=20)
@given(st.integers(0, 2**32 - 1))
def test_intervals_are_as_wide_as_in_theory(seed):
    values = np.random.default_rng(seed).normal(5.0, 2.0, size=400)
    interval = spread(values)
    half = 1.96 * values.std(ddof=1) / math.sqrt(len(values))
    assert (interval.high - interval.low) / 2 == pytest.approx(half, rel=0.12)
    assert (interval.high + interval.low) / 2 == pytest.approx(values.mean(), abs=0.1 * half)


def test_intervals_contain_the_true_mean_as_often_as_stated():
    rng = np.random.default_rng(1)
    count = 0
    for _ in range(300):
        interval = spread(rng.exponential(1.0, size=40))
        count += interval.low <= 1.0 <= interval.high
    assert 0.88 <= count / 300 <= 0.98


def test_missing_figures_are_omitted():
    assert spread(np.array([math.nan, math.nan])) is None
    assert spread(np.array([1.0, math.nan, 3.0])).mean == 2.0
    columns = {"row": [0, 1, 2], "side": ["a", "b", "a"], "penalties": [1, None, 3]}
    compared = compare(columns, ["side"])
    assert [group.label for group in compared.groups] == ["a", "b"]
    penalties = next(measure for measure in compared.spreads if measure.column == "penalties")
    first, second = compared.spreads[penalties]
    assert (first.mean, second) == (2.0, None)
    assert compared.constant(penalties) is None
    assert compared.label_of(1) == "b"


def test_figures_of_all_people_are_added_up():
    columns = {"people.ada.visits": [1, 2], "people.ben.visits": [10, None], "people.ben.x": [5, 5]}
    assert Measure("", "people.NAME.visits").values(columns).tolist() == [11.0, 2.0]
    assert Measure("", "people.NAME.replans").values(columns) is None


def test_figures_of_zones_are_compared_zone_by_zone():
    columns = {
        "row": [0, 1],
        "zones.aisle.entries": [1, 2],
        "zones.dock.entries": [10, 20],
        "zones.lab.entries": [0, 0],
    }
    values = compare(columns, []).values
    assert {measure.title: list(of_rows) for measure, of_rows in values.items()} == {
        "Entries into aisle": [1.0, 2.0],
        "Entries into dock": [10.0, 20.0],
        "Entries into lab": [0.0, 0.0],
    }


def test_figures_of_machines_that_a_trial_adds_are_compared():
    columns = {
        "row": [0, 1],
        "machines.tug.speed": [1.0, 2.0],
        "error": [None, None],
        "machines.tug.kind": ["tug", "tug"],
        "machines.tug.full_rounds": [3, 5],
        "machines.tug.ends": ["here", "there"],
        "machines.cart.kind": ["agv", "agv"],
        "machines.cart.runs": [1, 2],
    }
    titles = {measure.title: measure.chief for measure in compare(columns, []).spreads}
    assert titles == {"tug: full rounds": True, "cart: runs": False}


def test_measures_are_separate_columns():
    assert len({measure.column for measure in measures()}) == len(measures())


@pytest.mark.parametrize(
    ("value", "shown"),
    [(0.0, "0"), (3.0, "3"), (0.1234, "0.123"), (12.345, "12.35"), (123.45, "123.5"),
     (12345.6, "12,346"), (None, "–"), (math.nan, "–"), (-2.5, "−2.50"),
     (-0.0, "0"), (-6e-8, "0.000")],
)  # fmt: skip
def test_numbers_are_shown_with_their_significant_digits(value, shown):
    assert figure(value) == shown
